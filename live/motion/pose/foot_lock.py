"""Foot lock: keeps feet in contact in place, live for many dancers and offline for a clip; also foot lift after
cuts."""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Int32
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import smoothstep
from live.motion.editing.foot_correction import LEG_LENGTH
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.pose.foot_lock_kernels import (
    CLEARANCE,
    CLEARANCE_SOFTNESS,
    DROP,
    FOLLOWED_COLUMNS,
    HELD,
    HIP_DROP,
    LOCK_COLUMNS,
    extrapolate_feet,
    farthest_shift,
    pop_slide,
    update_lock,
)
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline, PoseSkeleton
from live.motion.skeleton import SOLE_BELOW_ANKLE

EVERYBODY: Final = slice(None)
LEG_JOINTS = PoseSkeleton.legs_only()[1]
"""The engine's joints that a FootLock uses: hips and both legs, shape (9,)."""


class FootLock:
    """Lock state of the feet of A dancers, and the return of released feet to their clips; advanced once per tick."""

    def __init__(self, dancer_count: int) -> None:
        self.state: Float32 = np.zeros((dancer_count, 2, LOCK_COLUMNS), np.float32)
        """Columns of each foot as in `foot_lock_kernels`, shape (A, 2, 16)."""

    def tick(
        self, leg_position: npt.NDArray[Any], contact: Bool, dt: float, landing: Bool | None = None,
        rows: slice = EVERYBODY,
    ) -> None:  # fmt: skip
        """Advance by `dt` [s]: unlocked `leg_position` (n, 9, 3) [m] of LEG_JOINTS, `contact` (n, 2), of these rows.

        `landing` (n, 2): feet that come to stand so soon that they must not be raised any more; none without it.
        """
        if landing is None:
            landing = contact
        state = self.state[rows]
        update_lock(state, leg_position, contact, landing, LEG_LENGTH, SOLE_BELOW_ANKLE, TOES_OVER_SOLE, dt)

    @property
    def max_shift(self) -> float:
        """Largest shift of any foot along x or z [m]."""
        return farthest_shift(self.state)

    def pop_slide(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return each dancer's foot slide [m] during clip contact, and its duration [s], since the last call, (A,)
        each.

        A leg out of reach lets its foot slip slightly more than that.
        """
        slid, stood = np.zeros((2, len(self.state)))
        pop_slide(self.state, slid, stood)
        return slid, stood

    def write_feet(self, feet: Float32, age: float, rows: slice = EVERYBODY) -> None:
        """Write the columns of these rows for the pose kernels, (n, 2, 12), `age` [s] after the last tick; free feet
        are extrapolated."""
        extrapolate_feet(feet, self.state[rows], age)


_POSED: Final = 1 << 14
"""Samples that are posed at a time."""


def leg_positions(store: ClipStore) -> Float32:
    """Return world positions of LEG_JOINTS [m] at all samples of a legs-only store, (S, 9, 3)."""
    count = len(store.root)
    position = np.empty((count, len(LEG_JOINTS), 3), np.float32)
    pipeline = PosePipeline(min(_POSED, count), PoseSkeleton.legs_only()[0])
    for begin in range(0, count, _POSED):
        part = position[begin : begin + _POSED]
        pipeline.sample[0] = np.minimum(np.arange(begin, begin + len(pipeline.age)), count - 1)
        part[:] = pipeline.run(store)[0][: len(part)]
    return position


def foot_heights(store: ClipStore) -> Float32:
    """Return sole heights of both feet over the floor [m] at all samples of a legs-only store, (S, 2): heel or ball."""
    position = leg_positions(store)
    sole = np.minimum(position[:, 3::4, 1] - SOLE_BELOW_ANKLE, position[:, 4::4, 1] - TOES_OVER_SOLE)
    return np.ascontiguousarray(np.maximum(sole, 0.0), np.float32)


def lock_feet(clip: Clip) -> Clip:
    """Return the clip with every foot in `contact` locked in place, and no sole below the floor.

    The hips sink by at most 2 cm if a leg is too short; knees bend, feet keep their rotation.
    """
    positions, _ = forward_kinematics(clip.root_position, clip.rotation)
    legs = np.ascontiguousarray(positions[:, LEG_JOINTS], np.float32)
    lock, count, contact = FootLock(1), clip.sample_count, clip.contact.copy()
    pipeline = PosePipeline(count)
    for sample in range(count):
        lock.tick(legs[sample : sample + 1], contact[sample : sample + 1], 1.0 / clip.sample_rate)
        pipeline.feet[sample, :, :FOLLOWED_COLUMNS] = lock.state[0, :, :FOLLOWED_COLUMNS]
        pipeline.feet[sample, :, HIP_DROP] = lock.state[0, :, DROP]
    pipeline.feet[:, :, HELD] = 0.0  # each sample already has its own shifts
    pipeline.sample[0] = np.arange(count)
    pipeline.lock = True
    world_position, world_rotation = pipeline.run(ClipStore.of(clip.root_position, clip.rotation))
    rotation = quaternion.align_signs(local_rotations(world_rotation))
    return Clip(
        name=clip.name,
        root_position=np.ascontiguousarray(world_position[:, 0]),
        rotation=np.ascontiguousarray(rotation, np.float32),
        sample_rate=clip.sample_rate,
        contact=contact,
    )


Floats = npt.NDArray[np.floating]

STAY_DISTANCE: Final = 0.12
"""A foot at most this far [m] from its new position does not move there: it is locked where it lands."""
ARRIVAL_DISTANCE: Final = 0.05
"""A foot on its way is locked when nearer than this [m] to its new position."""
LIFT_HEIGHT: Final = 0.06
"""Lift height of a foot on its way [m]."""
LIFT_TIME: Final = 0.1
DESCENT_TIMES: Final = (0.22, 0.36)
"""Lift time [s], and start and end of the descent [s] after the cut."""


class CutFootLift:
    """Lifts the feet of A dancers on their way to a new position after a cut, instead of dragging them."""

    def __init__(self, dancer_count: int) -> None:
        self.lift: Float32 = np.zeros((dancer_count, 2), np.float32)
        """Lift height of each foot on its way [m], 0 for other feet, shape (A, 2)."""

    def begin(self, rows: Int32, distance: Floats) -> None:
        """Start after a cut of the dancers `rows` (n,), whose feet have to move by `distance` (n, 2) [m]."""
        self.lift[rows] = np.where(distance < STAY_DISTANCE, 0.0, LIFT_HEIGHT)

    def may_lock(self, distance: Floats) -> Bool:
        """Return which feet, `distance` (A, 2) [m] from their positions, may be locked, (A, 2)."""
        return np.asarray(distance < np.where(self.lift > 0.0, ARRIVAL_DISTANCE, STAY_DISTANCE))

    def apply(self, feet: Float32, age: Float32) -> None:
        """Lift the feet in the columns CLEAR and ROUND of `feet` (A, 2, 12), `age` (A,) [s] after the cut."""
        up = (
            smoothstep(age / LIFT_TIME)
            * smoothstep((DESCENT_TIMES[1] - age) / (DESCENT_TIMES[1] - DESCENT_TIMES[0]))
            * (age < MAX_FADE_TIME)
        )
        lifted = self.lift * up[:, None].astype(np.float32)
        feet[:, :, CLEARANCE] = np.maximum(feet[:, :, CLEARANCE], lifted)
        feet[:, :, CLEARANCE_SOFTNESS] = np.maximum(feet[:, :, CLEARANCE_SOFTNESS], 0.3 * lifted)
