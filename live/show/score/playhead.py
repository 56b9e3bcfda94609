"""Playhead: where in its sections the score is, measure after measure, and where it goes when somebody asks (T015).

Measures are those of the show, counted from 0 by its measure lines. What is asked for takes effect at a line.

Places: the sections of a score as the playhead knows them, and where in them one measure of the show is (T015).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

END: Final = -1
"""Where a score goes that is over, and the section of a `Place` outside of all sections."""

When = Literal["measure", "section"]


@dataclass(frozen=True, slots=True)
class Stretch:
    """A section as the playhead knows it."""

    name: str
    measures: int | None
    """How long one pass is; None: it has no end."""
    repeat: int = 1
    """How many passes there are before it goes on; 0: until somebody says so."""
    then: int = END
    """Index of the section that comes after it, or END."""


@dataclass(frozen=True, slots=True)
class Place:
    """One measure of the score."""

    section: int
    """Index of the section; END before the first downbeat and when the score is over."""
    measure: int
    """Measure within the section, from 0."""
    turn: int = 0
    """How often this section had begun before, since the start of the show."""


@dataclass(frozen=True, slots=True)
class Stand:
    """Where the score is in one measure of the show, and what must be known to go on."""

    place: Place
    passes: int
    """Passes of this visit to the section, the present one included."""
    begun: tuple[int, ...]
    """How often each section has begun."""
    entered: bool
    """Whether the score came to this place with this measure: what is held in its measure begins nothing again."""
    jumped: bool = False
    """Whether it came here because somebody asked."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What waits for a line."""

    section: int | None = None
    """Where a jump goes ..."""
    measure: int = 0
    at_section: bool = False
    """... and whether it waits for the section's end."""
    leave: bool = False
    """Whether the section is left when its pass is over, whatever it repeats."""


LATER: Final = 4
"""Measures that are kept of what is over: somebody may still ask about the last one."""


class Playhead:
    """The place of every measure; deterministic: the same calls give the same places. Thread: the show's."""

    def __init__(self, stretches: Sequence[Stretch]) -> None:
        """At least one stretch; before the first `cross` the score waits for measure 0 of the first."""
        self.stretches = tuple(stretches)
        self.measure = -1
        """The running measure of the show."""
        self.held = False
        """Whether the score stays where it is."""
        self.practice: tuple[int, int] | None = None
        """First and last measure of the written score, from 0, that come again and again; None: no practice."""
        self._asked = Asked()
        self._stands = {-1: Stand(Place(END, -1), 0, (0,) * len(self.stretches), entered=True)}
        self._firsts: list[int] = []
        """The first measure of each section, all written one after the other."""
        first = 0
        for stretch in self.stretches:
            self._firsts.append(first)
            first += stretch.measures or 0

    def take_patch(self, fresh: "Playhead") -> None:
        """Go on in the sections of an edited score: where it is by name, else in the measure that has its number.

        A section that is shorter now is in the measure that follows as often as it fits. A jump to a section that is
        gone, and practice in measures that are, are forgotten.
        """
        old, names = self.stretches, {stretch.name.casefold(): i for i, stretch in enumerate(fresh.stretches)}
        known = [names.get(stretch.name.casefold()) for stretch in old]
        begun = [0] * len(fresh.stretches)
        stand = self._stands[self.measure]
        for index, count in zip(known, stand.begun, strict=True):
            if index is not None:
                begun[index] = count
        written = self.written(stand.place)
        self.stretches, self._firsts = fresh.stretches, fresh._firsts
        place, asked = stand.place, self._asked
        if place.section != END:
            place = self._found(known[place.section], place, written)
        if asked.section not in (None, END):
            index = known[asked.section or 0]
            size = None if index is None else self.stretches[index].measures
            there = index is not None and (size is None or asked.measure < size)
            asked = replace(asked, section=index) if there else Asked(leave=asked.leave)
        if self.practice is not None and self.length is not None and self.practice[1] >= self.length:
            self.practice = None
        self._stands = {self.measure: replace(stand, place=place, begun=tuple(begun))}
        self._ask(asked)

    def _found(self, index: int | None, place: Place, written: int) -> Place:
        """Where `place`, in the section that has the number `index` now, is in the sections as they are."""
        if index is not None:
            size = self.stretches[index].measures
            return replace(place, section=index, measure=place.measure if size is None else place.measure % size)
        try:
            return self.of_written(written)
        except ValueError:
            return Place(0, 0)

    # -- where it is -------------------------------------------------------------------------------------------

    def cross(self, measure: int) -> None:
        """`measure` (from 0; below 0 before the first downbeat) begins."""
        if measure < 0:
            self._stands = {measure: replace(self._stands[self.measure], place=Place(END, measure))}
        else:
            last = self._stand(max(measure - 1, -1)) if self.measure < measure - 1 else self._stands[self.measure]
            stand = self._stands.get(measure) or self._next(last, measure)
            self._stands = {k: kept for k, kept in self._stands.items() if measure - LATER <= k < measure}
            self._stands[measure] = stand
            self._settle(stand)
        self.measure = measure

    def place(self, measure: int) -> Place:
        """Where the score is in `measure`: the running one, one of the last few, or one to come if nothing more is
        asked for."""
        return self._stand(measure).place

    ahead = place

    def section_name(self, place: Place) -> str:
        """What its section is called; empty outside of all."""
        return "" if place.section == END else self.stretches[place.section].name

    def entered(self, measure: int) -> bool:
        """Whether the score comes to its place with `measure`: not if it is held there, nor outside of all sections."""
        stand = self._stand(measure)
        return stand.entered and stand.place.section != END

    def jumped(self, measure: int) -> bool:
        """Whether it is where it is in `measure` because somebody asked for it."""
        return self._stand(measure).jumped

    def written(self, place: Place) -> int:
        """The measure of `place` in the written score, all sections one after the other once, from 0."""
        return place.measure if place.section == END else self._firsts[place.section] + place.measure

    def of_written(self, measure: int) -> Place:
        """The place of a measure of the written score; ValueError if it has none such."""
        for index, (first, stretch) in enumerate(zip(self._firsts, self.stretches, strict=True)):
            if measure >= first and (stretch.measures is None or measure < first + stretch.measures):
                return Place(index, measure - first)
        raise ValueError(f"the score has no measure {measure + 1}: it has {self.length}")

    @property
    def length(self) -> int | None:
        """Measures of the written score; None if it has no end."""
        last = self.stretches[-1].measures
        return None if last is None else self._firsts[-1] + last

    @property
    def passes(self) -> int:
        """Which pass of its section the running measure belongs to, since the score came there, from 1."""
        return self._stand(self.measure).passes

    @property
    def waiting(self) -> bool:
        """Whether the section that runs repeats until somebody says that it goes on."""
        section = self.place(self.measure).section
        return section != END and self.stretches[section].repeat == 0 and not self._asked.leave

    @property
    def going(self) -> tuple[int, int, When] | None:
        """The jump that waits: section, measure, and what for; None if there is none."""
        asked = self._asked
        if asked.section is None:
            return None
        return asked.section, asked.measure, "section" if asked.at_section else "measure"

    # -- what is asked for -------------------------------------------------------------------------------------

    def jump(self, section: int, measure: int = 0, when: When = "measure") -> None:
        """Go to `measure` (from 0) of a section at the next line, or when the present pass is over; practice ends.

        The last jump counts. ValueError for a place that is not there.
        """
        if not 0 <= section < len(self.stretches):
            raise ValueError(f"there is no section {section}")
        size = self.stretches[section].measures
        if measure < 0 or (size is not None and measure >= size):
            raise ValueError(f"section {self.stretches[section].name!r} has no measure {measure + 1}: it has {size}")
        self.practice = None
        self._ask(Asked(section, measure, when == "section"))

    def advance(self, when: When = "section") -> None:
        """Leave the section for what follows it: when its pass is over, however often it repeats, or at the next line.

        From the end of the score this begins it again.
        """
        here = self.place(self.measure).section
        if here == END or when == "measure":
            then = 0 if here == END else self.stretches[here].then
            if then == END:
                self._ask(Asked(END))
            else:
                self.jump(then)
            return
        self.practice = None
        self._ask(replace(self._asked, leave=True))

    def hold(self, on: bool) -> None:
        """The score stays in its present measure, or goes on; the dance goes on with what it has."""
        self.held = on
        self._ask(self._asked)

    def loop(self, practice: tuple[int, int] | None) -> None:
        """Practise: from the next line on these measures of the written score (from 0, both included) come again and
        again, whatever repeats; None: go on from where it is. ValueError for measures that are not there."""
        if practice is not None:
            first, last = practice
            if first > last:
                raise ValueError(f"measures {first + 1} to {last + 1}: the first one comes last")
            self.of_written(first), self.of_written(last)
        self.practice = practice
        self._ask(Asked())

    # -- how it goes on ----------------------------------------------------------------------------------------

    def _ask(self, asked: Asked) -> None:
        self._asked = asked
        self._stands = {k: stand for k, stand in self._stands.items() if k <= self.measure}

    def _stand(self, measure: int) -> Stand:
        if measure in self._stands:
            return self._stands[measure]
        if measure < self.measure:
            return replace(self._stands[self.measure], place=Place(END, measure), entered=False)
        last = self.measure
        while last + 1 in self._stands:
            last += 1
        for number in range(last + 1, measure + 1):
            self._stands[number] = self._next(self._stands[number - 1], number)
        return self._stands[measure]

    def _settle(self, stand: Stand) -> None:
        """What has happened with this measure is not asked for any more."""
        if stand.jumped:
            self._asked = Asked()

    def _pending(self, number: int) -> Asked:
        """What is asked for at the line of `number`: it happens once, so only for the first measure that can."""
        happened = any(stand.jumped for k, stand in self._stands.items() if self.measure < k < number)
        return Asked() if happened else self._asked

    def _next(self, stand: Stand, number: int) -> Stand:
        """Where the score is in `number`, the measure after `stand`."""
        if number < 0:
            return replace(stand, place=Place(END, number))
        here, asked = stand.place, self._pending(number)
        if asked.section is not None and not asked.at_section:
            return self._begun(stand, asked.section, asked.measure, 1, jumped=True)
        if self.practice is not None:
            return self._practised(stand)
        if here.section == END:
            if here.measure < 0:
                return self._begun(stand, 0, 0, 1)
            return replace(stand, place=Place(END, here.measure + 1), entered=False, jumped=False)
        if self.held:
            return replace(stand, entered=False, jumped=False)
        stretch = self.stretches[here.section]
        if stretch.measures is None or here.measure + 1 < stretch.measures:
            there = replace(here, measure=here.measure + 1)
            return replace(stand, place=there, entered=True, jumped=False)
        if asked.section is not None:
            return self._begun(stand, asked.section, asked.measure, 1, jumped=True)
        if asked.leave:
            return self._begun(stand, stretch.then, 0, 1, jumped=True)
        if stretch.repeat == 0 or stand.passes < stretch.repeat:
            return self._begun(stand, here.section, 0, stand.passes + 1)
        return self._begun(stand, stretch.then, 0, 1)

    def _practised(self, stand: Stand) -> Stand:
        assert self.practice is not None
        first, last = self.practice
        here = self.written(stand.place) if stand.place.section != END else END
        if first <= here < last:
            there = self.of_written(here + 1)
            if there.section == stand.place.section:
                place = replace(stand.place, measure=there.measure)
                return replace(stand, place=place, entered=True, jumped=False)
            return self._begun(stand, there.section, there.measure, 1)
        there = self.of_written(first)
        return self._begun(stand, there.section, there.measure, stand.passes + 1)

    def _begun(self, stand: Stand, section: int, measure: int, passes: int, *, jumped: bool = False) -> Stand:
        """The score comes to a section."""
        if section == END:
            return Stand(Place(END, 0), 0, stand.begun, entered=False, jumped=jumped)
        turn = stand.begun[section]
        begun = (*stand.begun[:section], turn + 1, *stand.begun[section + 1 :])
        return Stand(Place(section, measure, turn), passes, begun, entered=True, jumped=jumped)
