"""Pose pipeline: preallocated inputs and outputs of the pose kernels for A dancers."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int32
from live.base.row_ranges import run_rows
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.pose.foot_lock_kernels import FEET_COLUMNS, TOES
from live.motion.pose.inertialization import zero_differences
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME
from live.motion.pose.pipeline_kernels import pose_dancers
from live.motion.pose.sample_kernels import BLOCK
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

RANGE: Final = 4 * BLOCK
"""So many dancers' poses are worth a range of their own."""
LEG_NAMES: Final = tuple(
    side + joint for side in ("left", "right") for joint in ("UpperLeg", "LowerLeg", "Foot", "Toes")
)


@dataclass(frozen=True, slots=True, eq=False)
class PoseSkeleton:
    """Skeleton data of J joints for the kernels."""

    offsets: Float32
    """Shape (J, 3) [m]."""
    parents: Int32
    """Shape (J,); a parent comes before its children."""
    body: Int32
    """UPPER_FIRST, UPPER_LAST, CHEST, HEAD as in `pipeline_kernels`, shape (4,)."""
    legs: Int32
    """Hip, knee, ankle and toes of the left and the right leg, shape (8,); empty if feet are never locked."""

    @classmethod
    @cache
    def whole(cls) -> "PoseSkeleton":
        """The engine's skeleton."""
        upper = [SKELETON.index(name) for name in SKELETON.names if name != "hips" and name not in LEG_NAMES]
        if upper != list(range(upper[0], upper[-1] + 1)):
            raise AssertionError("the joints of the upper body must follow each other")
        return cls(
            offsets=np.array(SKELETON.offsets),
            parents=np.array(SKELETON.parents),
            body=np.array([upper[0], upper[-1] + 1, SKELETON.index("upperChest"), SKELETON.index("head")], np.int32),
            legs=np.array([SKELETON.index(name) for name in LEG_NAMES], np.int32),
        )

    @classmethod
    @cache
    def legs_only(cls) -> tuple["PoseSkeleton", Int32]:
        """Hips and legs only, 9 joints, and their indices in the engine's skeleton, (9,)."""
        joints = np.array([0, *(SKELETON.index(name) for name in LEG_NAMES)], np.int32)
        place = {int(joint): row for row, joint in enumerate(joints)}
        parents = [-1 if joint == 0 else place[int(SKELETON.parents[joint])] for joint in joints]
        legs = cls(
            offsets=np.ascontiguousarray(SKELETON.offsets[joints]),
            parents=np.array(parents, np.int32),
            body=np.array([len(joints), len(joints), -1, -1], np.int32),
            legs=np.zeros(0, np.int32),
        )
        return legs, joints


@dataclass(frozen=True, slots=True, eq=False)
class ClipStore:
    """All clips concatenated, as the kernels read them: S samples, N nodes."""

    root: Float32
    """Hips [m], shape (S, 3)."""
    rotation: Float32
    """Local rotations, shape (S, J, 4). Signs are continuous within a clip; clips that are blended have the signs
    between which joints bend naturally (see `slerp_rows`)."""
    mean: Float32
    """Mean pose of each node, shape (N, J, 4), with its clip's signs; the reference of the amplitude (T058)."""

    @classmethod
    def of(cls, root: Float32, rotation: Float32, mean: Float32 | None = None) -> "ClipStore":
        """Create from arrays of any layout; without mean poses the amplitude is undefined."""
        if mean is None:
            mean = np.zeros((1, *rotation.shape[1:]), np.float32)
            mean[..., 0] = 1.0
        arrays = (np.require(array, np.float32, ["C", "W"]) for array in (root, rotation, mean))
        return cls(*arrays)


NOT_BENT: Final = np.zeros((0, 0, 3), np.float32)
NOT_LATE: Final = np.zeros((0, 0), np.float32)


class PosePipeline:
    """Fill the public arrays, then call `run`. Per frame only the blocks' few kilobytes are allocated."""

    def __init__(self, dancer_count: int, skeleton: PoseSkeleton | None = None) -> None:
        self.skeleton = skeleton if skeleton is not None else PoseSkeleton.whole()
        joints, count = len(self.skeleton.parents), dancer_count
        self.sample: Float64 = np.zeros((4, count))
        """Fractional samples of the clips PRESENT, PRESENT_TAKE, NEXT and NEXT_TAKE, shape (4, A)."""
        self.placement: Float64 = np.zeros((4, count, 4))
        """Placement of these clips: x, z [m], yaw of the path, yaw of the body [rad], shape (4, A, 4)."""
        self.share: Float32 = np.zeros((5, count), np.float32)
        """Shares LOWER, UPPER, INTO_NEXT, NEXT_LOWER and NEXT_UPPER, 0 to 1, shape (5, A)."""
        self.mean: Int32 = np.zeros((2, count), np.int32)
        """Nodes whose mean poses the amplitude refers to: present and next clip, shape (2, A)."""
        self.amplitude: Float32 = np.ones(count, np.float32)
        """Amplitude of the upper body, 1 = as recorded, shape (A,) (T058)."""
        self.bend: Float32 = NOT_BENT
        """How the mood bends the joints of the upper body, (A, U, 3) rotation vectors [rad]; empty: not at all."""
        self.late: Float32 = NOT_LATE
        """How late the hands are in each of the four clips [samples], (4, A); empty: not at all."""
        self.head: Float32 = np.zeros(count, np.float32)
        """Share of the head's turn to the audience, 0 to 1, shape (A,) (T123-T125)."""
        self.feet: Float32 = np.zeros((count, 2, FEET_COLUMNS), np.float32)
        """Foot lock, columns as in `foot_lock_kernels`; the legs are unchanged unless `lock` is set."""
        self.lock = False
        self.difference: Float32 = zero_differences(1, joints)
        """Fading differences after cuts, (A, rows, 7) as in `inertialization_kernels`; read only where `age` is below
        MAX_FADE_TIME."""
        self.age: Float32 = np.full(count, MAX_FADE_TIME, np.float32)
        """Time since each dancer's last cut [s], shape (A,)."""
        self.difference_rows: Int32 = np.arange(joints, dtype=np.int32)
        """Row of the fading differences for each joint, shape (J,)."""
        self.position: Float32 = np.zeros((count, joints, 3), np.float32)
        """World positions of the joints [m], shape (A, J, 3)."""
        self.rotation: Float32 = np.zeros((count, joints, 4), np.float32)
        """World rotations of the joints, shape (A, J, 4)."""
        self._soles = np.array([SOLE_BELOW_ANKLE, TOES_OVER_SOLE], np.float32)
        self._count = count

    def has_valid_shapes(self) -> bool:
        """Whether all arrays have the shapes for its number of dancers, so that the kernels can run on them."""
        count, joints = self._count, len(self.skeleton.parents)
        shapes = (
            (self.sample, (4, count)), (self.placement, (4, count, 4)), (self.share, (5, count)),
            (self.mean, (2, count)), (self.amplitude, (count,)), (self.head, (count,)),
            (self.feet, (count, 2, FEET_COLUMNS)), (self.age, (count,)), (self.difference_rows, (joints,)),
            (self.position, (count, joints, 3)), (self.rotation, (count, joints, 4)),
        )  # fmt: skip
        bend = self.bend.shape in ((0, 0, 3), (count, self.skeleton.body[1] - self.skeleton.body[0], 3))
        late = self.late.shape in ((0, 0), (4, count))
        return bend and late and all(array.shape == shape for array, shape in shapes)

    def run(
        self,
        clips: ClipStore,
        out: tuple[npt.NDArray[Any], npt.NDArray[Any]] | None = None,
        *,
        only: Sequence[int] | None = None,
    ) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Return world positions (A, J, 3) [m] and rotations (A, J, 4), in `out` if given, else in the pipeline's own
        arrays.

        If `only` is given, only blocks that contain these dancers are computed.
        """
        position, rotation = out if out is not None else (self.position, self.rotation)
        if not self.lock:
            self.feet[:, :, TOES] = -1.0
        skeleton = self.skeleton

        def part(begin: int, end: int) -> None:
            pose_dancers(
                position, rotation, clips.root, clips.rotation, clips.mean,
                self.sample, self.placement, self.share, self.mean, self.amplitude, self.bend, self.late,
                self.head, self.feet,
                self.difference, self.age, self.difference_rows,
                skeleton.offsets, skeleton.parents, skeleton.body, skeleton.legs, self._soles, begin, end,
            )  # fmt: skip

        if only is None:
            run_rows(part, self._count, least=RANGE, block=BLOCK)
        else:
            for begin in sorted({row - row % BLOCK for row in only}):
                part(begin, min(begin + BLOCK, self._count))
        return position, rotation
