"""Types of arrays and of arguments, for annotations.

Arguments are checked as the simple types that they are converted to. Type checkers see all that is
accepted: numbers of NumPy, arrays and lists for tuples, and any path.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

if TYPE_CHECKING:
    from os import PathLike

    _Integers: TypeAlias = npt.NDArray[np.integer[Any]]
    _Reals: TypeAlias = npt.NDArray[np.integer[Any] | np.floating[Any]]

    Number: TypeAlias = float | np.integer[Any] | np.floating[Any]
    Count: TypeAlias = int | np.integer[Any]
    Counts: TypeAlias = Sequence[Count] | _Integers
    Numbers: TypeAlias = Sequence[float] | _Reals
    Pair: TypeAlias = Numbers
    Rows: TypeAlias = Sequence[Numbers] | _Reals
    FilePath: TypeAlias = str | PathLike[str]
else:
    Number = float
    Count = int
    Counts = tuple[int, int]
    Numbers = Sequence[float]
    Pair = tuple[float, float]
    Rows = Sequence[Sequence[float]]
    FilePath = str | Path

Point: TypeAlias = Pair
Time: TypeAlias = Number | None
"""A time [s]; None: an end of what was recorded."""
