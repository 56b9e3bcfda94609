"""Playhead: the position in the sections of a score for each measure of the show (T015).

Measures of the show count from 0 at its measure lines. Requests such as jumps take effect at a line.
"""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

END: Final = -1
"""Next section after the last one, and the section of a `Place` outside of all sections."""

When = Literal["measure", "section"]


@dataclass(frozen=True, slots=True)
class SectionTiming:
    """A section as the playhead sees it."""

    name: str
    measures: int | None
    """Length of one pass; None: no end."""
    repeat: int = 1
    """Number of passes before the next section; 0: until an operator advances."""
    next_section: int = END
    """Index of the next section, or END."""


@dataclass(frozen=True, slots=True)
class Place:
    """Position in the score: one measure of one section."""

    section: int
    """Index of the section; END before the first downbeat and after the end of the score."""
    measure: int
    """Measure within the section, from 0."""
    turn: int = 0
    """How often this section had begun before, since the start of the show."""


@dataclass(frozen=True, slots=True)
class PlayheadState:
    """Position of the score in one measure of the show, with the state needed to continue."""

    place: Place
    passes: int
    """Passes of this visit to the section, including the present one."""
    begin_counts: tuple[int, ...]
    """How often each section has begun."""
    entered: bool
    """Whether the score entered this place with this measure; a held measure starts nothing again."""
    jumped: bool = False
    """Whether a request brought the score here."""


@dataclass(frozen=True, slots=True)
class PlayheadRequest:
    """Requests that wait for a line."""

    section: int | None = None
    """Target section of a jump."""
    measure: int = 0
    at_section: bool = False
    """Whether the jump waits for the end of the section."""
    leave: bool = False
    """Whether to leave the section after this pass, regardless of its repeats."""


LOOKAHEAD_MEASURES: Final = 512
"""Look-ahead for the next beginning of a section [measures]."""
KEPT_MEASURES: Final = 4
"""Past measures that are kept, because callers may still ask about the last one."""


class Playhead:
    """Position of each measure. Deterministic: the same calls give the same places. Thread: the show's."""

    def __init__(self, sections: Sequence[SectionTiming]) -> None:
        """At least one stretch; before the first `begin_measure` the score waits for measure 0 of the first."""
        self.sections = tuple(sections)
        self.measure = -1
        """Current measure of the show."""
        self.held = False
        """Whether the score stays in its measure."""
        self.practice: tuple[int, int] | None = None
        """First and last measure of the practice loop in the written score, from 0; None: no practice."""
        self._request = PlayheadRequest()
        self._states = {-1: PlayheadState(Place(END, -1), 0, (0,) * len(self.sections), entered=True)}
        self._section_starts: list[int] = []
        """First measure of each section in the written score."""
        first = 0
        for stretch in self.sections:
            self._section_starts.append(first)
            first += stretch.measures or 0

    def apply_patch(self, fresh: "Playhead") -> None:
        """Adopt the sections of an edited score. The section is found by name, else by its written measure number.

        In a section that is shorter now, the measure wraps around. A jump to a removed section and practice in removed
        measures are cancelled.
        """
        old, names = self.sections, {stretch.name.casefold(): i for i, stretch in enumerate(fresh.sections)}
        known = [names.get(stretch.name.casefold()) for stretch in old]
        begun = [0] * len(fresh.sections)
        stand = self._states[self.measure]
        for index, count in zip(known, stand.begin_counts, strict=True):
            if index is not None:
                begun[index] = count
        written = self.written_measure(stand.place)
        self.sections, self._section_starts = fresh.sections, fresh._section_starts
        place, asked = stand.place, self._request
        if place.section != END:
            place = self._relocate(known[place.section], place, written)
        if asked.section not in (None, END):
            index = known[asked.section or 0]
            size = None if index is None else self.sections[index].measures
            there = index is not None and (size is None or asked.measure < size)
            asked = replace(asked, section=index) if there else PlayheadRequest(leave=asked.leave)
        if self.practice is not None and self.length is not None and self.practice[1] >= self.length:
            self.practice = None
        self._states = {self.measure: replace(stand, place=place, begin_counts=tuple(begun))}
        self._set_request(asked)

    def _relocate(self, index: int | None, place: Place, written: int) -> Place:
        """Return `place` in the present sections; its section has the number `index` now."""
        if index is not None:
            size = self.sections[index].measures
            return replace(place, section=index, measure=place.measure if size is None else place.measure % size)
        try:
            return self.place_of_written(written)
        except ValueError:
            return Place(0, 0)

    # -- position ----------------------------------------------------------------------------------------------

    def begin_measure(self, measure: int) -> None:
        """Begin `measure` (from 0; below 0 before the first downbeat)."""
        if measure < 0:
            self._states = {measure: replace(self._states[self.measure], place=Place(END, measure))}
        else:
            last = self._state_at(max(measure - 1, -1)) if self.measure < measure - 1 else self._states[self.measure]
            stand = self._states.get(measure) or self._next(last, measure)
            self._states = {k: kept for k, kept in self._states.items() if measure - KEPT_MEASURES <= k < measure}
            self._states[measure] = stand
            self._clear_done(stand)
        self.measure = measure

    def place(self, measure: int) -> Place:
        """Return the place of `measure`: the current one, one of the last few, or a future one if no more requests
        come."""
        return self._state_at(measure).place

    ahead = place

    def section_name(self, place: Place) -> str:
        """Return the name of the place's section; empty outside of all sections."""
        return "" if place.section == END else self.sections[place.section].name

    def entered(self, measure: int) -> bool:
        """Whether the score enters its place with `measure`; False while held and outside of all sections."""
        stand = self._state_at(measure)
        return stand.entered and stand.place.section != END

    def jumped(self, measure: int) -> bool:
        """Whether a request brought the score to its place in `measure`."""
        return self._state_at(measure).jumped

    def written_measure(self, place: Place) -> int:
        """Return the measure of `place` in the written score (each section once, in order), from 0."""
        return place.measure if place.section == END else self._section_starts[place.section] + place.measure

    def place_of_written(self, measure: int) -> Place:
        """Return the place of a measure of the written score; raises ValueError if there is none."""
        index = bisect_right(self._section_starts, measure) - 1
        length = self.sections[index].measures
        if measure >= 0 and (length is None or measure < self._section_starts[index] + length):
            return Place(index, measure - self._section_starts[index])
        raise ValueError(f"the score has no measure {measure + 1}: it has {self.length}")

    @property
    def length(self) -> int | None:
        """Measures of the written score; None if it has no end."""
        last = self.sections[-1].measures
        return None if last is None else self._section_starts[-1] + last

    @property
    def passes(self) -> int:
        """Number of the current pass through the section, from 1 at each arrival."""
        return self._state_at(self.measure).passes

    @property
    def waiting(self) -> bool:
        """Whether the current section repeats until an operator advances."""
        section = self.place(self.measure).section
        return section != END and self.sections[section].repeat == 0 and not self._request.leave

    @property
    def pending_jump(self) -> tuple[int, int, When] | None:
        """The waiting jump: section, measure and when it happens; None if there is none."""
        asked = self._request
        if asked.section is None:
            return None
        return asked.section, asked.measure, "section" if asked.at_section else "measure"

    @property
    def course(self) -> tuple[object, ...]:
        """Everything that decides the places of future measures: while it is the same, they are the same."""
        return self.measure, self.pending_jump, self.practice, self.held, self.waiting

    def next_begin(self, first: int, begins: Callable[[Place], bool] = lambda place: place.measure == 0) -> int | None:
        """Return the first measure from `first` on with which a section begins, or another place that `begins`; None
        if there is none within `LOOKAHEAD_MEASURES`."""
        for measure in range(first, first + LOOKAHEAD_MEASURES):
            if self.entered(measure) and begins(self.place(measure)):
                return measure
        return None

    # -- requests ----------------------------------------------------------------------------------------------

    def jump(self, section: int, measure: int = 0, when: When = "measure") -> None:
        """Go to `measure` (from 0) of a section at the next line or after the present pass; practice ends.

        The last jump counts. Raises ValueError for a missing place.
        """
        if not 0 <= section < len(self.sections):
            raise ValueError(f"there is no section {section}")
        size = self.sections[section].measures
        if measure < 0 or (size is not None and measure >= size):
            raise ValueError(f"section {self.sections[section].name!r} has no measure {measure + 1}: it has {size}")
        self.practice = None
        self._set_request(PlayheadRequest(section, measure, when == "section"))

    def advance(self, when: When = "section") -> None:
        """Leave the section for the next one, after the present pass regardless of repeats, or at the next line.

        At the end of the score this starts it again.
        """
        here = self.place(self.measure).section
        if here == END or when == "measure":
            then = 0 if here == END else self.sections[here].next_section
            if then == END:
                self._set_request(PlayheadRequest(END))
            else:
                self.jump(then)
            return
        self.practice = None
        self._set_request(replace(self._request, leave=True))

    def hold(self, on: bool) -> None:
        """Keep the score in its present measure, or resume it; the dancers continue with their current steps."""
        self.held = on
        self._set_request(self._request)

    def loop(self, practice: tuple[int, int] | None) -> None:
        """Practice: from the next line on repeat these measures of the written score (from 0, both included); None:
        resume from the present measure. Raises ValueError for missing measures."""
        if practice is not None:
            first, last = practice
            if first > last:
                raise ValueError(f"measures {first + 1} to {last + 1}: the first one comes last")
            self.place_of_written(first), self.place_of_written(last)
        self.practice = practice
        self._set_request(PlayheadRequest())

    # -- transitions -------------------------------------------------------------------------------------------

    def _set_request(self, request: PlayheadRequest) -> None:
        self._request = request
        self._states = {k: stand for k, stand in self._states.items() if k <= self.measure}

    def _state_at(self, measure: int) -> PlayheadState:
        if measure in self._states:
            return self._states[measure]
        if measure < self.measure:
            return replace(self._states[self.measure], place=Place(END, measure), entered=False)
        last = self.measure
        while last + 1 in self._states:
            last += 1
        for number in range(last + 1, measure + 1):
            self._states[number] = self._next(self._states[number - 1], number)
        return self._states[measure]

    def _clear_done(self, state: PlayheadState) -> None:
        """Clear the requests that took effect with this measure."""
        if state.jumped:
            self._request = PlayheadRequest()

    def _pending(self, number: int) -> PlayheadRequest:
        """Return the requests for the line of `number`; each takes effect once, at the first possible measure."""
        happened = any(stand.jumped for k, stand in self._states.items() if self.measure < k < number)
        return PlayheadRequest() if happened else self._request

    def _next(self, state: PlayheadState, number: int) -> PlayheadState:
        """Return the position in `number`, the measure after `state`."""
        if number < 0:
            return replace(state, place=Place(END, number))
        here, asked = state.place, self._pending(number)
        if asked.section is not None and not asked.at_section:
            return self._enter(state, asked.section, asked.measure, 1, jumped=True)
        if self.practice is not None:
            return self._next_in_practice(state)
        if here.section == END:
            if here.measure < 0:
                return self._enter(state, 0, 0, 1)
            return replace(state, place=Place(END, here.measure + 1), entered=False, jumped=False)
        if self.held:
            return replace(state, entered=False, jumped=False)
        stretch = self.sections[here.section]
        if stretch.measures is None or here.measure + 1 < stretch.measures:
            there = replace(here, measure=here.measure + 1)
            return replace(state, place=there, entered=True, jumped=False)
        if asked.section is not None:
            return self._enter(state, asked.section, asked.measure, 1, jumped=True)
        if asked.leave:
            return self._enter(state, stretch.next_section, 0, 1, jumped=True)
        if stretch.repeat == 0 or state.passes < stretch.repeat:
            return self._enter(state, here.section, 0, state.passes + 1)
        return self._enter(state, stretch.next_section, 0, 1)

    def _next_in_practice(self, state: PlayheadState) -> PlayheadState:
        assert self.practice is not None
        first, last = self.practice
        here = self.written_measure(state.place) if state.place.section != END else END
        if first <= here < last:
            there = self.place_of_written(here + 1)
            if there.section == state.place.section:
                place = replace(state.place, measure=there.measure)
                return replace(state, place=place, entered=True, jumped=False)
            return self._enter(state, there.section, there.measure, 1)
        there = self.place_of_written(first)
        return self._enter(state, there.section, there.measure, state.passes + 1)

    def _enter(
        self, state: PlayheadState, section: int, measure: int, passes: int, *, jumped: bool = False
    ) -> PlayheadState:
        """Return the position at the start of a visit or pass of a section."""
        if section == END:
            return PlayheadState(Place(END, 0), 0, state.begin_counts, entered=False, jumped=jumped)
        turn = state.begin_counts[section]
        begun = (*state.begin_counts[:section], turn + 1, *state.begin_counts[section + 1 :])
        return PlayheadState(Place(section, measure, turn), passes, begun, entered=True, jumped=jumped)
