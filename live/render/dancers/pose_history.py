"""The poses in which dancers were at earlier beats, from which ghosts are drawn; kept while there are any."""

import math
from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.picture import GROUPS
from live.base.stage_snapshot import StageView
from live.base.styles import MOST_GHOSTS
from live.render.dancers.dancer_batch import Crowd, pose_texture
from live.render.gl_release import release_all

Float32 = npt.NDArray[np.float32]

_LEAP: Final = 16.0
"""Beats in one picture beyond which the show has jumped."""


class PoseHistory:
    """A ring of pose textures; a group's dancers leave a ghost whenever the beat is a multiple of their spacing."""

    def __init__(self, ctx: moderngl.Context, capacity: int) -> None:
        self._ctx = ctx
        self._allocate(capacity)

    def _allocate(self, capacity: int) -> None:
        self._capacity = capacity
        self.textures = [pose_texture(self._ctx, capacity) for _ in range(MOST_GHOSTS)]
        width, rows = self.textures[0].size
        self._texels = np.zeros((MOST_GHOSTS, rows, width, 4), np.float32)
        self.forget()

    def forget(self) -> None:
        """There are no ghosts."""
        self._left = np.full((MOST_GHOSTS, GROUPS), np.nan)  # the beat at which each was left
        self._next = np.zeros(GROUPS, np.int64)
        self._beat = math.nan

    def update(self, view: StageView, crowd: Crowd) -> None:
        """Take a moment whose poses `crowd` holds already."""
        if crowd.capacity != self._capacity:
            release_all(*self.textures)
            self._allocate(crowd.capacity)
        beat = view.beat
        if not self._beat <= beat < self._beat + _LEAP:
            self.forget()
            self._beat = beat
        spacing = crowd.styles.spacing
        line = np.floor(beat / spacing)
        leaving = (line > np.floor(self._beat / spacing)) & crowd.styles.masks["trails"]
        for group in np.flatnonzero(leaving).tolist():
            self._leave(group, float(line[group] * spacing[group]), view, crowd)
        self._beat = beat

    def _leave(self, group: int, beat: float, view: StageView, crowd: Crowd) -> None:
        """The dancers of a group leave their poses of now."""
        slot = int(self._next[group]) % MOST_GHOSTS
        self._next[group] += 1
        self._left[slot, group] = beat
        rows, width = crowd.texels.shape[:2]
        blocks = -(-self._capacity // rows)
        mine = np.zeros(blocks * rows, np.bool_)
        mine[: len(view.group)] = view.group % GROUPS == group
        shape = (rows, blocks, width // blocks, 4)
        where = mine.reshape(blocks, rows).T[:, :, None, None]
        np.copyto(self._texels[slot].reshape(shape), crowd.texels.reshape(shape), where=where)
        self.textures[slot].write(self._texels[slot])

    def ages(self, slot: int) -> Float32:
        """Beats since each group's ghosts in a slot were left, -1 where there are none, shape (16,)."""
        return np.asarray(np.nan_to_num(self._beat - self._left[slot], nan=-1.0), np.float32)

    def release(self) -> None:
        """Free the textures."""
        release_all(*self.textures)
