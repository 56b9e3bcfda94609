"""Steps of seen performers: recognised at the measure line, answered by dancers, and learnt.

A measure is read twice: two beats before its end, early enough for dancers to answer in the next measure, and as a
whole when it is over, for the status and for canons. What is to be learnt becomes a `Take`; outside of the show a
thread makes a step of it (`learnt_step.py`), and StepsChanged brings it into the graph.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.event import ControlEvent
from live.graph.step_library import StepLibrary
from live.motion.editing.path_bend import source_name
from live.motion.recognition.step_recognition import (
    MIN_MOTION,
    RecognisedStep,
    StepTemplates,
    is_seen,
    motion_of,
)
from live.show.capture.danced_poses import LEAD_OUT_BEATS, DancedPoses, Take, empty_take
from live.show.desk.refusals import Refusals
from live.show.patch.patch import Patch
from live.show.patch.section_capture import AnswerSection
from live.show.patch.section_io import DEFAULT_PERFORMER
from live.show.patch.section_motion import parse_entry
from live.show.score.step_names import UnknownStep, find_step, step_measures
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion

EARLY_BEATS: Final = 1.85
"""Beats before the measure line at which a step is answered in the next measure: just before that one is planned."""
UNHEARD_BEATS: Final = 2
"""Whole beats of the measure that are not heard then."""
LATE_BEATS: Final = 0.25
"""Most beats after a line for which the last poses of a measure are waited for."""
ANTICIPATION_BEATS: Final = 0.5
"""Who asks so shortly before the line to learn the last measure means the one that ends there."""
MAX_MEASURES: Final = 4
MAX_TAKES: Final = 4
"""Most measures of a take, and takes that are learnt at a time."""
MAX_NAME: Final = 64
WAYS: Final = ("same", "next", "other", "map")


@dataclass(slots=True)
class _Reading:
    """What was read of a performer: the measures read last, early and as a whole, and the last whole one."""

    early: int
    whole: int
    measure: int = 0
    step: str = ""
    mirrored: bool = False
    confidence: float = 0.0


@dataclass(slots=True)
class _Answer:
    """Present settings of an `[[answer]]`."""

    section: AnswerSection
    on: bool
    how: str
    group: str

    @classmethod
    def of(cls, section: AnswerSection) -> "_Answer":
        return cls(section, section.on, section.how, section.group)


class SeenSteps:
    """Recognised steps, answers and takes of all performers of one show. Deterministic. Thread: the show's."""

    EVENTS = (
        events.MocapFrame, events.LearnStep, events.LearningFailed, events.SwitchAnswer, events.SetAnswerHow,
        events.SetAnswerGroup,
    )  # fmt: skip

    def __init__(
        self, patch: Patch, motion: "GroupMotion", dancers: "Dancers", refusals: Refusals, *, seed: int
    ) -> None:
        """Raises UnknownStep for an unknown step in a map, PersonError for words of dancers without a meaning."""
        self._patch, self._motion, self._dancers, self._refusals, self._seed = patch, motion, dancers, refusals, seed
        self.answers = [_Answer.of(section) for section in patch.answer]
        for index, section in enumerate(patch.answer):
            try:
                motion.casting.select(section.group, motion.state.position)
                for step in (name for pair in section.map.items() for name in pair):
                    find_step(dancers.graph, step)
            except UnknownStep as error:
                unknown = UnknownStep(f"answer {section.name!r}: {error}")
                unknown.place = ("answer", index, "map")
                raise unknown from None
            except PersonError as error:
                words = f"answer {section.name!r}: {error.message}"
                raise PersonError(words, error.remedy, ("answer", index, "group")) from None
        self.takes: list[Take] = []
        """What is learnt or will be: it stays until the step can be danced."""
        self._poses: dict[str, DancedPoses] = {}
        self._readings: dict[str, _Reading] = {}
        self._clips_read = 0
        self.templates: StepTemplates | None = None
        """The library's measures; None if the patch has neither performers nor answers, so that nothing is read."""
        self.read_library()

    def read_library(self) -> None:
        """Make the templates of the present graph."""
        self.templates, self._clips_read = None, 0
        if self._patch.mocap or self._patch.answer:
            library = self._dancers.graph.library
            self.templates, self._clips_read = _templates(library, 0), len(library.clips)

    def set_graph(self, graph: "MotionGraph") -> None:
        """Use a graph that contains all clips of the old one: only new ones are read."""
        if self.templates is not None and len(graph.library.clips) > self._clips_read:
            self.templates = self.templates.joined(_templates(graph.library, self._clips_read))
        self._clips_read = len(graph.library.clips)

    def apply_patch(self, fresh: "SeenSteps") -> None:
        """Adopt the answers of an edited patch that changed; live settings stay for the others."""
        known = {answer.section.name: answer for answer in self.answers}
        self.answers = [
            known[one.section.name] if (one.section.name in known and known[one.section.name].section == one.section)
            else one for one in fresh.answers
        ]  # fmt: skip
        if self.templates is None or fresh.templates is None:
            self.templates, self._clips_read = fresh.templates, fresh._clips_read

    # -- events ------------------------------------------------------------------------------------------------------

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `EVENTS`; raises PersonError for what is unknown or impossible."""
        match event:
            case events.MocapFrame():
                self._add_pose(event, now)
            case events.LearnStep():
                self._learn(event, now)
            case events.LearningFailed():
                self.takes = [take for take in self.takes if take.name != event.name]
                raise PersonError(f"{event.performer}: {event.name!r} is not learnt: {event.reason}")
            case _:
                self._set_answers(event)

    def _add_pose(self, event: events.MocapFrame, now: Now) -> None:
        poses = self._poses.get(event.performer)
        if poses is None:
            poses = self._poses[event.performer] = DancedPoses()
            measure = math.floor(now.danced_beats / now.measure_beats)
            self._readings[event.performer] = _Reading(measure, measure)
        try:
            poses.add(event.pose, now.danced_beats_at(event.time), event.time)
        except ValueError as error:
            raise PersonError(f"{event.performer}: {error}") from None

    def _set_answers(self, event: ControlEvent) -> None:
        """Change settings of answers."""
        match event:
            case events.SwitchAnswer():
                for answer in self._find(event.answer):
                    answer.on = event.on
            case events.SetAnswerHow():
                if event.how not in WAYS:
                    raise PersonError(f"{event.how[:60]!r} is no way to answer", f"one of {', '.join(WAYS)}")
                found = self._find(event.answer)
                if event.how == "map" and (bare := [one.section.name for one in found if not one.section.map]):
                    raise PersonError(f"answer {bare[0]!r} has no map of steps", "add `map` to its [[answer]]")
                for answer in found:
                    answer.how = event.how
            case events.SetAnswerGroup():
                self._motion.casting.select(event.group, self._motion.state.position)
                for answer in self._find(event.answer):
                    answer.group = event.group

    def _find(self, name: str) -> list[_Answer]:
        """Return the answers of this name, all for `*`; PersonError if there is none."""
        found = [one for one in self.answers if name.strip() in ("*", one.section.name)]
        if not found:
            known = ", ".join(one.section.name for one in self.answers) or "none: add [[answer]] to the patch"
            raise PersonError(f"no answer is called {name[:60]!r}", f"there are: {known}")
        return found

    def _learn(self, event: events.LearnStep, now: Now) -> None:
        """Note what is to be learnt; PersonError if it cannot be."""
        names = [section.name for section in self._patch.mocap] or [DEFAULT_PERFORMER]
        if event.performer not in names:
            raise PersonError(f"no performer is called {event.performer[:60]!r}", f"there are: {', '.join(names)}")
        poses = self._poses.get(event.performer)
        if poses is None or not poses.count:
            raise PersonError(f"{event.performer} was never seen", "start the camera or the suit first")
        name = " ".join(event.name.split())
        if not name or len(name) > MAX_NAME or not name.isprintable():
            raise PersonError(f"{event.name[:60]!r} is no name for a step", f"1 to {MAX_NAME} printable characters")
        library = self._dancers.graph.library
        if library.step_index(name) is not None or any(take.name.casefold() == name.casefold() for take in self.takes):
            raise PersonError(f"there is a step called {name!r} already", "choose another name")
        if not 1 <= event.measures <= MAX_MEASURES:
            raise PersonError(f"{event.measures} measures", f"1 to {MAX_MEASURES} can be learnt at a time")
        if event.when not in ("last", "next"):
            raise PersonError(f"when {event.when[:60]!r}", "last: what was danced just now, next: what comes")
        if len(self.takes) >= MAX_TAKES:
            raise PersonError(f"{MAX_TAKES} steps are being learnt", "wait until they can be danced")
        self._motion.casting.select(event.group, self._motion.state.position)
        size, beats = now.measure_beats, now.danced_beats
        if event.when == "next":
            first = math.ceil(beats / size - 1e-6) * size
        else:
            first = (math.floor((beats + ANTICIPATION_BEATS) / size) - event.measures) * size
            if poses.first_beat > first + LATE_BEATS:
                raise PersonError(
                    f"{event.performer} was not seen for {event.measures} whole measures before",
                    "dance them again, or learn the next ones",
                )
        self.takes.append(
            empty_take(event.performer, name, event.group, event.repeats, event.measures, size, float(first))
        )

    # -- time --------------------------------------------------------------------------------------------------------

    def tick(self, now: Now) -> list[ControlEvent]:
        """Advance by one tick; return the steps that dancers are asked for."""
        if not self._poses:
            return []
        called = self._end_takes(now)
        if self.templates is not None:
            for performer, reading in self._readings.items():
                called += self._read(performer, reading, self.templates, now)
        return called

    def _read(self, performer: str, reading: _Reading, templates: StepTemplates, now: Now) -> list[ControlEvent]:
        """Read the measures of a performer that are due; return the answers."""
        size, beats, called = now.measure_beats, now.danced_beats, list[ControlEvent]()
        number = math.floor(beats / size)
        answers = [one for one in self.answers if one.on and one.section.performer == performer]
        early = size - UNHEARD_BEATS
        if size != templates.beats_per_measure:
            return []
        if reading.early < number and early >= 2 and (number + 1) * size - beats <= EARLY_BEATS:
            reading.early = number
            prompt = [one for one in answers if one.how != "next"]
            if prompt:
                found = self._recognise(performer, templates, number * size, early)
                called += self._answers(prompt, found, now)
        poses = self._poses[performer]
        line = number * size
        if reading.whole < number - 1 and (poses.last_beat >= line or beats >= line + LATE_BEATS):
            reading.whole = number - 1
            found = self._recognise(performer, templates, line - size, size)
            reading.measure, reading.confidence, reading.mirrored = number, found.confidence, found.mirrored
            reading.step = self._dancers.graph.library.steps[found.step] if found.step >= 0 else ""
            called += self._answers([one for one in answers if one.how == "next" or early < 2], found, now)
        return called

    def _recognise(self, performer: str, templates: StepTemplates, first: float, count: int) -> RecognisedStep:
        hips, rotation, stamp = self._poses[performer].between(first - 0.5, first + count + 0.5)
        return templates.recognise(hips, rotation, stamp[:, 0], float(first), count)

    def _answers(self, answers: list[_Answer], found: RecognisedStep, now: Now) -> list[ControlEvent]:
        """Return what is asked of the dancers; a step of several measures is answered when it begins."""
        graph, called = self._dancers.graph, list[ControlEvent]()
        if found.step < 0 or found.measure > 0:
            return []
        for answer in answers:
            name = graph.library.steps[found.step]
            if found.confidence < answer.section.sure:
                continue
            if answer.how == "map":
                mapped = {step.casefold(): other for step, other in answer.section.map.items()}.get(name.casefold())
                if mapped is None:
                    continue
                name = mapped
            elif answer.how == "other":
                other = self._other_step(found.step, answer, now.span.number)
                if other is None:
                    continue
                name = other
            measures = float(step_measures(graph, find_step(graph, name))) if self._can_dance(name) else 0.0
            if measures:
                called.append(
                    events.CallStep(time=now.time, source="answer", name=name, measures=measures, group=answer.group)
                )
        return called

    def _can_dance(self, name: str) -> bool:
        index = self._dancers.graph.library.step_index(name)
        return index is not None and len(self._dancers.graph.entries(index)) > 0

    def _other_step(self, step: int, answer: _Answer, measure: int) -> str | None:
        """Return another step, drawn from those of the answering groups; of the library if they have no other."""
        graph, groups = self._dancers.graph, self._patch.group
        members = self._motion.casting.groups_of(answer.group)
        own = {parse_entry(entry)[0] for index in members or () for entry in groups[index].steps}
        indices = sorted({i for name in own if (i := graph.library.step_index(name)) is not None})
        everything = range(len(graph.library.steps))
        for choice in (indices, everything):
            others = [each for each in choice if each != step and len(graph.entries(each))]
            if others:
                chance = np.random.default_rng([self._seed, max(measure, 0), self.answers.index(answer)])
                return graph.library.steps[others[int(chance.integers(len(others)))]]
        return None

    def _end_takes(self, now: Now) -> list[ControlEvent]:
        """Cut out what has been danced, and ask for the steps that can be danced now."""
        called: list[ControlEvent] = []
        for take in tuple(self.takes):
            if take.is_over:
                if self._can_dance(take.name):
                    self.takes.remove(take)
                    if take.repeats:
                        length = float(take.repeats * take.measures)
                        called.append(
                            events.CallStep(
                                time=now.time, source="learn", name=take.name, measures=length, group=take.group
                            )
                        )
                continue
            poses = self._poses[take.performer]
            if poses.last_beat < take.end and now.danced_beats < take.end + LATE_BEATS:
                continue
            reason = self._cut(take, poses)
            if reason:
                self.takes.remove(take)
                self._refusals.add(f"learn: {take.performer}: {take.name!r} is not learnt: {reason}")
        return called

    def _cut(self, take: Take, poses: DancedPoses) -> str:
        """Take the poses of a take from those that are kept; return why it cannot be learnt, empty if it can."""
        size = take.beats_per_measure
        hips, rotation, stamp = poses.between(take.first - size, take.end + LEAD_OUT_BEATS)
        beats = stamp[:, 0]
        if not is_seen(beats, take.first, take.measures * size):
            return "the performer was not seen all the time; dance it again"
        if motion_of(hips, rotation, beats, take.first, take.measures * size) < MIN_MOTION:
            return "the performer stood still"
        take.hips, take.rotation, take.stamp = hips, rotation, stamp
        return ""

    # -- reports -----------------------------------------------------------------------------------------------------

    def settings(self) -> dict[str, tuple[bool, str, str]]:
        """Return the present settings by answer: on, how, and group."""
        return {one.section.name: (one.on, one.how, one.group) for one in self.answers}

    def words(self) -> str:
        """Return what was recognised in the last measure: `anna: groove 0.8`, empty if nothing was."""
        rows = self._readings.items()
        return ", ".join(f"{name}: {one.step} {one.confidence:.1f}" for name, one in rows if one.step)

    def facts(self) -> dict[str, Any]:
        """Return for the status, by performer: the step danced in the last measure, how sure that is, and what is being
        learnt."""
        told: dict[str, Any] = {}
        for performer, reading in self._readings.items():
            learning = [take.name for take in self.takes if take.performer == performer]
            told[performer] = {
                "step": reading.step or None,
                "mirrored": reading.mirrored,
                "confidence": round(reading.confidence, 2),
                "measure": reading.measure,
                "learning": learning,
            }
        return told


def _templates(library: StepLibrary, first: int) -> StepTemplates:
    """Return the templates of the clips of a library from number `first` on: those that are steps by themselves."""
    upright = {clip.step for clip in library.clips if not clip.mirrored}
    clips = [
        (library.steps.index(clip.step), clip)
        for clip in library.clips[first:]
        if not clip.unjoined
        and not (clip.mirrored and clip.step in upright)
        and source_name(clip.clip.name) == clip.clip.name
    ]
    return StepTemplates.of(clips, library.beats_per_measure)
