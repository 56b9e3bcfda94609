"""Synthesis of a follower from a leader's motion: search, up-sampling, answer, feet and hands.

The distance of a unit (1) is not only that of the leader's points now, as in the paper, but also of those a while
before and after: what a unit is part of tells better which one the follower danced. If a learnt follower says where
she is expected, too, a second search finds units that lie between there and the first answer.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.motion.clip import Clip
from live.motion.partner.answer import Answer, Smoothing, answer, enforce_feet, enforce_holds
from live.motion.partner.decoder import Reading, decode
from live.motion.partner.path_leader import keep_near_path
from live.motion.partner.point_clouds import Cloud, joined_clouds, leader_cloud
from live.motion.partner.refinement import refine
from live.motion.partner.time_scaled_units import make_stretches
from live.motion.partner.units import Example, Units

RATE: Final = 7.5
"""Frames per second of the search (H012)."""
STRETCH: Final = 0.15
"""Largest change of a unit's length [s] (H005)."""
CONTINUITY: Final = 1.0
"""k, for a search at RATE (H007)."""
MAX_BEAT_DISTANCE: Final = 0.04
"""Largest distance of unit boundaries from beats, if beats are known [s]."""
CONTEXT: Final = (0.5, 1.5, -0.5)
"""How long ago a leader's points count too [s]; negative: how long after."""
PRESENT_WEIGHT: Final = 3
"""How many times the present points count, if others count once."""


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """Parameters of the search and of the constraints."""

    rate: float = RATE
    stretch: float = STRETCH
    k: float = CONTINUITY
    """Weight of continuity for each set of points that the distance compares (H007)."""
    beam: float = np.inf
    """Cells worse than the best by this [m²] are pruned (H010)."""
    context: tuple[float, ...] = CONTEXT
    """How long ago a leader's points count too [s]; negative: how long after. Empty: the present alone."""
    free_ends: bool = True
    """Whether the input may begin and end within a unit: it need not begin on a beat."""
    beats: Float64 | None = None
    """Times of the leader's beats [s], (n,), if known: units begin and end on them."""
    max_beat_distance: float = MAX_BEAT_DISTANCE
    """Largest distance of a boundary from a beat [s]."""
    smoothing: Smoothing = "eased"
    hold_feet: bool = True
    max_path_distance: float = np.inf
    """Largest distance of a walking dancer from their path [m]."""
    hold_hands: bool = True


WALK_SEARCH: Final = SearchSettings(rate=10.0, stretch=0.2, k=4.0, context=(), hold_hands=False)
"""Walks that a path leads: a larger k is better (H007); only the present of a path is compared."""


@dataclass(frozen=True, slots=True, eq=False)
class PartnerResult:
    """A follower and intermediate results of its synthesis."""

    clip: Clip
    answer: Answer
    """The motion before foot and hand constraints."""
    coarse: Reading
    reading: Reading
    """The reading at the clips' rate."""
    seconds: dict[str, float]
    """Duration of each stage [s]."""


def no_clock() -> float:
    """Return 0: a clock that does not advance."""
    return 0.0


class StageTimer:
    """Durations of stages by name [s], measured with the caller's `clock`."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self.clock = clock
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Add the duration of the `with` block to the stage `name`."""
        began = self.clock()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + self.clock() - began


def decode_input(
    x: Cloud, units: Units, search: SearchSettings, stages: StageTimer, follower: Cloud | None = None
) -> tuple[Reading, Reading]:
    """Return the coarse reading of an input and the one at the input's rate.

    `follower` (T, 6): where the follower's hip joints, hands and feet are expected, at the times of `x`, if known.
    """
    if search.context or follower is not None:
        with stages("context"):
            x, units = (
                _in_context(x, search, follower),
                replace(units, examples=tuple(_example_in_context(one, search, follower) for one in units.examples)),
            )
        sets = PRESENT_WEIGHT + len(search.context) + (follower is not None)
        search = replace(search, k=sets * search.k)
    longest = float(units.seconds.max() + search.stretch)
    if (x.count - 1) / x.rate < float(units.seconds.min()) - search.stretch:
        raise PersonError(
            f"the leader moves for {(x.count - 1) / x.rate:.2f} s, which is shorter than any unit "
            f"({units.seconds.min():.2f} s)",
            "give a longer motion",
        )
    with stages("stretches"):
        stretches = make_stretches(units, search.rate, search.stretch)
    free = int(longest * search.rate) if search.free_ends else 0
    free = max(min(free, (x.count - 1) // 4), 0) if search.free_ends else 0
    with stages("search"):
        thin = x.resampled(search.rate)
        free = min(free, max((thin.count - 1 - int(stretches.duration[-1])) // 2, 0))
        toll = boundary_costs(search, thin)
        coarse = decode(
            thin, stretches, k=search.k, beam=search.beam, free_start=free, free_end=free, boundary_cost=toll
        )
    with stages("up-sampling"):
        fine = refine(x, units, coarse, k=search.k, stretch=search.stretch, boundary_cost=boundary_costs(search, x))
    return coarse, fine


def _in_context(x: Cloud, search: SearchSettings, follower: Cloud | None) -> Cloud:
    """Return the present points, PRESENT_WEIGHT times, those of the context, and the follower's."""
    rows = np.arange(float(x.count))
    around = [replace(x.at(np.asarray(rows - lag * x.rate, np.float64)), rate=x.rate) for lag in search.context]
    other = [] if follower is None else [follower.at(rows)]
    return joined_clouds([*(PRESENT_WEIGHT * [x]), *around, *other])


def _example_in_context(example: Example, search: SearchSettings, follower: Cloud | None) -> Example:
    own = None if follower is None else leader_cloud(example.follower)
    return replace(example, leader=example.live_control, control=_in_context(example.control, search, own))


def boundary_costs(search: SearchSettings, x: Cloud) -> Float64 | None:
    """Return the cost of a boundary at each frame of `x`: 0 near a beat, else infinite. None if beats are unknown."""
    if search.beats is None or not len(search.beats):
        return None
    time = np.arange(x.count) / x.rate
    after = np.clip(np.searchsorted(search.beats, time), 1, max(len(search.beats) - 1, 1))
    away = np.abs(time - search.beats[np.minimum(after, len(search.beats) - 1)])
    away = np.minimum(away, np.abs(time - search.beats[after - 1]))
    toll = np.where(away <= max(search.max_beat_distance, 0.5 / x.rate + 1e-9), 0.0, np.inf)
    toll[0] = toll[-1] = 0.0
    return np.asarray(toll)


def find_partner(
    leader: Clip,
    x: Cloud,
    units: Units,
    search: SearchSettings,
    clock: Callable[[], float] = no_clock,
    *,
    expected: Cloud | None = None,
) -> PartnerResult:
    """Return the follower for a leader whose control cloud is `x`, at the rate of the leader's clip.

    `expected` (T, 6): where a learnt follower has the hip joints, hands and feet, at the times of `x`; it is searched
    once more, then, midway between there and the first answer. `clock` [s] measures the stages; the core does not read
    a clock itself.
    """
    stages = StageTimer(clock)
    coarse, fine = decode_input(x, units, search, stages)
    with stages("answer"):
        made = answer(fine, units, x.count, search.smoothing)
    if expected is not None:
        coarse, fine = decode_input(x, units, search, stages, _midway(leader_cloud(made.clip), expected))
        with stages("answer"):
            made = answer(fine, units, x.count, search.smoothing)
    clip = made.clip if np.isinf(search.max_path_distance) else keep_near_path(made.clip, x, search.max_path_distance)
    with stages("feet and hands"):
        if search.hold_feet:
            clip = enforce_feet(clip)
        if search.hold_hands and leader.sample_count == clip.sample_count:
            clip = enforce_holds(clip, leader, made.holds)
    return PartnerResult(clip, made, coarse, fine, stages.seconds)


def _midway(one: Cloud, other: Cloud) -> Cloud:
    last = other.at(np.arange(float(one.count)))
    return Cloud(0.5 * (one.floor + last.floor), 0.5 * (one.height + last.height), one.rate)


def shown_beats(made: Answer, reading: Reading, units: Units) -> Float64:
    """Return the times at which the answer shows beats of its units' recordings [s], ascending."""
    times = []
    for n, unit in enumerate(reading.unit.tolist()):
        of = units.examples[int(units.example[unit])]
        start, length = float(units.start[unit]), float(units.length[unit])
        inside = of.beats[(of.beats >= start - 1e-6) & (of.beats < start + length - 1e-6)]
        times.append((reading.start[n] + (inside - start) * reading.duration[n] / length) / reading.rate)
    return np.sort(np.concatenate(times)) if times else np.zeros(0)
