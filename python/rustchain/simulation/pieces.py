"""The memory of a run whose rows are written to a file during the run."""

from __future__ import annotations

import re

from rustchain.arguments import plain, shown
from rustchain.errors import InvalidInput
from rustchain.simulation.recording import Piece

DEFAULT = "256 MB"

# Rows of a chunk. With twice as many, a killed process loses up to twice as many rows; the speed of
# writing changes by less than 5 %.
_CHUNK = 256

# How much memory a piece takes at most, over the size of its rows: the rows while they are
# recorded, in arrays that are doubled when they grow, and the piece before while it is written.
_COPIES = 4

_UNITS = {"B": 1, "KB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}
_UNITS |= {"KIB": 2**10, "MIB": 2**20, "GIB": 2**30, "TIB": 2**40}
_FORM = re.compile(r"\s*(\d{1,15}(?:\.\d{1,15})?)\s*([kKmMgGtT]?[iI]?[bB])\s*", re.ASCII)


def rows_of_a_piece(out: object, memory: object, numbers: int) -> Piece:
    """Return how many rows of so many numbers are written at once.

    Raises
    ------
    InvalidInput
        `memory` is no size, holds no row, or there is no file for which it would be.
    """
    if out is None and memory is not None:
        msg = f"memory = {shown(memory)}: is for runs with a file; pass out= too, or leave it out"
        raise InvalidInput(msg)
    size = bytes_of(DEFAULT if memory is None else memory)
    row = 8 * numbers
    most = size // (_COPIES * row)
    if most < 1:
        msg = (
            f"memory = {shown(memory)}: is too little for rows of {row} bytes; expected at least "
            f"{_COPIES * row}; for a good speed, take {_COPIES * row * _CHUNK / 1e6:.0f} MB"
        )
        raise InvalidInput(msg)
    chunk = min(_CHUNK, most)
    return Piece(chunk, most - most % chunk)


def bytes_of(memory: object) -> int:
    """Return a size in bytes, or raise `InvalidInput`."""
    value = plain(memory)
    if isinstance(value, int) and not isinstance(value, bool) and 0 < value < 2**60:
        return value
    found = _FORM.fullmatch(value) if isinstance(value, str) else None
    if found is not None and found[2].upper() in _UNITS:
        size = float(found[1]) * _UNITS[found[2].upper()]
        if 1.0 <= size < 2.0**60:
            return int(size)
    msg = f"memory = {shown(memory)}: expected a size such as '256 MB' or '1 GiB', or bytes"
    raise InvalidInput(msg)
