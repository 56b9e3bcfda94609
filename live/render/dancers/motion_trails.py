"""Motion history for trails: paths of hands and feet for ribbons, and poses at earlier beats for ghosts."""

import math
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32
from live.base.picture_parameters import LONGEST_RIBBON, MAX_GHOSTS, PART_COUNT
from live.base.stage_snapshot import StageView
from live.motion.skeleton import SKELETON
from live.render.body.drawn_joints import ANCHORS
from live.render.dancers.dancer_batch import DancerBatch
from live.render.dancers.skinning import pose_texture
from live.render.render_kernels import limb_tips, pose_texels
from live.render.shader import release_all

SAMPLES_PER_BEAT: Final = 12
"""Samples per beat; the ribbon is a smooth curve between them."""
SAMPLES: Final = int(LONGEST_RIBBON) * SAMPLES_PER_BEAT + 6
LIMBS: Final = 4
"""Left and right hand, left and right foot."""
_ROW_LIMIT: Final = 4096
"""Dancers in one row of the texture."""
_JOINTS: Final = np.array([SKELETON.index(n) for n in ("leftHand", "rightHand", "leftToes", "rightToes")], np.int32)
_TIPS: Final = np.array([[0.12, -0.01, 0.0], [-0.12, -0.01, 0.0], [0.0, -0.005, 0.04], [0.0, -0.005, 0.04]], np.float32)


class LimbHistory:
    """Ring buffer of limb positions at every twelfth of a beat, in rows of a texture; the last row is the current one.

    Samples lie exactly on their beats at any frame rate: positions between two frames are interpolated linearly.
    """

    def __init__(self, ctx: moderngl.Context, capacity: int) -> None:
        self._ctx = ctx
        self._allocate(capacity)

    def _allocate(self, capacity: int) -> None:
        self._capacity = capacity
        self.blocks = -(-capacity // _ROW_LIMIT)
        self.columns = min(capacity, _ROW_LIMIT)
        shape = (self.blocks * self.columns, LIMBS, 4)
        self._now, self._before, self._between = (np.zeros(shape, np.float32) for _ in range(3))
        self.texture = self._ctx.texture((self.columns * LIMBS, (SAMPLES + 1) * self.blocks), 4, dtype="f4")
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.clear()

    def clear(self) -> None:
        """Clear the history."""
        self.valid_count = 0
        """Number of valid samples, counted from the newest."""
        self._beat = math.nan
        self._grid = 0

    def update(self, view: StageView, capacity: int) -> None:
        """Add a moment; after a jump the history is cleared."""
        if capacity != self._capacity:
            self.texture.release()
            self._allocate(capacity)
        limb_tips(view.joint_position, view.joint_rotation, view.present, _JOINTS, _TIPS, self._now)
        grid = math.floor(view.beat * SAMPLES_PER_BEAT)
        if not (self._beat <= view.beat and grid - self._grid < SAMPLES):
            self.clear()
            self._grid = grid
        for sample in range(self._grid + 1, grid + 1):
            share = (sample / SAMPLES_PER_BEAT - self._beat) / max(view.beat - self._beat, 1e-9)
            np.subtract(self._now, self._before, out=self._between)
            self._between *= np.float32(share)
            self._between += self._before
            self._write(self._between, sample % SAMPLES)
            self.valid_count = min(self.valid_count + 1, SAMPLES)
        self._write(self._now, SAMPLES)
        self._grid, self._beat = grid, view.beat
        self._now, self._before = self._before, self._now

    def _write(self, tips: Float32, row: int) -> None:
        self.texture.write(tips, viewport=(0, row * self.blocks, self.columns * LIMBS, self.blocks))

    @property
    def ring(self) -> tuple[float, float, float, float]:
        """Row of the newest sample, number of rows, beats since that sample, samples per beat."""
        return (
            float(self._grid % SAMPLES),
            float(SAMPLES),
            self._beat - self._grid / SAMPLES_PER_BEAT,
            float(SAMPLES_PER_BEAT),
        )

    def release(self) -> None:
        """Free the texture."""
        release_all(self.texture)


_REST: Final = np.ascontiguousarray(SKELETON.rest_positions(), np.float32)
_JUMP_BEATS: Final = 16.0
"""More beats than this between two pictures are a jump."""


class PoseHistory:
    """Ring buffer of pose textures; a group leaves ghosts at every multiple of its spacing in beats."""

    def __init__(self, ctx: moderngl.Context, capacity: int) -> None:
        self._ctx = ctx
        self._allocate(capacity)

    def _allocate(self, capacity: int) -> None:
        self._capacity = capacity
        self.textures = [pose_texture(self._ctx, capacity) for _ in range(MAX_GHOSTS)]
        width, rows = self.textures[0].size
        self._texels = np.zeros((MAX_GHOSTS, rows, width, 4), np.float32)
        self._poses = np.zeros((rows, width, 4), np.float32)
        self.clear()

    def clear(self) -> None:
        """Remove all ghosts."""
        self._ghost_beat = np.full((MAX_GHOSTS, PART_COUNT), np.nan)  # beat of each ghost
        self._beat = math.nan

    def update(self, view: StageView, batch: DancerBatch) -> None:
        """Add a moment of the dancers of `batch`."""
        if batch.capacity != self._capacity:
            release_all(*self.textures)
            self._allocate(batch.capacity)
        beat = view.beat
        if not self._beat <= beat < self._beat + _JUMP_BEATS:
            self.clear()
            self._beat = beat
        spacing = batch.styles.spacing
        line = np.floor(beat / spacing)
        leaving = (line > np.floor(self._beat / spacing)) & batch.styles.masks["trails"]
        for group in np.flatnonzero(leaving).tolist():
            slot = int(line[group]) % MAX_GHOSTS  # the same whenever the history began
            self._store_ghosts(group, float(line[group] * spacing[group]), slot, view)
        self._beat = beat

    def _store_ghosts(self, group: int, beat: float, slot: int, view: StageView) -> None:
        """Store the current poses of a group's dancers as ghosts."""
        self._ghost_beat[slot, group] = beat
        pose_texels(view.joint_position, view.joint_rotation, _REST, ANCHORS, self._poses)
        rows, width = self._poses.shape[:2]
        blocks = -(-self._capacity // rows)
        mine = np.zeros(blocks * rows, np.bool_)
        mine[: len(view.group)] = view.group % PART_COUNT == group
        shape = (rows, blocks, width // blocks, 4)
        where = mine.reshape(blocks, rows).T[:, :, None, None]
        np.copyto(self._texels[slot].reshape(shape), self._poses.reshape(shape), where=where)
        self.textures[slot].write(self._texels[slot])

    def ages(self, slot: int) -> Float32:
        """Return the age of each group's ghosts in a slot [beats], -1 if there are none, shape (PART_COUNT,)."""
        return np.asarray(np.nan_to_num(self._beat - self._ghost_beat[slot], nan=-1.0), np.float32)

    def release(self) -> None:
        """Free the textures."""
        release_all(*self.textures)
