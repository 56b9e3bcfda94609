"""Drivers of an upper body: what a sketch's legs and pelvis do around each moment, as numbers to compare."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import MIRROR
from live.motion.texture.frequency_bands import RATE, SampledClip, headings, low_pass, rotate_about_vertical
from live.motion.texture.texture_settings import JOINT_GROUPS, joint_names

REACHES: Final[dict[float, tuple[int, ...]]] = {
    0.5: (-12, -8, -4, 0, 4, 8, 12),
    0.0: (0,),
    1.0: (-24, -16, -8, -4, 0, 4, 8, 16, 24),
}
"""Reach of a window to both sides [s], the common one first, and the samples at 24 Hz that it holds."""
VELOCITY_UNIT: Final = 3.0
"""Velocity of the hips [m/s] that counts as a radian."""
TURN_UNIT: Final = 10.0
"""Speed of turning [rad/s] that counts as a radian."""
HEIGHT_UNIT: Final = 0.33
"""Height of the hips above their median [m] that counts as a radian."""
PLACE_UNIT: Final = 0.5
"""Way of a knee or foot [m] that counts as a radian."""
_REFLECTION: Final = np.array((-1.0, 1.0, 1.0))
_ROTATION_REFLECTION: Final = np.array((1.0, 1.0, -1.0, -1.0))


ROTATIONS: Final = "rotations"
HEADING: Final = "heading"
HIPS: Final = "hips"


@dataclass(frozen=True, slots=True)
class DriverSet:
    """Joints that drive, and whether the pelvis drives, too."""

    joints: tuple[int, ...]
    pelvis: bool
    """Tilt, velocity, turning and height of the hips."""
    measured: str = ROTATIONS
    """What counts of the joints: their `ROTATIONS`, or their places seen from the hips, in upright axes that turn with
    the hips' `HEADING` or in the axes of the `HIPS`. How a recording's bones are twisted does not change places."""

    @property
    def name(self) -> str:
        """Name for reports."""
        words = _WORDS.get(self.joints) or joint_names(self.joints)
        if self.measured != ROTATIONS:
            words = f"places of {words} from the {self.measured}"
        return f"{words}, pelvis" if self.pelvis and 0 not in self.joints else words


_HIPS_KNEES: Final = tuple(sorted(JOINT_GROUPS["hips"] + JOINT_GROUPS["knees"]))
_LEGS: Final = tuple(sorted(_HIPS_KNEES + JOINT_GROUPS["ankles"]))
_KNEES_FEET: Final = tuple(sorted(JOINT_GROUPS["knees"] + JOINT_GROUPS["ankles"]))
_KNEES_TOES: Final = tuple(one for one in JOINT_GROUPS["legs"] if one not in JOINT_GROUPS["hips"])
_WORDS: Final = {
    _HIPS_KNEES: "hips, knees",
    _LEGS: "hips, knees, ankles",
    _KNEES_FEET: "knees, ankles",
    _KNEES_TOES: "knees, ankles, toes",
}
DRIVER_SETS: Final = (
    DriverSet(_KNEES_TOES, True, HEADING),
    DriverSet(_LEGS, True),
    DriverSet(_HIPS_KNEES, False),
    DriverSet(_KNEES_FEET, False, HEADING),
    DriverSet(_KNEES_FEET, False, HIPS),
)
"""Sets among which cross-validation chooses."""


def driver_signals(take: SampledClip, drivers: DriverSet, reference: Float64) -> Float64:
    """Return the signals of the drivers, (T, D), about radians in size.

    `reference` (J, 4) are the rotations from which joints are measured.
    """
    parts: list[Float] = [] if drivers.measured == ROTATIONS else [_places(take, drivers)]
    for joint in drivers.joints:
        if joint and drivers.measured == ROTATIONS:
            away = quaternion.mul(quaternion.inverse(reference[joint]), take.rotation[:, joint])
            parts.append(quaternion.to_rotation_vector(away))
    if drivers.pelvis or 0 in drivers.joints:
        hips, heading = take.rotation[:, 0], headings(take.rotation[:, 0])
        up = quaternion.rotate(quaternion.inverse(hips), np.broadcast_to(np.array((0.0, 1.0, 0.0)), (len(hips), 3)))
        rate = np.zeros((len(hips), 4))
        if len(hips) > 1:
            rate[:, :3] = rotate_about_vertical(np.gradient(take.root, axis=0), -heading) * (RATE / VELOCITY_UNIT)
            rate[:, 3] = np.gradient(heading) * (RATE / TURN_UNIT)
        height = (take.root[:, 1:2] - np.median(take.root[:, 1])) / HEIGHT_UNIT
        parts += [up, low_pass(rate, 1), height]
    return np.asarray(np.concatenate(parts, axis=1), np.float64)


def _places(take: SampledClip, drivers: DriverSet) -> Float64:
    """Return the places of the joints from the hips, (T, 3 n), `PLACE_UNIT` long."""
    rotation, turned = take.rotation, np.zeros(len(take.root))
    if drivers.measured == HEADING:
        turned = headings(rotation[:, 0])
    else:
        rotation = rotation.copy()
        rotation[:, 0] = quaternion.IDENTITY
    position, _ = forward_kinematics(np.zeros((len(rotation), 3)), rotation)
    places = [rotate_about_vertical(position[:, joint], -turned) for joint in drivers.joints]
    return np.asarray(np.concatenate(places, axis=1) / PLACE_UNIT, np.float64)


def windows_of(signals: Float64, reach: float) -> Float64:
    """Return the signals (T, D) of the window around each sample, (T, W D); ends are held."""
    at = np.arange(len(signals))[:, None] + np.array(REACHES[reach])
    return np.asarray(signals[np.clip(at, 0, len(signals) - 1)].reshape(len(signals), -1))


def mirror_sampled(take: SampledClip) -> SampledClip:
    """Return the take with left and right exchanged (T042)."""
    return SampledClip(take.clip, take.root * _REFLECTION, take.rotation[:, MIRROR] * _ROTATION_REFLECTION)
