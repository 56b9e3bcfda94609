"""Write docs/patch.md, the reference of patch files, from the schema that reads them; `--check` only compares."""

import sys
import types
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from live.show.patch.patch import Patch
from live.show.patch.section_base import Section

OUT = Path(__file__).resolve().parents[1] / "docs" / "patch.md"

HEAD = """# Patch files

A patch is a TOML file, or a folder with `show.toml`. Positions are stage metres (x, z): the origin is the centre of the
stage, +x to the right as the audience sees it, +z towards the audience. Measures count from 1. Files, folders
and steps are looked up beside the patch first, then in the project's `patches/`. `live check PATCH` says what is wrong,
and where.

**A folder** may hold parts of the patch in files of their own: beside `show.toml` those of `formations/`, `looks/` and
`score/` whose names end in `.toml`, read in this order and that of their names. Tables in double brackets follow each
other, keys of one table come together; one key twice is refused, with both places. Together they have at most 256 files
and 16 MB, each at most 4 MB.

**An editor** that knows TOML schemas (taplo, Even Better TOML) completes keys, shows what they are for and underlines
what is not allowed: `live schema --out patch.schema.json`, and `#:schema patch.schema.json` in a file's first line.

**While a show runs** from files they may be edited: within a beat the new patch is read, checked and tried out beside
the show, which takes it up at the next measure: what has begun goes on, what is planned is planned anew. Of the last
beats of a measure the steps of the next one are chosen already; then they come a measure later. What was changed live
(faders, facing, formations) stays, unless the edit changes that very value. A section that runs is found again by its
name. What is wrong is told on the terminal, in the overlay and in the status (`patch`: `version`, `problem`, `waits`),
and the last good patch goes on. These count from the next start on, and are told by name: `seed`, `steps`, `reserve`,
`[music]`, `[sound]`, `[clock]`, `[link]`, `[osc]`, ports and time code of `[midi]`, `[stage]`, `steering.separation`
and `steering.combine`, how many gates and groups there are, and of a group `dancers`, `soloists`, `radius`, `partners`,
`arm_length`, `hands`, `formation`, `centre` and `size`. Steps may be edited too: whoever dances one finishes it, and
begins it as it is now; a step whose file is gone is not begun any more. The journal holds the whole patch, and steps
that have changed as they were and are: a replay needs neither of the files.
"""


def reference() -> str:
    """The whole page."""
    parts = [HEAD, _table("At the top", Patch, top=True)]
    for name, field in Patch.model_fields.items():
        section = _section(field.annotation)
        if section is not None:
            many = get_origin(field.annotation) is tuple
            parts.append(_table(f"`[[{name}]]`" if many else f"`[{name}]`", section))
            parts += _inner(name, section)
    return "\n".join(parts)


def _inner(name: str, section: type[Section]) -> list[str]:
    """The tables within a table of which there may be many, as `[[midi.map]]`."""
    inner = {key: _section(field.annotation) for key, field in section.model_fields.items()}
    return [
        _table(f"`[[{name}.{key}]]`", kind)
        for key, kind in inner.items()
        if kind is not None and get_origin(section.model_fields[key].annotation) is tuple
    ]


def _section(annotation: Any) -> type[Section] | None:
    kinds = get_args(annotation) if get_origin(annotation) in (tuple, Union, types.UnionType) else (annotation,)
    found = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Section)]
    return found[0] if found else None


def _table(title: str, section: type[Section], *, top: bool = False) -> str:
    about = "" if top else (section.__doc__ or "").partition(": ")[2]
    rows = [
        f"## {title}\n",
        f"{about[:1].upper()}{about[1:]}\n" if about else "",
        "| key | value | default | |",
        "|-|-|-|-|",
    ]
    for name, field in section.model_fields.items():
        if top and _section(field.annotation) is not None:
            continue
        text = " ".join((field.description or "").split())
        rows.append(f"| `{name}` | {_kind(field)} | {_default(field)} | {text} |")
    return "\n".join(row for row in rows if row) + "\n"


def _kind(field: FieldInfo) -> str:
    words = _type_words(field.annotation)
    limits = {type(limit).__name__.lower(): limit for limit in field.metadata}
    low = next((getattr(limits[k], k) for k in ("ge", "gt") if k in limits), None)
    high = next((getattr(limits[k], k) for k in ("le", "lt") if k in limits), None)
    return words if low is None and high is None else f"{words}, {low:g} to {high:g}"


def _type_words(annotation: Any) -> str:
    origin = get_origin(annotation)
    if origin is Literal:
        return " or ".join(f'"{value}"' for value in get_args(annotation))
    if origin in (Union, types.UnionType):
        return " or ".join(_type_words(kind) for kind in get_args(annotation) if kind is not type(None))
    if origin is tuple:
        kinds = get_args(annotation)
        if kinds[-1] is not Ellipsis:
            return f"[{', '.join(map(_type_words, kinds))}]"
        inner = _type_words(kinds[0])
        return f"list of {inner}" + ("" if inner.endswith("]") else "s")
    if origin is dict:
        kind = get_args(annotation)[1]
        return "table" if kind is Any else f"table of {_type_words(kind)}s by name"
    if hasattr(annotation, "__metadata__"):
        return _type_words(get_args(annotation)[0])
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return "table"
    return {str: "text", float: "number", int: "whole number", bool: "true or false"}[annotation]


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "needed"
    value = field.default
    if value is None:
        return "–"
    if isinstance(value, str):
        return f'`"{value}"`'
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f"`{list(value) if isinstance(value, tuple) else value}`"


def main() -> int:
    """Write or check; 1 if the page is out of date."""
    text = reference()
    if "--check" in sys.argv[1:]:
        return 0 if OUT.exists() and OUT.read_text(encoding="utf-8") == text else 1
    OUT.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
