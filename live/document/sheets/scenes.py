"""Scenes of a show: the stretches of measures that get a stage picture each, with words about what happens in them."""

import itertools
from dataclasses import dataclass
from math import ceil
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.document.sheets.show_record import FreeMotion, Led, ShowRecord

PHRASE: Final = 4
"""Measures of a scene where dancers move freely."""
LONGEST: Final = 8
"""Measures from which on a stretch is divided into phrases if somebody moves."""
MOVED_M: Final = 1.0
"""Somebody whose place changes by more than this has moved [m]; steps on the spot sway less."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A stretch of measures."""

    first: int
    """Its first measure, from 0."""
    end: int
    """The measure after its last."""
    led: tuple[Led, ...]
    """Segments that begin in it, then those that go on."""
    free: tuple[FreeMotion, ...]
    """Elements that act in it."""

    def beats(self, record: ShowRecord) -> tuple[float, float]:
        """Return its first danced beat, and the one after its last."""
        return float(self.first * record.beats), float(self.end * record.beats)


def calm_ways(record: ShowRecord, scene: Scene) -> Float64:
    """Return the ways of a scene without the sway of steps: means over a measure, and over less towards both ends,
    which stay as they are; (T, A, 2) [m], NaN for those off the stage."""
    rows = record.rows(scene.first, scene.end)
    place, there = record.place[rows].astype(np.float64), record.present[rows]
    half = int((rows.stop - rows.start) / (scene.end - scene.first) / 2)
    found = np.full_like(place, np.nan)
    whole = there.all(axis=0)
    found[:, whole] = _calm(place[:, whole], half)
    for dancer in np.flatnonzero(there.any(axis=0) & ~whole):
        seen = np.flatnonzero(there[:, dancer])
        stretch = slice(int(seen[0]), int(seen[-1]) + 1)
        found[stretch, dancer] = _calm(place[stretch, dancer], half)
    return found


def _calm(place: Float64, half: int) -> Float64:
    """Return running means over `half` samples on each side, fewer towards the ends, of (T, ..., 2)."""
    count = len(place)
    sums = np.concatenate([np.zeros_like(place[:1]), np.cumsum(place, axis=0)])
    at = np.arange(count)
    room = np.minimum(half, np.minimum(at, count - 1 - at))
    size = (2 * room + 1).reshape(-1, *[1] * (place.ndim - 1))
    return np.asarray((sums[at + room + 1] - sums[at - room]) / size)


def scenes_of(record: ShowRecord) -> list[Scene]:
    """Return the scenes of a show in order; together they are all of its measures."""
    bounds = {0, record.measures}
    bounds |= {number for number, one in enumerate(record.course.measures) if one.begins}
    for led in record.led:
        bounds |= {led.measure, _line(record, led.end, led.measure)}
    for free in record.free:
        bounds |= {int(free.begin // record.beats), ceil(free.end / record.beats - 1e-9)}
    kept = sorted(bound for bound in bounds if 0 <= bound <= record.measures)
    kept = _join(record, kept)
    found: list[Scene] = []
    for first, end in itertools.pairwise(kept):
        every = PHRASE if end - first > LONGEST and _moves(record, first, end) else end - first
        for begin in range(first, end, every):
            found.append(_scene(record, begin, min(begin + every, end)))
    return found


def _line(record: ShowRecord, beat: float, first: int) -> int:
    """Return the first measure line at or after a beat, later than that of the measure `first`."""
    return max(ceil(beat / record.beats - 1e-6), first + 1)


def _join(record: ShowRecord, bounds: list[int]) -> list[int]:
    """Leave out bounds with which nothing begins and after which nobody moves: the standing belongs to the arrival."""
    begins = {0, record.measures}
    begins |= {number for number, one in enumerate(record.course.measures) if one.begins}
    begins |= {led.measure for led in record.led} | {int(free.begin // record.beats) for free in record.free}
    kept = []
    for bound, after in zip(bounds, [*bounds[1:], record.measures], strict=True):
        if bound in begins or _moves(record, bound, after):
            kept.append(bound)
    return kept


def _moves(record: ShowRecord, first: int, end: int) -> bool:
    """Whether somebody's place changes between the lines of these measures."""
    lines = record.lines[first : end + 1]
    there = record.present[lines].all(axis=0)
    way = np.ptp(record.place[lines], axis=0)
    return bool((np.hypot(way[:, 0], way[:, 1])[there] > MOVED_M).any())


def _scene(record: ShowRecord, first: int, end: int) -> Scene:
    begin, over = first * record.beats, end * record.beats
    fresh = [led for led in record.led if first <= led.measure < end]
    going = [led for led in record.led if led.measure < first and led.end > begin + 1e-6]
    free = [one for one in record.free if one.begin < over - 1e-6 and one.end > begin + 1e-6]
    return Scene(first, end, (*fresh, *going), tuple(free))


def count_label(record: ShowRecord, beat: float) -> str:
    """Return a danced beat as measure and count, `3:2`; the measure as it is counted in its section."""
    beat = max(beat, 0.0)
    measure = min(int((beat + 1e-4) // record.beats), record.measures - 1)
    count = int(beat - measure * record.beats + 1e-4) + 1
    if count > record.beats:
        return f"the end of {record.course.measures[measure].number}"
    return f"{record.course.measures[measure].number}:{count}"


def measures_words(record: ShowRecord, scene: Scene) -> str:
    """Return the measures of a scene, as `measures 5-8` or `verse, measures 5-8, 2nd time`."""
    first, last = record.course.measures[scene.first], record.course.measures[scene.end - 1]
    one = scene.end - scene.first == 1
    numbers = str(first.number) if one else f"{first.number}–{last.number}"
    words = f"measure{'' if one else 's'} {numbers}"
    if not first.section:
        return words
    again = "" if first.time == 1 else f", {_ordinal(first.time)} time"
    return f"{first.section}, {words}{again}"


def _ordinal(number: int) -> str:
    ending = "th" if 10 <= number % 100 <= 20 else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"


def scene_title(scene: Scene) -> str:
    """Return what a scene shows in a few words: formations first."""
    begun = [led for led in scene.led if led.measure >= scene.first]
    names = list(dict.fromkeys(_short(led.words) for led in begun))
    if not names and scene.led:
        return f"{_short(scene.led[0].words)}, going on"
    if not names:
        names = list(dict.fromkeys(free.kind for free in scene.free))
    return ", ".join(names) or "steps"


def _short(words: str) -> str:
    return words.removeprefix("to ").removeprefix("hold ")


def scene_lines(record: ShowRecord, scene: Scene) -> list[str]:
    """Return what leads whom in a scene, and what else the score does in it, a line each."""
    lines = []
    for led in scene.led:
        who = f"{led.group}: " if led.group else ""
        more = ", going on" if led.measure < scene.first else ""
        lines.append(f"{who}{led.words}{more}, there at {arrival_label(record, led.end)}")
    for free in scene.free:
        who = f"{free.group}: " if free.group else ""
        going = "goes on, " if free.begin < scene.first * record.beats else ""
        lines.append(f"{who}free, {free.kind} ({going}until {arrival_label(record, free.end)})")
    if not lines:
        lines.append("no segment and no element: only their steps move them")
    begin, over = scene.beats(record)
    marks = [mark for mark in record.marks if begin <= mark.beat < over]
    lines += [f"{count_label(record, mark.beat)}  {mark.words}" for mark in marks]
    if record.course.measures[scene.end - 1].waits:
        section = record.course.measures[scene.end - 1].section
        lines.append(f"{section!r} repeats and waits for GO or a cue: then counts start again")
    return lines


def arrival_label(record: ShowRecord, beat: float) -> str:
    """Return the beat of an arrival; one on a measure line is that of the next measure."""
    if beat >= record.measures * record.beats - 1e-4:
        return "the end" if beat < record.measures * record.beats + 1e-4 else "after the end"
    here = record.course.measures[min(int((beat + 1e-4) // record.beats), record.measures - 1)]
    before = record.course.measures[max(ceil(beat / record.beats - 1e-4) - 1, 0)]
    if here.section != before.section or here.number < before.number:
        return f"the end of {before.number}"
    return count_label(record, beat)
