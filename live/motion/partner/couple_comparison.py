"""Agreement of an answer with the real follower: joints, facing, stances, turns, transitions and patterns (H022).

The paper compares patterns of eight beats, whose names a person has set, and two-beat segments within them: 86 of 91
patterns and 359 of 364 segments were those of the real follower. With labels of a person the same is counted here: each
unit of an answer has the label that its recording has there. Without, transitions between recognised stances are
compared, which is not the same: see `couple_states`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.clip import Clip
from live.motion.editing.facing import heading_of, wrap
from live.motion.partner.couple_states import CoupleStates, Transition, Turn
from live.motion.partner.decoder import Reading
from live.motion.partner.evaluation import follower_errors, joint_positions
from live.motion.partner.units import Units

NO_LABEL: Final = "no label"
"""Words for a pattern that the answer dances with units without a label."""
LabelAt = Callable[[str, float], str | None]
"""Returns the label of a recording by its name at a time [s]; None: there is none."""


@dataclass(frozen=True, slots=True)
class Count:
    """So many of so many agree."""

    same: int
    of: int

    @property
    def share(self) -> float | None:
        """The share from 0 to 1; None of nothing."""
        return self.same / self.of if self.of else None

    def __add__(self, other: "Count") -> "Count":
        return Count(self.same + other.same, self.of + other.of)


@dataclass(frozen=True, slots=True)
class LabelSpan:
    """A label from one time to another [s]."""

    begin: float
    end: float
    label: str | None


@dataclass(frozen=True, slots=True)
class PatternComparison:
    """One pattern: what the real follower danced, and what the answer does."""

    begin: float
    """Time [s]."""
    end: float
    real: str
    """Label of a person, or the recognised transitions in words."""
    answer: str
    same: bool
    whole: bool
    """Whether all of it is the same: every unit, or every transition, as the paper counts."""
    joint_m: float
    """Mean distance of the joints within it [m]."""
    facing_deg: float
    """Mean difference of the hips' headings within it [degrees]."""
    known: bool = True
    """Whether the answer's part of it can be told: most of it is danced with units that have a label."""


@dataclass(frozen=True, slots=True, eq=False)
class CoupleComparison:
    """How an answer agrees with the real follower over a take."""

    joint_m: float
    aligned_m: float
    hip_distance_m: float
    facing_deg: float
    turned_share: float
    """Share of the time in which the hips point more than 90 degrees away from the real ones."""
    stance: Count
    """Samples in the same stance."""
    embrace: Count
    """Samples in which both are open or both closed, whatever the hands."""
    turns: Count
    """Turns with a turn of the other in the same direction at that time, of all turns of both."""
    turn_kinds: Count
    """Of those, turns of the same kind."""
    transitions: Count
    """Transitions of four beats that are the same."""
    units: Count | None
    """Units with the same label of a person; None: without labels."""
    patterns: tuple[PatternComparison, ...]
    labelled: bool
    """Whether `patterns` compare labels of a person."""

    @property
    def pattern_count(self) -> Count:
        """How many patterns are the same, of those that are known."""
        known = [one for one in self.patterns if one.known]
        return Count(sum(one.same for one in known), len(known))

    @property
    def whole_count(self) -> Count:
        """How many patterns are wholly the same, of those that are known."""
        known = [one for one in self.patterns if one.known]
        return Count(sum(one.whole for one in known), len(known))


@dataclass(frozen=True, slots=True, eq=False)
class ComparedDance:
    """A take as the real follower danced it, or as it was answered."""

    follower: Clip
    states: CoupleStates
    transitions: tuple[Transition, ...]


def compare_couples(
    leader: Clip,
    real: ComparedDance,
    answer: ComparedDance,
    labels: Sequence[LabelSpan] = (),
    danced: Sequence[LabelSpan] = (),
) -> CoupleComparison:
    """Return how an answer agrees with the real follower.

    `labels`: the take's patterns, labelled by a person; `danced`: the units of the answer with their labels. Without
    `labels` two transitions are a pattern.
    """
    rate = real.follower.sample_rate
    count = min(leader.sample_count, real.follower.sample_count, answer.follower.sample_count)
    own, truth = joint_positions(answer.follower)[:count], joint_positions(real.follower)[:count]
    errors = follower_errors(own, truth, joint_positions(leader)[:count], rate)
    away = np.linalg.norm(own - truth, axis=-1).mean(axis=-1)
    headings = [heading_of(one.follower.rotation[:count, 0]) for one in (answer, real)]
    facing = np.degrees(np.abs(wrap(headings[0] - headings[1])))
    stances = answer.states.stance[:count], real.states.stance[:count]
    turns, kinds = _turn_agreement(real.states.turns, answer.states.turns)
    pairs = list(zip(real.transitions, answer.transitions, strict=False))

    def compared(begin: float, end: float, words: tuple[str, str | None], same: bool, whole: bool) -> PatternComparison:
        part = slice(round(begin * rate), max(round(end * rate), round(begin * rate) + 1))
        joint_m, degrees = (float(values[part].mean()) if len(values[part]) else 0.0 for values in (away, facing))
        known = words[1] is not None
        return PatternComparison(begin, end, words[0], words[1] or NO_LABEL, same, whole, joint_m, degrees, known)

    if labels:
        patterns = [compared(*row) for row in _labelled_patterns(labels, danced)]
    else:
        patterns = [compared(*row) for row in _recognised_patterns(pairs, rate)]
    return CoupleComparison(
        errors.joint_m, errors.aligned_m, errors.hip_distance_m, float(facing.mean()), float((facing > 90.0).mean()),
        Count(int((stances[0] == stances[1]).sum()), count),
        Count(int((stances[0] % 2 == stances[1] % 2).sum()), count),
        turns, kinds, Count(sum(one.same(other) for one, other in pairs), len(pairs)),
        _unit_agreement(labels, danced) if labels else None, tuple(patterns), bool(labels),
    )  # fmt: skip


def _turn_agreement(real: Sequence[Turn], answer: Sequence[Turn]) -> tuple[Count, Count]:
    """Return the agreement of turns, and of the kinds of those that meet.

    Each turn meets one of the other side that overlaps it and goes in its direction; the share is their F1 score.
    """
    free = list(answer)
    met, same = 0, 0
    for one in real:
        both = [each for each in free if min(one.end, each.end) > max(one.begin, each.begin)]
        both = [each for each in both if each.turns * one.turns > 0.0]
        if not both:
            continue
        best = max(both, key=lambda each: min(one.end, each.end) - max(one.begin, each.begin))
        free.remove(best)
        met += 1
        same += best.kind == one.kind
    return Count(2 * met, len(real) + len(answer)), Count(same, met)


Row = tuple[float, float, tuple[str, str | None], bool, bool]


def _recognised_patterns(pairs: list[tuple[Transition, Transition]], rate: float) -> list[Row]:
    """Return begin, end [s], words and agreement of each two transitions, which make a pattern."""
    found: list[Row] = []
    for first, second in zip(pairs[::2], pairs[1::2], strict=False):
        same = [one.same(other) for one, other in (first, second)]
        words = tuple(
            f"{one.before.words}, {one.turn}, {one.after.words}, {other.turn}, {other.after.words}"
            for one, other in zip(first, second, strict=True)
        )
        begin, end = first[0].begin / rate, second[0].end / rate
        found.append((begin, end, (words[0], words[1]), all(same), all(same)))
    return found


def _labelled_patterns(labels: Sequence[LabelSpan], danced: Sequence[LabelSpan]) -> list[Row]:
    """Return the same for labelled patterns; the answer's label is that of most of the time."""
    found: list[Row] = []
    for one in labels:
        seconds: dict[str | None, float] = {}
        for unit in danced:
            inside = min(one.end, unit.end) - max(one.begin, unit.begin)
            if inside > 0.0:
                seconds[unit.label] = seconds.get(unit.label, 0.0) + inside
        best = max(seconds, key=lambda name: seconds[name], default=None)
        middles = [unit for unit in danced if one.begin <= 0.5 * (unit.begin + unit.end) < one.end]
        whole = bool(middles) and all(unit.label == one.label for unit in middles)
        found.append((one.begin, one.end, (str(one.label), best), best == one.label, whole))
    return found


def _unit_agreement(labels: Sequence[LabelSpan], danced: Sequence[LabelSpan]) -> Count:
    """Return how many units have the take's label in their middle; those without a label on a side do not count."""
    same = of = 0
    for unit in danced:
        middle = 0.5 * (unit.begin + unit.end)
        real = next((one.label for one in labels if one.begin <= middle < one.end), None)
        if real is not None and unit.label is not None:
            of += 1
            same += real == unit.label
    return Count(same, of)


def danced_labels(reading: Reading, units: Units, label_at: LabelAt) -> list[LabelSpan]:
    """Return the units of an answer with the labels of their recordings: transcription comes with the search (H026)."""
    found = []
    for n, unit in enumerate(reading.unit.tolist()):
        begin = float(reading.start[n]) / reading.rate
        of = units.examples[int(units.example[unit])]
        middle = (float(units.start[unit]) + 0.5 * float(units.length[unit])) / units.rate
        found.append(LabelSpan(begin, begin + float(reading.duration[n]) / reading.rate, label_at(of.name, middle)))
    return found


def transition_cuts(beats: Float64, last: float, *, first: int, beats_each: int) -> Float64:
    """Return every `beats_each`th of the `beats` (n,), from the one of index `first` on, within 0 to `last`, which is
    in their unit."""
    inside = beats[first % beats_each :: beats_each]
    return np.asarray(inside[(inside >= 0.0) & (inside <= last)])
