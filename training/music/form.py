"""The form of a piece: sections with their bars, chords and players; and the bar as a player sees it."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from random import Random

from training.music.harmony import Chord, Key
from training.music.piece import Metre

Harmony = list[list[tuple[float, Chord]]]
"""For each bar its chords and where they start, as shares of the bar."""


@dataclass(slots=True)
class Section:
    """So many bars with one idea. `roles`: who plays (None: all). Sections of one label have one harmony and melody."""

    label: str
    bars: int
    energy: float = 0.7
    roles: Collection[str] | None = None
    harmony: Harmony = field(default_factory=list)


@dataclass(slots=True)
class Bar:
    """One bar of the form. Positions are in beats from its beginning."""

    index: int
    metre: Metre
    key: Key
    section: Section
    place: int  # bar within the section
    chords: list[tuple[float, Chord]]
    following: Chord  # the chord of the next bar
    first: bool  # of the piece

    @property
    def energy(self) -> float:
        return self.section.energy

    @property
    def closing(self) -> bool:
        """The last bar of its section."""
        return self.place == self.section.bars - 1

    def phrase_end(self, length: int = 4) -> bool:
        """The last bar of a phrase of so many bars."""
        return self.place % length == length - 1 or self.closing

    def chord_at(self, position: float) -> Chord:
        found = self.chords[0][1]
        for start, chord in self.chords:
            if start <= position + 1e-6:
                found = chord
        return found

    def spans(self) -> list[tuple[float, float, Chord]]:
        """Start, length and chord of each span with one chord."""
        starts = [start for start, _ in self.chords] + [float(self.metre.beats)]
        return [(start, starts[index + 1] - start, chord) for index, (start, chord) in enumerate(self.chords)]


def bars_of(sections: list[Section], metre: Metre, key: Key) -> list[Bar]:
    """All bars of the form, with the chords' places turned into beats of the metre (rounded to a beat)."""
    flat = [(section, place) for section in sections for place in range(section.bars)]
    bars = []
    for index, (section, place) in enumerate(flat):
        row = section.harmony[place % len(section.harmony)]
        chords = [(float(_round(share, metre)), chord) for share, chord in row]
        after, at = flat[(index + 1) % len(flat)]
        following = after.harmony[at % len(after.harmony)][0][1]
        bars.append(Bar(index, metre, key, section, place, chords, following, index == 0))
    return bars


def _round(share: float, metre: Metre) -> int:
    beat = round(share * metre.beats + 0.01)
    return min(metre.beats - 1, beat)


Compose = Callable[[str, int], Harmony]
"""Label and bars of a section to its harmony."""


def lay_out(
    rng: Random,
    plan: list[tuple[str, float, Collection[str] | None]],
    bars: int,
    compose: Compose,
    lengths: tuple[int, ...] = (4, 8, 8, 8, 16),
) -> list[Section]:
    """Sections of the plan (label, energy, roles) until the bars are full, each label with one length and harmony."""
    known: dict[str, Harmony] = {}
    sections: list[Section] = []
    have, turn = 0, 0
    if rng.random() < 0.4:
        turn = rng.randrange(len(plan))
    while have < bars:
        label, energy, roles = plan[turn % len(plan)]
        if label not in known:
            length = rng.choice(lengths)
            if label in ("intro", "break", "drums"):
                length = rng.choice([2, 4, 4, 8])
            known[label] = compose(label, length)
        sections.append(Section(label, len(known[label]), energy, roles, known[label]))
        have += len(known[label])
        turn += 1
    return sections


RHYTHM = ("drums", "percussion", "bass")


def song(rng: Random, roles: Collection[str]) -> list[tuple[str, float, Collection[str] | None]]:
    """The plan of a song: verses, choruses, an intro by some, a break without drums or with the drums alone."""
    named = sorted(roles)
    plan: list[tuple[str, float, Collection[str] | None]] = []
    draw = rng.random()
    if draw < 0.25:
        plan.append(("intro", 0.5, rng.sample(named, max(1, len(named) // 2))))
    elif draw < 0.4 and "drums" in roles:
        plan.append(("drums", 0.6, ("drums", "percussion")))
    quiet = [role for role in named if role not in ("lead", "brass") or rng.random() < 0.5]
    thin = [role for role in named if rng.random() < 0.75 or role == "drums"] or named
    plan += [("verse", rng.uniform(0.35, 0.65), quiet), ("chorus", rng.uniform(0.7, 1.0), None)]
    if rng.random() < 0.5:
        plan.insert(-1, ("verse", 0.6, thin))
    draw = rng.random()
    if draw < 0.18:
        plan.append(("break", 0.3, [role for role in named if role not in RHYTHM] or named))
    elif draw < 0.3:
        plan.append(("break", 0.6, [role for role in named if role in RHYTHM] or named))
    elif draw < 0.6:
        plan.append(("bridge", rng.uniform(0.4, 0.9), thin))
    return plan


def layers(rng: Random, roles: Collection[str]) -> list[tuple[str, float, Collection[str] | None]]:
    """The plan of a track: players enter one after the other over one loop, some drop out, all come back."""
    order = sorted(roles)
    rng.shuffle(order)
    if "drums" in order and rng.random() < 0.6:
        order.remove("drums")
        order.insert(0, "drums")
    plan: list[tuple[str, float, Collection[str] | None]] = []
    for count in range(rng.randint(1, len(order)), len(order) + 1):
        plan.append(("loop", 0.5 + 0.4 * count / len(order), order[:count]))
    plan.append(("loop", 1.0, None))
    if rng.random() < 0.5:
        plan.append(("break", 0.3, [role for role in order if role != "drums"] or order))
        plan.append(("loop", 1.0, None))
    return plan
