"""Machine and revision of a measurement: times compare only where both are the same."""

from __future__ import annotations

import platform
import re
import subprocess
from pathlib import Path

import rustchain as rc

ROOT = Path(__file__).parent.parent
MEASURED = ("src", "python", "benches", "Cargo.toml", "Cargo.lock")


def machine() -> str:
    """Return processor and instruction set."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        found = re.search(r"model name\s*:\s*(.*)", info.read_text())
        model = found.group(1) if found else model
    return f"{model}, one core, instructions {rc.instruction_set()}"


def git(*arguments: str) -> str:
    """Return the output of git in this repository."""
    return subprocess.run(
        ["git", *arguments], cwd=ROOT, check=True, capture_output=True, encoding="utf-8"
    ).stdout.strip()


def revision() -> str:
    """Return the commit, and whether the measured code differs from it."""
    try:
        commit = git("rev-parse", "--short=8", "HEAD")
        changed = git("status", "--porcelain", "--", *MEASURED)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return f"{commit} with changes" if changed else commit


def provenance() -> str:
    """Return machine and revision as the pages print them."""
    return f"{machine()}, revision {revision()}"
