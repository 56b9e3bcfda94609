"""Pages of the reference of patch files, made from the schema that reads them: one for each table."""

import types
from collections.abc import Iterable
from typing import Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from live.app.bridges import installed_bridges
from live.show.patch.patch import Patch
from live.show.patch.patch_schema import field_docs
from live.show.patch.section_base import Section, colour_value

HEAD = """# Patch files

A patch is a TOML file, or a folder with `show.toml`. Positions are stage metres (x, z): the origin is the centre of the
stage, +x points to the right as the audience sees it, +z towards the audience. Measures count from 1. Files, folders
and steps are looked up next to the patch first, then in the project's `patches/`. `live check PATCH` reports mistakes
with their lines.

**Folders.** A folder may hold parts of the patch in separate files: next to `show.toml`, all files of `formations/`,
`looks/` and `score/` whose names end in `.toml`, read in this order and by name. Tables in double brackets are
appended; keys of one table are merged. A key that occurs twice is refused, with both places. The limits are 256 files,
4 MB each and 16 MB together.

**Colours** are a word of the web (`"gold"`), sRGB as in `"#f80"`, or linear red, green and blue: `[1.0, 0.25, 0.0]`.

**Editors** that know TOML schemas (taplo, Even Better TOML) complete keys, explain them and underline mistakes:
`live schema --out patch.schema.json`, and `#:schema patch.schema.json` in a file's first line.

**Editing during a show.** The files of a running show may be edited. Within a beat the new patch is read, checked and
prepared next to the show, which adopts it at the next measure. What has begun continues; what is planned is planned
again. In the last beats of a measure the next steps are already chosen; they change one measure later. A value that was
changed live (fader, facing, formation) stays, unless the edit changes that value. A running section is found again by
its name. Mistakes are shown on the terminal, in the overlay and in the status (`patch`: `version`, `problem`, `waits`);
the last good patch stays in use.

These keys take effect at the next start, and are reported by name: `seed`, `steps`, `takes`, `variations`,
`reserve`, `[music]`, `[sound]`, `[clock]`, `[link]`, `[osc]`, ports and time code of `[midi]`, `steering.separation`,
`steering.combine`, `[[background]]`, `[[character]]`, `[texture]`, `picture.passes`, examples of a `[[partner]]`, the
number of groups, and of a group `dancers`, `soloists`, `radius`, `partners`, `arm_length`, `hands`, `formation`,
`centre` and `size`.

Steps may be edited too. A dancer finishes the step they are in, and begins the new version next time. A step whose file
is gone is not begun again. The journal holds the whole patch, and edited steps before and after, so a replay needs none
of the files.
"""


def patch_pages() -> dict[str, str]:
    """Return the pages by file name: the rules with the keys at the top, then a page for each table."""
    pages: dict[str, str] = {}
    rows = []
    models: list[type[Section]] = [Patch, *installed_bridges().patch_tables()]
    for name, field in [item for model in models for item in model.model_fields.items()]:
        section = _section(field.annotation)
        if section is not None:
            title = f"`[[{name}]]`" if get_origin(field.annotation) is tuple else f"`[{name}]`"
            pages[f"{name}.md"] = "\n".join(["#" + _table(title, section).removeprefix("##"), *_inner(name, section)])
            rows.append(f"| [{title}]({name}.md) | {_about(section)} |")
    tree = ["```{toctree}", ":maxdepth: 1", ":hidden:", "", *(page.removesuffix(".md") for page in pages), "```", ""]
    tables = ["## Tables", "", "| table | purpose |", "|-|-|", *rows, ""]
    return {"index.md": "\n".join([HEAD, *tree, *tables, _table("At the top", Patch, top=True)]), **pages}


def _about(section: type[Section]) -> str:
    about = (section.__doc__ or "").partition(": ")[2]
    return " ".join(f"{about[:1].upper()}{about[1:]}".split())


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
    about = "" if top else _about(section)
    rows = [
        f"## {title}\n",
        f"{about}\n" if about else "",
        "| key | value | default | meaning |",
        "|-|-|-|-|",
    ]
    texts = field_docs(section)
    for name, field in section.model_fields.items():
        if top and _section(field.annotation) is not None:
            continue
        text = " ".join((field.description or texts.get(name, "")).split())
        rows.append(f"| `{name}` | {_kind(field)} | {_default(field)} | {text} |")
    return "\n".join(row for row in rows if row) + "\n"


def _is_colour(metadata: Iterable[Any]) -> bool:
    return any(getattr(each, "func", None) is colour_value for each in metadata)


def _kind(field: FieldInfo) -> str:
    words = "colour" if _is_colour(field.metadata) else _type_words(field.annotation)
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
        if _is_colour(annotation.__metadata__):
            return "colour"
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
