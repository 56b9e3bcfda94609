"""Procedural elements of a show: force fields placed by the score or live, each for a group (T105-T110, T132).

The group of an element is a bit in a mask per dancer (T104, T105: per subgroup).
"""

from collections.abc import Mapping
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentState
from live.agents.elements.element import Element
from live.agents.elements.element_field import ElementField
from live.base.arrays import Bool, Float32, UInt64
from live.base.element_kinds import ATTRACTOR, EVERYBODY, FLOW_NAMES, KIND_NAMES, PARTICIPANT, REPULSOR
from live.base.errors import PersonError, error_context
from live.base.stage_snapshot import StageView
from live.control.events.elements import PlaceElement
from live.control.events.launches import LaunchEnded
from live.show.group.casting import EVERYONE, Casting
from live.show.patch.patch import Patch
from live.show.patch.section_elements import ElementSection
from live.show.score.score import Score
from live.show.stages.now import Now

SCORE: Final = "score"
"""Source name of the score's elements."""


def element_of_section(section: ElementSection) -> PlaceElement:
    """Return the element of a section of the score, as a control would place it."""
    points = section.points or ((section.at,) if section.to is None else (section.at, section.to))
    return PlaceElement(
        time=0.0, source=SCORE, kind=section.kind, points=points, strength=section.strength, measures=section.measures,
        group=section.group, radius=section.radius, closed=section.closed, flow=section.flow, whom=section.whom,
    )  # fmt: skip


def target_of(whom: str) -> int:
    """Return the index of the dancer whose number is `whom`, -1 if it is no number."""
    return int(whom) - 1 if whom.isdecimal() and len(whom) < 7 else -1


Places = npt.NDArray[np.floating]

BITS: Final = 64


def make_element(
    event: PlaceElement, *, groups: int, target_group: int, start: float, beats_per_measure: int, gain: float = 1.0
) -> Element:
    """Return the element of an event from the beat `start` on, with `gain` times its strength.

    `groups`: mask of the addressed groups; `target_group`: bit of the group `whom`, -1 if that is a number. Raises
    PersonError for an unknown kind and an impossible place.
    """
    if event.kind not in KIND_NAMES or (event.flow and event.flow not in FLOW_NAMES):
        raise PersonError(f"no element is called {event.kind or event.flow!r}")
    return Element(
        kind=KIND_NAMES[event.kind], points=event.points, strength=event.strength * gain, start_beat=start,
        end_beat=start + event.measures * beats_per_measure, groups=groups, source=event.source, closed=event.closed,
        radius=event.radius, fair=event.fair, flow_kind=FLOW_NAMES[event.flow or "uniform"],
        target=target_of(event.whom), target_group=target_group,
    )  # fmt: skip


def _table_kind(event: PlaceElement) -> int:
    """Return the kind of its row in the table, -1 for an unknown one."""
    return PARTICIPANT if event.fair else KIND_NAMES.get(event.kind, -1)


class GroupMasks:
    """Assigns a bit to each group expression, and a mask of these bits to each dancer.

    Expressions with places are evaluated once. All others are updated when dancers change their groups.
    """

    def __init__(self, casting: Casting) -> None:
        self._casting = casting
        self._words: list[str | None] = [None] * BITS
        self._follows_groups = [False] * BITS
        self.bits: UInt64 = np.zeros(len(casting.group), np.uint64)
        """Mask of the groups of each dancer, shape (A,)."""

    def mask(self, words: str, position: Places, used: int) -> int:
        """Return the mask of an element for the dancers that `words` select; `used`: bits of active elements.

        Raises PersonError for unknown words, and for too many groups at a time.
        """
        if words.strip() in EVERYONE:
            return EVERYBODY
        return 1 << self.bit(words, position, used)

    def bit(self, words: str, position: Places, used: int) -> int:
        """Return the bit number of these words. Raises as `mask` does."""
        folded = words.casefold().strip()
        who = self._casting.select(words, position)
        lasting = not self._casting.depends_on_places(words)
        if lasting and folded in self._words:
            return self._words.index(folded)
        free = next((n for n in range(BITS) if self._words[n] is None or not used >> n & 1), None)
        if free is None:
            raise PersonError(f"elements for more than {BITS} groups at a time", "let some of them end first")
        self._words[free], self._follows_groups[free] = folded, lasting
        if not lasting:
            self._words[free] = f"{folded}, when it was asked"
        self._write(free, who)
        return free

    def update_groups(self, position: Places) -> None:
        """Evaluate all expressions without places again."""
        for number, words in enumerate(self._words):
            if words is not None and self._follows_groups[number]:
                self._write(number, self._casting.select(words, position))

    def _write(self, number: int, who: npt.NDArray[np.bool_]) -> None:
        bit = np.uint64(1 << number)
        self.bits[who] |= bit
        self.bits[~who] &= ~bit


class Elements:
    """The elements of one show. The score's begin at their measures, those of controls now or at the next line."""

    EVENTS = (PlaceElement, LaunchEnded)

    def __init__(self, patch: Patch, casting: Casting, *, seed: int, score: Score | None = None) -> None:
        count = len(casting.group)
        half = (patch.stage.width / 2, patch.stage.depth / 2)
        self._score = score or Score(patch)
        self._group_masks = GroupMasks(casting)
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
        self._placed_measure = -1
        self._measure_elements: list[Element] = []
        self.gain = 1.0
        """Strength factor of elements that begin from now on."""
        for index, section in enumerate(patch.element):  # errors are reported at the start, not in measure 200
            with error_context(f"element in measure {section.measure:g}", ("element", index)):
                self._build(element_of_section(section), 0.0, 4, np.zeros((count, 2), np.float32))

    def apply_patch(self, fresh: "Elements") -> None:
        """Evaluate group expressions again, as names or members may have changed."""
        self._group_masks.update_groups(np.zeros((len(self._ahead), 2), np.float32))

    @property
    def influence(self) -> Float32:
        """Total influence of elements on each agent, 0 to 1, shape (A,)."""
        return self._field.influence

    @property
    def in_force(self) -> tuple[Element, ...]:
        """The elements that have not ended, oldest first."""
        return self._field.elements

    @property
    def levels(self) -> npt.NDArray[np.float64]:
        """How far each of them acts, 0 to 1, (E,)."""
        return self._field.levels

    def dancers_of(self, element: Element) -> Bool:
        """Return which dancers an element addresses, (A,)."""
        bits = self._group_masks.bits
        if element.groups == EVERYBODY:
            return np.ones(len(bits), np.bool_)
        return np.asarray(bits & np.uint64(element.groups) != 0)

    def attractor_of(self, dancer: int) -> npt.NDArray[np.float64] | None:
        """Return the centre of the newest attractor for a dancer [m], (2,); None if there is none."""
        bits = int(self._group_masks.bits[dancer])
        for element in reversed(self._field.elements):
            if element.kind in (ATTRACTOR, PARTICIPANT) and (element.groups == EVERYBODY or element.groups & bits):
                middle: npt.NDArray[np.float64] = np.mean(np.array(element.points, np.float64), axis=0)
                return middle
        return None

    def begin_measure(self, measure: int, beat: float, beats_per_measure: int, position: Float32) -> None:
        """Place the score's elements that begin in `measure` (from 0), whose line is or will be at `beat`.

        Called when the measure begins, and earlier by the look-ahead. Only the first call has an effect.
        """
        if measure <= self._placed_measure:
            return
        self._placed_measure = measure
        if measure >= 0 and self._score.playhead.jumped(measure):  # elements from before the jump end
            self._field.end(beat, source=SCORE)
        self._measure_elements.clear()
        for section in self._score.elements(measure):
            start = beat + (section.measure - int(section.measure)) * beats_per_measure
            placed = self._place(element_of_section(section), start, beats_per_measure, position)
            self._measure_elements.append(placed)

    def withdraw(self, measure: int) -> None:
        """Remove the elements placed ahead of time for `measure`, which has not begun."""
        if measure > self._placed_measure:
            return
        self._placed_measure = measure - 1
        for element in self._measure_elements:
            self._field.remove(element)
        self._measure_elements.clear()

    def handle(self, event: PlaceElement | LaunchEnded, now: Now) -> None:
        """Place the element of an event now, or at the next line; end a launched one. Raises PersonError if it is
        invalid."""
        if isinstance(event, LaunchEnded):
            if event.what == "elements":
                self.end_source(event.source, now.beat)
            return
        beats_per_measure, position = now.timeline.beats_per_measure, now.position
        last = self._last_of.get(event.source)
        start = now.span.end if event.next else now.beat
        if last is not None and event.drag and last.table_kind == _table_kind(event):
            moved = self._build(event, start, beats_per_measure, position)
            self._last_of[event.source] = self._field.move(last, moved)
            return
        placed = self._place(event, start, beats_per_measure, position)
        if len(self._last_of) > 4096:  # bounds memory for many senders
            self._last_of.clear()
        self._last_of[event.source] = placed

    def handle_touches(self, touches: Mapping[str, PlaceElement | None], now: Now, *, at_once: bool) -> None:
        """Apply what the audience touches, by source: None, or another kind than before, fades the former element out.

        `at_once`: former elements are removed without a fade.
        """
        for source, event in touches.items():
            repels = None if event is None else not event.fair
            self.forget(source, now.beat, other=repels, at_once=at_once)
            if event is not None:
                self.handle(event, now)

    def _build(self, event: PlaceElement, start: float, beats_per_measure: int, position: Float32) -> Element:
        """Return the element of an event from the beat `start` on. Raises PersonError if it is invalid."""
        dancer = target_of(event.whom)
        if dancer >= len(self._group_masks.bits):
            raise PersonError(f"no dancer has the number {event.whom}", f"there are {len(self._group_masks.bits)}")
        used = 0 if event.group.strip() in EVERYONE and not event.whom else self._used()
        groups = self._group_masks.mask(event.group, position, used)
        target = -1
        if event.whom and dancer < 0:
            target = self._group_masks.bit(event.whom, position, used | (groups if groups != EVERYBODY else 0))
        return make_element(
            event, groups=groups, target_group=target, start=start, beats_per_measure=beats_per_measure, gain=self.gain
        )

    def _place(self, event: PlaceElement, start: float, beats_per_measure: int, position: Float32) -> Element:
        element = self._build(event, start, beats_per_measure, position)
        self._field.add(element)
        return element

    def _used(self) -> int:
        """Return the bits of groups that active elements use."""
        used = 0
        for element in self._field.elements:
            if element.groups != EVERYBODY:
                used |= element.groups
            if element.target_group >= 0:
                used |= 1 << element.target_group
        return used

    def has_source(self, source: str) -> bool:
        """Whether an element of this source is active."""
        return any(element.source == source for element in self._field.elements)

    def forget(self, source: str, beat: float, *, other: bool | None = None, at_once: bool = False) -> None:
        """Fade out the elements of `source`.

        `other`: only if its last one is not a repulsor (true) or is one (false). `at_once`: remove the last one without
        a fade.
        """
        last = self._last_of.get(source)
        if last is None or (other is not None and (last.table_kind == REPULSOR) == other):
            return
        del self._last_of[source]
        if at_once:
            self._field.remove(last)
        else:
            self._field.end(beat, source=source)

    def clear(self, beat: float) -> None:
        """Fade out all elements from `beat` on, from their present levels. Elements that have not begun are removed."""
        self._field.clear(beat)

    def end_source(self, source: str, beat: float) -> None:
        """Fade out the elements of this source from `beat` on, from their present levels."""
        if self._last_of.pop(source, None) is not None:
            self._field.end(beat, source=source)

    def update_groups(self, position: Float32) -> None:
        """Update the masks after dancers have changed their groups."""
        self._group_masks.update_groups(position)

    def resize(self, half_width: float, half_depth: float) -> None:
        """Set the stage's half sizes [m]."""
        self._field.resize(half_width, half_depth)

    # -- each tick -----------------------------------------------------------------------------------------------

    def refresh(self, beat: float, wants: AgentCommand, state: AgentState) -> None:
        """Update which elements act at `beat`. Called once a tick, before `blend`."""
        self._field.refresh(beat, wants, state, self._group_masks.bits)

    def blend(self, wants: AgentCommand, state: AgentState, *, time: float, beat: float, ahead: bool) -> None:
        """Blend the elements' influence at `beat` on agents in `state` into the commands `wants`.

        `ahead`: for the look-ahead, on a copy; `refresh` must be called before the next call without it.
        """
        influence = self._ahead if ahead else None
        if ahead:
            self._field.preview(beat)
        self._field.apply(wants, state, self._group_masks.bits, time=time, influence=influence)

    def show(self, view: StageView) -> None:
        """Copy the acting elements into the drawing snapshot."""
        self._field.write_view(view)
