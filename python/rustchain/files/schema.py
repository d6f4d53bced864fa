"""The JSON Schema of drive files, from the same models that read them."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_args, get_origin

from rustchain.arguments import plain
from rustchain.catalogue.standard import catalogue_chain
from rustchain.description.base import Description
from rustchain.description.chain import Chain
from rustchain.description.docstrings import descriptions_of
from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.files.models import (
    Field,
    Maker,
    chain_of_catalogue,
    fields_of,
    members_of,
    sections,
    tables_of,
)
from rustchain.simulation.simulation import Simulation

_FILE = {
    "type": "object",
    "description": "A file of rows of numbers with commas between; its path is relative to this.",
    "properties": {"file": {"type": "string", "description": "Path of the file."}},
    "required": ["file"],
    "additionalProperties": False,
}
_LEAVES = {float: "number", int: "integer", str: "string", bool: "boolean"}


def schema() -> dict[str, Any]:
    """Return the JSON Schema, draft 2020-12, of a drive file read as JSON."""
    made = _Schema()
    texts: dict[str, Maker] = {"simulation": Scene, "run": Simulation.run}
    tables = {
        name: made.table(fields, descriptions_of(texts[name]))
        for name, fields in sections().items()
    }
    tables["simulation"]["description"] = "Laws, solver and start of the scene."
    tables["run"]["description"] = "Duration and report of the run, and where the result goes."
    other = tables["simulation"]["properties"]["min_approach_speed"]
    other["description"] = "Another name of min_impact_velocity."
    drive = made.value(ChainDrive) | {"description": "The drive to simulate."}
    mechanism = made.value(Mechanism) | {"description": "The mechanism to simulate."}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "rustchain drive file",
        "description": "A drive, how it is simulated and for how long; units are SI.",
        "type": "object",
        "properties": {"drive": drive, "mechanism": mechanism, **tables},
        "oneOf": [{"required": ["drive"]}, {"required": ["mechanism"]}],
        "additionalProperties": False,
        "$defs": {"file": _FILE, **made.definitions},
    }


class _Schema:
    """Gathers the definitions of all tables that a file may have."""

    def __init__(self) -> None:
        self.definitions: dict[str, Any] = {}

    def table(self, fields: Mapping[str, Field], texts: Mapping[str, str]) -> dict[str, Any]:
        """Return the schema of a table."""
        properties = {}
        for name, field in fields.items():
            properties[name] = self.value(field.hint)
            if texts.get(name):
                properties[name]["description"] = texts[name]
            if field.default not in (None, ()):
                properties[name]["default"] = _as_json(field.default)
        found = {"type": "object", "properties": properties, "additionalProperties": False}
        needed = [name for name, field in fields.items() if field.needed]
        return found | ({"required": needed} if needed else {})

    def value(self, hint: Any) -> dict[str, Any]:  # noqa: ANN401
        """Return the schema of what an annotation allows."""
        references = [self._reference(name, make) for name, make in tables_of(hint).items()]
        others = [self._plain(m) for m in members_of(hint) if not tables_of(m)]
        if any(each.get("type") == "array" for each in others):
            others.append({"$ref": "#/$defs/file"})
        kinds = [each for k, each in enumerate(others) if each not in others[:k]]
        allowed = [*references, *kinds]
        if {} in allowed:
            return {}
        return allowed[0] if len(allowed) == 1 else {"anyOf": allowed}

    def _plain(self, hint: Any) -> dict[str, Any]:  # noqa: ANN401
        """Return the schema of what is no table."""
        if hint in _LEAVES:
            return {"type": _LEAVES[hint]}
        if get_origin(hint) is Literal:
            return {"enum": [word for word in get_args(hint) if word is not None]}
        if get_origin(hint) in (list, tuple, Sequence):
            items = [each for each in get_args(hint) if each is not Ellipsis]
            if len(set(items)) != 1:
                return {"type": "array"}
            count = {"minItems": len(items), "maxItems": len(items)} if len(items) > 1 else {}
            return {"type": "array", "items": self.value(items[0]), **count}
        return {}

    def _reference(self, name: str, maker: Maker) -> dict[str, Any]:
        """Return a reference to the definition of a table, which is made when it is new."""
        if name not in self.definitions:
            self.definitions[name] = {}  # a table may hold its own kind
            target = catalogue_chain if maker is chain_of_catalogue else maker
            texts = descriptions_of(target)
            if maker is chain_of_catalogue:
                texts |= {n: t for n, t in descriptions_of(Chain).items() if n not in texts}
            table = self.table(_without_needed_links(maker), texts)
            table["properties"] = {"type": {"const": name}, **table["properties"]}
            first = inspect.cleandoc(target.__doc__ or "").split("\n")[0]
            self.definitions[name] = {"description": first, **table}
        return {"$ref": f"#/$defs/{name}"}


def _without_needed_links(maker: Maker) -> dict[str, Field]:
    """Return the fields of a table; a chain's `links` may be those of the drive that it is in."""
    fields = dict(fields_of(maker))
    if maker in (Chain, chain_of_catalogue):
        fields["links"] = fields["links"]._replace(needed=False)
    return fields


def _as_json(value: object) -> Any:  # noqa: ANN401
    """Return a default as a file would write it."""
    return json.loads(value.to_json()) if isinstance(value, Description) else plain(value)
