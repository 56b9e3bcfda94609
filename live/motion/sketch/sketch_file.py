"""Reader for sketches: dance steps written by hand in TOML with a few keys per measure.

The format is described in `patches/steps/README.md`; `live.motion.sketch.sketch_clips` converts sketches to clips.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from live.base.toml import KeyPath, error_line, line_of, parse_toml, toml_line_numbers
from live.motion.sketch.phrase_takes import Take, read_directions, read_takes
from live.motion.sketch.sketch_attributes import ATTRIBUTES, read_attributes
from live.motion.sketch.sketch_notation import PAIRS, PARTS, NotationError, Vocabulary, read_counts, read_phrases
from live.motion.step_clip import DIRECTIONS

MAX_BEATS: Final = 64
MAX_KEYS: Final = 100
MAX_TEXT: Final = 200_000
MIN_COUNT_INTERVAL: Final = 0.08
"""Minimum time between two counts of one part [beats]."""
LIMBS: Final = ("left_hand", "right_hand", "left_foot", "right_foot")
MIRRORED_CHANNELS: Final = frozenset({"left", "turn", "tilt"})
"""Channels of the trunk whose sign changes when mirrored."""


class SketchError(ValueError):
    """A sketch that cannot be used; the message is one line with file, line, field, problem and remedy."""

    def __init__(self, file: str, line: int, field: str, problem: str, remedy: str) -> None:
        super().__init__(f"{file}:{line}: {field}: {problem}; {remedy}")
        self.file = file
        self.line = line
        self.field = field
        self.problem = problem
        self.remedy = remedy


@dataclass(frozen=True, slots=True)
class Key:
    """The amounts of one part on one count."""

    beat: float
    """Beats from the start of the step, from 0."""
    amounts: Mapping[str, float]
    """Channel → metres, radians or 1 for a flag (see `sketch_notation`)."""
    line: int = 0


@dataclass(frozen=True, slots=True)
class Sketch:
    """One step as written. Distances in metres, `swing` and counts in beats."""

    name: str
    file: str
    beats: int = 4
    beats_per_measure: int = 4
    bpm: float = 112.0
    travels: bool = False
    directions: tuple[str, ...] = DIRECTIONS
    """Directions of a travelling step, among the nine; the mirrored step has the mirrored directions (T134)."""
    mirror: bool = True
    cyclic: bool = True
    short: float = 0.35
    """Metres per measure of the short directions (T131)."""
    long: float = 0.75
    """Metres per measure of the long directions (T131)."""
    bounce: float = 0.03
    """Lowering of the pelvis on each beat [m] if no line of [pelvis] has up or down."""
    swing: float = 0.7
    """Maximum duration of a swing to the next place [beats]."""
    late: float = 0.08
    """How late hands are at the places of their keys [beats]."""
    breath: float = 1.0
    """Depth of the breath, 1 as at rest."""
    attributes: Mapping[str, Any] = field(default_factory=dict)
    """Further attributes by the names of StepClip's fields (see `sketch_attributes`)."""
    takes: tuple[Take, ...] = ()
    """Runs of measures that are separate steps; if empty, the whole is one step."""
    parts: Mapping[str, tuple[Key, ...]] = field(default_factory=dict)
    """Part → its keys in the order of beats."""
    lines: Mapping[KeyPath, int] = field(default_factory=dict)

    def error(self, part: str, problem: str, remedy: str) -> SketchError:
        """Return an error with the line of `part` (a field or a table of the file)."""
        return SketchError(self.file, line_of(dict(self.lines), (part,)), part, problem, remedy)


_NUMBERS: Final[Mapping[str, tuple[float, float, float]]] = {
    # field: minimum, maximum, factor from the written value to the engine's unit
    "bpm": (30.0, 300.0, 1.0),
    "short": (0.05, 3.0, 1.0),
    "long": (0.05, 3.0, 1.0),
    "bounce": (0.0, 20.0, 0.01),
    "swing": (0.2, 2.0, 1.0),
    "late": (0.0, 0.5, 1.0),
    "breath": (0.0, 4.0, 1.0),
}
_WHOLES: Final = {"beats": (1, MAX_BEATS), "beats_per_measure": (1, 12)}
_SWITCHES: Final = ("travels", "mirror", "cyclic", "alternate")


def parse_sketch(text: str, file: str) -> Sketch:
    """Parse the TOML `text` of `file`; raises SketchError at the first error."""
    if len(text) > MAX_TEXT:
        raise SketchError(file, 1, "file", f"{len(text)} characters are too many", f"at most {MAX_TEXT}")
    try:
        table = parse_toml(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        problem, remedy = str(error).split("(at ")[0].strip(), "a line is word = value"
        if "overwrite" in problem or "twice" in problem:
            problem, remedy = "a word, count or table is written twice", "put it all on one line, or leave one out"
        raise SketchError(file, error_line(str(error), text), "TOML", problem, remedy) from None
    return _Reader(table, toml_line_numbers(text), file).sketch()


class _Reader:
    def __init__(self, table: dict[str, Any], lines: dict[KeyPath, int], file: str) -> None:
        self.table = table
        self.lines = lines
        self.file = file

    def sketch(self) -> Sketch:
        for name, value in self.table.items():
            self._check_name(name, value)
        attributes = read_attributes(self.table, self._error)
        sketch = Sketch(name=self._name(), file=self.file, lines=self.lines, attributes=attributes, **self._fields())
        if sketch.beats % sketch.beats_per_measure:
            remedy = f"make beats a multiple of beats_per_measure ({sketch.beats_per_measure})"
            raise self._error(("beats",), f"{sketch.beats} beats are not whole measures", remedy)
        alternate = bool(self.table.get("alternate", False))
        if alternate and sketch.beats % 2:
            raise self._error(("alternate",), "an odd number of beats has no halves", "make beats even")
        if alternate and "body" in self.table:
            remedy = "leave out alternate, or turn the pelvis and the chest only"
            raise self._error(("body",), "the whole body cannot turn in a step that alternates", remedy)
        sketch = replace(sketch, directions=self._directions(), takes=self._takes(sketch))
        parts = self._parts(sketch.beats / 2 if alternate else float(sketch.beats))
        if alternate:
            parts = _alternate_sides(parts, sketch.beats / 2)
            sketch = replace(sketch, attributes=_alternate_shapes(sketch.attributes, sketch.beats / 2))
        sketch = replace(sketch, parts={part: _merge_keys(keys) for part, keys in parts.items() if keys})
        self._check_keys(sketch)
        return sketch

    def _directions(self) -> tuple[str, ...]:
        if "directions" in self.table and self.table.get("travels") is not True:
            raise self._error(("directions",), "the step does not travel", "say travels = true, or leave it out")
        return read_directions(self.table, self._error)

    def _takes(self, sketch: Sketch) -> tuple[Take, ...]:
        takes = read_takes(self.table, sketch.beats // sketch.beats_per_measure, self._error)
        if takes and not sketch.cyclic:
            raise self._error(("take",), "a step that does not repeat has no takes", "leave out cyclic or the takes")
        if takes and "body" in self.table:
            remedy = "turn the pelvis and the chest only, or write a file for each"
            raise self._error(("body",), "the whole body cannot turn in a phrase of several takes", remedy)
        return takes

    def _error(self, path: KeyPath, problem: str, remedy: str) -> SketchError:
        name = ".".join(f'"{key}"' if " " in str(key) or "&" in str(key) else str(key) for key in path)
        return SketchError(self.file, line_of(self.lines, path), name, problem, remedy)

    def _check_name(self, name: str, value: object) -> None:
        fields = ["name", *_WHOLES, *_SWITCHES, *_NUMBERS, *ATTRIBUTES, "directions", "take"]
        tables = [*PARTS, *PAIRS]
        if name not in fields and name not in tables:
            raise self._error((name,), "unknown", f"fields: {', '.join(fields)}; parts: {', '.join(tables)}")
        if name in tables and not isinstance(value, dict):
            raise self._error((name,), "is a part of the body", f"write it as a table: [{name}]")

    def _name(self) -> str:
        name = self.table.get("name")
        if not isinstance(name, str) or not name.strip() or len(name) > 60 or not name.isprintable():
            raise self._error(("name",), f"read {name!r:.40}", 'give the step a name, e.g. name = "side step"')
        return name.strip()

    def _fields(self) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name, (least, most) in _WHOLES.items():
            value = self.table.get(name)
            if value is None:
                continue
            if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
                raise self._error((name,), f"read {value!r:.40}", f"a whole number from {least} to {most} is needed")
            values[name] = value
        for name, (low, high, factor) in _NUMBERS.items():
            value = self.table.get(name)
            if value is None:
                continue
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not math.isfinite(value) or not low <= value <= high:
                raise self._error((name,), f"read {value!r:.40}", f"a number from {low:g} to {high:g} is needed")
            values[name] = float(value) * factor
        for name in _SWITCHES:
            value = self.table.get(name)
            if value is not None and not isinstance(value, bool):
                raise self._error((name,), f"read {value!r:.40}", "true or false is needed")
            if value is not None and name != "alternate":
                values[name] = value
        return values

    def _parts(self, beats: float) -> dict[str, list[Key]]:
        parts: dict[str, list[Key]] = {}
        for table, lines in self.table.items():
            if table in PAIRS:
                targets = [f"{side}_{PAIRS[table]}" for side in ("left", "right")]
                words: Vocabulary = {
                    w: c for w, c in PARTS[targets[0]].items() if w.split()[-1] not in ("left", "right")
                }
            elif table in PARTS:
                targets, words = [table], PARTS[table]
            else:
                continue
            for count, value in lines.items():
                keys = self._line(table, count, value, words, beats)
                for part in targets:
                    self._add(parts.setdefault(part, []), keys, part, (table, count))
        return parts

    def _line(self, table: str, count: str, value: object, words: Vocabulary, beats: float) -> list[Key]:
        path = (table, count)
        if not isinstance(value, str):
            example = next(iter(words))
            raise self._error(path, f"read {value!r:.40}", f'write words in quotes, e.g. "{example} 5"')
        try:
            counts = read_counts(count, beats)
            amounts = read_phrases(value, table, words)
        except NotationError as error:
            raise self._error(path, error.problem, error.remedy) from None
        line = line_of(self.lines, path)
        return [Key(beat, amounts, line) for beat in counts]

    def _add(self, keys: list[Key], new: list[Key], part: str, path: KeyPath) -> None:
        for key in new:
            for old in keys:
                same = abs(old.beat - key.beat) < 1e-6
                if same and (part in LIMBS or set(old.amounts) & set(key.amounts)):
                    problem = f"count {key.beat + 1:g} of {part} is told twice (also on line {old.line})"
                    raise self._error(path, problem, "keep one of the two")
            keys.append(key)
        if len(keys) > MAX_KEYS:
            raise self._error(path, f"more than {MAX_KEYS} keys for {part}", "write fewer counts")

    def _check_keys(self, sketch: Sketch) -> None:
        for part, keys in sketch.parts.items():
            following = [*keys[1:], replace(keys[0], beat=keys[0].beat + sketch.beats)]
            for key, after in zip(keys, following, strict=True):
                if after.beat - key.beat < MIN_COUNT_INTERVAL:
                    problem = f"{part} has less than {MIN_COUNT_INTERVAL:g} beat between two counts"
                    raise SketchError(sketch.file, after.line, part, problem, "leave one of them out")
            early, late = keys[0].beat < 0.25, keys[-1].beat > sketch.beats - 0.25
            if not sketch.cyclic and (early or late):
                problem = "a step that is not cyclic begins and ends in the neutral stance"
                remedy = f'keep to the counts from "1e" to "{sketch.beats}a"'
                raise SketchError(sketch.file, keys[0 if early else -1].line, part, problem, remedy)
        body = sketch.parts.get("body", ())
        if body and body[0].beat == 0.0 and body[0].amounts["turn"] != 0.0:
            problem = "a step begins facing the front"
            raise SketchError(sketch.file, body[0].line, "body", problem, "let the first turn come after count 1")
        if sketch.travels:
            self._check_travel(sketch)

    def _check_travel(self, sketch: Sketch) -> None:
        body = sketch.parts.get("body", ())
        if body and abs(math.remainder(body[-1].amounts["turn"], 2.0 * math.pi)) > 1e-6:
            problem = "a step that travels must face the front again at its end"
            raise SketchError(sketch.file, body[-1].line, "body", problem, "turn by 0 or 360, or leave out travels")
        if not sketch.cyclic:
            raise self._error(("cyclic",), "a step that travels must repeat", "leave out cyclic or travels")
        for part in ("left_foot", "right_foot"):
            keys = sketch.parts.get(part, ())
            leaves = any({"up", "lift"} & set(key.amounts) for key in keys)
            places = {tuple(key.amounts.get(word, 0.0) for word in ("out", "forward", "turn")) for key in keys}
            if not leaves and len(places) < 2:
                problem = f"{part} never leaves the floor, so the step cannot travel"
                raise self._error(("travels",), problem, 'lift it once, e.g. "2" = "home, lift 4"')


def _merge_keys(keys: list[Key]) -> tuple[Key, ...]:
    """Return the keys sorted by beat; keys of the same count are merged."""
    merged: list[Key] = []
    for key in sorted(keys, key=lambda key: key.beat):
        if merged and key.beat - merged[-1].beat < 1e-6:
            merged[-1] = replace(merged[-1], amounts={**merged[-1].amounts, **key.amounts})
        else:
            merged.append(key)
    return tuple(merged)


def _alternate_shapes(attributes: Mapping[str, Any], half: float) -> dict[str, Any]:
    """Return the attributes with the hand shapes of the first half followed by the same mirrored, unless the second
    half has its own."""
    hands = attributes.get("hands", ())
    if not hands or hands[-1][0] >= half:
        return dict(attributes)
    return {**attributes, "hands": hands + tuple((beat + half, right, left) for beat, left, right in hands)}


def _alternate_sides(parts: dict[str, list[Key]], half: float) -> dict[str, list[Key]]:
    """Return the keys of the first half followed by the same keys mirrored."""
    whole: dict[str, list[Key]] = {part: list(keys) for part, keys in parts.items()}
    for part, keys in parts.items():
        side, _, limb = part.partition("_")
        other = {"left": f"right_{limb}", "right": f"left_{limb}"}.get(side, part)
        for key in keys:
            amounts = dict(key.amounts)
            if other == part:
                amounts = {name: -value if name in MIRRORED_CHANNELS else value for name, value in amounts.items()}
            whole.setdefault(other, []).append(Key(key.beat + half, amounts, key.line))
    return whole
