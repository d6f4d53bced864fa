"""What the methods of a result need to know of it: that they are its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from rustchain.results.result import Result


class Itself:
    """A part of `Result`, which inherits it."""

    @property
    def _result(self) -> Result:
        """The result itself, by its own type."""
        return cast("Result", self)
