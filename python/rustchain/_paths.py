"""What is said of files that are not there or cannot be written."""

from __future__ import annotations

import os
from pathlib import Path


def check_there(path: str | Path, writer: str) -> None:
    """Raise where no file is that `writer` could have written."""
    remedy = f"give a file that {writer} wrote"
    if Path(path).is_dir():
        raise IsADirectoryError(f"path = {path}: is a folder: {remedy}")
    if not Path(path).exists():
        raise FileNotFoundError(f"path = {path}: there is no such file: {remedy}")


def unwritable(error: OSError) -> str:
    """Return what is said of a file that cannot be written."""
    reason = str(error) if error.errno is None else os.strerror(error.errno)
    return f"cannot be written ({reason}): name a file where there is room and you may write"
