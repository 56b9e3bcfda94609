"""Transitions: how well the end of one measure passes into the start of another (T032-T034, K001-K003).

The similarity is that of two point clouds of the skeleton over a window, after the rigid 2D motion of the second that
brings it nearest to the first. All pairs at once are one complex matrix product (K003): with the floor coordinates of a
centred cloud as complex numbers a = √w (x + iz), the best rotation is the argument of aᴴb and

    D = |a|² + |b|² + |y_a|² + |y_b|² - 2 |aᴴb| - 2 y_a·y_b .
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.graph.library import StepLibrary, window_samples
from live.motion.posing.pipeline import PosePipeline
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

WINDOW_SAMPLES = 12
"""Poses in a window; the cloud has 12 · J points."""


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """For every ordered pair of nodes (u, v): from the end of u to the start of v (N nodes)."""

    distance: Float64
    """Root of the weighted mean squared distance of the aligned clouds [m], shape (N, N)."""
    yaw: Float64
    """Rotation that brings v's axes into u's [rad], shape (N, N)."""
    shift: Float64
    """Translation that follows it (x, z) [m], shape (N, N, 2)."""


def joint_weights() -> Float64:
    """Weight of each joint in the cloud, sum 1, shape (J,): feet carry, hips lead, hands may differ."""
    weights = np.ones(SKELETON.joint_count)
    for name, weight in (("Hand", 0.4), ("LowerArm", 0.7), ("Foot", 2.0), ("Toes", 1.5), ("hips", 2.0)):
        for joint, joint_name in enumerate(SKELETON.names):
            if joint_name.endswith(name):
                weights[joint] = weight
    return np.asarray(weights / weights.sum(), np.float64)


def window_weights(count: int = WINDOW_SAMPLES) -> Float64:
    """Weight along the window, sum 1, shape (count,): larger towards the measure line, where the blend ends."""
    weights = np.linspace(0.5, 1.5, count)
    return np.asarray(weights / weights.sum(), np.float64)


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


def all_pairs(first: Float64, second: Float64) -> Transitions:
    """K003 for all pairs of clouds `first` (N, K, J, 3) and `second` (M, K, J, 3); weights sum to 1."""
    weights = np.outer(window_weights(first.shape[1]), joint_weights()).reshape(-1)
    root = np.sqrt(weights)

    def flatten(cloud: Float64) -> tuple[Complex, Float64, Complex]:
        points = cloud.reshape(len(cloud), -1, 3)
        floor: Complex = points[..., 0] + 1j * points[..., 2]
        centre: Complex = floor @ weights.astype(np.complex128)
        return np.asarray(root * (floor - centre[:, None])), root * points[..., 1], centre

    a, y_a, centre_a = flatten(first)
    b, y_b, centre_b = flatten(second)
    product = a.conj() @ b.T
    squared = (
        (np.abs(a) ** 2).sum(1)[:, None]
        + (np.abs(b) ** 2).sum(1)[None]
        + (y_a**2).sum(1)[:, None]
        + (y_b**2).sum(1)[None]
        - 2.0 * np.abs(product)
        - 2.0 * (y_a @ y_b.T)
    )
    yaw = np.angle(product)
    # (x, z) turned by yaw is (x + iz) · exp(-i yaw), since yaw turns +z towards +x
    shift = centre_a[:, None] - centre_b[None] * np.exp(-1j * yaw)
    return Transitions(np.sqrt(np.maximum(squared, 0.0)), yaw, np.stack([shift.real, shift.imag], axis=-1))
