"""``bench schema``: the JSON Schemas that editors use."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import print_json


def schema(
    kind: Annotated[
        str | None, typer.Argument(help="Print this one: scenario, procedure, vehicle, tyre, road, …")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write all of them into this folder.")] = None,
) -> None:
    """Print or write the JSON Schemas of all file kinds (draft-07), for editors.

    Examples: bench schema scenario

    bench schema --out schemas

    First line of a file then: # yaml-language-server: $schema=schemas/scenario.schema.json
    """
    from bench.scenario.file_kinds import SCHEMA_KINDS, schema_of
    from signals.errors import unknown_name

    if kind is not None and kind not in SCHEMA_KINDS:
        raise unknown_name("kind of file", kind, SCHEMA_KINDS)
    if kind is not None or out is None:
        chosen = [kind] if kind is not None else list(SCHEMA_KINDS)
        schemas = {name: schema_of(name) for name in chosen}
        print_json(schemas[kind] if kind is not None else schemas)
    if out is not None:
        from bench.scenario.file_kinds import write_schemas

        for path in write_schemas(out, [kind] if kind is not None else SCHEMA_KINDS):
            print(path)
