"""Carrying: how far dancers are carried beyond their steps, and agents along with their dancers."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.wings.entrances import ON
from live.show.dancers import Dancers
from live.show.group_motion import GroupMotion
from live.show.patch import Patch

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

FAITHFUL: Final = 0.4
"""Share of what legs give that a faithful dancer (obedience 0) is carried beyond her step at most."""
FAR: Final = np.float32(1e4)
"""Where those who are not on the stage are for the parting of the others [m]."""


class Carrying:
    """Decides every dancer's correction, and changes it within the measure."""

    def __init__(self, patch: Patch, dancers: Dancers, motion: GroupMotion) -> None:
        self._patch, self._dancers, self._motion = patch, dancers, motion

    def bound(self, node: Int32) -> Float64:
        """How far each dancer may be carried beyond her `node` (A,) [m], shape (A,): by legs, patch and obedience."""
        obedience = self._dancers.variation.obedience
        give = self._dancers.graph.node_give[np.maximum(node, 0)]
        return np.asarray(
            np.minimum(give * (FAITHFUL + (1.0 - FAITHFUL) * obedience), self._patch.locomotion.correction_m)
        )

    def settle(self, target: Float64) -> None:
        """Decide how the coming measures, all else of which is written, are corrected to end at `target` (A, 2) [m]."""
        coming, stage = self._dancers.coming, self._patch.stage
        end = coming.end_position()  # turned on the feet that carry, the hips end elsewhere
        error = target - end
        bound = self.bound(coming.node)
        error *= np.minimum(1.0, bound / np.maximum(np.hypot(*error.T), 1e-9))[:, None]
        anchor = np.ascontiguousarray(end, np.float32)
        place = np.ascontiguousarray(end + error, np.float32)
        on = self._motion.entrances.state == ON
        apart, held = np.where(on[:, None], place, FAR), np.where(on[:, None], anchor, FAR)
        self._motion.part(apart, held, self._patch.locomotion.correction_m)
        edge = np.array([stage.width / 2, stage.depth / 2], np.float32)
        place[on] = np.clip(apart[on], -edge, edge)
        coming.correction[:, :2] = place.astype(np.float64) - anchor
