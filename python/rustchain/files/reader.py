"""Drive files: tables of TOML, checked by their models and made into descriptions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from rustchain import _rustchain
from rustchain.arguments import shown
from rustchain.catalogue.generators import chain_drive, open_chain
from rustchain.catalogue.standard import catalogue_chain, two_sprocket_drive
from rustchain.description.base import Description
from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.errors import InvalidInput
from rustchain.files.models import (
    Field,
    Maker,
    fields_of,
    item_of,
    leaf_problem,
    may_be_none,
    members_of,
    sections,
    tables_of,
    tag_of,
)
from rustchain.files.source import Key, Source, name_of, text_of
from rustchain.files.writer import NONE
from rustchain.names import suggest
from rustchain.paths import reason

# Of a value that may be anything: a description is a table with its type.
ANY = Description | Sequence[Description] | None


def read(path: Path) -> tuple[Source, dict[str, Any]]:
    """Return a file and what it describes: scene, run.

    Raises
    ------
    InvalidInput
        With a line for each thing that is wrong, in the order of the file.
    """
    source = Source.of(path)
    found = Reader(source).file()
    if (out := found["run"].get("out")) is not None:
        found["run"]["out"] = path.parent / out
    return source, found


def value_of_text(where: str, name: str, text: str) -> Any:  # noqa: ANN401
    """Return what a value stands for that is written as in a drive file.

    Parameters
    ----------
    where : str
        What the message begins with where it is refused.
    name : str
        What the value is of.
    text : str
        A value of TOML, in which a table is a description with its type; or text without quotes,
        or the type of a description that needs no fields.

    Raises
    ------
    InvalidInput
        A table is no description.
    """
    try:
        content, _ = _rustchain.read_toml(f"value = {text}")
    except ValueError:
        content = {}
    if content.keys() != {"value"}:
        if text.startswith(("[", "{", '"', "'")):
            msg = (
                f"{where}: {name} = {shown(text)}: is no value of TOML; expected a number, text, "
                "true, false, [list] or {type='Name', field=value}; quote it for the shell"
            )
            raise InvalidInput(msg)
        # Of a name, any text; of all else, that of a class is short for a table with its type.
        is_class = text in tables_of(ANY) and name.rpartition(".")[2] != "name"
        content = {"value": {"type": text} if is_class else text}
    reader = Reader(Source(Path(where), {name: content["value"]}))
    found = reader.value(content["value"], ANY, (name,))
    reader.check()
    return found


_SYSTEMS = {"drive": ChainDrive, "mechanism": Mechanism}

# Their `links` replace those of a chain that they are given.
LINKS_OF_DRIVE: tuple[Maker, ...] = (chain_drive, open_chain, two_sprocket_drive)
MOST_LINKS = 100_000  # of a Chain; holds a place until the links are counted


class _Wrong:
    """Placeholder of a value that was refused."""


_WRONG = _Wrong()


class Reader:
    """Makes the values of a file, and gathers what is wrong with it."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self._refusals: list[tuple[tuple[int, int], InvalidInput]] = []

    def file(self) -> dict[str, Any]:
        """Return the scene and the keywords of its run."""
        content = self.source.content
        fields = {name: Field(kind, name not in content) for name, kind in _SYSTEMS.items()}
        if any(name in content for name in _SYSTEMS) or set(content) - {*_SYSTEMS, *sections()}:
            fields = {name: field._replace(needed=False) for name, field in fields.items()}
        else:
            del fields["mechanism"]  # a drive is what is mostly forgotten
        fields |= {name: Field(dict, False) for name in sections()}
        found: dict[str, Any] = {name: {} for name in sections()}
        for name, value in self.entries(content, fields, ()):
            if name in sections():
                value = self.section(name, value)
            elif isinstance(value, Mapping):
                value = self.value(value, _SYSTEMS[name], (name,))
            else:
                value = self.refuse((name,), f"{shown(value)}: must be a table")
            found[name] = value
        self.check()
        return {"scene": self._scene(found), "run": found["run"]}

    def check(self) -> None:
        """Raise what was refused, a line each, in the order of the file."""
        refusals = [error for _, error in sorted(self._refusals, key=lambda each: each[0])]
        if len(refusals) == 1:
            raise refusals[0]
        if refusals:
            raise InvalidInput("\n".join(map(str, refusals))) from refusals[0]

    def _scene(self, found: Mapping[str, Any]) -> Scene:
        """Return the scene of a system and the keywords that go with it."""
        systems = [found[name] for name in _SYSTEMS if name in found]
        if len(systems) != 1:
            raise self.source.refusal_at((), "has a drive and a mechanism; expected one of them")
        try:
            return Scene(systems[0], **found["simulation"])
        except (InvalidInput, TypeError) as error:
            raise self.source.refusal(("simulation",), str(error)) from error

    def refuse(self, key: Key, message: str) -> _Wrong:
        """Keep what is wrong with `key`."""
        return self._keep(key, self.source.refusal_at(key, message))

    def _keep(self, key: Key, error: InvalidInput) -> _Wrong:
        while key and key not in self.source.places:
            key = key[:-1]
        self._refusals.append((self.source.places.get(key, (0, 0)), error))
        return _WRONG

    def entries(
        self, table: Mapping[str, Any], fields: Mapping[str, Field], key: Key, tag: str = ""
    ) -> list[tuple[str, Any]]:
        """Return the entries of a table that it may have; refuse others, and missing ones.

        `tag` is the key that gives the type of the table, if it has one.
        """
        unknown = [name for name in table if name not in fields and name != tag]
        for name in unknown:
            self.refuse((*key, name), f"unknown key; {suggest(name, fields)}")
        if not unknown:  # a misspelt key is often what another one is missing for
            for name, field in fields.items():
                if field.needed and name not in table:
                    self.refuse(key, f"{name!r} is missing: it must be given")
        return [(name, value) for name, value in table.items() if name in fields]

    def section(self, name: str, value: object) -> dict[str, Any]:
        """Return the keywords in the table ``simulation`` or ``run``."""
        if not isinstance(value, Mapping):
            self.refuse((name,), f"{shown(value)}: must be a table")
            return {}
        fields = sections()[name]
        entries = self.entries(value, fields, (name,))
        return {each: self.value(v, fields[each].hint, (name, each)) for each, v in entries}

    def value(self, value: Any, hint: Any, key: Key) -> Any:  # noqa: ANN401
        """Return what a value stands for: a description for a table, the rest as it is."""
        makers, item = tables_of(hint), item_of(hint)
        if isinstance(value, Mapping) and value.keys() == {"file"}:
            return self._numbers(str(value["file"]), key)
        if makers and isinstance(value, Mapping):
            return self._table(value, makers, key)
        if item is not None and isinstance(value, list):
            return self._all([self.value(v, item, (*key, i)) for i, v in enumerate(value)])
        if item is not None and len(members_of(hint)) == 1:
            return self.refuse(key, f"{shown(value)}: must be a list of tables")
        if value == NONE and may_be_none(hint):
            return None
        if (expected := leaf_problem(value, hint)) is not None:
            near = _near(value, hint)
            return self.refuse(key, f"{shown(value)}: must be {expected}{near}")
        if isinstance(value, list):  # of numbers, or of files of them
            return self._all([self.value(v, Any, (*key, i)) for i, v in enumerate(value)])
        return value

    def _all(self, values: list[Any]) -> Any:  # noqa: ANN401
        return _WRONG if _WRONG in values else values

    def _table(self, value: Mapping[str, Any], makers: Mapping[str, Maker], key: Key) -> Any:  # noqa: ANN401
        """Return the description that a table stands for."""
        name = tag_of(value, makers)
        if name is None:
            if "type" not in value:
                known = {name: None for make in makers.values() for name in fields_of(make)}
                unknown = [each for each in value if each not in known]
                for each in unknown:
                    self.refuse((*key, each), f"unknown key; {suggest(each, known)}")
                if unknown:
                    return _WRONG
                fit = [each for each in makers if set(value) <= set(fields_of(makers[each]))]
                listed = " or ".join(f"type = {each!r}" for each in fit or makers)
                return self.refuse(key, f"its keys fit several types; expected one; add {listed}")
            given = value["type"]
            message = f"{shown(given)} is not known; {suggest(given, makers)}"
            return self.refuse((*key, "type"), message)
        before, fields = len(self._refusals), fields_of(makers[name])
        self._check_name(value, fields, key)
        entries = self.entries(self._with_links(value, makers[name], key), fields, key, "type")
        made = {each: self.value(v, fields[each].hint, (*key, each)) for each, v in entries}
        if len(self._refusals) > before:
            return _WRONG
        try:
            return makers[name](**made)
        except (InvalidInput, TypeError) as error:
            refused = self.source.refusal(key, str(error))
            refused.__cause__ = error
            return self._keep(key, refused)

    def _check_name(self, drive: Mapping[str, Any], fields: Mapping[str, Field], key: Key) -> None:
        """Refuse a chain that the catalogue lacks, so that all mistakes are told at once."""
        if isinstance(name := drive.get("chain"), str) and "chain" in fields:
            try:
                catalogue_chain(name, 4)
            except InvalidInput as error:
                self.refuse((*key, "chain"), str(error).removeprefix("chain: "))

    def _with_links(self, drive: Mapping[str, Any], maker: Maker, key: Key) -> Mapping[str, Any]:
        """Return the table of a drive whose chain has the drive's number of links.

        A number in the table of the chain is refused where the maker would replace it.
        """
        chain = drive.get("chain")
        if not isinstance(chain, Mapping) or maker not in LINKS_OF_DRIVE:
            return drive
        links, own = drive.get("links"), chain.get("links")
        if own is not None:
            if maker is two_sprocket_drive and links in (None, own):
                return drive
            counted = "; without it they are counted" if maker is chain_drive else ""
            message = (
                f"{shown(own)}: is not used; remove it, and give the drive's number as "
                f"{name_of((*key, 'links'))}{counted}"
            )
            self.refuse((*key, "chain", "links"), message)
            return drive
        if not isinstance(links, int):
            if maker is two_sprocket_drive:
                return drive
            each = chain.get("elongation")
            links = len(each) if isinstance(each, list) else MOST_LINKS
        return {**drive, "chain": {**chain, "links": links}}

    def _numbers(self, name: str, key: Key) -> Any:  # noqa: ANN401
        """Return the numbers of another file, for ``{file = "..."}``."""
        try:
            return _rows_of_numbers(self.source.path.parent / name)
        except (OSError, ValueError) as error:
            why = reason(error) if isinstance(error, OSError) else str(error)
            remedy = "give a file of rows of numbers with commas between"
            return self.refuse((*key, "file"), f"{shown(name)}: {why}: {remedy}")


def _near(value: object, hint: Any) -> str:  # noqa: ANN401
    """Return the nearest of the words that are allowed, if one is near."""
    words = [w for m in members_of(hint) if get_origin(m) is Literal for w in get_args(m)]
    near = suggest(value, words) if words else ""
    return f"; {near}" if near.startswith("did you") else ""


def _rows_of_numbers(path: Path) -> list[list[float]]:
    """Return the rows of a table; what stands behind ``#`` is a comment."""
    rows: list[list[float]] = []
    first = 0
    for number, line in enumerate(text_of(path).splitlines(), 1):
        cells = line.partition("#")[0].strip()
        if not cells:
            continue
        row = []
        for cell in cells.split(","):
            try:
                row.append(float(cell))
            except ValueError:
                hint = "; put '#' before a line of names" if not rows else ""
                msg = f"line {number}: {shown(cell.strip())} is no number{hint}"
                raise ValueError(msg) from None
        first = first or number
        if rows and len(row) != len(rows[0]):
            msg = f"line {number} has {len(row)} numbers, line {first} has {len(rows[0])}"
            raise ValueError(msg)
        rows.append(row)
    if not rows:
        msg = "has no row of numbers"
        raise ValueError(msg)
    return rows
