"""How a body's arms go together, and with its steps: strength and phase of their coupling."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float, Float64
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.texture.frequency_bands import sample_clip, split_bands

Complex128 = npt.NDArray[np.complex128]

_LIMBS = tuple(SKELETON.index(name) for name in ("leftHand", "rightHand", "leftFoot", "rightFoot"))


@dataclass(frozen=True, slots=True)
class Coordination:
    """Coupling of the forward swing of limbs in one band: complex correlations of their analytic signals (Gabor).

    The magnitude, 0 to 1, is the strength; the angle [rad] is the phase by which the first limb is ahead.
    """

    arms: complex
    """Of the left and the right hand."""
    steps: complex
    """Of each hand and the foot of the other side, both sides together."""

    def distance(self, other: "Coordination") -> float:
        """Return the mean distance of the couplings in the complex plane, 0 (the same) to 2 (opposite)."""
        return 0.5 * (abs(self.arms - other.arms) + abs(self.steps - other.steps))

    def report(self) -> dict[str, dict[str, float]]:
        """Return strengths and phases [degrees] as JSON values."""
        return {
            name: {"strength": round(abs(one), 3), "phase_deg": round(float(np.degrees(np.angle(one))), 1)}
            for name, one in (("left_right_arms", self.arms), ("arms_steps", self.steps))
        }


def coordination_of(clip: Clip, band: int) -> Coordination:
    """Return the coordination of a clip in one band, 1 the highest."""
    rotation = sample_clip(clip).rotation.copy()
    rotation[:, 0] = (1.0, 0.0, 0.0, 0.0)
    position, _ = forward_kinematics(np.zeros((len(rotation), 3)), rotation)
    forward = split_bands(position[:, _LIMBS, 2], band)[band - 1]
    left_hand, right_hand, left_foot, right_foot = analytic_signal(forward).T
    return Coordination(
        coupling(left_hand, right_hand),
        coupling(np.concatenate((left_hand, right_hand)), np.concatenate((right_foot, left_foot))),
    )


def analytic_signal(signal: Float64) -> Complex128:
    """Return the analytic signal (T, C) of real signals (T, C): negative frequencies removed."""
    count = len(signal)
    factor = np.zeros(count)
    factor[0] = 1.0
    factor[1 : (count + 1) // 2] = 2.0
    if count % 2 == 0:
        factor[count // 2] = 1.0
    return np.asarray(np.fft.ifft(np.fft.fft(signal, axis=0) * factor[:, None], axis=0), np.complex128)


def coupling(a: Complex128, b: Complex128) -> complex:
    """Return the complex correlation of analytic signals (T,), 0 where one does not move."""
    size = float(np.sqrt((np.abs(a) ** 2).sum() * (np.abs(b) ** 2).sum()))
    return complex((a * np.conj(b)).sum() / size) if size > 1e-9 else 0j


def correlation(a: Float, b: Float) -> float:
    """Return the correlation of all columns of signals (T, C) together, 0 where one does not move."""
    size = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum() / size) if size > 1e-9 else 0.0
