"""Ghosts of dancers in the poses of earlier beats (after Marey's chronophotographs, 1882)."""

import moderngl
import numpy as np

from live.base.stage_snapshot import StageView
from live.base.styles import MOST_GHOSTS
from live.render.dancers.dancer_batch import Crowd
from live.render.dancers.pose_history import PoseHistory
from live.render.gl_release import release_all
from live.render.pass_context import Making
from live.render.shader import program, set_uniform


class GhostPass:
    """Draws over the bound target, which must not write depth; `follow` once a picture while there are trails."""

    def __init__(self, making: Making) -> None:
        ctx = self._ctx = making.ctx
        self._program = program(ctx, "ghost_vertex.glsl", "ghost_fragment.glsl", (("SOFT", 0),))
        self.history = PoseHistory(ctx, max(making.scene.dancer_count, 1))

    def follow(self, crowd: Crowd, view: StageView) -> None:
        """Take the poses of this picture where a ghost is to be left."""
        self.history.update(view, crowd)

    def draw(self, crowd: Crowd) -> None:
        """Draw the ghosts of all dancers who have any, the oldest first."""
        self._ctx.enable(moderngl.CULL_FACE)
        ages = [self.history.ages(slot) for slot in range(MOST_GHOSTS)]
        for slot in sorted(range(MOST_GHOSTS), key=lambda slot: -float(ages[slot].max())):
            if ages[slot].max() >= 0.0:
                set_uniform(self._program, "ages", [tuple(four) for four in np.reshape(ages[slot], (4, 4)).tolist()])
                crowd.draw(self._program, crowd.quality.ghost_level, "trails", poses=self.history.textures[slot])
        self._ctx.disable(moderngl.CULL_FACE)

    def release(self) -> None:
        """Free everything."""
        release_all(self._program, self.history)
