"""Foot lock: feet that carry stay where they are, live for a crowd and offline for a clip.

Landing: feet that a cut sends to other places are lifted on the way, and not dragged there over the floor.
"""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.pose.foot_lock_kernels import (
    CLEAR,
    FOLLOWED_COLUMNS,
    HELD,
    LOCK_COLUMNS,
    ROUND,
    SHIFT_X,
    SHIFT_Z,
    farthest_shift,
    follow_feet,
    swing_feet,
    take_slid,
)
from live.motion.pose.inertialization_kernels import LONGEST
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline, PoseSkeleton
from live.motion.skeleton import SOLE_BELOW_ANKLE

Float32 = npt.NDArray[np.float32]
Bool = npt.NDArray[np.bool_]

LEG_JOINTS = PoseSkeleton.legs_only()[1]
"""The engine's joints that a FootLock watches: hips and both legs, shape (9,)."""


class FootLock:
    """Which feet of A dancers are held, where, and how those let go swing back; advanced once a tick."""

    def __init__(self, dancer_count: int) -> None:
        self.state: Float32 = np.zeros((dancer_count, 2, LOCK_COLUMNS), np.float32)
        """Shift, place and speed of each foot as in legs/kernels.py, shape (A, 2, 12)."""

    def tick(self, leg_position: npt.NDArray[Any], contact: Bool, dt: float) -> None:
        """Follow the unlocked feet: `leg_position` (A, 9, 3) [m] of LEG_JOINTS, `contact` (A, 2), `dt` [s]."""
        follow_feet(self.state, leg_position, contact, SOLE_BELOW_ANKLE, TOES_OVER_SOLE, dt)

    @property
    def farthest(self) -> float:
        """How far any foot is shifted along x or z [m]."""
        return farthest_shift(self.state)

    def held(self) -> npt.NDArray[np.float64]:
        """How far each held foot is from its clip's place, x, z [m], 0 for free ones, shape (A, 2, 2)."""
        shift = self.state[:, :, (SHIFT_X, SHIFT_Z)].astype(np.float64)
        return np.ascontiguousarray(shift * self.state[:, :, HELD, None])

    def slid(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """How far each dancer's feet have slid [m] where clips have them on the floor, and how long they stood [s],
        since this was last asked, (A,) each. A leg that does not reach lets its foot slip a little more than that."""
        slid, stood = np.zeros((2, len(self.state)))
        take_slid(self.state, slid, stood)
        return slid, stood

    def place(self, feet: Float32, age: float) -> None:
        """Write what the pose kernels need, (A, 2, 9), `age` [s] after the last tick: free feet have swung on."""
        swing_feet(feet, self.state, age)


def foot_heights(store: ClipStore) -> Float32:
    """How high the soles of both feet are over the floor [m] at all samples of legs alone, (S, 2): heel or ball."""
    pipeline = PosePipeline(len(store.root), PoseSkeleton.legs_only()[0])
    pipeline.sample[0] = np.arange(len(store.root))
    position, _ = pipeline.run(store)
    sole = np.minimum(position[:, 3::4, 1] - SOLE_BELOW_ANKLE, position[:, 4::4, 1] - TOES_OVER_SOLE)
    return np.ascontiguousarray(np.maximum(sole, 0.0), np.float32)


def lock_feet(clip: Clip) -> Clip:
    """The clip with every foot that its `contact` says carries held in place, and no sole below the floor.

    The hips sink by 2 cm at most where a leg is too short; knees bend, feet keep their rotation.
    """
    positions, _ = forward_kinematics(clip.root_position, clip.rotation)
    legs = np.ascontiguousarray(positions[:, LEG_JOINTS], np.float32)
    lock, count, contact = FootLock(1), clip.sample_count, clip.contact.copy()
    pipeline = PosePipeline(count)
    for sample in range(count):
        lock.tick(legs[sample : sample + 1], contact[sample : sample + 1], 1.0 / clip.sample_rate)
        pipeline.feet[sample, :, :FOLLOWED_COLUMNS] = lock.state[0, :, :FOLLOWED_COLUMNS]
    pipeline.feet[:, :, HELD] = 0.0  # the shifts are already those of their own samples
    pipeline.sample[0] = np.arange(count)
    pipeline.lock = True
    world_position, world_rotation = pipeline.run(ClipStore.of(clip.root_position, clip.rotation))
    rotation = quaternion.continuous(local_rotations(world_rotation))
    return Clip(
        name=clip.name,
        root_position=np.ascontiguousarray(world_position[:, 0]),
        rotation=np.ascontiguousarray(rotation, np.float32),
        sample_rate=clip.sample_rate,
        contact=contact,
    )


Int32 = npt.NDArray[np.int32]
Floats = npt.NDArray[np.floating]

STAYS: Final = 0.12
"""A foot that is no farther than this [m] from its new place does not go there: it is held where it comes down."""
ARRIVED: Final = 0.05
"""One that is on its way is held where it is nearer than this [m] to its new place."""
HIGHEST: Final = 0.06
"""Others are lifted so far [m]."""
UP: Final = 0.1
DOWN: Final = (0.22, 0.36)
"""It is up within so many seconds, and comes down between these."""


class Landing:
    """Which feet of A dancers are on their way to where a cut sent them."""

    def __init__(self, dancer_count: int) -> None:
        self.lift: Float32 = np.zeros((dancer_count, 2), np.float32)
        """How high each foot is lifted on its way [m], 0 for feet that stay or have none, shape (A, 2)."""

    def begin(self, rows: Int32, way: Floats) -> None:
        """The dancers `rows` (n,) are cut: their feet have a `way` (n, 2) [m] to go."""
        self.lift[rows] = np.where(way < STAYS, 0.0, HIGHEST)

    def near(self, away: Floats) -> Bool:
        """Which feet may be held that are `away` (A, 2) [m] from their places, (A, 2)."""
        return np.asarray(away < np.where(self.lift > 0.0, ARRIVED, STAYS))

    def clear(self, feet: Float32, age: Float32) -> None:
        """Lift them, by the columns CLEAR and ROUND of `feet` (A, 2, 9), `age` (A,) [s] after the cut."""
        up = _ease(age / UP) * _ease((DOWN[1] - age) / (DOWN[1] - DOWN[0])) * (age < LONGEST)
        lifted = self.lift * up[:, None].astype(np.float32)
        feet[:, :, CLEAR] = np.maximum(feet[:, :, CLEAR], lifted)
        feet[:, :, ROUND] = np.maximum(feet[:, :, ROUND], 0.3 * lifted)


def _ease(t: Floats) -> Floats:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))
