"""Transitions: how well the end of one measure passes into the start of another (T032-T034, K001-K003).

The similarity is that of two point clouds of the skeleton over a window, after the rigid 2D motion of the second that
brings it nearest to the first. All pairs at once are one complex matrix product (K003): with the floor coordinates of a
centred cloud as complex numbers a = √w (x + iz), the best rotation is the argument of aᴴb and

    D = |a|² + |b|² + |y_a|² + |y_b|² - 2 |aᴴb| - 2 y_a·y_b .
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.graph.build.flat import FlatClouds
from live.graph.build.nearest_pairs import aligned
from live.graph.build.weights import WINDOW_SAMPLES, Metric, joint_weights, window_weights
from live.graph.step_library import StepLibrary, window_samples
from live.motion.pose.pose_pipeline import PosePipeline
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]

__all__ = [
    "WINDOW_SAMPLES",
    "Transitions",
    "all_pairs",
    "clouds",
    "joint_weights",
    "transition_windows",
    "window_weights",
]


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """For every ordered pair of nodes (u, v): from the end of u to the start of v (N nodes)."""

    distance: Float64
    """Root of the weighted mean squared distance of the aligned clouds [m], shape (N, N)."""
    yaw: Float64
    """Rotation that brings v's axes into u's [rad], shape (N, N)."""
    shift: Float64
    """Translation that follows it (x, z) [m], shape (N, N, 2)."""


def clouds(library: StepLibrary, samples: Float64) -> Float64:
    """World positions of the joints at fractional samples (N, K) of the library, shape (N, K, J, 3) [m]."""
    flat = np.ascontiguousarray(samples.reshape(-1))
    pipeline = PosePipeline(len(flat))
    pipeline.sample[0] = flat
    position, _ = pipeline.run(library.store)
    return np.asarray(position.reshape(*samples.shape, SKELETON.joint_count, 3), np.float64)


def transition_windows(library: StepLibrary, window: float) -> tuple[Float64, Float64]:
    """Clouds of the last and of the lead-in `window` (a share of the measure) of every node: two (N, K, J, 3)."""
    length = (library.node_last - library.node_first) * window
    end = window_samples(library.node_last - length, library.node_last, WINDOW_SAMPLES)
    start = window_samples(library.node_first - length, library.node_first, WINDOW_SAMPLES)
    start = np.maximum(start, library.node_lead[:, None])
    return clouds(library, end), clouds(library, start)


def all_pairs(first: Float64, second: Float64, metric: Metric | None = None) -> Transitions:
    """K003 for all pairs of clouds `first` (N, K, J, 3) and `second` (M, K, J, 3), in one matrix product.

    Holds some ten arrays of (N, M): for the pairs within a threshold in libraries of any size see `near_pairs`.
    """
    metric = Metric.of() if metric is None else metric
    a, b = FlatClouds.of(first, metric), FlatClouds.of(second, metric)
    product = a.floor.conj() @ b.floor.T
    squared = a.size[:, None] + b.size[None] - 2.0 * np.abs(product) - 2.0 * (a.height @ b.height.T)
    motion = aligned(product, a.centre[:, None], b.centre[None])
    return Transitions(np.sqrt(np.maximum(squared, 0.0)), motion[..., 2], motion[..., :2])
