"""Warnings that point at the caller's line."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from pathlib import Path

# The package, and what calls its decorated functions.
_INSIDE = (str(Path(__file__).parent) + os.sep, contextlib.__file__)


def warn_caller(message: str, category: type[Warning] = UserWarning) -> None:
    """Warn of the innermost line outside the package, however many of its functions lie between."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_INSIDE):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)
