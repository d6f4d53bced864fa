"""What a run records, and how far it is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Literal, NoReturn, get_args

from rustchain._names import suggest
from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    from tqdm import tqdm


Group = Literal["hinges", "teeth", "sprockets", "bodies", "energy"]

WALL_BUDGET = 0.05  # [s] between looks at the keyboard and the progress bar


def known_groups(record: Sequence[str], energy: bool) -> tuple[list[str], bool]:
    """Return the groups to record, each of which must exist, and whether to keep the energy."""
    if not isinstance(record, Iterable):
        msg = f"record = {record!r}: must be a sequence of groups: {', '.join(get_args(Group))}"
        raise InvalidInput(msg)
    groups = [record] if isinstance(record, str) else list(record)
    for group in groups:
        if group not in get_args(Group):
            msg = f"record: {group!r} is no group; {suggest(group, get_args(Group))}"
            raise InvalidInput(msg)
    return groups, True if "energy" in groups else energy


def seconds_bar(total: float, progress: bool, description: str | None = None) -> tqdm[NoReturn]:
    """Return a bar of simulated seconds [s]."""
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n:.4f}/{total:.4f} s [{elapsed}<{remaining}, {rate_noinv_fmt}]"
    return tqdm(
        desc=description,
        total=total,
        unit=" s",
        bar_format=form,
        disable=None if progress else True,
    )
