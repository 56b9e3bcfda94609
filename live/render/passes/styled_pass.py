"""Render passes for the visual styles of groups: styled bodies, x-ray, ghosts, ribbons and particles.

`StylePasses` combines them and does nothing while all groups are plain. Ghosts are poses of earlier beats (after
Marey's chronophotographs, 1882).
"""

from typing import Any

import moderngl
import numpy as np

from live.base.arrays import Float64
from live.base.picture_parameters import (
    LONGEST_RIBBON,
    MAX_GHOSTS,
    PART_COUNT,
    STYLE_ADDRESS_PREFIX,
    STYLE_SIZE,
    STYLES_START,
    group_parameter,
)
from live.base.stage_snapshot import StageView
from live.render.dancers.dancer_batch import DancerBatch
from live.render.dancers.group_styles import NEARNESS
from live.render.dancers.motion_trails import PoseHistory
from live.render.dancers.xray_skeleton import bone_vertices
from live.render.pass_context import Memory, Moment, PassSetup, ScenePass
from live.render.passes.particle_pass import ParticlePass
from live.render.passes.trail_pass import RibbonPass
from live.render.shader import HEAD, WORN, compile_program, release_all, set_uniform


class StyledPass:
    """Draws styled bodies (flat, dissolving, with contours) into the bound target: lit, or as G-buffer (`surface`)."""

    def __init__(self, ctx: moderngl.Context, *, characters: bool = False) -> None:
        self._ctx = ctx
        self._programs = [
            (
                compile_program(ctx, "styled_vertex.glsl", "styled_fragment.glsl", (("SOFT", 1), ("SURFACE", surface))),
                compile_program(
                    ctx, "contour_vertex.glsl", "contour_fragment.glsl", (("SOFT", 1), ("SURFACE", surface))
                ),
            )
            for surface in (0, 1)
        ]
        self._head_programs = [
            compile_program(
                ctx, "styled_vertex.glsl", "styled_fragment.glsl", (("SOFT", 1), ("SURFACE", surface), *HEAD)
            )
            for surface in (0, 1)
        ]
        self._character_programs = [
            compile_program(
                ctx, "styled_vertex.glsl", "styled_fragment.glsl", (("SOFT", 1), ("SURFACE", surface), *WORN)
            )
            for surface in (0, 1)
            if characters
        ]

    def draw(self, crowd: DancerBatch, floor_map: moderngl.Texture, *, surface: bool = False) -> None:
        """Draw all styled bodies."""
        ctx, quality = self._ctx, crowd.quality
        body, ink = self._programs[surface]
        ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        ctx.depth_func = "<="
        floor_map.use(1)
        worn = self._character_programs[surface] if self._character_programs else None
        head = self._head_programs[surface]
        for linked in filter(None, (body, head, worn)):
            set_uniform(linked, "floor_map", 1)
        for where in NEARNESS:
            level = quality.level_of(where)
            crowd.draw(body, level, f"bodies {where}", character_program=worn, head_program=head)
        ctx.front_face = "cw"  # draw the back faces of the enlarged body
        for where in NEARNESS:
            crowd.draw(ink, quality.level_of(where), f"ink {where}")
        ctx.front_face = "ccw"
        ctx.depth_func = "<"

    def release(self) -> None:
        """Free the programs."""
        release_all(*(one for both in self._programs for one in both), *self._head_programs)
        release_all(*self._character_programs)


class XrayPass:
    """Draws glowing skeletons in transparent bodies over the bound target, which must not write depth."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        constants = (("SOFT", 0),)
        self._glass = compile_program(ctx, "styled_vertex.glsl", "glass_fragment.glsl", constants)
        self._bone = compile_program(ctx, "bone_vertex.glsl", "bone_fragment.glsl", constants)
        self._bones = ctx.buffer(bone_vertices().tobytes())

    def draw(self, crowd: DancerBatch) -> None:
        """Draw all dancers with the x-ray style."""
        self._ctx.enable(moderngl.CULL_FACE)
        crowd.draw(self._glass, crowd.quality.ghost_level, "xray")
        self._ctx.disable(moderngl.CULL_FACE)
        crowd.draw_geometry(self._bone, "xray", self._vertices, moderngl.TRIANGLES)

    def _vertices(self, body: str) -> tuple[Any, ...]:
        return self._bones, "4f 4f 4f", "in_begin", "in_end", "in_bone"

    def release(self) -> None:
        """Free everything."""
        release_all(self._bones, self._glass, self._bone)


class GhostPass:
    """Draws ghosts over the bound target, which must not write depth; call `record` each frame while there are any."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._program = compile_program(
            ctx, "ghost_vertex.glsl", "ghost_fragment.glsl", (("SOFT", 0), ("PART_COUNT", PART_COUNT))
        )
        self.history = PoseHistory(ctx, max(making.scene.dancer_count, 1))

    def record(self, crowd: DancerBatch, view: StageView) -> None:
        """Record the poses of this frame where a ghost is due."""
        self.history.update(view, crowd)

    def draw(self, crowd: DancerBatch) -> None:
        """Draw all ghosts, the oldest first."""
        self._ctx.enable(moderngl.CULL_FACE)
        ages = [self.history.ages(slot) for slot in range(MAX_GHOSTS)]
        for slot in sorted(range(MAX_GHOSTS), key=lambda slot: -float(ages[slot].max())):
            if ages[slot].max() >= 0.0:
                set_uniform(self._program, "ages", [tuple(four) for four in np.reshape(ages[slot], (-1, 4)).tolist()])
                crowd.draw(self._program, crowd.quality.ghost_level, "trails", poses=self.history.textures[slot])
        self._ctx.disable(moderngl.CULL_FACE)

    def release(self) -> None:
        """Free everything."""
        release_all(self._program, self.history)


_TRANSLUCENT_STYLES = ("trails", "ribbons", "xray", "particles")
_RIBBONS, _GHOSTS, _SPACING = (
    group_parameter(f"{STYLE_ADDRESS_PREFIX}{name}", 0).first - STYLES_START
    for name in ("ribbons", "trails", "trails/spacing")
)
"""Columns of a group's style."""


class StylePasses(ScenePass):
    """All style passes: styled bodies are drawn with the other dancers; translucent styles over the stage."""

    def __init__(self, making: PassSetup) -> None:
        self._ctx, self._multisampled = making.ctx, making.quality.samples > 0
        self._styled = StyledPass(making.ctx, characters=bool(making.scene.characters))
        self._ghosts, self._ribbons = GhostPass(making), RibbonPass(making)
        self._particles, self._xray = ParticlePass(making), XrayPass(making)

    @staticmethod
    def memory(row: Float64) -> Memory:
        """Return what ribbons and ghosts show of earlier moments in a picture with these parameters."""
        styles = row[STYLES_START:].reshape(-1, STYLE_SIZE)
        ghosts = styles[styles[:, _GHOSTS] > 0.0, _SPACING]
        beats = (MAX_GHOSTS + 1.0) * float(ghosts.max(initial=0.0))
        return Memory(beats=max(beats, LONGEST_RIBBON + 1.0) if (styles[:, _RIBBONS] > 0.0).any() else beats)

    def active(self, moment: Moment) -> bool:
        """Whether any group has a style other than plain."""
        if moment.batch.styles.has_effects:
            return True
        self._ghosts.history.clear()
        self._ribbons.history.clear()
        return False

    def prepare(self, moment: Moment) -> None:
        """Record motion for ribbons and ghosts while any group shows them."""
        styles = moment.batch.styles
        for each, name in ((self._ribbons, "ribbons"), (self._ghosts, "trails")):
            if moment.cut:
                each.history.clear()
            if styles.masks[name].any():
                each.record(moment.batch, moment.view)
            else:
                each.history.clear()

    follow = prepare

    def draw_surfaces(self, moment: Moment) -> None:
        """Draw styled bodies into the G-buffer."""
        if _has_bodies(moment):
            self._styled.draw(moment.batch, moment.floor, surface=True)

    def draw_lit(self, moment: Moment) -> None:
        """Draw styled bodies into a multisampled target."""
        if _has_bodies(moment):
            self._styled.draw(moment.batch, moment.floor)

    def light_active(self, moment: Moment) -> bool:
        """Whether `draw_lit` draws. Without multisampling, styled bodies are also lit there: their depth is known."""
        return _has_translucent(moment) or (_has_bodies(moment) and not self._multisampled)

    def draw_light(self, moment: Moment) -> None:
        """Light styled bodies if not done yet, then draw the translucent styles over the stage, the softest first."""
        ctx, crowd = self._ctx, moment.batch
        target = ctx.fbo
        target.depth_mask = False
        if _has_bodies(moment) and not self._multisampled:
            self._styled.draw(crowd, moment.floor)
        ctx.enable(moderngl.DEPTH_TEST | moderngl.BLEND)
        ctx.disable(moderngl.CULL_FACE)
        ctx.depth_func = "<="
        ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        if crowd.count("trails"):
            self._ghosts.draw(crowd)
        if crowd.count("ribbons"):
            self._ribbons.draw(crowd)
        if crowd.count("xray"):
            self._xray.draw(crowd)
        if crowd.count("particles"):
            self._particles.draw(crowd, moment.view)
        ctx.depth_func = "<"
        ctx.disable(moderngl.BLEND | moderngl.DEPTH_TEST)
        target.depth_mask = self._multisampled

    def release(self) -> None:
        """Free everything."""
        release_all(self._styled, self._ghosts, self._ribbons, self._particles, self._xray)


def _has_bodies(moment: Moment) -> bool:
    return any(moment.batch.count(f"bodies {where}") for where in NEARNESS)


def _has_translucent(moment: Moment) -> bool:
    return any(moment.batch.count(name) for name in _TRANSLUCENT_STYLES)
