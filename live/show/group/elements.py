"""Elements: the procedural elements of a show, put there by the score or live, each for its own group (T105-T110)."""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import Wants
from live.agents.crowd.agent_state import AgentState
from live.agents.elements.element import Element
from live.agents.elements.element_field import ElementField
from live.agents.elements.element_kinds import ATTRACTOR, EVERYBODY, KIND_NAMES, REPULSOR, VOICE
from live.base.errors import PersonError, named
from live.base.stage_snapshot import StageView
from live.control.events import events
from live.show.group.addressees import Addressees
from live.show.group.casting import EVERYONE, Casting
from live.show.group.elements_of import ElementEvent, Placing, placing_of_event, placing_of_section
from live.show.patch.patch import Patch
from live.show.score.score import Score

Float32 = npt.NDArray[np.float32]

SCORE: Final = "score"
"""The source of what the score places."""


class Elements:
    """The elements of one show: from the patch's score at their measures, from controls now or at the next line."""

    def __init__(self, patch: Patch, casting: Casting, *, seed: int, score: Score | None = None) -> None:
        count = len(casting.group)
        half = (patch.stage.width / 2, patch.stage.depth / 2)
        self._score = score or Score(patch)
        self._addressees = Addressees(casting)
        self._field = ElementField(
            count,
            half_width=half[0],
            half_depth=half[1],
            seed=seed,
            separation=patch.steering.separation,
            combine=patch.steering.combine,
        )
        self._ahead: Float32 = np.zeros(count, np.float32)
        self._last_of: dict[str, Element] = {}
        self._placed = -1
        self._of_line: list[Element] = []
        self.gain = 1.0
        """How much stronger elements are that begin from now on."""
        for index, section in enumerate(patch.element):  # whatever is wrong is told at the start, not in measure 200
            with named(f"element in measure {section.measure:g}", ("element", index)):
                self._made(placing_of_section(section), "", 0.0, 4, np.zeros((count, 2), np.float32))

    def take_patch(self, fresh: "Elements") -> None:
        """Answer anew who is meant by groups that have other names or members now."""
        self._addressees.regrouped(np.zeros((len(self._ahead), 2), np.float32))

    @property
    def influence(self) -> Float32:
        """How far elements have taken each agent from her plan, 0 to 1, shape (A,)."""
        return self._field.influence

    @property
    def in_force(self) -> tuple[Element, ...]:
        """The elements that have not ended, oldest first."""
        return self._field.elements

    def attractor_of(self, dancer: int) -> npt.NDArray[np.float64] | None:
        """The middle of the newest attractor for that dancer [m], (2,); None if there is none."""
        bits = int(self._addressees.bits[dancer])
        for element in reversed(self._field.elements):
            if element.kind in (ATTRACTOR, VOICE) and (element.groups == EVERYBODY or element.groups & bits):
                middle: npt.NDArray[np.float64] = np.mean(np.array(element.points, np.float64), axis=0)
                return middle
        return None

    def begin_measure(self, measure: int, beat: float, beats_per_measure: int, position: Float32) -> None:
        """Put the score's elements in force that begin in `measure` (from 0), whose line is or will be at `beat`.

        To be called when the measure begins, and before if somebody looks ahead; the first call counts.
        """
        if measure <= self._placed:
            return
        self._placed = measure
        if measure >= 0 and self._score.playhead.jumped(measure):  # what the score had elsewhere is over
            self._field.end(beat, source=SCORE)
        self._of_line.clear()
        for section in self._score.elements(measure):
            start = beat + (section.measure - int(section.measure)) * beats_per_measure
            placed = self._place(placing_of_section(section), SCORE, start, beats_per_measure, position)
            self._of_line.append(placed)

    def withdraw(self, measure: int) -> None:
        """Take back what was put there ahead of time for `measure`, which has not begun."""
        if measure > self._placed:
            return
        self._placed = measure - 1
        for element in self._of_line:
            self._field.remove(element)
        self._of_line.clear()

    def act(
        self, event: ElementEvent, *, beat: float, next_line: float, beats_per_measure: int, position: Float32
    ) -> None:
        """Let an event place its element at `beat`, or at the next line; PersonError if it means nothing."""
        placing = placing_of_event(event)
        voice = isinstance(event, events.Voice)
        later = not isinstance(event, events.Voice) and event.next
        drag = isinstance(event, events.Attract | events.Repel) and event.drag
        last = self._last_of.get(event.source)
        start = next_line if later else beat
        if last is not None and (drag or voice) and last.table_kind == self._kind(placing):
            self._last_of[event.source] = self._field.move(
                last, self._made(placing, event.source, start, beats_per_measure, position)
            )
            return
        placed = self._place(placing, event.source, start, beats_per_measure, position)
        if len(self._last_of) > 4096:  # as many as there may be senders of voices
            self._last_of.clear()
        self._last_of[event.source] = placed

    @staticmethod
    def _kind(placing: Placing) -> int:
        return VOICE if placing.fair else KIND_NAMES[placing.kind]

    def _made(self, placing: Placing, source: str, start: float, beats_per_measure: int, position: Float32) -> Element:
        if placing.dancer >= len(self._addressees.bits):
            raise PersonError(f"no dancer has the number {placing.whom}", f"there are {len(self._addressees.bits)}")
        used = 0 if placing.group.strip() in EVERYONE and not placing.whom else self._used()
        groups = self._addressees.mask(placing.group, position, used)
        target = -1
        if placing.whom and placing.dancer < 0:
            target = self._addressees.bit(placing.whom, position, used | (groups if groups != EVERYBODY else 0))
        element = placing.element(
            groups=groups, target_group=target, source=source, start=start, beats_per_measure=beats_per_measure
        )
        return element if self.gain == 1.0 else replace(element, strength=element.strength * self.gain)

    def _place(self, placing: Placing, source: str, start: float, beats_per_measure: int, position: Float32) -> Element:
        element = self._made(placing, source, start, beats_per_measure, position)
        self._field.add(element)
        return element

    def _used(self) -> int:
        """The bits of groups that elements in force have."""
        used = 0
        for element in self._field.elements:
            if element.groups != EVERYBODY:
                used |= element.groups
            if element.target_group >= 0:
                used |= 1 << element.target_group
        return used

    def has(self, source: str) -> bool:
        """Whether an element of this source is in force."""
        return any(element.source == source for element in self._field.elements)

    def forget(self, source: str, beat: float, *, other: bool | None = None, at_once: bool = False) -> None:
        """Let what `source` has placed fade out; `other`: only where it is no repulsor (true) or is one (false);
        `at_once`: as if it had never been."""
        last = self._last_of.get(source)
        if last is None or (other is not None and (last.table_kind == REPULSOR) == other):
            return
        del self._last_of[source]
        if at_once:
            self._field.remove(last)
        else:
            self._field.end(beat, source=source)

    def clear(self, beat: float) -> None:
        """Let every element fade out from `beat` on, from the level it has; those yet to come never begin."""
        self._field.clear(beat)

    def end_of(self, source: str, beat: float) -> None:
        """Let what this source has placed fade out from `beat` on, from the level it has."""
        if self._last_of.pop(source, None) is not None:
            self._field.end(beat, source=source)

    def regrouped(self, position: Float32) -> None:
        """Dancers have changed their groups."""
        self._addressees.regrouped(position)

    def resize(self, half_width: float, half_depth: float) -> None:
        """The stage's half sizes [m] are these from now on."""
        self._field.resize(half_width, half_depth)

    # -- each tick -----------------------------------------------------------------------------------------------

    def refresh(self, beat: float, wants: Wants, state: AgentState) -> None:
        """Once a tick, before `wish`: which elements act at `beat`."""
        self._field.refresh(beat, wants, state, self._addressees.bits)

    def wish(self, wants: Wants, state: AgentState, *, time: float, beat: float, ahead: bool) -> None:
        """Blend what the elements wish at `beat` of agents in `state` into `wants`.

        `ahead`: on a copy and later than now; `refresh` has to come before the next wish that is meant.
        """
        influence = self._ahead if ahead else None
        if ahead:
            self._field.foresee(beat)
        self._field.wish(wants, state, self._addressees.bits, time=time, influence=influence)

    def show(self, view: StageView) -> None:
        """Copy what acts now into the drawing snapshot."""
        self._field.show(view)
