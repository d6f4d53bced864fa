"""Random choices that a seed alone decides, and what was chosen, in words."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")


class Draw:
    """Random numbers of one scene; `features` collects what makes the scene special."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self.features: list[str] = []

    def between(self, low: float, high: float) -> float:
        return self._random.uniform(low, high)

    def log_between(self, low: float, high: float) -> float:
        return math.exp(self._random.uniform(math.log(low), math.log(high)))

    def integer(self, low: int, high: int) -> int:
        return self._random.randint(low, high)

    def one_of(self, choices: Sequence[T]) -> T:
        return choices[self._random.randrange(len(choices))]

    def sign(self) -> int:
        return self.one_of((-1, 1))

    def chance(self, probability: float, feature: str = "") -> bool:
        """Return True with this probability; `feature` is then one of the scene's."""
        happens = self._random.random() < probability
        if happens and feature:
            self.features.append(feature)
        return happens
