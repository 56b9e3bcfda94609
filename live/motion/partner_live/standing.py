"""Standing: feet of those who answer are held where they stand, as those of all other dancers are (T050, K014)."""

import numpy as np
import numpy.typing as npt

from live.motion.partner_live.stage_partner_kernels import joints_in_parents
from live.motion.pose.foot_lock import LEG_JOINTS, FootLock
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


class Standing:
    """The feet of A dancers, of whom few answer."""

    def __init__(self, count: int) -> None:
        self.lock = FootLock(count)
        self._legs: Float32 = np.zeros((count, len(LEG_JOINTS), 3), np.float32)
        self._contact: Bool = np.zeros((count, 2), np.bool_)
        self._pipeline = PosePipeline(0)

    def tick(self, rows: Int32, position: Float32, contact: Bool, dt: float) -> None:
        """A tick of `dt` [s]: the dancers `rows` (n,) would be at `position` (n, J, 3), and these of their feet stand,
        `contact` (n, 2); all others' feet are let go."""
        self._contact[:] = False
        self._contact[rows] = contact
        self._legs[rows] = position[:, LEG_JOINTS]
        self.lock.tick(self._legs, self._contact, dt)

    def hold(self, rows: Int32, position: Float32, rotation: Float32, age: float) -> None:
        """Hold the feet of the dancers `rows` (n,) in poses (A, J, 3) and (A, J, 4), world, `age` [s] after a tick."""
        if not len(rows) or not self.lock.farthest:
            return
        if len(self._pipeline.age) != len(rows):
            self._pipeline = PosePipeline(len(rows))
            self._pipeline.sample[0] = np.arange(len(rows))
            self._pipeline.lock = True
        pipeline, parents = self._pipeline, self._pipeline.skeleton.parents
        one = FootLock(0)
        one.state = np.ascontiguousarray(self.lock.state[rows])
        one.place(pipeline.feet, age)
        own = np.empty((len(rows), *rotation.shape[1:]), np.float32)
        joints_in_parents(np.ascontiguousarray(rotation[rows]), parents, own)
        held = pipeline.run(ClipStore.of(position[rows, 0], own))
        position[rows], rotation[rows] = held
