"""Render pipeline: floor map, dancers and stage, then picture passes and the film curve.

There are three variants:

- *plain*, in software without an active picture pass: deferred shading in 8 bits;
- *soft*, the same in half floats, if a picture pass is active or light is drawn over the scene;
- *lit*, on a graphics card: multisampled forward shading in half floats.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import moderngl
import numpy as np

from live.base.custom_pass import CustomShader
from live.base.set_geometry import SetItem
from live.base.stage_snapshot import FLOOR_MARGIN, Camera
from live.render.adaptive_quality import Quality
from live.render.camera import PicturePart, Size, screen_bounds, view_rays, world_to_clip
from live.render.pass_context import HDR, Moment, PassSetup, PicturePass, ScenePass, Surfaces
from live.render.pass_faults import PassFaults, pass_name
from live.render.passes.alpha_pass import AlphaPass
from live.render.passes.antialias_pass import AntialiasPass
from live.render.passes.background_pass import BackgroundPass, FrontPass
from live.render.passes.beam_pass import BeamPass
from live.render.passes.bloom_pass import BloomPass
from live.render.passes.blur_pass import BlurPass
from live.render.passes.colour_pass import FinalPass, GradePass, VignettePass
from live.render.passes.custom_pass import CustomPass
from live.render.passes.dancer_pass import DancerPass, GBufferPass, MultisampleTarget, light_variant
from live.render.passes.floor_pass import FloorPass, ReflectionPass
from live.render.passes.focus_pass import FocusPass
from live.render.passes.garment_pass import GarmentPass
from live.render.passes.ink_pass import InkPass
from live.render.passes.plan_pass import PlanPass
from live.render.passes.scenery_pass import SceneryPass
from live.render.passes.set_pass import ItemPass
from live.render.passes.stage_pass import BackdropPass, StagePass
from live.render.passes.styled_pass import StylePasses
from live.render.passes.title_pass import TitlePass
from live.render.passes.trail_pass import TrailsPass
from live.render.shader import Releasable, release_all
from live.render.worlds.constellation_pass import ConstellationPass
from live.render.worlds.paper_pass import PaperPass
from live.render.worlds.ripple_pass import RipplePass
from live.render.worlds.world_textures import WorldTextures

PICTURE_PASSES: Final[Mapping[str, Callable[[PassSetup], PicturePass]]] = {
    "focus": FocusPass,
    "blur": BlurPass,
    "trails": TrailsPass,
    "bloom": BloomPass,
    "ink": InkPass,
    "grade": GradePass,
    "vignette": VignettePass,
}
"""Classes for `[picture] passes`, by name; `shadow` and `mirror` belong to the scene."""
AT_END: Final = "vignette"
"""This pass, if it is the last one, is done together with the film curve."""


class PassChain:
    """The picture passes of a show, and the two textures between them."""

    def __init__(self, setup: PassSetup) -> None:
        self._ctx = setup.ctx
        order = setup.scene.passes
        self.vignette_at_end = order[-1:] == (AT_END,)
        own = {one.name: (one, slot) for slot, one in enumerate(setup.scene.custom_passes)}
        self._custom_passes: dict[str, CustomPass] = {}
        self._passes: list[tuple[str, PicturePass]] = [("paper", PaperPass(setup))]
        for name in order:
            if name in own:
                self._custom_passes[name] = CustomPass(setup, *own[name])
                self._passes.append((name, self._custom_passes[name]))
            elif name in PICTURE_PASSES and not (name == AT_END and self.vignette_at_end):
                self._passes.append((name, PICTURE_PASSES[name](setup)))
        self._names = {one: name for name, one in self._passes}
        self._final = FinalPass(setup.ctx)
        self._create_targets(setup.size)

    def _create_targets(self, size: Size) -> None:
        count = 2
        self._textures = [self._ctx.texture(size, 4, dtype=HDR) for _ in range(count)]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._targets = [self._ctx.framebuffer([texture]) for texture in self._textures]

    def set_custom_passes(self, passes: tuple[CustomShader, ...]) -> None:
        """Replace the source of custom passes; PersonError if one does not compile: its last version stays."""
        for one in passes:
            there = self._custom_passes.get(one.name)
            if there is not None and there.definition != one:
                there.replace_source(one)

    def active(self, moment: Moment, left_out: Sequence[str]) -> list[PicturePass]:
        """Return the passes that change something now, in order, without those in `left_out`."""
        return [one for name, one in self._passes if name not in left_out and one.active(moment)]

    def would_change(self, name: str, moment: Moment) -> bool:
        """Whether a pass would change something now, even if it is left out."""
        return any(one.active(moment) for known, one in self._passes if known == name)

    def follow(self, moment: Moment, left_out: Sequence[str]) -> None:
        """Let the passes take in a moment that is not drawn."""
        for one in self.active(moment, left_out):
            if isinstance(one, FocusPass):
                one.follow(moment)

    def draw(
        self,
        active: list[PicturePass],
        source: moderngl.Texture,
        target: moderngl.Framebuffer,
        surfaces: Surfaces | None,
        moment: Moment,
        faults: PassFaults,
    ) -> None:
        """Draw `source` (compressed light) through the `active` passes into `target`; `faults` records the current
        pass."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        last = active[-1] if active else None
        bloom = last if isinstance(last, BloomPass) else None
        turn = 0
        for one in active if bloom is None else active[:-1]:
            faults.begin(self._names[one])
            one.draw(source, self._targets[turn], surfaces, moment)
            source, turn = self._textures[turn], 1 - turn
        if bloom is None:
            faults.begin_essential()
            self._final.draw(source, target)
        else:
            faults.begin(self._names[bloom])
            gathered, strength = bloom.compute_glow(source), bloom.strength(moment)
            faults.begin_essential()
            self._final.draw(source, target, gathered, strength)

    def resize(self, size: Size) -> None:
        """Set a new size of what is drawn [pixels]."""
        release_all(*self._targets, *self._textures)
        self._create_targets(size)
        for _, one in self._passes:
            one.resize(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._textures, self._final, *(one for _, one in self._passes))


SCENE_PASSES: Final[tuple[Callable[[PassSetup], ScenePass], ...]] = (
    GarmentPass, ItemPass, SceneryPass, BackgroundPass, StylePasses, RipplePass, ConstellationPass, BeamPass, PlanPass,
    TitlePass, FrontPass,
)  # fmt: skip
"""Scene passes, in drawing order."""
_STAGE_PASSES: Final = (SceneryPass, BackgroundPass, RipplePass, PlanPass, FrontPass)
"""Scene passes of the stage around the dancers, which pictures with alpha lack."""
SHARPENING: Final = 0.6
"""Strength of sharpening for a scene that is drawn smaller than the picture and stretched."""
STUDIO_WALL_DISTANCE: Final = 7.0
"""Distance of the studio's wall from the stage [m]: no wall is farther away."""
_BODY_REACH: Final = 0.25
"""The generated body reaches at most this far beyond its joints [m]."""


class Pipeline:
    """All passes of one renderer with their targets; GL objects are created here and in `resize`."""

    def __init__(self, setup: PassSetup, part: PicturePart) -> None:
        """`part`: the part of the picture that is drawn, of the size of `setup`."""
        ctx, scene, size, quality = setup.ctx, setup.scene, setup.size, setup.quality
        self._ctx, self._scene, self._part, self._quality = ctx, scene, part, quality
        worn = bool(scene.characters)
        self._stage_size = scene.stage_size
        self.floor = FloorPass(ctx, quality, _floor_size(scene.stage_size))
        self._mirror = ReflectionPass(ctx, size, quality.mirror_divisor, characters=worn)
        self._backdrop = BackdropPass(ctx, size, coarse=quality.samples == 0)
        self._textures = WorldTextures(ctx)
        self.chain = PassChain(setup)
        self.faults = PassFaults()
        """Circuit breakers of the passes."""
        self._lit = quality.samples > 0
        self._surface = GBufferPass(ctx, quality, size, characters=worn)
        self._stages = {hdr: StagePass(ctx, hdr=hdr) for hdr in ((True,) if self._lit else (False, True))}
        if self._lit:
            self._targets = {quality.samples: MultisampleTarget(ctx, quality.samples, size)}
            self._target = self._targets[quality.samples]
            self._dancer = DancerPass(ctx, quality, characters=worn)
            self._matte = AlphaPass(ctx, size) if setup.transparent else None
        else:
            self._smooth = {hdr: AntialiasPass(ctx, self._surface.depth, size, hdr=hdr) for hdr in (False, True)}
        self._scene_passes = [make(setup) for make in SCENE_PASSES if not (setup.transparent and make in _STAGE_PASSES)]
        self._followers = [one for one in self._scene_passes if type(one).follow is not ScenePass.follow]
        self.titles = next(one for one in self._scene_passes if isinstance(one, TitlePass))
        """Titles, which may also lie over the finished picture."""
        self._beams = next(one for one in self._scene_passes if isinstance(one, BeamPass))
        self.floor.casters = [one.draw_shadows for one in self._scene_passes]
        self._open_air = False
        self._mirror.mirrored = [one.draw_mirrored for one in self._scene_passes]
        self.set_camera(scene.camera)

    def set_stage(self, stage_size: tuple[float, float], items: tuple[SetItem, ...]) -> None:
        """Draw a stage of another size, width by depth [m], and other props; then set the camera."""
        if stage_size != self._stage_size:
            self._stage_size = stage_size
            self.floor.set_floor_size(_floor_size(stage_size))
            self._backdrop.invalidate()
        for one in self._scene_passes:
            if isinstance(one, ItemPass):
                one.set_items(items)
            elif isinstance(one, BackgroundPass):
                one.stage_size = stage_size

    def set_quality(self, quality: Quality) -> None:
        """Draw with another quality of the same tier; its GL objects are created once and kept."""
        self._quality = self._surface.quality = quality
        self.floor.select_resolution(quality.floor_map)
        if self._lit:
            if quality.samples not in self._targets:
                self._targets[quality.samples] = MultisampleTarget(self._ctx, quality.samples, self._part.size)
            self._target = self._targets[quality.samples]
            self._dancer.quality = quality
        else:
            for smooth in self._smooth.values():
                smooth.sharpness = SHARPENING if quality.scale < 1.0 else 0.0

    @property
    def problems(self) -> list[str]:
        """Messages about failed files and passes; the last good state is drawn."""
        of_files = [words for one in self._scene_passes for words in one.problems]
        return of_files + self.faults.messages()

    def set_camera(self, camera: Camera) -> None:
        """Update everything that depends on the camera, except the uniform block."""
        self._floor_rows = _floor_row_count(camera, self._stage_size, self._part, open_air=self._open_air)
        self._world_to_clip = world_to_clip(camera, self._part)

    def has_effect(self, kind: str, moment: Moment) -> bool:
        """Whether leaving out a pass, or half of the particles and ribbons (`styles`), saves time now."""
        if kind == "mirror":
            return kind in self._scene.passes and moment.uniforms.mirrors
        if kind == "styles":
            return any(moment.batch.count(name) for name in ("particles", "ribbons", "trails", "xray"))
        return not kind or self.chain.would_change(kind, moment)

    def invalidate_backdrop(self) -> None:
        """Invalidate the backdrop, because light or camera have changed."""
        self._backdrop.invalidate()

    def draw(self, moment: Moment, target: moderngl.Framebuffer) -> None:
        """Draw the finished picture of a moment into `target`; errors of passes are recorded and raised."""
        try:
            self._draw(moment, target)
        except Exception as error:
            self.faults.record_failure(error)
            raise

    def begin_anew(self, titles: Sequence[tuple[str, str]]) -> None:
        """Forget what does not depend on `Moment.cut`; `titles` as for `TitlePass.begin_anew`."""
        self._backdrop.begin_anew()
        self.titles.begin_anew(titles)

    def follow(self, moment: Moment) -> None:
        """Let the passes take in a moment that is not drawn."""
        for one in self._followers:
            if one.active(moment):
                one.follow(moment)
        self.titles.prepare_titles(moment.view)
        self.chain.follow(moment, self._quality.left_out)
        self._backdrop.follow(moving=moment.uniforms.light_changed)

    def _draw(self, moment: Moment, target: moderngl.Framebuffer) -> None:
        frame, crowd, faults = moment.uniforms, moment.batch, self.faults
        here = [one for one in self._scene_passes if faults.begin(pass_name(one)) and one.active(moment)]
        faults.begin_essential()
        self._beams.within = self._adds_beams(here, moment)
        active = self.chain.active(moment, (*self._quality.left_out, *faults.disabled))
        crowd.skin()
        self._textures.bind()
        if frame.open_air != self._open_air:
            self._open_air = frame.open_air
            self.set_camera(frame.camera)
        self._backdrop.draw(frame.worlds, moving=frame.light_changed)
        boxes = [one.box for one in self._scene_passes if one.box is not None]
        shadows = self._has("shadow") and frame.shadows
        self.floor.draw(crowd, moment.view, frame.light, boxes, shadows=shadows, beams=frame.beams_lit)
        where = moment.rectangle = self._dancer_rectangle(moment)
        seen = faults.begin("mirror") and self._has("mirror") and frame.mirrors
        self._mirror.draw(crowd, visible=seen, rows=self._floor_rows)
        for one in faults.iterate(here):
            one.prepare(moment)
        if self._lit:
            self._draw_lit(moment, here)
            surfaces = self._draw_surfaces(moment, here) if _needs_surfaces(active) else None
            matte = self._matte
            if matte is None:
                self.chain.draw(active, self._target.resolve(), target, surfaces, moment, faults)
            else:
                light = matte.straighten(self._target.resolve())
                self.chain.draw(active, light, matte.target, surfaces, moment, faults)
                matte.draw(target, moment.view.brightness)
            return
        overs = [one for one in here if one.light_active(moment)]
        hdr = bool(active or overs)
        surfaces = self._draw_surfaces(moment, here, named=_needs_surfaces(active))
        smooth = self._smooth[hdr]
        into = smooth.target
        into.use()
        into.scissor = where
        self._surface.shade(moment.floor, light_variant(frame), hdr=hdr, beams=self._beams.within)
        self._draw_stage(into, moment, hdr=hdr)
        for one in faults.iterate(overs):
            one.draw_light(moment)
        if hdr:
            self.chain.draw(active, smooth.smooth(where), target, surfaces, moment, faults)
        else:
            smooth.draw(target, where)

    def _has(self, name: str) -> bool:
        return name in self._scene.passes and name not in self._quality.left_out

    def _adds_beams(self, here: list[ScenePass], moment: Moment) -> bool:
        """Whether the stage can add the beams' light itself: nothing that must lie behind it comes after it."""
        beams = self._beams
        if beams not in here or (self._lit and self._matte is not None):
            return False
        before = here[: here.index(beams)]
        return not any(
            (one.light_active(moment) and not one.only_adds) or (self._lit and one.box is not None) for one in before
        )

    def _draw_lit(self, moment: Moment, here: list[ScenePass]) -> None:
        into = self._target.begin()
        self._dancer.draw(moment.batch, moment.floor, light_variant(moment.uniforms))
        for one in self.faults.iterate(here):
            one.draw_lit(moment)
        overs = [one for one in here if one.light_active(moment)]
        if self._matte is None:
            self._draw_stage(into, moment, hdr=True)
        else:
            self._matte.store_coverage(into)
            into.color_mask = (True, True, True, False)  # light covers nothing
        for one in self.faults.iterate(overs):
            one.draw_light(moment)
        into.color_mask = (True, True, True, True)

    def _draw_surfaces(self, moment: Moment, here: list[ScenePass], *, named: bool = True) -> Surfaces:
        self._surface.draw(moment.batch, with_ids=named)
        for one in self.faults.iterate(here):
            one.draw_surfaces(moment)
        return self._surface.surfaces

    def _draw_stage(self, into: moderngl.Framebuffer, moment: Moment, *, hdr: bool) -> None:
        frame = moment.uniforms
        self._stages[hdr].draw(
            into, self._floor_rows, self._backdrop.texture, moment.floor, self._mirror.texture,
            lamps=frame.spots_lit, beams=self._beams.within, resized=frame.stage_resized,
            patterned=frame.floor_patterned, water=frame.worlds["water"] > 0.0,
        )  # fmt: skip

    def _dancer_rectangle(self, moment: Moment) -> tuple[int, int, int, int]:
        """Return the rectangle that dancers and items may cover; other pixels need no lighting or smoothing."""
        low, high = moment.batch.box.astype(np.float64)
        for one in self._scene_passes:
            if one.box is not None:
                low, high = np.minimum(low, one.box[0]), np.maximum(high, one.box[1])
        if low[0] > high[0]:
            return 0, 0, 0, 0
        reach = max(_BODY_REACH, moment.batch.reach)
        return screen_bounds(self._world_to_clip, self._part.size, low - reach, high + reach)

    def resize(self, part: PicturePart, camera: Camera) -> None:
        """Draw another part of the picture, or one of another size, seen from this camera."""
        self._part, size = part, part.size
        self._mirror.resize(size)
        self._backdrop.resize(size)
        self._surface.resize(size)
        self.chain.resize(size)
        if self._lit:
            for lit in self._targets.values():
                lit.resize(size)
            if self._matte is not None:
                self._matte.resize(size)
        else:
            for smooth in self._smooth.values():
                smooth.resize(self._surface.depth, size)
        for one in self._scene_passes:
            one.resize(size)
        self.set_camera(camera)

    def release(self) -> None:
        """Free everything."""
        own: list[Releasable] = [
            self._textures,
            self.floor,
            self._mirror,
            self._backdrop,
            self.chain,
            *self._stages.values(),
        ]
        if self._lit and self._matte is not None:
            own.append(self._matte)
        own += [*self._targets.values(), self._dancer] if self._lit else [*self._smooth.values()]
        release_all(*self._scene_passes, *own, self._surface)


def _floor_size(stage_size: tuple[float, float]) -> tuple[float, float]:
    """Return width and depth [m] of the floor's map."""
    return stage_size[0] + 2 * FLOOR_MARGIN, stage_size[1] + 2 * FLOOR_MARGIN


def _needs_surfaces(active: list[PicturePass]) -> bool:
    return any(one.needs_surfaces for one in active)


def _floor_row_count(
    camera: Camera, stage_size: tuple[float, float], part: PicturePart, *, open_air: bool = False
) -> int:
    """Return how many pixel rows from below can show the floor; the rows above show only the back wall, or the sky."""
    (corner, right, up), size = view_rays(camera, part), part.size
    if abs(right[1]) > 1e-9:
        return size[1]  # the picture is tilted: the floor may be anywhere
    rows = (np.arange(size[1])[:, None] + 1.0) / size[1]
    wall = -np.inf if open_air else -0.5 * stage_size[1] - STUDIO_WALL_DISTANCE
    seen = 0
    for side in (0.0, 0.5, 1.0):
        ways = corner + side * right + rows * up
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = -camera.eye[1] / ways[:, 1]
            floor = (ways[:, 1] < 0.0) & (camera.eye[2] + reach * ways[:, 2] > wall)
        if floor.any():
            seen = max(seen, int(np.flatnonzero(floor)[-1]) + 1)
    return min(seen + 1, size[1])
