"""Centre of mass, angular momentum and zero-moment point of clips, segment by segment and by differences in time.

Written from the definitions, with nothing of `live.motion.editing.body_mass` but its table.
"""

from dataclasses import dataclass

import numpy as np

from live.base.arrays import Bool, Float64
from live.motion import quaternion
from live.motion.editing.body_mass import SEGMENTS
from live.motion.forward_kinematics import forward_kinematics
from live.motion.step_clip import StepClip

GRAVITY = 9.81


@dataclass(frozen=True)
class BodyPhysics:
    """Of the samples of a step's measures, without the first and the last."""

    centre: Float64
    """Centre of mass [m], (T, 3)."""
    momentum: Float64
    """Angular momentum about it per mass [m²/s], (T, 3)."""
    pushes: Float64
    """Acceleration against gravity that the floor gives [m/s²], (T - 2, 3)."""
    zero_moment: Float64
    """Zero-moment point on the floor (x, z) [m], (T - 2, 2)."""

    @property
    def carried(self) -> Bool:
        """Whether the floor carries at least half the weight, (T - 2,)."""
        return np.asarray(self.pushes[:, 1] > 0.5 * GRAVITY)


def physics_of(step: StepClip) -> BodyPhysics:
    """Return the physics of a step; clips without a lead-in are not meant."""
    rate, (first, last) = step.clip.sample_rate, measure_samples(step)
    part = slice(first - 1, last + 2)
    position, world = forward_kinematics(
        step.clip.root_position[part].astype(np.float64), step.clip.rotation[part].astype(np.float64)
    )
    place = {j: position[:, j] + quaternion.rotate(world[:, j], at) for j, (_, at, _) in SEGMENTS.items()}
    centre = np.sum([SEGMENTS[j][0] * place[j] for j in place], axis=0)
    momentum = np.zeros((len(centre) - 2, 3))
    for joint, (share, _, radii) in SEGMENTS.items():
        off = place[joint] - centre
        momentum += share * np.cross(off[1:-1], (off[2:] - off[:-2]) * (0.5 * rate))
        turn = quaternion.mul(world[2:, joint], quaternion.inverse(world[:-2, joint]))
        spin = quaternion.to_rotation_vector(turn) * (0.5 * rate)
        own = quaternion.rotate(quaternion.inverse(world[1:-1, joint]), spin)
        momentum += share * quaternion.rotate(world[1:-1, joint], radii**2 * own)
    centre = centre[1:-1]
    pushes = (centre[2:] - 2.0 * centre[1:-1] + centre[:-2]) * rate**2 + (0.0, GRAVITY, 0.0)
    torque = (momentum[2:] - momentum[:-2]) * (0.5 * rate)
    # the force acts at a point p of the floor: (p - c) × f = dL/dt, apart from the vertical moment
    x = centre[1:-1, 0] - (centre[1:-1, 1] * pushes[:, 0] - torque[:, 2]) / pushes[:, 1]
    z = centre[1:-1, 2] - (centre[1:-1, 1] * pushes[:, 2] + torque[:, 0]) / pushes[:, 1]
    return BodyPhysics(centre, momentum, pushes, np.stack([x, z], axis=1))


def measure_samples(step: StepClip) -> tuple[int, int]:
    """First and last sample of a step's measures."""
    return round(step.first), round(step.first + step.measures * step.samples_per_measure)
