"""Checks that every name in scenes, cues, calls and trackers of a patch exists, before a show runs."""

from collections.abc import Callable, Iterator, Sequence
from typing import Final, get_args

import numpy as np

from live.base.errors import PersonError
from live.base.parameter import WORLD_NAMES
from live.control.events import events
from live.control.registry.command import controls_of
from live.control.registry.registry import FIRST_NAMES, REGISTRY
from live.motion.recognition.recognition_names import MOVEMENT_NAMES
from live.show.dancers.timing_offsets import parse_ripple
from live.show.desk.parameter_table import LOOK, VIEW, WORLD, split_key
from live.show.group.casting import EVERYONE, Casting
from live.show.patch.patch import Patch
from live.show.patch.section_base import InvalidEntry
from live.show.patch.section_capture import AnswerSection
from live.show.patch.section_io import DEFAULT_PERFORMER, MocapSection, PsnSection
from live.show.patch.section_motion import parse_facing
from live.show.patch.section_music import PERFORMER_PREFIX
from live.show.patch.section_stage import PROJECTOR
from live.show.patch_checks.cue_cycle_check import cue_loops
from live.show.patch_checks.score_checks import calls_of, signals_of
from live.show.score.playhead import When
from live.show.score.section_span import score_length

MIN_LOOP_BEATS: Final = 0.999
"""Cue loops within so many beats are an error; slower ones may be intended."""
START_NAME: Final = "start"
"""Name of the view, look and scene that every patch begins with."""
BUILT_IN_VIEWS: Final = ("front", "side", "top", "around")
"""Views that every show has, unless the patch gives these names to its own."""


def built_in_views(patch: Patch) -> list[str]:
    """Return the views that exist without a `[[view]]`."""
    return [START_NAME, *BUILT_IN_VIEWS, *([PROJECTOR] if patch.projector is not None else [])]


def check_cues(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error for an unknown name in a scene or cue, and for an unknown scene in the score."""
    yield from _check_start(patch)
    yield from _check_scenes(patch)
    scenes = {_folded(scene.name) for scene in patch.scene} | {START_NAME}
    sections = {_folded(section.name) for section in patch.section}
    for number, cue in enumerate(patch.cue):
        if cue.scene is not None and _folded(cue.scene) not in scenes:
            words = f"cue {cue.name!r}: no scene is called {cue.scene!r}; there are: {', '.join(sorted(scenes))}"
            yield InvalidEntry(words, "cue", number, "scene")
        if cue.section is not None and _folded(cue.section) not in sections:
            known = ", ".join(section.name for section in patch.section) or "none: write [[section]]"
            words = f"cue {cue.name!r}: no section is called {cue.section!r}; there are: {known}"
            yield InvalidEntry(words, "cue", number, "section")
        if cue.when == "section" and not sections:
            words = f'cue {cue.name!r}: when = "section", but the patch has no [[section]]'
            yield InvalidEntry(words, "cue", number, "when")
    yield from _check_named_cues(patch)
    yield from _check_loops(patch)
    for number, at in enumerate(patch.at):
        if at.scene is not None and _folded(at.scene) not in scenes:
            words = (
                f"at measure {at.measure}, beat {at.beat:g}: no scene is called {at.scene!r}; there are: "
                f"{', '.join(sorted(scenes))}"
            )
            yield InvalidEntry(words, "at", number, "scene")


def _check_start(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error if a view, look or scene has the reserved name of the initial one."""
    named = {"view": [view.name for view in patch.view], "looks": [look.name for look in patch.looks]}
    for kind, names in (named | {"scene": [scene.name for scene in patch.scene]}).items():
        for index, name in enumerate(names):
            if _folded(name) == START_NAME:
                what = {"view": "[camera]", "looks": "[look]"}.get(kind, "[camera], [look] and [motion]")
                words = f"{name!r} names the start of the patch, from {what}: give this one another name"
                yield InvalidEntry(words, kind, index, "name")


def _check_loops(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error if a cue calls itself or loops within a beat; slower loops of several cues are allowed."""
    for loop in cue_loops(patch, within=MIN_LOOP_BEATS):
        name = patch.cue[loop.cue].name
        if loop.direct:
            words = (
                f"cue {name!r} calls itself: it would come again for ever, and stand by nothing but the cue after it; "
                "what comes again is an [[at]] in a [[section]] that repeats"
            )
        else:
            words = (
                f"cue {name!r} calls its way back to itself within {loop.min_beats:g} beats, for ever: "
                'when = "measure" or a count_in for one of them'
            )
        yield InvalidEntry(words, *loop.key_path)


def _check_named_cues(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error if two cues share a number, or if a called cue does not exist."""
    numbers: dict[float, str] = {}
    for index, cue in enumerate(patch.cue):
        if cue.number is not None and cue.number in numbers:
            words = f"cues {numbers[cue.number]!r} and {cue.name!r} both have number {cue.number:g}: change one of them"
            yield InvalidEntry(words, "cue", index, "number")
        if cue.number is not None:
            numbers[cue.number] = cue.name
    told = {f"{number:g}": name for number, name in numbers.items()}
    for index, cue in enumerate(patch.cue):
        other = told.get(_folded(cue.name), cue.name)
        if other != cue.name:
            words = f"cue {cue.name!r} is called as cue {other!r} is numbered: change one of them"
            yield InvalidEntry(words, "cue", index, "name")
    names = {_folded(cue.name) for cue in patch.cue} | {f"{number:g}" for number in numbers}
    for call, values, place in calls_of(patch):
        if FIRST_NAMES.get(call) != "cue" or (name := _folded(str(values[0]))) in names:
            continue
        known = ", ".join(cue.name for cue in patch.cue) or "none"
        yield InvalidEntry(f"call {call}: no cue is called {name!r}; there are: {known}", *place)


def _check_scenes(patch: Patch) -> Iterator[InvalidEntry]:
    selections = _SelectionTable(patch)
    for index, dressed in enumerate(patch.group):
        for key in dressed.draw:
            whom = key.strip().partition(" ")[2].strip()
            if whom and (fault := selections.fault(f"{dressed.name} & {whom}")) is not None:
                yield InvalidEntry(f"group {dressed.name!r}: draw {key!r}: {fault}", "group", index, "draw", key)
    for index, reaction in enumerate(patch.react):
        if reaction.sets is not None and (fault := selections.fault(reaction.group)) is not None:
            yield InvalidEntry(fault, "react", index, "group")
    named = {VIEW: {_folded(view.name) for view in patch.view} | set(built_in_views(patch))}
    named |= {LOOK: {_folded(look.name) for look in patch.looks} | {START_NAME}, WORLD: set(WORLD_NAMES)}
    for number, scene in enumerate(patch.scene):
        for key, value in scene.set.items():
            address, group = split_key(key)
            if (fault := selections.fault(group)) is not None:
                yield InvalidEntry(f"scene {scene.name!r}: {key!r}: {fault}", "scene", number, "set", key)
            if address in named and _folded(str(value)) not in named[address]:
                there = ", ".join(sorted(named[address]))
                words = f"scene {scene.name!r}: {key!r}: nothing is called {value!r}; there are: {there}"
                yield InvalidEntry(words, "scene", number, "set", key)


class _SelectionTable:
    """The selections that are possible with the dancers of a patch."""

    def __init__(self, patch: Patch) -> None:
        self._patch = patch
        self._casting: Casting | None = None

    def fault(self, words: str) -> str | None:
        """Return what is wrong with the words of a selection; None if they are valid."""
        if words.strip() in EVERYONE:
            return None
        self._casting = self._casting or Casting(self._patch)
        try:
            self._casting.select(words, np.zeros((len(self._casting.group), 2)))
        except PersonError as error:
            return str(error)
        return None


def _folded(name: str) -> str:
    return name.casefold().strip()


GATES: Final = ("left", "right", "back")
"""Gates of a stage without a `[[gate]]`."""


def check_call_names(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error for an unknown name in a call of the score or of a cue."""
    named: _NameTable | None = None
    seen: set[tuple[object, ...]] = set()
    for call, values, place in calls_of(patch):
        if call not in NAMED_CONTROLS or (call, *values) in seen:
            continue
        seen.add((call, *values))
        named = named or _NameTable(patch)
        try:
            named.check(REGISTRY.call(call, values, 0.0, "patch"))
        except PersonError as error:
            yield InvalidEntry(f"call {call}: {error}", *place)


class _NameTable:
    """The names that a patch defines, by kind, and the check of an event's names against them."""

    def __init__(self, patch: Patch) -> None:
        self._patch = patch
        stored = [str(values[0]) for call, values, _ in calls_of(patch) if call == "/dance/scene/store"]
        stored += [str(one.values.get("name")) for one in patch.midi.map if one.control == "/dance/scene/store"]
        self._scenes = [START_NAME, *(scene.name for scene in patch.scene), *stored]
        self._views = [*built_in_views(patch), *(view.name for view in patch.view)]
        self._looks = [START_NAME, *(look.name for look in patch.looks)]
        self._gates = [gate.name for gate in patch.gate] or list(GATES)

    def check(self, event: object) -> None:
        """Raise PersonError if the event uses an unknown name."""
        act = _NAME_CHECKS.get(type(event))
        if act is not None:
            act(self, event)

    def _scene(self, event: events.RecallScene) -> None:
        _require_name("scene", event.name, self._scenes)

    def _view(self, event: events.RecallView) -> None:
        _require_name("view", event.name, self._views)

    def _look(self, event: events.RecallLook) -> None:
        _require_name("look", event.name, self._looks)

    def _world(self, event: events.RecallWorld) -> None:
        _require_name("world", event.name, WORLD_NAMES)

    def _signal(self, event: events.Signal) -> None:
        _require_name("signal", event.name, sorted(signals_of(self._patch)))

    def _jump(self, event: events.JumpTo) -> None:
        _require_name("section", event.section, [section.name for section in self._patch.section])
        _require_name("when", event.when, get_args(When))
        size = next(one.measures for one in self._patch.section if _folded(one.name) == _folded(event.section))
        if event.measure > size:
            raise PersonError(f"section {event.section!r} has no measure {event.measure}", f"it has {size}")

    def _advance(self, event: events.Advance) -> None:
        _require_name("when", event.when, get_args(When))

    def _practice(self, event: events.Practice) -> None:
        length = score_length(self._patch)
        if event.first > event.last:
            raise PersonError(f"measures {event.first} to {event.last}: the first one comes last")
        if length is not None and event.last > length:
            raise PersonError(f"the score has no measure {event.last}", f"it has {length}")

    def _gate(self, event: events.Enter | events.Leave) -> None:
        if event.gate.strip() not in ("", "*"):
            _require_name("gate", event.gate, self._gates)

    def _facing(self, event: events.SetFacing) -> None:
        names = tuple(_folded(group.name) for group in self._patch.group)
        dancers = sum(group.dancers for group in self._patch.group) + self._patch.reserve
        parse_facing(event.facing, dancers=dancers, groups=names)

    def _ripple(self, event: events.SetRipple) -> None:
        parse_ripple(event.begins, event.beats)


def _require_name(what: str, name: str, known: Sequence[str]) -> None:
    """Raise PersonError if nothing of the kind `what` has this name."""
    if _folded(name) not in map(_folded, known):
        raise PersonError(f"no {what} is called {name!r}", f"there are: {', '.join(known) or 'none'}")


_NAME_CHECKS: Final[dict[type, Callable[..., None]]] = {
    events.RecallScene: _NameTable._scene,
    events.RecallView: _NameTable._view,
    events.RecallLook: _NameTable._look,
    events.RecallWorld: _NameTable._world,
    events.Signal: _NameTable._signal,
    events.JumpTo: _NameTable._jump,
    events.Advance: _NameTable._advance,
    events.Practice: _NameTable._practice,
    events.Enter: _NameTable._gate,
    events.Leave: _NameTable._gate,
    events.SetFacing: _NameTable._facing,
    events.SetRipple: _NameTable._ripple,
}
NAMED_CONTROLS: Final = frozenset(control.address for cls in _NAME_CHECKS for control in controls_of(cls))
"""Controls with names that only the patch defines."""


def check_trackers(psn: PsnSection, performers: Sequence[MocapSection]) -> Iterator[InvalidEntry]:
    """Yield an error for a tracker that is missing in `[psn] trackers`, if given, or that two performers share."""
    whose = {each.name: each.name for each in performers if each.tracker is None}
    for index, each in enumerate(performers):
        if each.tracker is None:
            continue
        place = "mocap", index, "tracker"
        if psn.trackers and each.tracker not in psn.trackers:
            known = ", ".join(psn.trackers)
            words = f"mocap {each.name!r}: no tracker is called {each.tracker!r}; [psn] trackers has: {known}"
            yield InvalidEntry(words, *place)
        other = whose.setdefault(each.tracker, each.name)
        if other != each.name:
            words = f"mocap {each.name!r}: tracker {each.tracker!r} is already {other!r}; give each their own"
            yield InvalidEntry(words, *place)


def check_answers(answers: Sequence[AnswerSection], performers: Sequence[MocapSection]) -> Iterator[InvalidEntry]:
    """Yield an error for an answer to a performer that does not exist, and for a map that is missing or not used."""
    names = [each.name for each in performers] or ["live"]
    for index, answer in enumerate(answers):
        if answer.performer not in names:
            words = (
                f"answer {answer.name!r}: no performer is called {answer.performer!r}; there are: {', '.join(names)}"
            )
            yield InvalidEntry(words, "answer", index, "performer")
        if answer.how == "map" and not answer.map:
            words = f'answer {answer.name!r}: how = "map" needs `map = {{ groove = "kick" }}`'
            yield InvalidEntry(words, "answer", index, "how")
        if answer.map and answer.how != "map":
            words = f'answer {answer.name!r}: `map` has no effect unless how = "map"'
            yield InvalidEntry(words, "answer", index, "map")


def check_performers(patch: Patch) -> Iterator[InvalidEntry]:
    """Yield an error for an unknown performer of a gesture or a reaction, and for an unknown number of hers."""
    names = [each.name for each in patch.mocap] or [DEFAULT_PERFORMER]
    known, folded = ", ".join(names), {name.casefold() for name in names}
    for index, gesture in enumerate(patch.gesture):
        if gesture.performer is not None and gesture.performer.casefold() not in folded:
            words = f"gesture {gesture.name!r}: no performer is called {gesture.performer!r}; there are: {known}"
            yield InvalidEntry(words, "gesture", index, "performer")
    for index, reaction in enumerate(patch.react):
        if reaction.to is None or not reaction.to.startswith(PERFORMER_PREFIX):
            continue
        name, _, number = reaction.to.removeprefix(PERFORMER_PREFIX).rpartition("/")
        if number not in MOVEMENT_NAMES:
            words = f"{reaction.to!r}: {number!r} is unknown; there are: {', '.join(MOVEMENT_NAMES)}"
            yield InvalidEntry(words, "react", index, "to")
        elif name and name.casefold() not in folded:
            yield InvalidEntry(
                f"{reaction.to!r}: no performer is called {name!r}; there are: {known}", "react", index, "to"
            )
