"""Step attributes in a sketch besides the motion: structure (T135, T136), author, style, tags (T040), mood (T143), hand
shapes."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from live.base.body.hand_shapes import AUTO, SHAPE_NAMES
from live.base.motion_parameters import MOOD_NAMES
from live.base.toml import KeyPath

WORDS: Final = ("begin_pose", "end_pose", "author", "style")
ATTRIBUTES: Final = (
    "leading_foot", "weight_transfer", "begin_pose", "end_pose", "author", "style", "tags", "mood", "hand_shape",
)  # fmt: skip
MAX_WORD: Final = 64
MAX_TAGS: Final = 64


def read_attributes(table: Mapping[str, Any], error: Callable[[KeyPath, str, str], Exception]) -> dict[str, Any]:
    """Return the attributes in the TOML `table` of a sketch as StepClip fields; raises `error(...)` for a wrong one.

    `error` takes the path of the field, the problem and the remedy.
    """
    values: dict[str, Any] = {}
    for name in ATTRIBUTES:
        value = table.get(name)
        if value is None:
            continue
        if name == "leading_foot" and value not in ("left", "right"):
            raise error((name,), f"read {value!r:.40}", 'write "left" or "right"')
        if name == "weight_transfer" and not isinstance(value, bool):
            raise error((name,), f"read {value!r:.40}", "true or false is needed")
        if name in WORDS and not _is_word(value):
            raise error((name,), f"read {value!r:.40}", f"a text of 1 to {MAX_WORD} characters is needed")
        if name == "tags":
            if not isinstance(value, list) or len(value) > MAX_TAGS or not all(map(_is_word, value)):
                remedy = f'write at most {MAX_TAGS} words in brackets: tags = ["slow", "low"]'
                raise error((name,), f"read {value!r:.40}", remedy)
            value = tuple(value)
        if name == "mood":
            value = _mood(value, error)
        if name == "hand_shape":
            try:
                values["hands"] = hand_shapes(value)
            except ValueError as problem:
                raise error((name,), str(problem), SHAPE_HELP) from None
            continue
        values[name] = value
    return values


def mood_values(mood: Mapping[str, float]) -> tuple[float, ...]:
    """Return a mood in the order of MOOD_NAMES, () for none."""
    return tuple(float(mood.get(name, 0.0)) for name in MOOD_NAMES) if any(mood.values()) else ()


SHAPE_HELP: Final = (
    f'write hand_shape = "ballet", or what changes on a beat: [{{ beat = 1, left = "fist" }}, {{ beat = 3, both = '
    f'"open" }}]; shapes are {", ".join(SHAPE_NAMES)}, and {AUTO} for no shape'
)
MAX_SHAPES: Final = 64


def hand_shapes(value: object) -> tuple[tuple[float, str, str], ...]:
    """Return what a step's `hand_shape` says as `StepClip.hands`: a shape of both hands, or a list of changes.

    Each change has a `beat`, from 1, and a shape of the `left`, the `right` hand or `both`. ValueError if it is wrong.
    """
    rows = [{"beat": 1, "both": value}] if isinstance(value, str) else value
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows) or len(rows) > MAX_SHAPES:
        raise ValueError(f"read {value!r:.60}")
    known, now = {AUTO: "", **{name: name for name in SHAPE_NAMES}}, ["", ""]
    found: list[tuple[float, str, str]] = []
    for row in rows:
        for key, word in row.items():
            if key not in ("beat", "left", "right", "both") or (key != "beat" and word not in known):
                raise ValueError(f"read {key} = {word!r:.40}")
        beat = row.get("beat", 1)
        if isinstance(beat, bool) or not isinstance(beat, int | float) or not 1.0 <= beat <= 1000.0:
            raise ValueError(f"read beat = {beat!r:.40}, a number from 1 expected")
        if found and beat - 1.0 <= found[-1][0]:
            raise ValueError(f"beat {beat:g} does not come after beat {found[-1][0] + 1.0:g}")
        for side, key in enumerate(("left", "right")):
            now[side] = known[row.get(key, row.get("both", now[side] or AUTO))]
        found.append((float(beat) - 1.0, now[0], now[1]))
    return tuple(found)


def _mood(value: object, error: Callable[[KeyPath, str, str], Exception]) -> tuple[float, ...]:
    words = f"{', '.join(MOOD_NAMES)}, each from -1 to 1: mood = {{ energy = -1 }}"
    if not isinstance(value, dict):
        raise error(("mood",), f"read {value!r:.40}", f"write a table of {words}")
    for name, number in value.items():
        if name not in MOOD_NAMES:
            raise error(("mood", name), "unknown", f"moods are {words}")
        if isinstance(number, bool) or not isinstance(number, int | float) or not -1.0 <= number <= 1.0:
            raise error(("mood", name), f"read {number!r:.40}", f"moods are {words}")
    return mood_values(value)


def _is_word(value: object) -> bool:
    return isinstance(value, str) and len(value.strip()) > 0 and len(value) <= MAX_WORD and value.isprintable()
