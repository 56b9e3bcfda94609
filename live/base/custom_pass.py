"""Custom render passes, written by users in GLSL: name, source text and parameters.

    uniform float speed;   // 0 4 1   how fast the waves go
    vec4 pass(vec2 at) { return vec4(light(at + 0.01 * sin(beat * speed)), 1.0); }

A uniform with a range in its comment is a parameter: lowest, highest and first value, then a description.
"""

import re
from dataclasses import dataclass
from typing import Final

from live.base.errors import PersonError

MOST_PASSES: Final = 4
"""Maximum number of custom passes in a patch."""
MOST_PARAMETERS: Final = 15
"""Maximum number of parameters of one pass."""
MOST_CHARACTERS: Final = 32_000
NUMBERS: Final = 1 + MOST_PARAMETERS
"""Numbers of one pass in the picture's row: its amount, then its parameters."""
NAME: Final = re.compile(r"[a-z][a-z0-9_]{0,31}")
"""Valid names of custom passes; each is also a file name and part of an address."""
ROOT: Final = "/dance/pass"

_UNIFORM: Final = re.compile(r"^\s*uniform\s+(\w+)\s+(\w+)\s*;\s*(?://\s*(.*))?$")
_PASS: Final = re.compile(r"\bvec4\s+pass\s*\(\s*vec2\b")
KNOWN: Final = frozenset(
    {
        "beat",
        "phase",
        "measure",
        "tempo",
        "energy",
        "time",
        "size",
        "amount",
        "light",
        "last",
        "depth",
        "normal",
        "dancer",
    }
)
"""Names that are predefined in every pass."""


@dataclass(frozen=True, slots=True)
class OwnParameter:
    """A parameter of a custom pass."""

    name: str
    low: float
    high: float
    start: float
    words: str


@dataclass(frozen=True, slots=True)
class OwnPass:
    """One custom pass."""

    name: str
    source: str
    """GLSL source."""
    parameters: tuple[OwnParameter, ...]


@dataclass(frozen=True, slots=True)
class OwnNumber:
    """Position of one number among the numbers of all custom passes, and its range."""

    place: int
    low: float
    high: float
    start: float


def read_own_pass(name: str, source: str) -> OwnPass:
    """Return the pass `name` with this source; PersonError names the fault and its line."""
    where = f"passes/{name}.glsl"
    if NAME.fullmatch(name) is None:
        raise PersonError(f"a pass cannot be called {name[:40]!r}", "small letters, digits and _ only, a letter first")
    if len(source) > MOST_CHARACTERS:
        raise PersonError(f"{where}: {len(source)} characters; a pass has at most {MOST_CHARACTERS}")
    if _PASS.search(source) is None:
        raise PersonError(f"{where}: no `vec4 pass(vec2 at)` in it", "that function gives light and how much of it")
    found: list[OwnParameter] = []
    for number, line in enumerate(source.splitlines(), start=1):
        match = _UNIFORM.match(line)
        if match is None:
            continue
        kind, called, comment = match.groups()
        found.append(_parameter(f"{where}, line {number}", kind, called, comment or ""))
        if [one.name for one in found].count(called) > 1:
            raise PersonError(f"{where}, line {number}: a second uniform {called!r}")
    if len(found) > MOST_PARAMETERS:
        raise PersonError(f"{where}: {len(found)} uniforms; a pass has at most {MOST_PARAMETERS}")
    return OwnPass(name, source, tuple(found))


def _parameter(where: str, kind: str, name: str, comment: str) -> OwnParameter:
    if kind != "float":
        raise PersonError(f"{where}: uniform {name!r} is a {kind}", "only `uniform float` can be set")
    if name in KNOWN:
        raise PersonError(f"{where}: {name!r} is predefined", "remove the line, or choose another name")
    words = comment.split(maxsplit=3)
    try:
        low, high, start = (float(word) for word in words[:3])
    except ValueError:
        low = high = start = float("nan")
    if not -1e6 <= low <= start <= high <= 1e6 or low == high:
        raise PersonError(
            f"{where}: uniform {name!r} has no range",
            f"write `uniform float {name};   // 0 1 0.5`: lowest, highest, first",
        )
    return OwnParameter(name, low, high, start, words[3] if len(words) > 3 else "")


def own_numbers(passes: tuple[OwnPass, ...]) -> dict[str, OwnNumber]:
    """Return all numbers of custom passes by address; the passes lie one behind the other."""
    numbers = {}
    for slot, one in enumerate(passes[:MOST_PASSES]):
        first = slot * NUMBERS
        numbers[f"{ROOT}/{one.name}"] = OwnNumber(first, 0.0, 1.0, 1.0)
        for index, known in enumerate(one.parameters, start=1):
            address = f"{ROOT}/{one.name}/{known.name}"
            numbers[address] = OwnNumber(first + index, known.low, known.high, known.start)
    return numbers
