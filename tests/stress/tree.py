"""Scenes as trees of JSON values: paths to their numbers, and copies with other values."""

from __future__ import annotations

import copy
import dataclasses
import json
from collections.abc import Iterator
from typing import Any

import rustchain as rc
from rustchain.description.base import Description, class_named

Path = tuple[str | int, ...]


def tree_of(scene: rc.Scene) -> dict[str, Any]:
    """Return a scene as a tree of dicts, lists, numbers and texts."""
    return json.loads(scene.to_json())


def scene_of(tree: dict[str, Any]) -> rc.Scene:
    """Return the scene of a tree; its values are checked as those of every description."""
    return Description.from_json(json.dumps(tree))


def nodes(tree: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield every value with its path, outer ones first."""
    yield path, tree
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from nodes(value, (*path, key))
    elif isinstance(tree, list):
        for k, value in enumerate(tree):
            yield from nodes(value, (*path, k))


def numbers(tree: Any) -> Iterator[tuple[Path, int | float]]:
    """Yield every number with its path."""
    for path, value in nodes(tree):
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield path, value


def with_value(tree: dict[str, Any], path: Path, value: Any) -> dict[str, Any]:
    """Return a copy with another value at a path."""
    made = copy.deepcopy(tree)
    place = made
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return made


def without(tree: dict[str, Any], path: Path) -> dict[str, Any]:
    """Return a copy without an item of a list."""
    made = copy.deepcopy(tree)
    place = made
    for key in path[:-1]:
        place = place[key]
    del place[path[-1]]
    return made


def defaults(node: Any) -> dict[str, Any]:
    """Return the default values of the fields of a description, by name, as a tree has them."""
    kind = class_named(node.get("type")) if isinstance(node, dict) else None
    if kind is None:
        return {}
    return {
        field.name: json.loads(json.dumps(field.default, default=_plain))
        for field in dataclasses.fields(kind)
        if field.default is not dataclasses.MISSING
    }


def _plain(value: Any) -> Any:
    return json.loads(value.to_json())
