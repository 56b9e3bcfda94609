"""What scenes and cues of a patch name is there: looked at before anything plays."""

from collections.abc import Sequence
from typing import Final, Protocol

from live.show.desk.parameter_table import LOOK, VIEW, split
from live.show.patch.cue import CueSection
from live.show.patch.cue_cycle_check import cue_loops
from live.show.patch.group import GroupSection
from live.show.patch.midi import MidiSection
from live.show.patch.scene import NamedLookSection, SceneSection, ViewSection
from live.show.patch.score import AtSection, ScoreSection
from live.show.patch.score_checks import Written, calls_of
from live.show.patch.section_base import Amiss
from live.show.patch.section_stage import GateSection, ProjectorSection


class Recalled(Written, Protocol):
    """What is looked at of a patch."""

    @property
    def reserve(self) -> int: ...
    @property
    def midi(self) -> MidiSection: ...
    @property
    def gate(self) -> Sequence[GateSection]: ...
    @property
    def group(self) -> Sequence[GroupSection]: ...
    @property
    def view(self) -> Sequence[ViewSection]: ...
    @property
    def projector(self) -> ProjectorSection | None: ...
    @property
    def looks(self) -> Sequence[NamedLookSection]: ...
    @property
    def scene(self) -> Sequence[SceneSection]: ...
    @property
    def cue(self) -> Sequence[CueSection]: ...
    @property
    def section(self) -> Sequence[ScoreSection]: ...
    @property
    def at(self) -> Sequence[AtSection]: ...


CUE_CALLS: Final = ("/dance/cue", "/dance/standby")
"""Controls whose first value is a cue."""
FASTEST: Final = 0.999
"""Cues that come back to themselves within so many beats are a mistake; slower ones may be meant."""
START: Final = "start"
"""The view, look and scene that every patch has: what it begins with."""
EVERY_SHOW: Final = ("front", "side", "top", "around")
"""Views that every show has, unless the patch calls others so."""
PROJECTOR: Final = "projector"
"""The view of a patch with a `[projector]`."""


def standing_views(patch: Recalled) -> list[str]:
    """The views that a patch has without a `[[view]]`."""
    return [START, *EVERY_SHOW, *([PROJECTOR] if patch.projector is not None else [])]


def check_cues(patch: Recalled) -> None:
    """Amiss for a scene or cue of the patch that names what is not there, and for a scene recalled by the score."""
    _check_start(patch)
    _check_scenes(patch)
    scenes = {_folded(scene.name) for scene in patch.scene} | {START}
    sections = {_folded(section.name) for section in patch.section}
    for number, cue in enumerate(patch.cue):
        if cue.scene is not None and _folded(cue.scene) not in scenes:
            words = f"cue {cue.name!r}: no scene is called {cue.scene!r}; there are: {', '.join(sorted(scenes))}"
            raise Amiss(words, "cue", number, "scene")
        if cue.section is not None and _folded(cue.section) not in sections:
            known = ", ".join(section.name for section in patch.section) or "none: write [[section]]"
            words = f"cue {cue.name!r}: no section is called {cue.section!r}; there are: {known}"
            raise Amiss(words, "cue", number, "section")
        if cue.when == "section" and not sections:
            words = f'cue {cue.name!r}: when = "section", but the patch has no [[section]]'
            raise Amiss(words, "cue", number, "when")
    _check_named_cues(patch)
    _check_loops(patch)
    for number, at in enumerate(patch.at):
        if at.scene is not None and _folded(at.scene) not in scenes:
            words = (
                f"at measure {at.measure}, beat {at.beat:g}: no scene is called {at.scene!r}; there are: "
                f"{', '.join(sorted(scenes))}"
            )
            raise Amiss(words, "at", number, "scene")


def _check_start(patch: Recalled) -> None:
    """What a patch begins with has its name already."""
    named = {"view": [view.name for view in patch.view], "looks": [look.name for look in patch.looks]}
    for kind, names in (named | {"scene": [scene.name for scene in patch.scene]}).items():
        for index, name in enumerate(names):
            if _folded(name) == START:
                what = {"view": "[camera]", "looks": "[look]"}.get(kind, "[camera], [look] and [motion]")
                words = f"{name!r} is what the patch begins with, as {what} say: give this one another name"
                raise Amiss(words, kind, index, "name")


def _check_loops(patch: Recalled) -> None:
    """No cue calls itself, nor comes back to itself within a beat; slower loops of several cues are a way to write."""
    for loop in cue_loops(patch, within=FASTEST):
        name = patch.cue[loop.cue].name
        if loop.itself:
            words = (
                f"cue {name!r} calls itself: it would come again for ever, and stand by nothing but the cue after it; "
                "what comes again is an [[at]] in a [[section]] that repeats"
            )
        else:
            words = (
                f"cue {name!r} calls its way back to itself within {loop.beats:g} beats, for ever: "
                'when = "measure" or a count_in for one of them'
            )
        raise Amiss(words, *loop.place)


def _check_named_cues(patch: Recalled) -> None:
    """No number stands for two cues, and all cues that are called are there."""
    numbers: dict[float, str] = {}
    for index, cue in enumerate(patch.cue):
        if cue.number is not None and cue.number in numbers:
            words = f"cues {numbers[cue.number]!r} and {cue.name!r} both have number {cue.number:g}: change one of them"
            raise Amiss(words, "cue", index, "number")
        if cue.number is not None:
            numbers[cue.number] = cue.name
    told = {f"{number:g}": name for number, name in numbers.items()}
    for index, cue in enumerate(patch.cue):
        other = told.get(_folded(cue.name), cue.name)
        if other != cue.name:
            words = f"cue {cue.name!r} is called as cue {other!r} is numbered: change one of them"
            raise Amiss(words, "cue", index, "name")
    names = {_folded(cue.name) for cue in patch.cue} | {f"{number:g}" for number in numbers}
    for call, values, place in calls_of(patch):
        if call not in CUE_CALLS or (name := _folded(str(values[0]))) in names:
            continue
        known = ", ".join(cue.name for cue in patch.cue) or "none"
        raise Amiss(f"call {call}: no cue is called {name!r}; there are: {known}", *place)


def _check_scenes(patch: Recalled) -> None:
    groups = {_folded(group.name) for group in patch.group}
    known = ", ".join(group.name for group in patch.group)
    named = {VIEW: {_folded(view.name) for view in patch.view} | set(standing_views(patch))}
    named |= {LOOK: {_folded(look.name) for look in patch.looks} | {START}}
    for number, scene in enumerate(patch.scene):
        for key, value in scene.set.items():
            address, group = split(key)
            if group != "*" and _folded(group) not in groups:
                words = f"scene {scene.name!r}: {key!r}: no group is called {group!r}; there are: {known}"
                raise Amiss(words, "scene", number, "set", key)
            if address in named and _folded(str(value)) not in named[address]:
                there = ", ".join(sorted(named[address]))
                words = f"scene {scene.name!r}: {key!r}: nothing is called {value!r}; there are: {there}"
                raise Amiss(words, "scene", number, "set", key)


def _folded(name: str) -> str:
    return name.casefold().strip()
