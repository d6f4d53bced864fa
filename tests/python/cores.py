"""Simulations whose compiled core is watched, stopped or broken."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from rustchain.simulation import simulation


class CoreAround:
    """A core that does what the one in it does."""

    def __init__(self, core: Any) -> None:
        self.core = core

    def __getattr__(self, name: str) -> Any:
        return getattr(self.core, name)


@contextmanager
def cores_within(kind: Callable[[Any], Any]) -> Iterator[list[Any]]:
    """Put the core of each simulation that is made meanwhile into one of `kind`; give these."""
    made: list[Any] = []
    core_of = simulation.core_of

    def around(*arguments: Any) -> Any:
        made.append(kind(core_of(*arguments)))
        return made[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation, "core_of", around)
        yield made
