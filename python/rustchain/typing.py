"""Types of arrays, for annotations."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
Time: TypeAlias = float | None
"""A time [s]; None: an end of what was recorded."""
