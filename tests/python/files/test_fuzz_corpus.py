"""Inputs that coverage-guided fuzzing found: each is read, or refused by the package."""

import contextlib
import warnings
import zipfile
from pathlib import Path

import pytest

import fuzz
import rustchain as rc

CORPUS = Path(__file__).parents[2] / "data" / "fuzz"


@pytest.mark.parametrize("target", sorted(path.stem for path in CORPUS.glob("*.zip")))
def test_each_input_is_read_or_refused(target, tmp_path, monkeypatch):
    monkeypatch.setattr(fuzz, "rc", rc, raising=False)
    monkeypatch.chdir(tmp_path)  # a scene may name another file
    read, refused = fuzz.TARGETS[target][1](), []
    with zipfile.ZipFile(CORPUS / f"{target}.zip") as corpus, warnings.catch_warnings():
        warnings.simplefilter("ignore", rc.RustchainWarning)
        contents = [corpus.read(name) for name in corpus.namelist()]
    for content in contents:
        with contextlib.suppress(OSError):
            try:
                read(content, tmp_path)
            except rc.RustchainError as error:
                refused.append(str(error))
    assert refused
    if target != "snapshot":  # a state is that of one version
        assert len(refused) < len(contents)  # some are read: both ways are tried
    assert not [error for error in refused if "defect of rustchain" in error]
