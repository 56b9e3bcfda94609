"""Footstep timing of a sketch: stances, swings, flights and weight distribution (in beats)."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion.curve import interpolate
from live.motion.sketch.sketch_file import Key, Sketch

FAR_BEAT: Final = 1000.0
"""A beat later than all others; its negative is earlier than all others."""
_MAX_RISE_BEATS: Final = 0.5
"""Maximum duration of a foot's rise to a key in the air [beats]."""


@dataclass(frozen=True, slots=True)
class Stance:
    """One foot at one place, from its arrival to its departure [beats]."""

    arrive: float
    leave: float
    place: tuple[float, float, float]
    """Out and forward from its neutral place [m], turned out [rad], in body axes."""
    contacts: tuple[Key, ...]
    """The keys of this stance."""
    air: tuple[Key, ...]
    """The keys in the air between this place and the next."""
    lift: float | None
    """Height of the swing to the next place [m], if given."""
    number: int
    """Index of the stance in the sketch, equal in every repetition."""

    @property
    def middle(self) -> float:
        """The beat on which the foot is under the body."""
        return 0.5 * (self.arrive + self.leave)

    @property
    def touches(self) -> bool:
        """Whether the foot only touches the floor, without weight."""
        return all("touch" in key.amounts for key in self.contacts)


def find_stances(sketch: Sketch, part: str, first: float, last: float) -> list[Stance]:
    """Return the stances of a foot that cover the beats from `first` to `last`, with at least one more at each end."""
    keys = [(key.beat, key, number) for number, key in enumerate(sketch.parts.get(part, ()))]
    home = Key(0.0, {"home": 1.0})
    if not any(_on_floor(key) for _, key, _ in keys):
        keys.insert(0, (0.0 if not keys or keys[0][0] > 0.0 else -0.5, home, -1))
    if sketch.cyclic:
        cycles = range(math.floor(first / sketch.beats) - 2, math.ceil(last / sketch.beats) + 3)
        events = [(beat + cycle * sketch.beats, key, number) for cycle in cycles for beat, key, number in keys]
    else:
        last = max(sketch.beats - 0.5, 0.5 * (keys[-1][0] + sketch.beats))
        events = [(-FAR_BEAT, home, -1), *keys, (last, home, -2)]
    while not _on_floor(events[0][1]):
        events.pop(0)
    result = _stances(events, sketch.swing)
    if len(result) == 1:
        return [replace(result[0], arrive=-FAR_BEAT)]
    return result[1:-1] if sketch.cyclic else result  # the outermost stances are incomplete


def _on_floor(key: Key) -> bool:
    return key.amounts.get("up", 0.0) <= 0.0


def place_of(key: Key) -> tuple[float, float, float]:
    """Return out and forward from the neutral place [m] and turn-out [rad] of a foot's key."""
    amounts = key.amounts
    return amounts.get("out", 0.0), amounts.get("forward", 0.0), amounts.get("turn", 0.0)


def _stances(events: list[tuple[float, Key, int]], swing: float) -> list[Stance]:
    result: list[Stance] = []
    arrive, air, number = events[0][0], list[Key](), events[0][2]
    contacts = [replace(events[0][1], beat=arrive)]
    last_contact = max(arrive, 0.0) if arrive <= -FAR_BEAT else arrive
    for beat, key, key_number in events[1:]:
        if not _on_floor(key):
            air.append(replace(key, beat=beat))
            continue
        if not air and place_of(key) == place_of(contacts[-1]) and "lift" not in key.amounts:
            contacts.append(replace(key, beat=beat))
            last_contact = beat
            continue
        goal = air[0].beat if air else beat
        gap = goal - last_contact
        leave = max(goal - min(_MAX_RISE_BEATS if air else swing, 0.75 * gap), arrive + 0.05)
        result.append(
            Stance(arrive, leave, place_of(contacts[0]), tuple(contacts), tuple(air), key.amounts.get("lift"), number)
        )
        arrive, contacts, air, number, last_contact = beat, [replace(key, beat=beat)], [], key_number, beat
    result.append(Stance(arrive, FAR_BEAT, place_of(contacts[0]), tuple(contacts), (), None, number))
    return result


def delay_departures(own: list[Stance], other: list[Stance]) -> list[Stance]:
    """Return the stances with later departures where the other foot is still in the air; leaps need explicit keys."""
    result = []
    for stance in own:
        landing = [b.arrive for a, b in pairwise(other) if a.leave - 1e-6 < stance.leave < b.arrive]
        if landing and not stance.air:
            following = next((s.arrive for s in own if s.arrive > stance.leave), FAR_BEAT)
            stance = replace(stance, leave=max(stance.leave, min(landing[0], following - 0.2)))
        result.append(stance)
    return result


def find_flights(left: list[Stance], right: list[Stance]) -> list[tuple[float, float]]:
    """Return beat ranges (from, to) in which both feet are in the air."""
    gaps = [[(a.leave, b.arrive) for a, b in pairwise(own) if a.air] for own in (left, right)]
    both = [(max(a, c), min(b, d)) for a, b in gaps[0] for c, d in gaps[1]]
    return [(start, end) for start, end in both if end - start > 0.08]


def weight_balance(left: list[Stance], right: list[Stance], beats: Float) -> Float:
    """Return the weight distribution at `beats` (T,): +1 left foot, -1 right foot, 0 both (or in the air).

    Beyond ±1 in a long single support, where the foot must be directly under the body.
    """
    keys: list[tuple[float, float]] = []
    for own, sign in ((left, -1.0), (right, 1.0)):
        free: list[tuple[float, float]] = []
        for before, after in pairwise(own):
            start = before.arrive if before.touches else before.leave
            end = after.leave if after.touches else after.arrive
            if free and start <= free[-1][1]:
                free[-1] = (free[-1][0], end)
            else:
                free.append((start, end))
        for start, end in free:
            edge = min(0.3, 0.5 * (end - start))
            value = sign * (1.0 + 0.6 * min(max(end - start - 0.7, 0.0), 1.0))
            keys += [(start + edge, value), (end - edge, value)] if edge > 0.29 else [(start + edge, value)]
    keys.sort()
    merged: list[tuple[float, float]] = []
    for at, value in keys:
        if merged and at - merged[-1][0] < 0.02:
            merged[-1] = (merged[-1][0], 0.5 * (merged[-1][1] + value))
            continue
        if merged and at - merged[-1][0] > 2.01:  # long double support: the weight returns to the middle
            merged += [(merged[-1][0] + 0.8, 0.0), (at - 0.8, 0.0)]
        merged.append((at, value))
    if not merged:
        return np.zeros(len(beats))
    begin = merged[0][0] - 0.5
    if left[0].arrive <= -FAR_BEAT and right[0].arrive <= -FAR_BEAT:  # the sketch begins in the neutral stance
        begin = min(max(begin, 0.0), merged[0][0] - 0.05)
    table = np.array([(begin, 0.0), *merged, (merged[-1][0] + 0.5, 0.0)])
    return interpolate(table[:, 0], table[:, 1], beats)
