"""Renderer that draws a `StageView` into a framebuffer."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import moderngl

from live.base.arrays import Float64
from live.base.custom_pass import CustomShader
from live.base.element_kinds import PATH
from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import (
    BY_ADDRESS,
    STYLE_ADDRESS_PREFIX,
    STYLE_NAMES,
    WORLD_PREFIX,
    group_parameter,
    picture_row,
)
from live.base.set_geometry import SetItem
from live.base.stage_snapshot import Camera, Scene, StageView, Title
from live.base.system.process_control import return_free_memory
from live.render.adaptive_quality import HARDWARE, Quality, QualityStep, choose_quality, quality_steps
from live.render.camera import PicturePart, Size
from live.render.dancers.dancer_batch import DancerBatch
from live.render.pass_context import Moment, PassSetup
from live.render.passes.caption_pass import CaptionPass
from live.render.passes.overlay_pass import FrameTimeGraphPass, GuidePass, OverlayPass
from live.render.pipeline import Pipeline
from live.render.shader import FullscreenShader, release_all
from live.render.uniforms import FrameUniforms

_WARM_UP_ITEMS: Final = (SetItem("box", (0.0, 0.0), (1.0, 1.0, 1.0)),)
"""Props that are drawn before the show if it has none, since an edit may add some."""
JUMP_BEATS: Final = 64.0
"""After a jump of more beats than this a picture does not continue the previous one."""


class Renderer:
    """Draws moments of one scene at one size, or a part of them; GL objects are created here and in `resize`, none
    while drawing.

    `quality` overrides the choice by the driver. `blocking_video`: wait for pictures of videos, as in an offline film.
    Targets need no depth and no samples.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        *,
        size: Size | PicturePart,
        quality: Quality | None = None,
        steps: bool = False,
        blocking_video: bool = False,
        transparent: bool = False,
        warm_up: bool = True,
    ) -> None:
        """`size`: of the picture [pixels], or the part of it to draw. `steps`: also create what the lower quality steps
        need; see `set_step`. `transparent`: without a stage, in pictures with alpha (needs samples). `warm_up`: draw
        with everything once, so that no later picture has to wait for the driver; a film may wait."""
        self._ctx, self._scene, self._part = ctx, scene, _clamped(size)
        self.quality = quality or (
            _transparent_quality(ctx) if transparent else choose_quality(ctx, scene.dancer_count)
        )
        self._clear_alpha = 0.0 if transparent else 1.0
        self.steps = quality_steps(self.quality) if steps else (QualityStep("all", self.quality),)
        """The quality steps, the best one first."""
        self.step = 0
        """The current quality step."""
        self.mark: Callable[[str], None] = _ignore_mark
        """Callback after each part of a frame, for time measurement: "upload", "draw"."""
        self._drawn_size = self.size
        self._uniforms = FrameUniforms(ctx, scene, self._part)
        self._batch = DancerBatch(ctx, scene, self.quality, self._part)
        self._batch.set_styles(self._uniforms.row)
        self._setup = PassSetup(ctx, scene, self.quality, self.size, blocking_video, transparent)
        self._pipeline = Pipeline(self._setup, self._part)
        self._uniforms.vignette_at_end = self._pipeline.chain.vignette_at_end
        self._caption = CaptionPass(ctx, self._whole)
        self._guide = GuidePass(ctx)
        self._overlay = OverlayPass(ctx)
        self.graph = FrameTimeGraphPass(ctx)
        """The overlay's graph of frame times."""
        self._stretch = FullscreenShader(ctx, "stretch_fragment.glsl")
        self._scaled_target: tuple[moderngl.Texture, moderngl.Framebuffer] | None = None
        self._last_beat = 0.0  # of the last picture
        self._moment = Moment(StageView.allocate(0, 1), self._uniforms, self._batch, self._pipeline.floor.texture)
        if warm_up:
            self._warm_up()
        self._pipeline.set_stage(scene.stage_size, scene.items)
        self._moment.cut = True

    def _set_camera(self, camera: Camera) -> None:
        """Update everything that depends on the camera, except the uniform block."""
        self._pipeline.set_camera(camera)
        self._batch.set_camera(camera, self._part)

    def _warm_up(self) -> None:
        """Draw with every step and style once, because drivers compile a program when it first draws."""
        scratch = self._ctx.texture(self.size, 4)
        framebuffer = self._ctx.framebuffer([scratch])
        view = StageView.allocate(max(self._scene.dancer_count, 1), self._scene.joint_count)
        view.element_count, view.obstacle_count = 3, 1  # a point, a disc, and a line with something running along it
        view.element_radius[1], view.obstacle[0, 2] = 1.0, 1.0
        view.element_kind[2], view.element_corners[2] = PATH, 2
        view.guide_count, view.caption = 1, (("Warm up", 0.5),)
        view.titles = Title("Aa"), Title("Aa", "stage", (0.0, 2.0, 0.0))
        self._pipeline.set_stage(self._scene.stage_size, self._scene.items or _WARM_UP_ITEMS)
        for step in (*reversed(range(len(self.steps))), 0) if len(self.steps) > 1 else (0,):
            self.set_step(step)
            live = len(self.steps) > 1
            everything = (_warm_up_row(self._scene, passes=live), *(_lamp_rows(self._scene) if live else ()))
            rows = (*everything, None) if step == 0 else (None,)
            for view.picture in rows:
                self.draw(view, framebuffer)
        release_all(framebuffer, scratch)
        return_free_memory()  # compilers leave much behind

    @property
    def _texts(self) -> tuple[CaptionPass, GuidePass, OverlayPass, FrameTimeGraphPass]:
        """What is drawn over the finished picture."""
        return self._caption, self._guide, self._overlay, self.graph

    @property
    def size(self) -> Size:
        """Width and height of what is drawn [pixels]."""
        return self._part.size

    @property
    def part(self) -> PicturePart:
        """The part of the picture that is drawn."""
        return self._part

    @property
    def _whole(self) -> Size:
        """Width and height of the whole picture [pixels]."""
        return round(self._part.whole[0]), round(self._part.whole[1])

    @property
    def scene(self) -> Scene:
        """What it draws moments of, with the custom passes as they are now."""
        return self._scene

    def draw(self, view: StageView, target: moderngl.Framebuffer) -> None:
        """Draw one moment into `target` (the screen's framebuffer, or another one of this size)."""
        frame, moment = self._begin(view)
        if frame.level <= 0.0:
            target.use()
            target.clear(0.0, 0.0, 0.0, self._clear_alpha)
        else:
            self._batch.update(view, frame.light)
            self.mark("upload")
            if self._scaled_target is None:
                self._pipeline.draw(moment, target)
            else:
                self._draw_scaled(moment, target, self._scaled_target)
            self._draw_caption(view, target)
        moment.cut = frame.level <= 0.0
        self.annotate(view, target)
        self._pipeline.faults.record_success()

    def follow(self, view: StageView) -> None:
        """Take in a moment that is not drawn, for what later pictures remember of it (`film/picture_memory.py`)."""
        frame, moment = self._begin(view)
        if frame.level > 0.0:
            self._batch.reserve(view)
            self._pipeline.follow(moment)
        moment.cut = frame.level <= 0.0

    def begin_anew(self, titles: Sequence[tuple[str, str]] = ()) -> None:
        """Forget all pictures so far, before those of another part of the show; `titles`: texts that have been shown
        before it, with the names of their fonts."""
        self._uniforms.begin_anew()
        self._set_camera(self._uniforms.camera)
        self._batch.set_colours(self._uniforms.group_colours)
        self._batch.set_styles(self._uniforms.row)
        self._pipeline.begin_anew(titles)
        self._moment.cut = True

    def _begin(self, view: StageView) -> tuple[FrameUniforms, Moment]:
        """Write the values of a moment, and tell all that depends on them."""
        frame, moment = self._uniforms, self._moment
        frame.write(view)
        if frame.camera_changed:
            self._set_camera(frame.camera)
        if frame.light_changed:
            self._pipeline.invalidate_backdrop()
        if frame.colours_changed:
            self._batch.set_colours(frame.group_colours)
        if frame.styles_changed:
            self._batch.set_styles(frame.row)
        passed = 0.0 if moment.cut else view.beat - self._last_beat
        moment.view, moment.cut = view, moment.cut or not 0.0 <= passed <= JUMP_BEATS
        moment.beats, self._last_beat = 0.0 if moment.cut else passed, view.beat
        return frame, moment

    def _draw_caption(self, view: StageView, target: moderngl.Framebuffer) -> None:
        """Draw titles and the audience's caption, which belong to the picture."""
        faults = self._pipeline.faults
        try:
            if faults.begin("title"):
                self._pipeline.titles.draw_over(view, target, self._whole)
            if faults.begin("caption"):
                self._caption.draw(view, target)
        except Exception as error:
            faults.record_failure(error)
            raise

    def annotate(self, view: StageView, target: moderngl.Framebuffer) -> None:
        """Draw what only the operator sees over a finished picture: guides and overlay, if shown."""
        faults = self._pipeline.faults
        try:
            if view.overlay and faults.begin("graph"):
                self.graph.draw(target, self._whole)
            if faults.begin("guide"):
                self._guide.draw(view, target, self._whole)
            if faults.begin("overlay"):
                self._overlay.draw(view.overlay, target, self._whole)
        except Exception as error:
            faults.record_failure(error)
            raise

    def resize(self, size: Size | PicturePart) -> None:
        """Set a new size of the picture [pixels], or another part of it; (0, 0) of a minimised window becomes 1 x 1."""
        part = _clamped(size)
        if part == self._part:
            return
        letters, self._part, self._moment.cut = self._whole, part, True
        self._uniforms.resize(part)
        if letters != self._whole:
            self._caption.resize(self._whole)
        self._resize_targets(anew=True)
        self._batch.set_camera(self._uniforms.camera, part)

    @property
    def problems(self) -> list[str]:
        """Messages about failed files and passes; the last good state is drawn."""
        return self._pipeline.problems

    def reset_pass(self, name: str) -> None:
        """Enable a pass again that was left out after failures; empty: all."""
        self._pipeline.faults.reset(name)

    def set_stage(self, stage_size: tuple[float, float], items: tuple[SetItem, ...]) -> None:
        """Draw a stage of another size, width by depth [m], and other props; nothing is compiled."""
        if (stage_size, items) == (self._scene.stage_size, self._scene.items):
            return
        self._scene = replace(self._scene, stage_size=stage_size, items=items)
        self._setup = replace(self._setup, scene=self._scene)
        self._uniforms.set_stage_size(stage_size)
        self._pipeline.set_stage(stage_size, items)
        self._pipeline.set_camera(self._uniforms.camera)
        self._moment.floor = self._pipeline.floor.texture

    def set_custom_passes(self, passes: tuple[CustomShader, ...]) -> None:
        """Replace the source of custom passes; PersonError if one does not compile: its last version stays."""
        self._pipeline.chain.set_custom_passes(passes)
        fresh = {one.name: one for one in passes}
        known = tuple(fresh.get(one.name, one) for one in self._scene.custom_passes)
        self._scene = replace(self._scene, custom_passes=known)
        self._setup = replace(self._setup, scene=self._scene)

    def reload_shaders(self) -> None:
        """Rebuild all programs from the current shader files; PersonError if one does not compile: the old ones stay
        (new ones compiled before the error are freed with the context).

        For developers of looks: this takes seconds, in which nothing is drawn, and passes lose their history.
        """
        ctx = self._ctx
        made = Pipeline(replace(self._setup, size=self._drawn_size), self._part.scaled(self._drawn_size))
        others = (
            CaptionPass(ctx, self._whole),
            GuidePass(ctx),
            OverlayPass(ctx),
            FrameTimeGraphPass(ctx),
            FullscreenShader(ctx, "stretch_fragment.glsl"),
        )
        release_all(self._pipeline, *self._texts, self._stretch)
        self._pipeline, (self._caption, self._guide, self._overlay, self.graph, self._stretch) = made, others
        made.set_quality(self.quality)
        made.set_camera(self._uniforms.camera)
        made.invalidate_backdrop()
        self._moment.floor, self._moment.cut = made.floor.texture, True

    def set_step(self, step: int) -> None:
        """Draw with another quality step; one with another size resizes the pipeline."""
        if step == self.step and self.quality is self.steps[step].quality:
            return
        self.step, self.quality = step, self.steps[step].quality
        self._batch.set_quality(self.quality)
        self._pipeline.set_quality(self.quality)
        self._moment.floor = self._pipeline.floor.texture
        self._resize_targets()

    def has_effect(self, step: int) -> bool:
        """Whether that quality step would reduce the current picture."""
        return self._pipeline.has_effect(self.steps[step].kind, self._moment)

    def _resize_targets(self, *, anew: bool = False) -> None:
        """Resize the scene's targets to the size and scale of the current quality; `anew`: the part is another one."""
        scale = self.quality.scale
        width, height = _clamped_size((round(self.size[0] * scale), round(self.size[1] * scale)))
        if anew or (width, height) != self._drawn_size:
            self._drawn_size = width, height
            self._moment.cut = True
            self._pipeline.resize(self._part.scaled((width, height)), self._uniforms.camera)
        if self._scaled_target is not None and self._scaled_target[0].size != (width, height):
            release_all(*reversed(self._scaled_target))
            self._scaled_target = None
        if scale != 1.0 and self._scaled_target is None:
            texture = self._ctx.texture((width, height), 4)
            texture.repeat_x = texture.repeat_y = False
            self._scaled_target = texture, self._ctx.framebuffer([texture])

    def _draw_scaled(
        self, moment: Moment, target: moderngl.Framebuffer, small: tuple[moderngl.Texture, moderngl.Framebuffer]
    ) -> None:
        """Draw the picture smaller than `target` and stretch it; text is drawn later and stays sharp."""
        texture, framebuffer = small
        self._uniforms.resize(self._part.scaled(texture.size))
        self._uniforms.upload()
        self._pipeline.draw(moment, framebuffer)
        self._uniforms.resize(self._part)
        self._uniforms.upload()
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._stretch.draw(target, small=texture)

    def release(self) -> None:
        """Free everything; the renderer must not be used afterwards."""
        release_all(self._uniforms, self._batch, self._pipeline, *self._texts, self._stretch)
        if self._scaled_target is not None:
            release_all(*reversed(self._scaled_target))


def _ignore_mark(part: str) -> None:
    """Default of `Renderer.mark`: do nothing."""


def _warm_up_row(scene: Scene, *, passes: bool) -> Float64:
    """Return a parameter row that draws the first group in all styles at once, with all `passes` if set."""
    row = picture_row(scene)
    if passes:
        for name in ("trails", "ink", "vignette", "bloom", "focus", "blur"):
            row[BY_ADDRESS[f"/dance/pass/{name}"].first] = 0.5
        row[BY_ADDRESS["/dance/pass/grade/contrast"].first] = 1.1
    for kind, files in (("background", scene.backgrounds), ("scenery", scene.scenery)):
        for number in range(1, len(files) + 1):
            row[BY_ADDRESS[f"/dance/{kind}/{number}"].first] = 0.5
    for name in STYLE_NAMES:
        row[group_parameter(STYLE_ADDRESS_PREFIX + name, 0).row_slice] = 0.5
    return row


def _lamp_rows(scene: Scene) -> tuple[Float64, ...]:
    """Return parameter rows with what a show lights without being told: a follow spot, sides and beams; then with all
    worlds, too."""
    lit = picture_row(scene)
    for address in ("/dance/spot/4", "/dance/light/beams", "/dance/light/side"):
        lit[BY_ADDRESS[address].first] = 0.5
    worlds = lit.copy()
    for name in WORLD_NAMES:
        worlds[BY_ADDRESS[WORLD_PREFIX + name].first] = 0.5
    return lit, worlds


def _transparent_quality(ctx: moderngl.Context) -> Quality:
    """Return the quality for pictures with alpha, whose edges need multisampling. ValueError if there is none."""
    if ctx.max_samples < 1:
        raise ValueError("this driver has no multisampling, which pictures with alpha need")
    return replace(HARDWARE, samples=min(HARDWARE.samples, int(ctx.max_samples)))


def _clamped(size: Size | PicturePart) -> PicturePart:
    return size if isinstance(size, PicturePart) else PicturePart.of(_clamped_size(size))


def _clamped_size(size: Size) -> Size:
    return max(int(size[0]), 1), max(int(size[1]), 1)
