"""Writer for the warp of an output into a venue's TOML file, which keeps all other text and comments."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from live.base.errors import PersonError
from live.render.outputs.output import FULL_WINDOW, Output, Point
from live.render.outputs.warp import regular_mesh
from live.show.patch.patch_search_path import is_file
from live.show.patch.toml_model import parse_model, read_text
from live.show.venue.venue import FILE_HEADER, Venue

DIGITS = 5
"""Decimal places of a coordinate: 1/100 pixel of the largest projector."""


def update_output_toml(text: str, name: str, output: Output) -> str:
    """Return the TOML `text` (empty for a new file of the venue `name`) with corners and mesh of `output`.

    Everything else is kept, with comments; a missing output is added.
    """
    document = tomlkit.parse(text or f"{FILE_HEADER}name = {tomlkit.item(name).as_string()}\n")
    if "output" not in document:
        document["output"] = tomlkit.aot()
    tables: Any = document["output"]
    table = next((one for one in tables if str(one.get("name", "picture")).casefold() == output.name.casefold()), None)
    if table is None:
        table = tomlkit.table()
        table["name"] = output.name
        tables.append(table)
        table = tables[-1]
    _set_key(table, "corners", None if output.corners == FULL_WINDOW else _row(output.corners))
    mesh = output.mesh
    bends = bool(mesh) and mesh != regular_mesh(len(mesh[0]), len(mesh))
    _set_key(table, "mesh", _rows(mesh) if bends else None)
    return tomlkit.dumps(document)


def updated_output_text(path: Path, name: str, output: Output) -> str:
    """Return the new text of a venue's file; PersonError if the present text is invalid."""
    before = read_text(path, "venue") if is_file(path) else ""
    parse_model(before, str(path), Venue, "venue")
    try:
        text = update_output_toml(before, name, output)
    except TOMLKitError as error:
        raise PersonError(f"{path}: {error}", "correct the file, and save the output again") from None
    parse_model(text, str(path), Venue, "venue")
    return text


def _set_key(table: Any, key: str, value: Any) -> None:
    """Set a key, or remove it for None."""
    if value is not None:
        table[key] = value
    elif key in table:
        del table[key]


def _row(points: Sequence[Point]) -> Any:
    return tomlkit.item([[round(x, DIGITS), round(y, DIGITS)] for x, y in points])


def _rows(mesh: Sequence[Sequence[Point]]) -> Any:
    """Return the mesh as a TOML array with one row per line."""
    rows = tomlkit.array()
    for row in mesh:
        rows.append(_row(row))
    return rows.multiline(True)
