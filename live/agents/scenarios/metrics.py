"""Metrics of a crowd's trajectories: arrival, overlaps, contact, smoothness."""

from dataclasses import asdict, dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from live.agents.scenarios.scenario import Scenario
from live.base.arrays import Float64

RATE = 60.0
"""Trajectories are resampled at this rate [1/s]; accelerations and turns use half of it."""
SETTLED = 0.2
"""Measuring stops when all agents are this close to their goals [m]."""
OVERLAP = 0.005
"""Bodies that penetrate each other by this much [m] overlap."""
TOUCH = 0.02
"""Bodies closer than this [m] touch."""
MIN_WALKING_SPEED = 0.3
"""Minimum speed [m/s] at which a heading is defined."""
REST_COST, WALK_COST = 2.23, 1.26
"""Power of a walker per kg: rest + walk · v² [W/kg] (Guy et al. 2010, PLEdestrians)."""


@dataclass(frozen=True, slots=True)
class Metrics:
    """Metrics of one run; NaN where a value is undefined."""

    done: float
    """Share of the agents that arrived."""
    time_ratio: float
    """Mean over the agents that arrived: time ÷ time straight at the preferred speed."""
    last_arrival: float
    """Arrival time of the last agent that arrived [s]."""
    overlaps: int
    """Number of times that two bodies began to overlap by more than 5 mm."""
    overlaps_per_agent_minute: float
    deepest: float
    """Greatest penetration of two bodies [m]."""
    touching: float
    """Seconds that an agent is closer than 2 cm to others, summed over the others."""
    path_efficiency: float
    """Straight distance ÷ distance walked."""
    energy: float
    """Effort ÷ least effort for the straight path."""
    acceleration: float
    """Root mean square while walking [m/s²]."""
    jerk: float
    """Root mean square while walking [m/s³]."""
    turn_mean: float
    """Change of heading while walking [degrees/s]."""
    turn_p99: float
    """99th percentile of the same [degrees/s]."""

    def as_json(self) -> dict[str, float | int | None]:
        """Return the metrics by name; null for undefined values."""
        return {name: None if value != value else value for name, value in asdict(self).items()}


def measure(scenario: Scenario, time: Float64, position: Float64) -> Metrics:
    """Measure a run: `time` (T,) [s], ascending, `position` (T, A, 2) [m]."""
    frames = _resample(time, position)
    reach, straight = scenario.goal_radius, scenario.straight_distance - scenario.goal_radius
    away = np.linalg.norm(frames - scenario.last_goal, axis=2)
    if scenario.endless:
        away = np.full_like(away, np.inf)
    settled = np.flatnonzero((away <= SETTLED).all(axis=1))
    if len(settled):
        frames, away = frames[: settled[0] + 1], away[: settled[0] + 1]
    within = away <= reach
    arrived = within.any(axis=0)
    frame = np.where(arrived, np.argmax(within, axis=0), len(frames))
    overlaps, deepest, touching = _contacts(frames, scenario.radius)
    count, minutes = max(1, scenario.agent_count), len(frames) / RATE / 60.0
    counted = arrived & (straight > 1e-6)
    ratio = frame[counted] / RATE / (straight[counted] / scenario.preferred_speed)
    length, energy = _effort(frames, frame)
    ideal = 2.0 * straight[counted] * np.sqrt(REST_COST * WALK_COST)
    acceleration, jerk, turns = _smoothness(frames[::2], (frame + 1) // 2)
    return Metrics(
        done=float("nan") if scenario.endless else float(arrived.mean()) if len(arrived) else 1.0,
        time_ratio=_mean(ratio),
        last_arrival=float(frame[arrived].max() / RATE) if arrived.any() else float("nan"),
        overlaps=overlaps,
        overlaps_per_agent_minute=overlaps / (count * minutes),
        deepest=deepest,
        touching=2.0 * touching / count,
        path_efficiency=_mean(straight[counted] / np.maximum(length[counted], 1e-9)),
        energy=_mean(energy[counted] / ideal),
        acceleration=acceleration,
        jerk=jerk,
        turn_mean=_mean(turns),
        turn_p99=float(np.percentile(turns, 99)) if len(turns) else float("nan"),
    )


def _mean(values: Float64) -> float:
    return float(values.mean()) if len(values) else float("nan")


def _resample(time: Float64, position: Float64) -> Float64:
    """Return positions at 60 Hz, linear between the samples."""
    ticks = np.arange(int(np.floor(time[-1] * RATE + 1e-6)) + 1) / RATE
    right = np.clip(np.searchsorted(time, ticks, side="right"), 1, len(time) - 1) if len(time) > 1 else ticks * 0
    right = right.astype(np.int64)
    left = np.maximum(right - 1, 0)
    span = np.where(right > left, time[right] - time[left], 1.0)
    share = np.clip((ticks - time[left]) / span, 0.0, 1.0)[:, None, None]
    return position[left] * (1.0 - share) + position[right] * share


def _contacts(frames: Float64, radius: float) -> tuple[int, float, float]:
    """Return the number of overlaps, the greatest penetration [m], and the total contact time of all pairs [s]."""
    began, deepest, touching = 0, 0.0, 0
    before: npt.NDArray[np.int64] = np.empty(0, np.int64)
    for frame in frames:
        pairs = cKDTree(frame).query_pairs(2.0 * radius + TOUCH, output_type="ndarray") if len(frame) > 1 else before
        now = before[:0]
        if len(pairs):
            depth = 2.0 * radius - np.linalg.norm(frame[pairs[:, 0]] - frame[pairs[:, 1]], axis=1)
            touching += len(pairs)
            deepest = max(deepest, float(depth.max()))
            over = pairs[depth > OVERLAP]
            now = over[:, 0] * np.int64(len(frame)) + over[:, 1]
        began += len(np.setdiff1d(now, before)) if len(now) else 0
        before = now
    return began, deepest, touching / RATE


def _effort(frames: Float64, end: npt.NDArray[np.int64]) -> tuple[Float64, Float64]:
    """Return the length walked [m] and energy [J/kg] of each agent until their frame `end`, shapes (A,)."""
    step = np.linalg.norm(np.diff(frames, axis=0), axis=2)
    walked = np.arange(1, len(frames))[:, None] <= end
    energy = (REST_COST + WALK_COST * (step * RATE) ** 2) / RATE
    return (step * walked).sum(axis=0), (energy * walked).sum(axis=0)


def _smoothness(frames: Float64, end: npt.NDArray[np.int64]) -> tuple[float, float, Float64]:
    """Return rms acceleration and jerk, and all turn rates [degrees/s], from 30 Hz positions until frame `end` (A,)."""
    rate = RATE / 2.0
    velocity = np.diff(frames, axis=0) * rate
    acceleration = np.diff(velocity, axis=0) * rate
    jerk = np.diff(acceleration, axis=0) * rate
    speed = np.linalg.norm(velocity, axis=2)
    walks = (speed[1:] > MIN_WALKING_SPEED) & (speed[:-1] > MIN_WALKING_SPEED) & _until(end, 2, len(acceleration))
    before, after = velocity[:-1][walks], velocity[1:][walks]
    across = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.degrees(np.abs(np.arctan2(across, (before * after).sum(axis=1)))) * rate
    return _rms(acceleration, end, 2), _rms(jerk, end, 3), turn


def _until(end: npt.NDArray[np.int64], order: int, rows: int) -> npt.NDArray[np.bool_]:
    """Return which rows of `order`-th differences use frames up to `end` (A,) only, shape (rows, A)."""
    mask: npt.NDArray[np.bool_] = np.arange(rows)[:, None] + order <= end
    return mask


def _rms(difference: Float64, end: npt.NDArray[np.int64], order: int) -> float:
    squared = (difference**2).sum(axis=2)[_until(end, order, len(difference))]
    return float(np.sqrt(squared.mean())) if len(squared) else float("nan")
