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

from live.base.custom_pass import OwnPass
from live.base.stage_snapshot import FLOOR_MARGIN, Camera
from live.render.adaptive_quality import Quality
from live.render.camera import covered, rays, world_to_clip
from live.render.gl_release import Releasable, release_all
from live.render.pass_context import HDR, Making, Moment, PicturePass, ScenePass, Surfaces
from live.render.pass_faults import PassFaults, name_of
from live.render.passes.alpha_pass import MattePass
from live.render.passes.antialias_pass import SmoothPass
from live.render.passes.background_pass import BackgroundPass
from live.render.passes.beam_pass import BeamPass
from live.render.passes.bloom_pass import BloomPass
from live.render.passes.colour_pass import FinalPass, GradePass, VignettePass
from live.render.passes.custom_pass import OwnPicturePass
from live.render.passes.dancer_pass import DancerPass, LitTarget, SurfacePass
from live.render.passes.floor_pass import FloorPass, MirrorPass
from live.render.passes.ink_pass import InkPass
from live.render.passes.plan_pass import PlanPass
from live.render.passes.set_pass import ItemPass, vertices_of
from live.render.passes.stage_pass import BackdropPass, StagePass
from live.render.passes.styled_pass import StylePasses
from live.render.passes.trail_pass import TrailsPass
from live.render.uniforms import WALL_BEHIND

PICTURE_PASSES: Final[Mapping[str, Callable[[Making], PicturePass]]] = {
    "trails": TrailsPass,
    "bloom": BloomPass,
    "ink": InkPass,
    "grade": GradePass,
    "vignette": VignettePass,
}
"""Classes for `[picture] passes`, by name; `shadow` and `mirror` belong to the scene."""
AT_END: Final = "vignette"
"""This pass, if it is the last one, is done together with the film curve."""


class Chain:
    """The picture passes of a show, and the two textures between them."""

    def __init__(self, making: Making) -> None:
        self._ctx = making.ctx
        order = making.scene.passes
        self.vignette_at_end = order[-1:] == (AT_END,)
        own = {one.name: (one, slot) for slot, one in enumerate(making.scene.own)}
        self._own: dict[str, OwnPicturePass] = {}
        self._passes: list[tuple[str, PicturePass]] = []
        for name in order:
            if name in own:
                self._own[name] = OwnPicturePass(making, *own[name])
                self._passes.append((name, self._own[name]))
            elif name in PICTURE_PASSES and not (name == AT_END and self.vignette_at_end):
                self._passes.append((name, PICTURE_PASSES[name](making)))
        self._names = {one: name for name, one in self._passes}
        self._final = FinalPass(making.ctx)
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        count = 2 if self._passes else 0
        self._textures = [self._ctx.texture(size, 4, dtype=HDR) for _ in range(count)]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._targets = [self._ctx.framebuffer([texture]) for texture in self._textures]

    def take_own(self, passes: tuple[OwnPass, ...]) -> None:
        """Replace the source of custom passes; PersonError if one does not compile: its last version stays."""
        for one in passes:
            there = self._own.get(one.name)
            if there is not None and there.own != one:
                there.take(one)

    def active(self, moment: Moment, left_out: Sequence[str]) -> list[PicturePass]:
        """Return the passes that change something now, in order, without those in `left_out`."""
        return [one for name, one in self._passes if name not in left_out and one.active(moment)]

    def has(self, name: str, moment: Moment) -> bool:
        """Whether a pass would change something now, even if it is left out."""
        return any(one.active(moment) for known, one in self._passes if known == name)

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
            faults.may(self._names[one])
            one.draw(source, self._targets[turn], surfaces, moment)
            source, turn = self._textures[turn], 1 - turn
        if bloom is None:
            faults.essential()
            self._final.draw(source, target)
        else:
            faults.may(self._names[bloom])
            gathered, strength = bloom.gather(source), bloom.strength(moment)
            faults.essential()
            self._final.draw(source, target, gathered, strength)

    def resize(self, size: tuple[int, int]) -> None:
        """Set a new size of the picture [pixels]."""
        release_all(*self._targets, *self._textures)
        self._make(size)
        for _, one in self._passes:
            one.resize(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._textures, self._final, *(one for _, one in self._passes))


SCENE_PASSES: Final[tuple[Callable[[Making], ScenePass], ...]] = (
    ItemPass, BackgroundPass, StylePasses, BeamPass, PlanPass,
)  # fmt: skip
"""Scene passes, in drawing order."""
_OF_STAGE: Final = (BackgroundPass, PlanPass)
"""Scene passes behind or under the dancers, which pictures with alpha lack."""
CRISP: Final = 0.6
"""Strength of sharpening for a scene that is drawn smaller than the picture and stretched."""
_BODY_AROUND_JOINTS: Final = 0.25
"""The generated body reaches at most this far beyond its joints [m]."""


class Pipeline:
    """All passes of one renderer with their targets; GL objects are created here and in `resize`."""

    def __init__(self, making: Making) -> None:
        ctx, scene, size, quality = making.ctx, making.scene, making.size, making.quality
        self._ctx, self._scene, self._size, self._quality = ctx, scene, size, quality
        worn = bool(scene.characters)
        width, depth = scene.stage_size
        self.floor = FloorPass(ctx, quality, (width + 2 * FLOOR_MARGIN, depth + 2 * FLOOR_MARGIN))
        self._mirror = MirrorPass(ctx, size, quality.mirror_divisor, worn=worn)
        self._backdrop = BackdropPass(ctx, size, coarse=quality.samples == 0)
        self.chain = Chain(making)
        self.faults = PassFaults()
        """Circuit breakers of the passes."""
        self._lit = quality.samples > 0
        self._surface = SurfacePass(ctx, quality, size, worn=worn)
        self._stages = {hdr: StagePass(ctx, hdr=hdr) for hdr in ((True,) if self._lit else (False, True))}
        if self._lit:
            self._targets = {quality.samples: LitTarget(ctx, quality.samples, size)}
            self._target = self._targets[quality.samples]
            self._dancer = DancerPass(ctx, quality, worn=worn)
            self._matte = MattePass(ctx, size) if making.bare else None
        else:
            self._smooth = {hdr: SmoothPass(ctx, self._surface.depth, size, hdr=hdr) for hdr in (False, True)}
        self._scene_passes = [make(making) for make in SCENE_PASSES if not (making.bare and make in _OF_STAGE)]
        if scene.items:
            self.floor.casters = [one.cast for one in self._scene_passes]
        items = vertices_of(scene.items)[:, :3]
        self._standing = np.array([items.min(axis=0), items.max(axis=0)], np.float64) if len(items) else None
        self.look_from(scene.camera)

    def take(self, quality: Quality) -> None:
        """Draw with another quality of the same tier; its GL objects are created once and kept."""
        self._quality = self._surface.quality = quality
        self.floor.choose(quality.floor_map)
        if self._lit:
            if quality.samples not in self._targets:
                self._targets[quality.samples] = LitTarget(self._ctx, quality.samples, self._size)
            self._target = self._targets[quality.samples]
            self._dancer.quality = quality
        else:
            for smooth in self._smooth.values():
                smooth.crisp = CRISP if quality.scale < 1.0 else 0.0

    @property
    def problems(self) -> list[str]:
        """Messages about failed files and passes; the last good state is drawn."""
        of_files = [words for one in self._scene_passes if isinstance(one, BackgroundPass) for words in one.problems]
        return of_files + self.faults.words()

    def look_from(self, camera: Camera) -> None:
        """Update everything that depends on the camera, except the uniform block."""
        self._floor_rows = _rows_of_floor(camera, self._scene.stage_size, self._size)
        self._world_to_clip = world_to_clip(camera, self._size)

    def helps(self, kind: str, moment: Moment) -> bool:
        """Whether leaving out a pass, or half of the particles and ribbons (`styles`), saves time now."""
        if kind == "mirror":
            return kind in self._scene.passes and moment.frame.mirrors
        if kind == "styles":
            return any(moment.crowd.count(name) for name in ("particles", "ribbons", "trails", "xray"))
        return not kind or self.chain.has(kind, moment)

    def relit(self) -> None:
        """Invalidate the backdrop, because light or camera have changed."""
        self._backdrop.forget()

    def draw(self, moment: Moment, target: moderngl.Framebuffer) -> None:
        """Draw the finished picture of a moment into `target`; errors of passes are recorded and raised."""
        try:
            self._draw(moment, target)
        except Exception as error:
            self.faults.failed(error)
            raise

    def _draw(self, moment: Moment, target: moderngl.Framebuffer) -> None:
        frame, crowd, faults = moment.frame, moment.crowd, self.faults
        here = [one for one in self._scene_passes if faults.may(name_of(one)) and one.active(moment)]
        faults.essential()
        active = self.chain.active(moment, (*self._quality.left_out, *faults.out))
        self._backdrop.draw(moving=frame.relit)
        self.floor.draw(crowd, moment.view, shadows=self._has("shadow") and frame.shadows)
        seen = faults.may("mirror") and self._has("mirror") and frame.mirrors
        self._mirror.draw(crowd, seen=seen, rows=self._floor_rows)
        for one in faults.each(here):
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
        where = self._where_dancers_are(moment)
        overs = [one for one in here if one.over_active(moment)]
        hdr = bool(active or overs)
        surfaces = self._draw_surfaces(moment, here, named=_needs_surfaces(active))
        smooth = self._smooth[hdr]
        into = smooth.target
        into.use()
        into.scissor = where
        self._surface.shade(moment.floor, hdr=hdr, beside=moment.frame.beside)
        self._draw_stage(into, moment, hdr=hdr)
        for one in faults.each(overs):
            one.over(moment)
        if hdr:
            self.chain.draw(active, smooth.soften(where), target, surfaces, moment, faults)
        else:
            smooth.draw(target, where)

    def _has(self, name: str) -> bool:
        return name in self._scene.passes and name not in self._quality.left_out

    def _draw_lit(self, moment: Moment, here: list[ScenePass]) -> None:
        into = self._target.begin()
        self._dancer.draw(moment.crowd, moment.floor)
        for one in self.faults.each(here):
            one.lit(moment)
        overs = [one for one in here if one.over_active(moment)]
        if self._matte is None:
            self._draw_stage(into, moment, hdr=True)
        else:
            self._matte.keep(into)
            into.color_mask = (True, True, True, False)  # light covers nothing
        for one in self.faults.each(overs):
            one.over(moment)
        into.color_mask = (True, True, True, True)

    def _draw_surfaces(self, moment: Moment, here: list[ScenePass], *, named: bool = True) -> Surfaces:
        self._surface.draw(moment.crowd, named=named)
        for one in self.faults.each(here):
            one.surfaces(moment)
        return self._surface.surfaces

    def _draw_stage(self, into: moderngl.Framebuffer, moment: Moment, *, hdr: bool) -> None:
        frame = moment.frame
        self._stages[hdr].draw(
            into, self._floor_rows, self._backdrop.texture, moment.floor, self._mirror.texture,
            pools=frame.pools, resized=frame.resized,
        )  # fmt: skip

    def _where_dancers_are(self, moment: Moment) -> tuple[int, int, int, int]:
        """Return the rectangle that dancers and items may cover; other pixels need no lighting or smoothing."""
        low, high = moment.crowd.box.astype(np.float64)
        if self._standing is not None:
            low, high = np.minimum(low, self._standing[0]), np.maximum(high, self._standing[1])
        if low[0] > high[0]:
            return 0, 0, 0, 0
        reach = max(_BODY_AROUND_JOINTS, moment.crowd.reach)
        return covered(self._world_to_clip, self._size, low - reach, high + reach)

    def resize(self, size: tuple[int, int], camera: Camera) -> None:
        """Set a new size of the picture [pixels], seen from this camera."""
        self._size = size
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
        self.look_from(camera)

    def release(self) -> None:
        """Free everything."""
        own: list[Releasable] = [self.floor, self._mirror, self._backdrop, self.chain, *self._stages.values()]
        if self._lit and self._matte is not None:
            own.append(self._matte)
        own += [*self._targets.values(), self._dancer] if self._lit else [*self._smooth.values()]
        release_all(*self._scene_passes, *own, self._surface)


def _needs_surfaces(active: list[PicturePass]) -> bool:
    return any(one.needs_surfaces for one in active)


def _rows_of_floor(camera: Camera, stage_size: tuple[float, float], size: tuple[int, int]) -> int:
    """Return how many pixel rows from below can show the floor; the rows above show only the back wall."""
    corner, right, up = rays(camera, size)
    if abs(right[1]) > 1e-9:
        return size[1]  # the picture is tilted: the floor may be anywhere
    rows = (np.arange(size[1])[:, None] + 1.0) / size[1]
    wall = -0.5 * stage_size[1] - WALL_BEHIND
    seen = 0
    for side in (0.0, 0.5, 1.0):
        ways = corner + side * right + rows * up
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = -camera.eye[1] / ways[:, 1]
            floor = (ways[:, 1] < 0.0) & (camera.eye[2] + reach * ways[:, 2] > wall)
        if floor.any():
            seen = max(seen, int(np.flatnonzero(floor)[-1]) + 1)
    return min(seen + 1, size[1])
