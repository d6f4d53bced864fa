"""The superblock of streamed files, as HDF5 writes it in format 3, and files that are still marked.

HDF5 marks a file that is being written. Read in the mode for several readers, a damaged one makes
HDF5 repeat its reads for hours. So a marked file is read through an object that shows it unmarked.
"""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing_extensions import Buffer

SIGNATURE = b"\x89HDF\r\n\x1a\n\x03"
"""How a streamed file begins. Files of `Result.save` have superblock 0."""

SIZE = 48  # [bytes] of which the last four are the checksum
_MARK = 11  # place of the marks of files that are being written
_END = 28  # place of the address of the file's end
_WORD = 2**32 - 1


def is_hdf5(path: Path) -> bool:
    """Return whether a file is one of HDF5, as results are, streamed or not."""
    with path.open("rb") as file:
        return file.read(8) == SIGNATURE[:8]


def end_of(start: bytes) -> int:
    """Return the length of the file that HDF5 has written [bytes]."""
    return int(struct.unpack_from("<Q", start, _END)[0])


def is_marked(path: Path) -> bool:
    """Return whether a process writes the file, or has ended without closing it."""
    with path.open("rb") as file:
        start = file.read(SIZE)
    return len(start) == SIZE and start[_MARK] != 0


class Unmarked(io.FileIO):
    """A file that is read as if it had been closed.

    Raises
    ------
    ValueError
        The superblock does not match its checksum.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "rb")
        start = bytearray(self.read(SIZE))
        if struct.unpack_from("<I", start, SIZE - 4)[0] != _lookup3(bytes(start[:-4])):
            self.close()
            msg = "its superblock does not match its checksum"
            raise ValueError(msg)
        start[_MARK] = 0
        struct.pack_into("<Q", start, _END, self.seek(0, io.SEEK_END))
        struct.pack_into("<I", start, SIZE - 4, _lookup3(bytes(start[:-4])))
        self._start = bytes(start)

    def readinto(self, buffer: Buffer, /) -> int:
        """Read into a buffer; the superblock is the one without a mark."""
        place = self.tell()
        count = super().readinto(buffer)
        shown = self._start[place : place + count]
        memoryview(buffer).cast("B")[: len(shown)] = shown
        return count


def _lookup3(key: bytes) -> int:
    """Return HDF5's checksum of 44 bytes: `hashlittle` of Bob Jenkins' lookup3.c."""
    words = struct.unpack("<11I", key)
    a = b = c = (0xDEADBEEF + len(key)) & _WORD
    for first in range(0, 9, 3):
        a, b, c = ((x + y) & _WORD for x, y in zip((a, b, c), words[first:], strict=False))
        for k in (4, 6, 8, 16, 19, 4):
            a = ((a - c) & _WORD) ^ _rotated(c, k)
            c = (c + b) & _WORD
            a, b, c = b, c, a
    a, b = (a + words[9]) & _WORD, (b + words[10]) & _WORD
    for k in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - _rotated(b, k)) & _WORD
        a, b, c = b, c, a
    found: int = b  # where seven rotations of the three names leave c
    return found


def _rotated(word: int, bits: int) -> int:
    return (word << bits | word >> (32 - bits)) & _WORD
