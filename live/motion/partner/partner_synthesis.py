"""Synthesis of a follower from a leader's motion: search, up-sampling, answer, feet and hands."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.motion.clip import Clip
from live.motion.partner.answer import Answer, Smoothing, answer, enforce_feet, enforce_holds
from live.motion.partner.decoder import Reading, decode
from live.motion.partner.path_leader import keep_near_path
from live.motion.partner.point_clouds import Cloud
from live.motion.partner.refinement import refine
from live.motion.partner.time_scaled_units import make_stretches
from live.motion.partner.units import Units

RATE: Final = 7.5
"""Frames per second of the search (H012)."""
STRETCH: Final = 0.15
"""Largest change of a unit's length [s] (H005)."""
CONTINUITY: Final = 1.0
"""k, for a search at RATE (H007)."""
MAX_BEAT_DISTANCE: Final = 0.04
"""Largest distance of unit boundaries from beats, if beats are known [s]."""
WALK_RATE: Final = 10.0
WALK_STRETCH: Final = 0.2
WALK_CONTINUITY: Final = 4.0
"""k for walks, for which a larger value is better (H007)."""


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """Parameters of the search and of the constraints."""

    rate: float = RATE
    stretch: float = STRETCH
    k: float = CONTINUITY
    beam: float = np.inf
    """Cells worse than the best by this [m²] are pruned (H010)."""
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


def decode_input(x: Cloud, units: Units, search: SearchSettings, stages: StageTimer) -> tuple[Reading, Reading]:
    """Return the coarse reading of an input and the one at the input's rate."""
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
    leader: Clip, x: Cloud, units: Units, search: SearchSettings, clock: Callable[[], float] = no_clock
) -> PartnerResult:
    """Return the follower for a leader whose control cloud is `x`, at the rate of the leader's clip.

    `clock` [s] measures the stages; the core does not read a clock itself.
    """
    stages = StageTimer(clock)
    coarse, fine = decode_input(x, units, search, stages)
    with stages("answer"):
        made = answer(fine, units, x.count, search.smoothing)
    clip = made.clip if np.isinf(search.max_path_distance) else keep_near_path(made.clip, x, search.max_path_distance)
    with stages("feet and hands"):
        if search.hold_feet:
            clip = enforce_feet(clip)
        if search.hold_hands and leader.sample_count == clip.sample_count:
            clip = enforce_holds(clip, leader, made.holds)
    return PartnerResult(clip, made, coarse, fine, stages.seconds)


def shown_beats(made: Answer, reading: Reading, units: Units) -> Float64:
    """Return the times at which the answer shows beats of its units' recordings [s], ascending."""
    times = []
    for n, unit in enumerate(reading.unit.tolist()):
        of = units.examples[int(units.example[unit])]
        start, length = float(units.start[unit]), float(units.length[unit])
        inside = of.beats[(of.beats >= start - 1e-6) & (of.beats < start + length - 1e-6)]
        times.append((reading.start[n] + (inside - start) * reading.duration[n] / length) / reading.rate)
    return np.sort(np.concatenate(times)) if times else np.zeros(0)
