"""Names of the built-in render passes; custom ones, written by users in GLSL: name, source text and parameters.

    uniform float speed;   // 0 4 1   how fast the waves go
    vec4 pass(vec2 at) { return vec4(light(at + 0.01 * sin(beat * speed)), 1.0); }

A uniform with a range in its comment is a parameter: lowest, highest and first value, then a description.
"""

import re
from dataclasses import dataclass
from typing import Final

from live.base.errors import PersonError

PASSES: Final = ("shadow", "mirror", "focus", "blur", "trails", "bloom", "ink", "grade", "vignette")
"""The built-in passes in drawing order."""
MAX_PASSES: Final = 4
"""Maximum number of custom passes in a patch."""
MAX_PARAMETERS: Final = 15
"""Maximum number of parameters of one pass."""
MAX_SOURCE_LENGTH: Final = 32_000
NUMBERS_PER_PASS: Final = 1 + MAX_PARAMETERS
"""Numbers of one pass in the picture's row: its amount, then its parameters."""
NAME: Final = re.compile(r"[a-z][a-z0-9_]{0,31}")
"""Valid names of custom passes; each is also a file name and part of an address."""
PASS_ADDRESS: Final = "/dance/pass"

_UNIFORM: Final = re.compile(r"^\s*uniform\s+(\w+)\s+(\w+)\s*;\s*(?://\s*(.*))?$")
_PASS: Final = re.compile(r"\bvec4\s+pass\s*\(\s*vec2\b")
PREDEFINED_NAMES: Final = frozenset(
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
class CustomPassParameter:
    """A parameter of a custom pass."""

    name: str
    low: float
    high: float
    start: float
    description: str


@dataclass(frozen=True, slots=True)
class CustomShader:
    """One custom pass."""

    name: str
    source: str
    """GLSL source."""
    parameters: tuple[CustomPassParameter, ...]


@dataclass(frozen=True, slots=True)
class CustomPassNumber:
    """Position of one number among the numbers of all custom passes, and its range."""

    index: int
    low: float
    high: float
    start: float


def parse_custom_pass(name: str, source: str) -> CustomShader:
    """Return the pass `name` with this source; PersonError names the fault and its line."""
    where = f"passes/{name}.glsl"
    if NAME.fullmatch(name) is None:
        raise PersonError(f"a pass cannot be called {name[:40]!r}", "small letters, digits and _ only, a letter first")
    if len(source) > MAX_SOURCE_LENGTH:
        raise PersonError(f"{where}: {len(source)} characters; a pass has at most {MAX_SOURCE_LENGTH}")
    if _PASS.search(source) is None:
        raise PersonError(f"{where}: no `vec4 pass(vec2 at)` in it", "that function gives light and how much of it")
    found: list[CustomPassParameter] = []
    for number, line in enumerate(source.splitlines(), start=1):
        match = _UNIFORM.match(line)
        if match is None:
            continue
        kind, called, comment = match.groups()
        found.append(_parameter(f"{where}, line {number}", kind, called, comment or ""))
        if [one.name for one in found].count(called) > 1:
            raise PersonError(f"{where}, line {number}: a second uniform {called!r}")
    if len(found) > MAX_PARAMETERS:
        raise PersonError(f"{where}: {len(found)} uniforms; a pass has at most {MAX_PARAMETERS}")
    return CustomShader(name, source, tuple(found))


def _parameter(where: str, kind: str, name: str, comment: str) -> CustomPassParameter:
    if kind != "float":
        raise PersonError(f"{where}: uniform {name!r} is a {kind}", "only `uniform float` can be set")
    if name in PREDEFINED_NAMES:
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
    return CustomPassParameter(name, low, high, start, words[3] if len(words) > 3 else "")


def custom_pass_numbers(passes: tuple[CustomShader, ...]) -> dict[str, CustomPassNumber]:
    """Return all numbers of custom passes by address; the passes lie one behind the other."""
    numbers = {}
    for slot, one in enumerate(passes[:MAX_PASSES]):
        first = slot * NUMBERS_PER_PASS
        numbers[f"{PASS_ADDRESS}/{one.name}"] = CustomPassNumber(first, 0.0, 1.0, 1.0)
        for index, known in enumerate(one.parameters, start=1):
            address = f"{PASS_ADDRESS}/{one.name}/{known.name}"
            numbers[address] = CustomPassNumber(first + index, known.low, known.high, known.start)
    return numbers
