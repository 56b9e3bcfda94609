"""The renderer: a `StageView` into a framebuffer, pass by pass."""

from typing import Final

import moderngl
import numpy as np

from live.base.stage_view import FLOOR_MARGIN, PATH, Camera, Scene, StageView
from live.render.camera import covered, view_matrix, world_to_clip
from live.render.crowd import Crowd
from live.render.frame import WALL_BEHIND, FrameBlock
from live.render.passes.backdrop_pass import BackdropPass
from live.render.passes.dancer_pass import DancerPass
from live.render.passes.film_pass import FilmPass
from live.render.passes.floor_pass import FloorPass
from live.render.passes.guide_pass import GuidePass
from live.render.passes.mirror_pass import MirrorPass
from live.render.passes.overlay_pass import OverlayPass
from live.render.passes.smooth_pass import SmoothPass
from live.render.passes.stage_pass import StagePass
from live.render.passes.surface_pass import SurfacePass
from live.render.quality import Quality, choose
from live.render.release import Releasable, release_all

_BODY_AROUND_JOINTS: Final = 0.25
"""The body reaches at most this far beyond its joints [m]."""


class Renderer:
    """Draws moments of one scene at one size; GL objects are made here and in `resize`, none while drawing.

    `samples` is the multisampling; None chooses 4 on a graphics card and 0 where the processor draws. `quality`
    overrides the whole choice. `target` may name the framebuffer that will be drawn to: its size must then be `size`.
    Targets need no depth and no samples of their own.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        *,
        size: tuple[int, int],
        samples: int | None = None,
        target: moderngl.Framebuffer | None = None,
        quality: Quality | None = None,
    ) -> None:
        self._ctx, self._scene, self._size = ctx, scene, _checked(size)
        if target is not None and tuple(target.size) != size:
            raise ValueError(f"renderer: the target is {target.size}, the size asked for {size}")
        self.quality = quality or choose(ctx, scene.dancer_count, samples)
        self._frame = FrameBlock(ctx, scene, size)
        self._crowd = Crowd(ctx, scene, self.quality)
        width, depth = scene.stage_size
        self._floor = FloorPass(ctx, self.quality, (width + 2 * FLOOR_MARGIN, depth + 2 * FLOOR_MARGIN))
        self._mirror = MirrorPass(ctx, size, self.quality.mirror_divisor)
        self._backdrop = BackdropPass(ctx, size, coarse=self.quality.samples == 0)
        self._stage = StagePass(ctx, self.quality)
        self._guide = GuidePass(ctx)
        self._overlay = OverlayPass(ctx)
        self._lit_while_drawn = self.quality.samples > 0
        if self._lit_while_drawn:
            self._film = FilmPass(ctx, self.quality.samples, size)
            self._dancer = DancerPass(ctx, self.quality)
        else:
            self._surface = SurfacePass(ctx, self.quality, size)
            self._smooth = SmoothPass(ctx, self._surface.depth, size)
        self._look_from(scene.camera)
        self._draw_once()

    def _look_from(self, camera: Camera) -> None:
        """What depends on the camera beside the block of uniforms."""
        self._floor_rows = _rows_of_floor(camera, self._scene.stage_size, self._size)
        self._world_to_clip = world_to_clip(camera, self._size)
        self._crowd.look_from(camera)

    def _draw_once(self) -> None:
        """Drivers compile a program when it first draws: better now than in the show."""
        size = self._size
        scratch = self._ctx.texture(size, 4)
        framebuffer = self._ctx.framebuffer([scratch])
        view = StageView.allocate(max(self._scene.dancer_count, 1), self._scene.joint_count)
        view.element_count, view.obstacle_count = 3, 1  # a point, a disc, and a line with something running along it
        view.element_radius[1], view.obstacle[0, 2] = 1.0, 1.0
        view.element_kind[2], view.element_corners[2] = PATH, 2
        view.guide_count = 1
        self.draw(view, framebuffer)
        release_all(framebuffer, scratch)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [pixels]."""
        return self._size

    def draw(self, view: StageView, target: moderngl.Framebuffer) -> None:
        """Draw one moment into `target` (the screen's framebuffer or any other of this size)."""
        frame = self._frame
        frame.write(view)
        if frame.moved:
            self._look_from(frame.camera)
        if frame.relit:
            self._backdrop.forget()
        if frame.recoloured:
            self._crowd.recolour(frame.group_colours)
        if frame.level <= 0.0:
            target.use()
            target.clear(0.0, 0.0, 0.0, 1.0)
        else:
            self._crowd.update(view)
            self._backdrop.draw(moving=frame.relit)
            self._floor.draw(self._crowd, view)
            self._mirror.draw(self._crowd)
            if self._lit_while_drawn:
                self._draw_film(target)
            else:
                self._draw_plain(view, target)
        self._guide.draw(view, target, self._size)
        self._overlay.draw(view.overlay, target, self._size)

    def _draw_film(self, target: moderngl.Framebuffer) -> None:
        into = self._film.target
        into.use()
        into.clear()
        self._dancer.draw(self._crowd, self._floor.texture)
        self._draw_stage(into)
        self._film.draw(target)

    def _draw_plain(self, view: StageView, target: moderngl.Framebuffer) -> None:
        where = self._where_dancers_are(view)
        self._surface.draw(self._crowd)
        into = self._smooth.target
        into.use()
        into.scissor = where
        self._surface.shade(self._floor.texture)
        self._draw_stage(into)
        self._smooth.draw(target, where)

    def _where_dancers_are(self, view: StageView) -> tuple[int, int, int, int]:
        """The pixels that dancers may cover: others need neither be lit nor smoothed."""
        if len(view.joint_position) == 0:
            return 0, 0, 0, 0
        joints = view.joint_position.reshape(-1, 3)
        low, high = joints.min(axis=0) - _BODY_AROUND_JOINTS, joints.max(axis=0) + _BODY_AROUND_JOINTS
        return covered(self._world_to_clip, self._size, low.astype(np.float64), high.astype(np.float64))

    def _draw_stage(self, into: moderngl.Framebuffer) -> None:
        self._stage.draw(into, self._floor_rows, self._backdrop.texture, self._floor.texture, self._mirror.texture)

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]; a minimised window's (0, 0) is taken as 1 x 1."""
        size = _checked(size)
        if size == self._size:
            return
        self._size = size
        self._frame.resize(size)
        self._mirror.resize(size)
        self._backdrop.resize(size)
        if self._lit_while_drawn:
            self._film.resize(size)
        else:
            self._surface.resize(size)
            self._smooth.resize(self._surface.depth, size)
        self._look_from(self._frame.camera)

    def release(self) -> None:
        """Free everything that was made; the renderer must not be used afterwards."""
        own: list[Releasable] = [
            self._frame,
            self._crowd,
            self._floor,
            self._mirror,
            self._backdrop,
            self._stage,
            self._guide,
            self._overlay,
        ]
        own += [self._film, self._dancer] if self._lit_while_drawn else [self._smooth, self._surface]
        release_all(*own)


def _checked(size: tuple[int, int]) -> tuple[int, int]:
    return max(int(size[0]), 1), max(int(size[1]), 1)


def _rows_of_floor(camera: Camera, stage_size: tuple[float, float], size: tuple[int, int]) -> int:
    """How many rows of pixels from below can show the floor (above them is only the back wall)."""
    axes = view_matrix(camera)[:3, :3]
    up = np.tan(0.5 * np.deg2rad(camera.field_of_view_deg))
    rows = (2.0 * (np.arange(size[1]) + 1.0) / size[1] - 1.0) * up
    wall = -0.5 * stage_size[1] - WALL_BEHIND
    seen = 0
    for side in (-1.0, 0.0, 1.0):
        rays = -axes[2] + axes[0] * (side * up * size[0] / size[1]) + rows[:, None] * axes[1]
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = -camera.eye[1] / rays[:, 1]
            floor = (rays[:, 1] < 0.0) & (camera.eye[2] + reach * rays[:, 2] > wall)
        if floor.any():
            seen = max(seen, int(np.flatnonzero(floor)[-1]) + 1)
    return min(seen + 1, size[1])
