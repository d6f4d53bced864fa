"""What type checkers accept runs."""

import runpy
from pathlib import Path

import matplotlib.pyplot as plt


def test_calls_that_type_checkers_accept_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(Path(__file__).with_name("typed_calls.py")), run_name="__main__")
    plt.close("all")
