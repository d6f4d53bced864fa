"""The commands that list what there is: catalogue, schema."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import rustchain as rc
from rustchain.cli.common import (
    AsJson,
    Output,
    Quiet,
    check_file,
    clear_errors,
    make_room,
    printed,
)
from rustchain.extras import typer
from rustchain.paths import path_with_ending, write_whole


def catalogue(
    name: Annotated[
        str | None, typer.Argument(help="A chain, such as 'ANSI 40': all of its numbers.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the standard chains, or all numbers of one with their sources."""
    output = Output(as_json, quiet=False)
    with clear_errors():
        sizes = rc.chain_sizes()
        if name is not None:
            size = sizes[rc.catalogue_chain(name, links=8).name]
            output.say(size)
            output.document({"chain": size})
            return
        columns = ("pitch", "roller", "width", "pin", "mass", "strength")
        units = ("mm", "mm", "mm", "mm", "kg/m", "kN")
        for label, head in (("chain", columns), ("", units)):
            output.say(f"{label:<10}" + "".join(f"{one:>9}" for one in head))
        for size in sizes.values():
            lengths = (size.pitch, size.roller_diameter, size.inner_width, size.pin_diameter)
            row = "".join(f"{1e3 * length:9.3f}" for length in lengths)
            output.say(
                f"{size.name:<10}{row}{size.mass_per_length:9.3f}{1e-3 * size.strength:9.2f}"
            )
        output.document({"chains": list(sizes.values())})


def schema(
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="File to write; without it, the schema is printed."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write the JSON Schema of drive files, for editors that check and complete them."""
    from rustchain.files.schema import schema as schema_of_files

    with clear_errors():
        text = json.dumps(schema_of_files(), indent=2, ensure_ascii=False)
        if out is None:
            printed(text)
            return
        path_with_ending(out, "out", (".json",), "a JSON Schema is a JSON file")
        check_file(out, "schema.json")
        make_room(out)
        write_whole(out, f"{text}\n".encode(), "out")
        Output(json=False, quiet=quiet).say(out)
