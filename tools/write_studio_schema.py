"""Write studio/src/model/schema.json, from which the studio makes its forms, from the schema of patches; `--check` only
compares.

Of each kind of entry it has the fields in the order of the form: key, words, kind of control, limits, choices, default
and help. Which keys come first, and which are dancers or names of other entries, is in the tables below; everything
else follows from the schema.
"""

import json
import re
import sys
from pathlib import Path
from typing import Any, Final

from live.show.patch.patch_schema import patch_schema

OUT: Final = Path(__file__).resolve().parents[1] / "studio" / "src" / "model" / "schema.json"

FIRST: Final[dict[str, tuple[str, ...]]] = {
    "segment": ("measure", "measures", "group", "formation", "path", "match", "facing", "mirror", "beats_later"),
    "sequence": ("measure", "measures", "group", "steps", "choose"),
    "improvise": ("measure", "measures", "group", "steps", "at_least", "most", "phrase"),
    "element": ("kind", "measure", "measures", "group", "at", "to", "radius", "strength", "flow", "whom"),
    "signal": ("name", "measure", "beat", "on", "curve", "level"),
    "curve": ("name", "measure", "points"),
    "at": ("measure", "beat", "signal", "scene", "call", "values"),
    "regroup": ("measure", "dancers", "group"),
    "section": ("name", "measures", "repeat", "wait", "then"),
    "cue": ("name", "number", "text", "when", "count_in", "scene", "section", "then", "after"),
    "group": ("name", "dancers", "colour", "formation", "steps", "like", "beats_later", "mirrored", "soloists"),
    "gate": ("name", "at", "width"),
    "obstacle": ("name", "at", "radius", "wall_to"),
    "item": (),
    "view": (),
    "scene": ("name",),
    "react": (),
    "stage": ("width", "depth"),
    "clock": ("bpm", "beats_per_measure", "tempo_range"),
    "music": ("file", "bpm", "one_at_s"),
    "": ("name", "loop_measures", "seed", "reserve"),
}
"""Kinds of entries, "" for the keys at the top, and the keys that are always shown; all others are folded."""
ONLY: Final = ("clock", "music", "")
"""Of these only the keys above are in a form."""
NAMES: dict[tuple[str, str], str] = {
    ("segment", "group"): "dancers", ("sequence", "group"): "dancers", ("improvise", "group"): "dancers",
    ("element", "group"): "dancers", ("regroup", "dancers"): "dancers", ("regroup", "group"): "group",
    ("segment", "formation"): "formation", ("group", "formation"): "formation", ("group", "like"): "group",
    ("group", "travel_step"): "step", ("signal", "curve"): "curve", ("at", "signal"): "signal",
    ("at", "scene"): "scene",
    ("cue", "scene"): "scene", ("section", "then"): "section", ("sequence", "steps"): "steps",
    ("group", "steps"): "steps", ("element", "whom"): "dancers",
}  # fmt: skip
"""Texts that are dancers, steps, or the name of an entry of a list."""
NAMES |= {(kind, "section"): "section" for kind in FIRST if kind != "section"}
WORDS: Final = {
    "at": "place", "to": "to", "wall_to": "wall to", "bpm": "tempo", "one_at_s": "first beat", "file": "file",
    "beats_per_measure": "beats a measure", "beats_later": "later by", "ripple_beats": "ripple",
    "loop_measures": "length",
    "on": "when the music is", "then": "then", "most": "at most", "headings_deg": "headings", "like": "does what",
    "facing": "heading", "match": "who goes where", "way": "where ways cross", "call": "control",
}  # fmt: skip
"""Words of keys whose name says too little."""
UNITS: Final = (
    (r"_s$", "s"), (r"_deg$", "°"), (r"(^|_)measures?$", ""), (r"_beats$|^beats_later$|^count_in$", "beats"),
    (r"^bpm$", "bpm"),
    (r"^(width|depth|radius|centre|size|at|to|wall_to|arm_length)$", "m"),
)  # fmt: skip


def studio_schema() -> dict[str, list[dict[str, Any]]]:
    """Return the fields of each kind of entry."""
    schema = patch_schema()
    found = {}
    for kind, first in FIRST.items():
        properties, required = _properties(schema, kind)
        keys = [*first, *(key for key in properties if key not in first and kind not in ONLY)]
        found[kind] = [
            _field(kind, key, properties[key], required=key in required, folded=bool(first) and key not in first)
            for key in keys
            if key in properties
        ]
    return found


def _properties(schema: dict[str, Any], kind: str) -> tuple[dict[str, Any], list[str]]:
    told = schema if not kind else schema["properties"][kind]
    told = told.get("items", told)
    for part in (told, *told.get("allOf", ())):
        if "$ref" in part:
            told = schema["definitions"][part["$ref"].rsplit("/", 1)[1]]
    return told["properties"], told.get("required", [])


def _field(kind: str, key: str, told: dict[str, Any], *, required: bool, folded: bool) -> dict[str, Any]:
    unit = next((unit for pattern, unit in UNITS if re.search(pattern, key)), "")
    field: dict[str, Any] = {
        "key": key,
        "words": WORDS.get(key, re.sub(r"_(s|deg|beats)$", "", key).replace("_", " ")),
        "control": _control(kind, key, told),
        "help": _help(told.get("description", "")),
    }
    if unit:
        field["unit"] = unit
    if "default" in told:
        field["default"] = told["default"]
    if "enum" in told:
        field["choices"] = told["enum"]
    least, most = told.get("minimum", told.get("exclusiveMinimum")), told.get("maximum", told.get("exclusiveMaximum"))
    field |= {name: value for name, value in (("least", least), ("most", most)) if value is not None}
    field |= {name: True for name, value in (("required", required), ("folded", folded)) if value}
    return field


def _control(kind: str, key: str, told: dict[str, Any]) -> str:
    """Return the control of a field."""
    if (kind, key) in NAMES:
        return NAMES[kind, key]
    if "enum" in told:
        return "choice"
    if key == "colour":
        return "colour"
    if key in ("points", "path") and told.get("type") == "array":
        return "line"
    if any(one.get("type") == "boolean" for one in told.get("anyOf", ())) and kind == "segment":
        return "switch"
    match told.get("type"):
        case "boolean":
            return "switch"
        case "integer" | "number" as number:
            return str(number)
        case "string":
            return "text"
        case "array" if isinstance(told.get("items"), list) and len(told["items"]) == 2:
            return "pair"
        case "array" if isinstance(told.get("items"), dict) and told["items"].get("type") == "string":
            return "texts"
        case "array" if isinstance(told.get("items"), dict) and told["items"].get("type") in ("number", "integer"):
            return "numbers"
    return "json"


def _help(words: str) -> str:
    """Return a description for people: without marks of code and numbers of tasks."""
    return re.sub(r" \(T\d+\)", "", words).replace("`", "").replace("[m]", "in metres")


def text() -> str:
    """The whole file."""
    return json.dumps(studio_schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    made = text()
    if "--check" in sys.argv:
        sys.exit(0 if OUT.read_text(encoding="utf-8") == made else f"{OUT} is old: python tools/write_studio_schema.py")
    OUT.write_text(made, encoding="utf-8")
