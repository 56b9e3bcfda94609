"""A take: what a show has danced in its last measures, as entries of a score (T016, T022).

The recorder watches a running show and changes nothing in it. Steps are what each group danced; formations, paths and
pauses become segments, elements stay elements, and other commands become calls at their beats.
"""

import dataclasses
import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from live.base.arrays import Bool
from live.base.element_kinds import FLOW_NAMES
from live.control.events import events, groups, motion, parameters, partners, scenes
from live.control.events.event import ControlEvent
from live.control.registry.command import controls_of
from live.control.registry.control import Control
from live.control.registry.registry import REGISTRY
from live.document.edit import Edit
from live.show.group.division import dancer_words
from live.show.patch.patch import Patch
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_score import RegroupSection, SegmentSection
from live.show.show import Show
from live.show.stages.now import Now

KEPT_MEASURES: Final = 1024
"""Number of past measures that are remembered."""
MAX_EVENTS: Final = 200
"""Maximum number of events kept of one measure."""
ON_THE_LINE: Final = 0.5
"""A movement that begins so many beats after a measure line begins with the measure."""
ENDLESS: Final = 100_000
"""Measures of a section for a score that had no end."""
SEGMENTS: Final = (events.Evolve, events.Travel, events.Pause)
SKIPPED: Final = (motion.Clear, motion.CallStep, motion.StepNow, motion.SetSequence, motion.AskWhy, groups.Performer)
"""Commands whose result the steps show, or that belong to the moment."""
CALL_MODULES: Final = tuple(module.__name__ for module in (groups, motion, parameters, partners, scenes))


@dataclass(slots=True)
class Heard:
    """An event, and the beat of its measure at which it acted, from 0."""

    beat: float
    event: ControlEvent


@dataclass(slots=True)
class DancedMeasure:
    """What was danced in one measure."""

    number: int
    """Of the show, from 0."""
    beats: int
    steps: dict[int, tuple[str, int, int]] = field(default_factory=dict)
    """Of each group: the step most of it danced, the measure of that step from 0, and its length in measures."""
    parts: dict[tuple[int, ...], tuple[str, int, int]] = field(default_factory=dict)
    """Likewise of dancers (from 1) with steps of their own."""
    heard: list[Heard] = field(default_factory=list)
    segments: Sequence[SegmentSection] = ()
    """Entries of the score that began with it."""
    elements: Sequence[ElementSection] = ()
    regroups: Sequence[RegroupSection] = ()

    @property
    def is_whole(self) -> bool:
        """Whether its steps are known."""
        return bool(self.steps or self.parts)


class TakeRecorder:
    """Remembers the last measures of a show. Thread: the show's."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self._measures: deque[DancedMeasure] = deque(maxlen=KEPT_MEASURES)

    def observe(self, event: ControlEvent, now: Now) -> None:
        """Note an event that the show has handled."""
        if not self._measures or type(event) in SKIPPED:
            return
        measure = self._measures[-1]
        place = min(max(now.span.fraction(now.beat), 0.0), 0.999) * now.measure_beats
        if isinstance(event, events.PlaceElement) and event.drag and self._drag(event):
            return
        if isinstance(event, events.SetParameter):
            for row, heard in enumerate(measure.heard):
                one = heard.event
                same = isinstance(one, events.SetParameter) and (one.address, one.group) == (event.address, event.group)
                if same and int(heard.beat) == int(place):  # a fader: its last value in each beat
                    measure.heard[row] = Heard(heard.beat, event)
                    return
        if len(measure.heard) < MAX_EVENTS and _is_kept(event):
            measure.heard.append(Heard(place, event))

    def _drag(self, event: events.PlaceElement) -> bool:
        """Move the last element of the same source, if it is still remembered."""
        for measure in reversed(self._measures):
            for row, heard in reversed(list(enumerate(measure.heard))):
                one = heard.event
                if isinstance(one, events.PlaceElement) and (one.source, one.kind) == (event.source, event.kind):
                    measure.heard[row] = Heard(heard.beat, dataclasses.replace(one, points=event.points))
                    return True
        return False

    def frame(self) -> None:
        """Note what is danced now; call once in each frame."""
        show = self._show
        number = show.span.number
        if number < 0:
            return
        if not self._measures or self._measures[-1].number != number:
            score = show.score_runner.score
            made = DancedMeasure(number, show.timeline.beats_per_measure)
            made.segments, made.elements = score.segments(number), score.elements(number)
            made.regroups = score.regroups(number)
            self._measures.append(made)
        measure = self._measures[-1]
        if not measure.is_whole and show.span.fraction(show.timeline.beat_at(show.time)) > 0.5:
            self._add_steps(measure)

    def _add_steps(self, measure: DancedMeasure) -> None:
        show, subgroup = self._show, self._show.scheduler.subgroups.of_dancer
        group, there = show.casting.group, show.motion.present[: len(subgroup)]
        for index in range(len(show.patch.group)):
            own = self._danced((group == index) & (subgroup < 0) & there)
            if own is not None:
                measure.steps[index] = own
        for place in range(len(show.scheduler.subgroups.active)):
            step = self._danced((subgroup == place) & there)
            if step is not None:
                measure.parts[tuple((np.flatnonzero(subgroup == place) + 1).tolist())] = step

    def _danced(self, who: Bool) -> tuple[str, int, int] | None:
        """Return what most of the dancers `who` (A,) dance; None if there are none."""
        library, node = self._show.graph.library, self._show.dancers.node[who]
        if not node.size:
            return None
        step = int(np.bincount(library.node_step[node]).argmax())
        one = int(node[library.node_step[node] == step][0])
        return library.steps[step], int(library.node_measure[one]), int(library.node_measures[one])

    def last(self, count: int) -> list[DancedMeasure]:
        """Return the last whole measures, at most `count`, the oldest first."""
        whole = [measure for measure in self._measures if measure.number < self._show.span.number and measure.is_whole]
        kept: list[DancedMeasure] = []
        for measure in reversed(whole):
            if len(kept) == count or (kept and kept[-1].number != measure.number + 1):
                break
            kept.append(measure)
        return kept[::-1]


def _is_kept(event: ControlEvent) -> bool:
    if isinstance(event, events.PlaceElement):
        return not event.fair
    return type(event).__module__ in CALL_MODULES


def keep_edits(take: Sequence[DancedMeasure], patch: Patch, name: str) -> list[Edit]:
    """Return the edits that add a take as a section `name` to a patch: its steps, segments, elements and calls."""
    edits = [] if patch.section else list(_whole_score_as_section(patch))
    edits.append(Edit("insert", ("section",), {"name": name, "measures": len(take)}))
    tables: list[tuple[str, dict[str, Any]]] = []
    for index, group in enumerate(patch.group):
        steps = list(_sequence([measure.steps.get(index) for measure in take]))
        if any(step != "*" for step in steps):
            tables.append(("sequence", {"group": group.name, "measure": 1, "steps": _repeated(steps)}))
    tables += _part_sequences(take)
    names = {group.name.casefold() for group in patch.group}
    segments: list[dict[str, Any]] = []
    for row, measure in enumerate(take):
        for section in measure.segments:
            segments.append(_moved(section, row + 1))
        tables += [("element", _moved(each, row + 1 + each.measure % 1.0)) for each in measure.elements]
        tables += [("regroup", _moved(each, row + 1)) for each in measure.regroups]
        for heard in measure.heard:
            kind, table = _table(heard, row, measure.beats, names)
            if kind == "segment":
                segments.append(table)
            elif kind:
                tables.append((kind, table))
    tables += [("segment", table) for table in _fitted(segments, len(take))]
    for kind, table in tables:
        if table["measure"] < len(take) + 1:
            edits.append(Edit("insert", (kind,), {"section": name, **table}))
    return edits


def _part_sequences(take: Sequence[DancedMeasure]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the sequences of dancers with steps of their own, one for each row of measures."""
    for dancers in sorted({dancers for measure in take for dancers in measure.parts}):
        danced = [measure.parts.get(dancers) for measure in take]
        row = 0
        while row < len(danced):
            first = row
            while row < len(danced) and danced[row] is not None:
                row += 1
            steps = list(_sequence(danced[first:row]))
            if any(step != "*" for step in steps):
                words = dancer_words(list(dancers))
                yield "sequence", {"group": words, "measure": first + 1, "steps": _repeated(steps)}
            row += 1


def _whole_score_as_section(patch: Patch) -> Iterator[Edit]:
    """Give a score without sections one that is all of it, so that the take can stand behind it."""
    names = {section.name.casefold() for section in patch.section}
    name = next(made for made in ("show", *(f"show {k}" for k in range(2, 100))) if made not in names)
    if patch.loop_measures is None:
        yield Edit("insert", ("section",), {"name": name, "measures": ENDLESS})
        return
    yield Edit("set", ("loop_measures",), None)
    yield Edit("insert", ("section",), {"name": name, "measures": patch.loop_measures, "wait": True})


def _sequence(danced: Sequence[tuple[str, int, int] | None]) -> Iterator[str]:
    """Yield the steps of a group, `*` for a measure of a step that was not danced whole."""
    row = 0
    while row < len(danced):
        first = danced[row]
        if first is None:
            row += 1
            yield "*"
            continue
        step, part, length = first
        whole = part == 0 and danced[row : row + length] == [(step, k, length) for k in range(length)]
        yield step if whole else "*"
        row += length if whole else 1


def _repeated(steps: Sequence[str]) -> list[str]:
    """Return steps with equal ones in a row written once: `groove x4`."""
    rows: list[list[Any]] = []
    for step in steps:
        if rows and rows[-1][0] == step and rows[-1][1] < 999:
            rows[-1][1] += 1
        else:
            rows.append([step, 1])
    return [step if count == 1 else f"{step} x{count}" for step, count in rows]


def _moved(section: SegmentSection | ElementSection | RegroupSection, measure: float) -> dict[str, Any]:
    table = section.model_dump(mode="json", exclude_unset=True)
    table.pop("section", None)
    return {**table, "measure": measure if isinstance(section, ElementSection) else int(measure)}


def _table(heard: Heard, row: int, beats: int, groups_: set[str]) -> tuple[str, dict[str, Any]]:
    """Return the list and the entry of an event in measure `row` of the take; an empty list for none."""
    event, line = heard.event, row + 1
    if isinstance(event, events.PlaceElement):
        begin = line + 1.0 if event.next else round(line + heard.beat / beats, 3)
        return "element", {**_element(event), "measure": begin}
    if isinstance(event, SEGMENTS) and (event.group.strip() in ("", "*") or event.group.casefold().strip() in groups_):
        early = not event.next and heard.beat <= ON_THE_LINE
        measures = max(1, math.ceil(event.measures - 1e-9)) + (1 if early else 0)
        return "segment", {**_segment(event), "measure": line if early else line + 1, "measures": measures}
    call = call_of(event)
    if call is None:
        return "", {}
    return "at", {"measure": line, "beat": round(1.0 + heard.beat, 3), "call": call[0], "values": call[1]}


def _element(event: events.PlaceElement) -> dict[str, Any]:
    points = [[round(value, 3) for value in point] for point in event.points]
    table: dict[str, Any] = {"kind": event.kind, "measures": event.measures}
    if len(points) > 2 or event.closed:
        table["points"] = points
    else:
        table["at"] = points[0]
        if len(points) > 1:
            table["to"] = points[1]
    rest = {"strength": event.strength, "radius": event.radius, "closed": event.closed, "whom": event.whom}
    defaults = {"strength": 1.0, "radius": 0.0, "closed": False, "whom": ""}
    table |= {key: value for key, value in rest.items() if value != defaults[key]}
    if event.flow in FLOW_NAMES:
        table["flow"] = event.flow
    return table | ({"group": event.group} if event.group.strip() not in ("", "*") else {})


def _segment(event: Any) -> dict[str, Any]:
    table: dict[str, Any] = {} if event.group.strip() in ("", "*") else {"group": event.group}
    if isinstance(event, events.Evolve):
        table["formation"] = event.formation
        if event.match != "squared":
            table["match"] = event.match
        if event.ripple:
            table["ripple_beats"] = event.ripple
    elif isinstance(event, events.Travel):
        table["path"] = [[round(value, 3) for value in point] for point in event.points]
        if event.single_file:
            table["single_file"] = True
    return table


def _fitted(segments: list[dict[str, Any]], count: int) -> list[dict[str, Any]]:
    """Return segments of which each ends where a later one takes its dancers, and with the take."""
    ordered = sorted(segments, key=lambda table: int(table["measure"]))
    kept: list[dict[str, Any]] = []
    for table in ordered:
        who = str(table.get("group", "*")).casefold()
        for before in list(kept):
            other = str(before.get("group", "*")).casefold()
            overlaps = "*" in (who, other) or who == other
            if overlaps and before["measure"] + before.get("measures", 4) > table["measure"]:
                before["measures"] = table["measure"] - before["measure"]
                if before["measures"] < 1:
                    kept.remove(before)
        kept.append(dict(table))
    for table in kept:
        table["measures"] = max(min(table.get("measures", 4), count + 1 - table["measure"]), 1)
    return kept


def call_of(event: ControlEvent) -> tuple[str, list[Any]] | None:
    """Return address and values of a control that makes this event; None if there is none."""
    candidates: Sequence[Control] = controls_of(type(event))
    if isinstance(event, events.SetParameter):
        found = REGISTRY.find(event.address)
        candidates = () if found is None else (found,)
    for control in candidates:
        values = _values(event, control)
        for length in range(len(values) + 1):  # without the values that are left out anyway
            made = control.call(values[:length], event.time, event.source)
            if made == event:
                return control.address, values[:length]
    return None


def _values(event: ControlEvent, control: Control) -> list[Any]:
    numbers = iter(event.value if isinstance(event, events.SetParameter) else ())
    values: list[Any] = []
    for argument in control.arguments:
        value = getattr(event, argument.name, None)
        if isinstance(event, events.SetParameter) and argument.name not in ("group", "measures"):
            value = next(numbers)
        if argument.type == "bool":
            value = bool(value)
        elif argument.type == "float":
            value = float(value or 0.0)
        elif isinstance(value, tuple):
            value = ", ".join(f"{x:g} {z:g}" for x, z in value)
        values.append(value)
    return values


def formation_table(name: str, spec: Any) -> dict[str, Any]:
    """Return a formation's spec as a table of a patch, without what it has anyway."""
    plain = type(spec)()
    table = {
        one.name: _plain(getattr(spec, one.name))
        for one in dataclasses.fields(spec)
        if one.name != "like" and getattr(spec, one.name) != getattr(plain, one.name)
    }
    table.pop("counts_ahead", None)
    kept = {key: value for key, value in table.items() if key != "name"}
    if spec.like is not None:
        return {"name": name} | kept | {"like": spec.like.name}
    return {"name": name, "shape": spec.shape} | kept


def _plain(value: Any) -> Any:
    return [_plain(each) for each in value] if isinstance(value, tuple) else value
