"""Warnings that point at the caller's line, and the package's log."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import warnings
from pathlib import Path

from rustchain.errors import RustchainWarning

log = logging.getLogger("rustchain")
"""Starts, warnings and ends of runs and sweeps; silent until a handler is set."""
log.addHandler(logging.NullHandler())

# The package, and what calls its decorated functions.
_INSIDE = (str(Path(__file__).parent) + os.sep, contextlib.__file__)


def warn_caller(message: str, category: type[Warning] = RustchainWarning) -> None:
    """Warn of the innermost line outside the package, however many of its functions lie between."""
    log.warning(message)
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_INSIDE):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)
