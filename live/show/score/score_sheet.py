"""Score sheet of a patch: boxes over measures for sections, signals, steps, motion and calls (T015)."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np

from live.base.arrays import Bool
from live.show.patch.section_score import SegmentSection
from live.show.score.canon import StepSource
from live.show.score.playhead import END
from live.show.score.section_span import score_length
from live.show.show import Show

DEFAULT_MEASURES: Final = 16
"""Measures drawn of a score without entries."""
MAX_MEASURES: Final = 20_000
"""Maximum number of measures drawn."""
Kind = Literal["section", "signal", "sequence", "improvised", "own", "segment", "element", "regroup", "call"]
NO_NODES: Final = np.zeros(0, np.int32)


@dataclass(frozen=True, slots=True)
class Box:
    """A labelled span of measures in the written score."""

    first: int
    """From 0."""
    last: int
    label: str
    kind: Kind


@dataclass(frozen=True, slots=True)
class Track:
    """A row of boxes."""

    name: str
    boxes: tuple[Box, ...]
    group: int = -1
    """Group of the row; -1 for none."""
    depth: int = 0
    """How far it is within others: 1 for a part of a group, 2 for a part of that one."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A whole written score, each section once."""

    title: str
    measures: int
    tracks: tuple[Track, ...]

    def as_json(self) -> dict[str, Any]:
        """Return plain values for programs; measures count from 1."""
        return {
            "title": self.title,
            "measures": self.measures,
            "tracks": [
                {
                    "name": track.name,
                    "depth": track.depth,
                    "boxes": [
                        {"first": box.first + 1, "last": box.last + 1, "kind": box.kind, "words": box.label}
                        for box in track.boxes
                    ],
                }
                for track in self.tracks
            ],
        }


def build_sheet(show: Show) -> Sheet:
    """Return the score of a fresh show, which is used up. Random choices are shown as if all steps were reachable."""
    length = min(_length(show), MAX_MEASURES)
    show.playhead.loop((0, length - 1))
    steps, subgroups, others = _steps(show, length)
    patch = show.patch
    tracks = [Track("section", _sections(show, length)), Track("signals", tuple(others["signals"]))]
    below = _subgroup_tracks(show, subgroups)
    for index, (section, boxes) in enumerate(zip(patch.group, steps, strict=True)):
        tracks += [Track(section.name, tuple(boxes), index), *(track for track in below if track.group == index)]
    tracks += [track for track in below if track.group < 0]
    tracks += [Track(name, tuple(others[name])) for name in ("motion", "calls")]
    kept = [track for track in tracks if track.boxes]
    return Sheet(patch.name, length, tuple(kept))


def _length(show: Show) -> int:
    """Return the measures of the written score; if it has no end, up to the end of the last entry."""
    length = score_length(show.patch)
    if length is not None:
        return length
    last = DEFAULT_MEASURES
    patch = show.patch
    placed: tuple[Iterable[Any], ...] = (patch.element, patch.segment, patch.regroup, patch.sequence, patch.at,
                                         patch.signal, patch.improvise)  # fmt: skip
    for entries in placed:
        for entry in entries:
            if entry.measure is not None:
                last = max(last, int(entry.measure - 1 + (getattr(entry, "measures", None) or 1)))
    return last


def _sections(show: Show, length: int) -> tuple[Box, ...]:
    boxes, first = [], 0
    for section in show.patch.section:
        again = f"x{section.repeat}" if section.repeat > 1 else ""
        if section.wait or not section.repeat:  # GO leaves it only if the standby cue jumps elsewhere
            again = "until advance"
        after = f"then {section.then}" if section.then is not None else ""
        words = ", ".join(word for word in (section.name, again, after) if word)
        boxes.append(Box(first, first + section.measures - 1, words, "section"))
        first += section.measures
    return tuple(boxes) or (Box(0, length - 1, show.patch.name, "section"),)


def _subgroup_tracks(show: Show, rows: list[list[Box]]) -> list[Track]:
    """Return a track for each selection with steps in the score that is no group, each below what it is a part of."""
    found = []
    for written, boxes in zip(show.scheduler.subgroups.written, rows, strict=True):
        who = show.casting.possible(written[0].words)
        groups = np.unique(show.group[who])
        found.append((who, Track(written[0].words, tuple(boxes), int(groups[0]) if len(groups) == 1 else -1)))
    found.sort(key=lambda one: -int(one[0].sum()))  # larger ones first: what holds a part comes before it
    tracks: list[tuple[Bool, Track]] = []
    for who, track in found:
        holds = [
            place
            for place, (other, above) in enumerate(tracks)
            if above.group == track.group and not (who & ~other).any() and other.sum() > who.sum()
        ]
        if not holds:
            tracks.append((who, replace(track, depth=int(track.group >= 0))))
            continue
        depth = tracks[holds[-1]][1].depth + 1
        place = holds[-1] + 1
        while place < len(tracks) and tracks[place][1].depth >= depth:
            place += 1
        tracks.insert(place, (who, replace(track, depth=depth)))
    return [track for _, track in tracks]


def _steps(show: Show, length: int) -> tuple[list[list[Box]], list[list[Box]], dict[str, list[Box]]]:
    """Return the steps of each group, of each selection with steps, and all other boxes, measure by measure."""
    steps: list[list[Box]] = [[] for _ in show.patch.group]
    subgroups: list[list[Box]] = [[] for _ in show.scheduler.subgroups.written]
    others: dict[str, list[Box]] = {"signals": [], "motion": [], "calls": []}
    for measure in range(length):
        show.playhead.begin_measure(measure)
        for index in show.scheduler.order:
            programme = show.scheduler.programmes[index]
            _add_step(show, steps[index], measure, programme)
        for row, boxes in zip(show.scheduler.subgroups.written, subgroups, strict=True):
            part = row[0].program.part
            if part is not None and part.entry(measure) is not None:
                _add_step(show, boxes, measure, row[0].program)
        _add_boxes(show, measure, length, others)
    return steps, subgroups, others


def _add_step(show: Show, row: list[Box], measure: int, programme: StepSource) -> None:
    step = programme.step_for(measure, NO_NODES)
    name = "*" if step < 0 else show.graph.library.steps[step]
    kind = programme.part_kind(measure)
    last = row[-1] if row and row[-1].last == measure - 1 else None
    if last is not None and last.label == name and last.kind == kind and _same_section(show, measure):
        row[-1] = Box(last.first, measure, name, kind)
    else:
        row.append(Box(measure, measure, name, kind))


def _same_section(show: Show, measure: int) -> bool:
    before, now = show.playhead.place(measure - 1), show.playhead.place(measure)
    return before.section == now.section != END


def _add_boxes(show: Show, measure: int, length: int, rows: dict[str, list[Box]]) -> None:
    score, beats = show.score_runner.score, show.patch.clock.beats_per_measure
    for signal in score.signals(measure):
        rows["signals"].append(Box(measure, measure, _with_beat(signal.name, signal.beat), "signal"))
    for segment in score.segments(measure):
        rows["motion"].append(
            Box(measure, min(measure + segment.measures, length) - 1, _segment_words(segment), "segment")
        )
    for element in score.elements(measure):
        beat = (element.measure - int(element.measure)) * beats + 1.0
        last = int(np.ceil(element.measure - int(element.measure) + element.measures)) + measure - 1
        words = _with_beat(element.kind + _group_suffix(element.group), beat)
        rows["motion"].append(Box(measure, min(last, length - 1), words, "element"))
    for regroup in score.regroups(measure):
        rows["motion"].append(Box(measure, measure, f"{regroup.dancers} to {regroup.group}", "regroup"))
    for call in score.calls(measure):
        if call.signal is not None:
            rows["signals"].append(Box(measure, measure, _with_beat(call.signal, call.beat), "signal"))
        else:
            said = call.call or f"scene {call.scene}"
            words = " ".join([said.removeprefix("/dance/"), *(_value(value) for value in call.values)])
            rows["calls"].append(Box(measure, measure, _with_beat(words, call.beat), "call"))


def _segment_words(segment: SegmentSection) -> str:
    what = segment.formation or segment.evolution or ("travel" if segment.path is not None else "pause")
    return ("hold " if segment.hold else "") + what + _group_suffix(segment.group)


def _group_suffix(group: str) -> str:
    return "" if group.strip() in ("", "*") else f" ({group})"


def _value(value: str | float | bool) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _with_beat(words: str, beat: float) -> str:
    return words if beat == 1.0 else f"{words} @{beat:g}"
