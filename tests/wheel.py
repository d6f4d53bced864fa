"""Run what README shows with the installed package: for wheels in an empty environment.

`--base` leaves out what needs more than NumPy.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BASE = """
import rustchain as rc
result = rc.Simulation(rc.paper_drive(25.0)).run(duration=0.01)
assert result.success and result.peaks.hinge_force.max() > 0.0
print(rc.__version__, rc.__file__, rc.instruction_set(), result)
"""


def python(code: str) -> None:
    """Run code in the current folder, which holds nothing of the clone."""
    subprocess.run([sys.executable, "-c", code], check=True)


def command(*arguments: str) -> None:
    """Run the command `rustchain`, which is beside the interpreter."""
    print("$ rustchain", *arguments, flush=True)
    subprocess.run([Path(sys.executable).with_name("rustchain"), *arguments], check=True)


def main() -> None:
    """Run the base code, then README's blocks and the commands."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", action="store_true", help="only what needs NumPy alone")
    base = parser.parse_args().base
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            python(BASE)
            if base:
                return
            python("\n".join(blocks))
            command("--version")
            command("check", str(ROOT / "examples/three_shafts.toml"))
            command("run", "paper", "--duration", "0.05", "--out", "paper.nc")
            command("fmu", "paper", "--out", "paper.fmu")
            command("plot", "paper.nc", "--out", "figures")
            assert len(list(Path("figures").iterdir())) > 3
            command("report", "paper.nc", "--out", "report.html")
            assert Path("report.html").stat().st_size > 100_000
        finally:
            os.chdir(ROOT)


if __name__ == "__main__":
    main()
