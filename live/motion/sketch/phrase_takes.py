"""Takes: runs of measures of a sketched phrase that become separate steps with attributes (T042, T136).

A recorded dancer repeats a step several times with different begin and end poses. Likewise a sketch is one repeating
phrase with a `[[take]]` table for every run of measures that is a variation of the step.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from live.base.toml import KeyPath
from live.motion.sketch.sketch_attributes import ATTRIBUTES, read_attributes
from live.motion.step_clip import DIRECTIONS

MAX_TAKES: Final = 32
_FIELDS: Final = ("measures", *ATTRIBUTES)

ErrorFactory = Callable[[KeyPath, str, str], Exception]
"""Creates an error from the path of a field, the problem and the remedy."""


@dataclass(frozen=True, slots=True)
class Take:
    """A run of measures of the phrase."""

    first: int
    """First measure, from 0."""
    measures: int
    attributes: Mapping[str, Any]
    """Attributes that override those of the whole file (see `sketch_attributes`)."""


def read_takes(table: Mapping[str, Any], measures: int, error: ErrorFactory) -> tuple[Take, ...]:
    """Return the takes in the TOML `table` of a sketch of `measures` measures; raises `error(...)` for a wrong one."""
    rows = table.get("take", [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows) or len(rows) > MAX_TAKES:
        raise error(("take",), "is not a list of takes", f"write up to {MAX_TAKES} tables [[take]]")
    return tuple(_read_take(row, index, measures, error) for index, row in enumerate(rows))


def _read_take(row: Mapping[str, Any], index: int, measures: int, error: ErrorFactory) -> Take:
    def at(path: KeyPath, problem: str, remedy: str) -> Exception:
        return error(("take", index, *path), problem, remedy)

    for name in row:
        if name not in _FIELDS:
            raise at((name,), "unknown", f"fields of a take: {', '.join(_FIELDS)}")
    run = row.get("measures")
    pair = [run, run] if isinstance(run, int) else run
    whole = isinstance(pair, list) and len(pair) == 2 and all(type(value) is int for value in pair)
    if not isinstance(pair, list) or not whole or not 1 <= pair[0] <= pair[1] <= measures:
        remedy = f"the first and the last measure are needed, from 1 to {measures}, e.g. measures = [1, {measures}]"
        raise at(("measures",), f"read {run!r:.40}", remedy)
    return Take(pair[0] - 1, pair[1] - pair[0] + 1, read_attributes(row, at))


def read_directions(table: Mapping[str, Any], error: ErrorFactory) -> tuple[str, ...]:
    """Return the directions of T131 of the step, in the order of DIRECTIONS; all if none are given (T134)."""
    names = table.get("directions")
    if names is None:
        return DIRECTIONS
    if not isinstance(names, list) or not names or not all(name in DIRECTIONS for name in names):
        raise error(("directions",), f"read {names!r:.60}", f"a list of these is needed: {', '.join(DIRECTIONS)}")
    return tuple(name for name in DIRECTIONS if name in names)
