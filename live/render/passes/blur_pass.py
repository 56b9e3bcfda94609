"""Motion blur of dancers and camera: light is gathered along what moves while the shutter is open.

The method is that of McGuire, Hennessy, Bukowski and Osman 2012, A reconstruction filter for plausible motion blur. The
velocity of a dancer's pixel is that of the nearest bone, which needs no mesh: hair, clothes and characters move with
their bones.
"""

from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32, Float64
from live.base.picture_parameters import BY_ADDRESS
from live.base.stage_snapshot import StageView
from live.motion import quaternion
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.camera import FAR, NEAR
from live.render.headless import is_software
from live.render.pass_context import HDR, Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader, release_all
from live.render.uniforms import WALL_DISTANCE

_AMOUNT: Final = BY_ADDRESS["/dance/pass/blur"].first
_DIVISOR: Final = 2
"""Velocities are computed at 1/n of the picture's size."""
_TAPS: Final = (15, 9)
"""Samples along the way: on a graphics card, where the processor draws."""
_TILE: Final = 16
"""Side of a tile [pixels of the velocities]; with its neighbours it holds the longest way."""
_LONGEST: Final = 1.0 / 24.0
"""Longest way on either side of a pixel, as a share of the picture's height."""
_LEAP: Final = 1.0
"""A joint that moved farther than this [m] between two pictures was put there: it does not blur."""
LONGEST_INTERVAL_S: Final = 0.25
"""After a longer time between two pictures nothing blurs."""
_EXTENSIONS: Final = {"head": 0.20, "leftHand": 0.17, "rightHand": 0.17, "leftToes": 0.06, "rightToes": 0.06}
"""How far the body reaches beyond its last joints [m]."""


class BlurPass:
    """Draws the picture with motion blur; keeps the last picture's joints and camera."""

    needs_surfaces = True

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._velocity = FullscreenShader(
            ctx,
            "blur_velocity_fragment.glsl",
            (("NEAR", NEAR), ("FAR", FAR), ("WALL_BEHIND", WALL_DISTANCE), ("JOINTS", JOINT_COUNT)),
        )
        self._most = [FullscreenShader(ctx, "blur_tile_fragment.glsl") for _ in range(2)]
        self._final = FullscreenShader(
            ctx, "motion_blur_fragment.glsl", (("TAPS", _TAPS[is_software(ctx)]), ("TILE", _TILE * _DIVISOR))
        )
        self._motion = JointMotion()
        self._texture = ctx.texture((4, 1), 4, dtype="f4")
        self._last: Float64 | None = None
        self._time = 0.0
        self._reserve(max(making.scene.dancer_count, 1))
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        small = max(size[0] // _DIVISOR, 1), max(size[1] // _DIVISOR, 1)
        tiles = -(-small[0] // _TILE), -(-small[1] // _TILE)
        self._textures = [self._ctx.texture(each, 4, dtype=HDR) for each in (small, tiles, tiles)]
        for texture in self._textures:
            texture.repeat_x = texture.repeat_y = False
            texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._targets = [self._ctx.framebuffer([texture]) for texture in self._textures]

    def _reserve(self, dancers: int) -> None:
        """Make room for the joints of so many dancers, in blocks of rows."""
        limit = int(self._ctx.info["GL_MAX_TEXTURE_SIZE"])
        self._rows = min(dancers, limit)
        self._capacity = -(-dancers // self._rows) * self._rows
        self._texture.release()
        self._texture = self._ctx.texture((4 * JOINT_COUNT * (self._capacity // self._rows), self._rows), 4, dtype="f4")
        self._texture.filter = (moderngl.NEAREST, moderngl.NEAREST)

    @staticmethod
    def reach(height: float, row: Float64) -> float:
        """Return how far from a pixel it looks, with these parameters, in a picture of this height [pixels]."""
        return _LONGEST * height + 2.0 * _DIVISOR

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0."""
        used = moment.parameter(_AMOUNT) > 0.0
        if not used:
            self._last = None
        return used

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` with motion blur; the first picture after a cut has none."""
        assert surfaces is not None
        view, clip = moment.view, moment.uniforms.world_to_clip
        passed, self._time = view.time - self._time, view.time
        runs = self._last is not None and not moment.cut and 0.0 < passed <= LONGEST_INTERVAL_S
        self._upload(self._motion.update(view, fresh=not runs))
        self._velocity.set("motion_rows", self._rows)
        self._velocity.set("last_clip", tuple((self._last if runs else clip).T.ravel().tolist()))  # type: ignore[union-attr]
        self._velocity.set("shutter", moment.parameter(_AMOUNT))
        self._velocity.set("most", _LONGEST * moment.uniforms.height)
        self._last = clip
        velocity, tiles, around = self._textures
        self._velocity.draw(self._targets[0], depth=surfaces.depth, who=surfaces.identity, motion=self._texture)
        for shader, side, into, read in zip(self._most, (_TILE, 0), (1, 2), (velocity, tiles), strict=True):
            shader.set("tile", side)
            shader.draw(self._targets[into], source=read)
        self._final.draw(target, light=source, velocity=velocity, tiles=around)

    def _upload(self, motion: Float32) -> None:
        """Upload the motion of all joints, (A, J, 4, 4)."""
        count = len(motion)
        if count > self._capacity:
            self._reserve(count)
        width = 4 * JOINT_COUNT
        for block, first in enumerate(range(0, count, self._rows)):
            height = min(count - first, self._rows)
            self._texture.write(motion[first : first + height], viewport=(block * width, 0, width, height))

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        release_all(*self._targets, *self._textures)
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._textures, self._texture, self._velocity, *self._most, self._final)


class JointMotion:
    """Motion of all joints from one picture to the next."""

    def __init__(self) -> None:
        self._ends = _end_weights()
        self._position: Float32 = np.zeros((0, JOINT_COUNT, 3), np.float32)
        self._rotation: Float32 = np.zeros((0, JOINT_COUNT, 4), np.float32)
        self._present = np.zeros(0, np.bool_)
        self._rows: Float32 = np.zeros((0, JOINT_COUNT, 4, 4), np.float32)

    def update(self, view: StageView, *, fresh: bool) -> Float32:
        """Return, for each joint, where its bone begins and ends now [m], the rotation (x, y, z, w) back to the last
        picture, and where it began there; shape (A, J, 4, 4). `fresh`: nobody has moved."""
        position, rotation = view.joint_position, view.joint_rotation
        if len(position) != len(self._position):
            self._rows = np.zeros((len(position), JOINT_COUNT, 4, 4), np.float32)
            fresh = True
        if fresh:
            self._position, self._rotation = position.copy(), rotation.copy()
            self._present = view.present.copy()
        rows = self._rows
        rows[:, :, 0, :3] = position
        np.matmul(self._ends, position, out=rows[:, :, 1, :3])
        back = quaternion.mul(self._rotation, quaternion.inverse(rotation))
        last = np.where(self._put(view)[:, None, None], position, self._position)
        rows[:, :, 2, :3], rows[:, :, 2, 3] = back[..., 1:], back[..., 0]
        rows[self._put(view), :, 2] = (0.0, 0.0, 0.0, 1.0)
        rows[:, :, 3, :3] = last
        self._position[:], self._rotation[:], self._present[:] = position, rotation, view.present
        return rows

    def _put(self, view: StageView) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Return which dancers were put to another place or have just come, (A,)."""
        leap = np.abs(view.joint_position[:, 0] - self._position[:, 0]).max(axis=1) > _LEAP
        return np.asarray(leap | ~self._present, np.bool_)


def _end_weights() -> Float32:
    """Return the matrix that makes the ends of the bones from the joints, (J, J): a bone ends in the middle of the next
    joints; the last ones reach beyond their joint as far as the body does."""
    weights = np.zeros((JOINT_COUNT, JOINT_COUNT), np.float32)
    for joint, name in enumerate(SKELETON.names):
        parent, after = int(SKELETON.parents[joint]), np.flatnonzero(SKELETON.parents == joint)
        if len(after):
            weights[joint, after] = 1.0 / len(after)
            continue
        beyond = _EXTENSIONS.get(name, 0.1) / max(float(np.linalg.norm(SKELETON.offsets[joint])), 0.01)
        weights[joint, joint], weights[joint, parent] = 1.0 + beyond, -beyond
    return weights
