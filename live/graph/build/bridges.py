"""Bridges: stretches of recordings that lead from one step to another where the graph has no edge (T141, Fig 6.1).

A bridge is one or more measures long, begins like the first step's end, and ends like the second's beginning. The
search over all recordings runs before the show, at BASE_RATE: the clouds at the steps' ends are multiplied with the
windows at every frame of a recording (K003), some thousand windows at a time. Because the step's cloud is centred,
those of the recording need not be, so its windows are contiguous memory. A bridge is cut as a step clip for insertion.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from live.base.arrays import Complex64, Float32, Float64, Int64
from live.graph.build.metric import FlatClouds, Metric
from live.graph.build.transitions import clouds
from live.graph.motion_graph import MotionGraph
from live.graph.step_library import StepLibrary, window_samples
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline

BASE_RATE: Final = 30.0
"""Frames per second at which recordings are searched [Hz]."""
_PRODUCTS: Final = 1 << 19
"""Numbers in the largest array of the search: 4 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class PosedRecording:
    """A recording prepared for the search: T frames of J joints at BASE_RATE."""

    clip: Clip
    floor: Complex64
    """x + iz [m], shape (T, J)."""
    height: Float32
    """y [m], shape (T, J)."""

    @classmethod
    def of(cls, clip: Clip) -> "PosedRecording":
        """Pose a whole recording."""
        count = int(clip.seconds * BASE_RATE + 1e-9) + 1
        pipeline = PosePipeline(count)
        pipeline.sample[0] = np.minimum(np.arange(count) * (clip.sample_rate / BASE_RATE), clip.sample_count - 1.0)
        rotation = quaternion.align_signs(clip.rotation).astype(np.float32)
        position, _ = pipeline.run(ClipStore.of(clip.root_position, rotation))
        floor = (position[..., 0] + 1j * position[..., 2]).astype(np.complex64)
        return cls(clip, floor, np.ascontiguousarray(position[..., 1]))


@dataclass(frozen=True, slots=True)
class Bridge:
    """A stretch of a recording that may be danced between two steps."""

    recording: int
    """Index of the recording."""
    start: float
    """Begin in the recording [s]."""
    stop: float
    """End [s]; the stretch factor to whole measures follows from it."""
    source: int
    """The node before the bridge."""
    target: int
    """The node after the bridge."""
    begin_cost: float
    """Distance [m] from the end of `source` to the bridge's beginning."""
    end_cost: float
    """Distance [m] from the bridge's end to the beginning of `target`."""

    @property
    def cost(self) -> float:
        """The worse of the two joins [m]; below the graph's threshold, both can be danced."""
        return max(self.begin_cost, self.end_cost)


STRETCH: Final = 0.15
"""Largest share by which a bridge is shorter or longer than a measure."""


def find_bridges(
    graph: MotionGraph,
    recordings: Sequence[PosedRecording],
    source: int,
    target: int,
    *,
    measure_s: float,
    max_count: int = 5,
) -> list[Bridge]:
    """Return the `max_count` best bridges of a measure from step `source` to `target`, best first, without overlaps.

    `measure_s` is the length of a measure of the show [s]; a stretch that differs from it by up to the share `STRETCH`
    is danced faster or slower. ValueError for a length that is not positive.
    """
    if measure_s <= 0.0:
        raise ValueError(f"bridges for measures of {measure_s} s: more than 0 expected")
    library = graph.library
    frames = max(2, round(graph.window * measure_s * BASE_RATE) + 1)
    ends = np.flatnonzero((library.node_step == source) & (library.node_measure == library.node_measures - 1))
    begins = np.flatnonzero((library.node_step == target) & (library.node_measure == 0))
    metric = _metric(graph.rule.metric, frames)
    after = _windows(library, ends, library.node_last, graph.window, metric)
    before = _windows(library, begins, library.node_first, graph.window, metric)
    length = measure_s * BASE_RATE
    lengths = np.arange(np.ceil(length * (1.0 - STRETCH)), np.floor(length * (1.0 + STRETCH)) + 1).astype(np.int64)
    if not len(lengths):
        lengths = np.array([round(length)])
    found: list[Bridge] = []
    for number, recorded in enumerate(recordings):
        if len(recorded.floor) < frames + lengths[0]:
            continue
        (leave, out), (enter, into) = (_nearest(recorded, windows, metric) for windows in (after, before))
        for frame, size in _best(leave, enter, lengths, max_count):
            line = frame + frames - 1  # the window before the measure line ends on it
            found.append(
                Bridge(
                    number, line / BASE_RATE, (line + size) / BASE_RATE, int(ends[out[frame]]),
                    int(begins[into[frame + size]]), float(leave[frame]), float(enter[frame + size]),
                )
            )  # fmt: skip
    return sorted(found, key=lambda bridge: bridge.cost)[:max_count]


def _metric(metric: Metric, frames: int) -> Metric:
    """Return the same weights for windows of another number of poses."""
    own = np.linspace(0.0, 1.0, len(metric.window))
    weights = np.interp(np.linspace(0.0, 1.0, frames), own, metric.window)
    return Metric(metric.joint, np.asarray(weights / weights.sum()))


def _windows(library: StepLibrary, nodes: Int64, line: Float64, window: float, metric: Metric) -> FlatClouds:
    """Return clouds of the `window` before the samples `line` (N,) of some nodes."""
    length = (library.node_last[nodes] - library.node_first[nodes]) * window
    samples = window_samples(line[nodes] - length, line[nodes], len(metric.window))
    return FlatClouds.of(clouds(library, np.maximum(samples, library.node_lead[nodes, None])), metric)


def _nearest(recorded: PosedRecording, windows: FlatClouds, metric: Metric) -> tuple[Float64, Int64]:
    """Return, for every window of a recording by its first frame, the distance [m] and index of the nearest cloud."""
    count = len(recorded.floor) - len(metric.window) + 1
    size = _sizes(recorded, metric)
    # the cloud includes √w once; the other √w is applied to the recording
    root = np.sqrt(metric.points)
    floor, height = (windows.floor.conj() * root).astype(np.complex64), (windows.height * root).astype(np.float32)
    nearest, which = np.empty(count), np.empty(count, np.int64)
    rows = max(1, _PRODUCTS // max(len(windows), floor.shape[1]))
    for begin in range(0, count, rows):
        part = slice(begin, min(begin + rows, count))
        product = _stretches(recorded.floor, part, len(metric.window)) @ floor.T
        level = _stretches(recorded.height, part, len(metric.window)) @ height.T
        squared = windows.size - 2.0 * (np.sqrt(product.real**2 + product.imag**2) + level)
        which[part] = squared.argmin(axis=1)
        nearest[part] = squared.min(axis=1) + size[part]
    return np.sqrt(np.maximum(nearest, 0.0)), which


def _stretches(track: npt.NDArray[Any], part: slice, frames: int) -> npt.NDArray[Any]:
    """Return the windows of `frames` at first frames `part` of a track (T, J), one per row, (windows, frames · J)."""
    joints = track.shape[1]
    flat = track[part.start : part.stop + frames - 1].reshape(-1)
    return sliding_window_view(flat, frames * joints)[::joints]


def _sizes(recorded: PosedRecording, metric: Metric) -> Float64:
    """Return |b|² + |y_b|² [m²] of the centred cloud of every window of a recording."""
    floor, height = recorded.floor.astype(np.complex128), recorded.height.astype(np.float64)
    squares = (np.abs(floor) ** 2 + height**2) @ metric.joint
    centres = floor @ metric.joint
    window = metric.window[::-1]  # np.convolve reverses it
    centre = np.convolve(centres, window, "valid")
    return np.asarray(np.convolve(squares, window, "valid") - np.abs(centre) ** 2)


def _best(begin_cost: Float64, end_cost: Float64, lengths: Int64, max_count: int) -> list[tuple[int, int]]:
    """Return first frames and lengths of the best stretches; none begins within half a length of a better one."""
    count = len(begin_cost)
    cost, size = np.full(count, np.inf), np.zeros(count, np.int64)
    for length in lengths[lengths < count]:
        both = np.maximum(begin_cost[: count - length], end_cost[length:])
        better = both < cost[: count - length]
        cost[: count - length][better], size[: count - length][better] = both[better], length
    found: list[tuple[int, int]] = []
    apart = max(1, int(lengths[0]) // 2)
    while len(found) < max_count:
        frame = int(cost.argmin())
        if not np.isfinite(cost[frame]):
            break
        found.append((frame, int(size[frame])))
        cost[max(0, frame - apart) : frame + apart + 1] = np.inf
    return found
