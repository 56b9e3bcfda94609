"""Renderer that draws a `StageView` into a framebuffer."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import moderngl

from live.base.custom_pass import OwnPass
from live.base.picture_parameters import AMOUNTS, BY_ADDRESS, STYLE_OF_GROUP, Float64, of_group, picture_of
from live.base.stage_snapshot import PATH, Camera, Scene, StageView
from live.render.adaptive_quality import CARD, Quality, Step, choose, ladder_of
from live.render.dancers.dancer_batch import Crowd
from live.render.gl_release import release_all
from live.render.pass_context import Making, Moment
from live.render.passes.overlay_pass import GraphPass, GuidePass, OverlayPass
from live.render.pipeline import Pipeline
from live.render.shader import Full
from live.render.uniforms import FrameBlock

LEAP: Final = 64.0
"""After a jump of more beats than this a picture does not continue the previous one."""


class Renderer:
    """Draws moments of one scene at one size; GL objects are created here and in `resize`, none while drawing.

    `samples` is the multisampling; None chooses 4 on a graphics card and 0 in software. `quality` overrides the whole
    choice. `target`: the framebuffer that will be drawn to; its size must be `size`. `patient`: wait for pictures of
    videos, as in an offline film. Targets need no depth and no samples.
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
        steps: bool = False,
        patient: bool = False,
        bare: bool = False,
    ) -> None:
        """`steps`: also create what the lower quality steps need; see `take_step`.
        `bare`: without a stage, in pictures with alpha (needs samples)."""
        self._ctx, self._scene, self._size = ctx, scene, _checked(size)
        if target is not None and tuple(target.size) != size:
            raise ValueError(f"renderer: the target is {target.size}, the size asked for {size}")
        self.quality = quality or (_bare_quality(ctx) if bare else choose(ctx, scene.dancer_count, samples))
        self._empty = 0.0 if bare else 1.0
        self.steps = ladder_of(self.quality) if steps else (Step("all", self.quality),)
        """The quality steps, the best one first."""
        self.step = 0
        """The current quality step."""
        self.mark: Callable[[str], None] = _nobody
        """Callback after each part of a frame, for time measurement: "upload", "draw"."""
        self._drawn_size = self._size
        self._frame = FrameBlock(ctx, scene, size)
        self._crowd = Crowd(ctx, scene, self.quality, self._size)
        self._crowd.restyle(self._frame.row)
        self._making = Making(ctx, scene, self.quality, self._size, patient, bare)
        self._own: tuple[OwnPass, ...] = ()  # custom passes whose source was replaced
        self._pipeline = Pipeline(self._making)
        self._frame.vignette_at_end = self._pipeline.chain.vignette_at_end
        self._guide = GuidePass(ctx)
        self._overlay = OverlayPass(ctx)
        self.graph = GraphPass(ctx)
        """The overlay's graph of frame times."""
        self._stretch = Full(ctx, "stretch_fragment.glsl")
        self._small: tuple[moderngl.Texture, moderngl.Framebuffer] | None = None
        self._beat = 0.0  # of the last picture
        self._moment = Moment(StageView.allocate(0, 1), self._frame, self._crowd, self._pipeline.floor.texture)
        self._draw_once()

    def _look_from(self, camera: Camera) -> None:
        """Update everything that depends on the camera, except the uniform block."""
        self._pipeline.look_from(camera)
        self._crowd.look_from(camera, self._size)

    def _draw_once(self) -> None:
        """Draw with every step and style once, because drivers compile a program when it first draws."""
        size = self._size
        scratch = self._ctx.texture(size, 4)
        framebuffer = self._ctx.framebuffer([scratch])
        view = StageView.allocate(max(self._scene.dancer_count, 1), self._scene.joint_count)
        view.element_count, view.obstacle_count = 3, 1  # a point, a disc, and a line with something running along it
        view.element_radius[1], view.obstacle[0, 2] = 1.0, 1.0
        view.element_kind[2], view.element_corners[2] = PATH, 2
        view.guide_count = 1
        for step in (*reversed(range(len(self.steps))), 0) if len(self.steps) > 1 else (0,):
            self.take_step(step)
            for styles in (_everything(self._scene, passes=len(self.steps) > 1), None) if step == 0 else (None,):
                view.picture = styles
                self.draw(view, framebuffer)
        self._moment.cut = True
        release_all(framebuffer, scratch)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [pixels]."""
        return self._size

    def draw(self, view: StageView, target: moderngl.Framebuffer) -> None:
        """Draw one moment into `target` (the screen's framebuffer, or another one of this size)."""
        frame, moment = self._frame, self._moment
        frame.write(view)
        if frame.moved:
            self._look_from(frame.camera)
        if frame.relit:
            self._pipeline.relit()
        if frame.recoloured:
            self._crowd.recolour(frame.group_colours)
        if frame.restyled:
            self._crowd.restyle(frame.row)
        passed = 0.0 if moment.cut else view.beat - self._beat
        moment.view, moment.cut = view, moment.cut or not 0.0 <= passed <= LEAP
        moment.beats, self._beat = 0.0 if moment.cut else passed, view.beat
        if frame.level <= 0.0:
            target.use()
            target.clear(0.0, 0.0, 0.0, self._empty)
        else:
            self._crowd.update(view, frame.light)
            self.mark("upload")
            if self._small is None:
                self._pipeline.draw(moment, target)
            else:
                self._draw_small(moment, target, self._small)
        moment.cut = frame.level <= 0.0
        self.annotate(view, target)
        self._pipeline.faults.drawn()

    def annotate(self, view: StageView, target: moderngl.Framebuffer) -> None:
        """Draw what only the operator sees over a finished picture: guides and overlay, if shown."""
        faults = self._pipeline.faults
        try:
            if view.overlay and faults.may("graph"):
                self.graph.draw(target, self._size)
            if faults.may("guide"):
                self._guide.draw(view, target, self._size)
            if faults.may("overlay"):
                self._overlay.draw(view.overlay, target, self._size)
        except Exception as error:
            faults.failed(error)
            raise

    def resize(self, size: tuple[int, int]) -> None:
        """Set a new size of the picture [pixels]; (0, 0) of a minimised window becomes 1 x 1."""
        size = _checked(size)
        if size == self._size:
            return
        self._size, self._moment.cut = size, True
        self._frame.resize(size)
        self._fit()
        self._crowd.look_from(self._frame.camera, size)

    @property
    def problems(self) -> list[str]:
        """Messages about failed files and passes; the last good state is drawn."""
        return self._pipeline.problems

    def reset_pass(self, name: str) -> None:
        """Enable a pass again that was left out after failures; empty: all."""
        self._pipeline.faults.reset(name)

    def take_own(self, passes: tuple[OwnPass, ...]) -> None:
        """Replace the source of custom passes; PersonError if one does not compile: its last version stays."""
        self._pipeline.chain.take_own(passes)
        self._own = passes

    def take_shaders(self) -> None:
        """Rebuild all programs from the current shader files; PersonError if one does not compile: the old ones stay
        (new ones compiled before the error are freed with the context).

        For developers of looks: this takes seconds, in which nothing is drawn, and passes lose their history.
        """
        ctx = self._ctx
        made = Pipeline(replace(self._making, size=self._drawn_size))
        others = GuidePass(ctx), OverlayPass(ctx), GraphPass(ctx), Full(ctx, "stretch_fragment.glsl")
        made.chain.take_own(self._own)
        release_all(self._pipeline, self._guide, self._overlay, self.graph, self._stretch)
        self._pipeline, (self._guide, self._overlay, self.graph, self._stretch) = made, others
        made.take(self.quality)
        made.look_from(self._frame.camera)
        made.relit()
        self._moment.floor, self._moment.cut = made.floor.texture, True

    def take_step(self, step: int) -> None:
        """Draw with another quality step; one with another size resizes the pipeline."""
        if step == self.step and self.quality is self.steps[step].quality:
            return
        self.step, self.quality = step, self.steps[step].quality
        self._crowd.quality = self.quality
        self._pipeline.take(self.quality)
        self._moment.floor = self._pipeline.floor.texture
        self._fit()

    def helps(self, step: int) -> bool:
        """Whether that quality step would reduce the current picture."""
        return self._pipeline.helps(self.steps[step].kind, self._moment)

    def _fit(self) -> None:
        """Resize the scene's targets to the size and scale of the current quality."""
        scale = self.quality.scale
        width, height = _checked((round(self._size[0] * scale), round(self._size[1] * scale)))
        if (width, height) != self._drawn_size:
            self._drawn_size = width, height
            self._moment.cut = True
            self._pipeline.resize((width, height), self._frame.camera)
        if self._small is not None and self._small[0].size != (width, height):
            release_all(*reversed(self._small))
            self._small = None
        if scale != 1.0 and self._small is None:
            texture = self._ctx.texture((width, height), 4)
            texture.repeat_x = texture.repeat_y = False
            self._small = texture, self._ctx.framebuffer([texture])

    def _draw_small(
        self, moment: Moment, target: moderngl.Framebuffer, small: tuple[moderngl.Texture, moderngl.Framebuffer]
    ) -> None:
        """Draw the picture smaller than `target` and stretch it; text is drawn later and stays sharp."""
        texture, framebuffer = small
        self._frame.resize(texture.size)
        self._frame.upload()
        self._pipeline.draw(moment, framebuffer)
        self._frame.resize(self._size)
        self._frame.upload()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._stretch.draw(target, small=texture)

    def release(self) -> None:
        """Free everything; the renderer must not be used afterwards."""
        release_all(self._frame, self._crowd, self._pipeline, self._guide, self._overlay, self.graph, self._stretch)
        if self._small is not None:
            release_all(*reversed(self._small))


def _nobody(part: str) -> None:
    """Default of `Renderer.mark`: do nothing."""


def _everything(scene: Scene, *, passes: bool) -> Float64:
    """Return a parameter row that draws the first group in all styles at once, with all `passes` if set."""
    row = picture_of(scene)
    if passes:
        for name in ("trails", "ink", "vignette", "bloom"):
            row[BY_ADDRESS[f"/dance/pass/{name}"].first] = 0.5
        row[BY_ADDRESS["/dance/pass/grade/contrast"].first] = 1.1
    for name in AMOUNTS:
        row[of_group(STYLE_OF_GROUP + name, 0).where] = 0.5
    return row


def _bare_quality(ctx: moderngl.Context) -> Quality:
    """Return the quality for pictures with alpha, whose edges need multisampling. ValueError if there is none."""
    if ctx.max_samples < 1:
        raise ValueError("this driver has no multisampling, which pictures with alpha need")
    return replace(CARD, samples=min(CARD.samples, int(ctx.max_samples)))


def _checked(size: tuple[int, int]) -> tuple[int, int]:
    return max(int(size[0]), 1), max(int(size[1]), 1)
