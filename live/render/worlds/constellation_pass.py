"""Render pass of the constellation: dancers as points of light joined by fine lines, among stars in depth."""

from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.pass_context import Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform
from live.render.worlds.stroke_kernels import STROKE_NUMBERS, fill_strokes

STARS: Final = 2600
_SEED: Final = 12
_REACH: Final = 1.5
"""Tips of two dancers that are nearer than this are joined [m]."""
_TIPS: Final = np.array(
    [SKELETON.index(name) for name in ("head", "leftHand", "rightHand", "leftToes", "rightToes")], np.int32
)
_PARENTS: Final = np.array(SKELETON.parents, np.int32)
_STROKES_PER_DANCER: Final = 2 * JOINT_COUNT + 24
MAX_STROKES: Final = 16_384
"""Largest number of strokes that are drawn."""


class ConstellationPass(ScenePass):
    """Draws stars and strokes over the stage; costs nothing while the world is not seen."""

    only_adds = True

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._stars_program = compile_program(ctx, "star_vertex.glsl", "star_fragment.glsl")
        self._stroke_program = compile_program(ctx, "stroke_vertex.glsl", "stroke_fragment.glsl", (("SOFT", 0),))
        self._stars_buffer = ctx.buffer(star_rows().tobytes())
        self._stars = ctx.vertex_array(self._stars_program, [(self._stars_buffer, "3f 3f", "in_place", "in_chance")])
        count = min(_STROKES_PER_DANCER * max(making.scene.dancer_count, 1), MAX_STROKES)
        self._rows = np.zeros((count, STROKE_NUMBERS), np.float32)
        self._buffer = ctx.buffer(reserve=self._rows.nbytes, dynamic=True)
        self._strokes = ctx.vertex_array(
            self._stroke_program, [(self._buffer, "3f 3f 3f/i", "in_begin", "in_end", "in_stroke")]
        )
        self._weight = joint_weights()
        self._has_stars = not making.transparent
        self._count = 0

    def active(self, moment: Moment) -> bool:
        """Whether the constellation is seen."""
        return moment.uniforms.worlds["constellation"] > 0.0

    def light_active(self, moment: Moment) -> bool:
        """The same as `active`: called only then."""
        return True

    def prepare(self, moment: Moment) -> None:
        """Find the strokes of this frame."""
        view = moment.view
        self._count = fill_strokes(
            view.joint_position, view.present, _PARENTS, _TIPS, self._weight, _REACH,
            moment.uniforms.worlds["constellation"], self._rows,
        )  # fmt: skip
        if self._count:
            self._buffer.write(self._rows[: self._count])

    def draw_light(self, moment: Moment) -> None:
        """Draw the stars, the strokes, and those in the dark floor."""
        ctx = self._ctx
        ctx.enable(moderngl.DEPTH_TEST | moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        ctx.disable(moderngl.CULL_FACE)
        target = ctx.fbo
        keeps_depth = target.depth_mask
        target.depth_mask = False
        ctx.depth_func = "<="
        ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        if self._has_stars:
            self._stars.render(moderngl.POINTS)
        if self._count:
            moment.batch.bind_program(self._stroke_program)
            for mirrored in (1, 0) if self._has_stars else (0,):
                set_uniform(self._stroke_program, "mirrored", mirrored)
                self._strokes.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._count)
        ctx.depth_func = "<"
        ctx.disable(moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        target.depth_mask = keeps_depth

    def release(self) -> None:
        """Free everything."""
        release_all(
            self._stars, self._strokes, self._stars_buffer, self._buffer, self._stars_program, self._stroke_program
        )


def star_rows() -> Float32:
    """Return place [m] and three random numbers of each star, shape (STARS, 6): a shell around and above the stage."""
    draw = np.random.default_rng(_SEED)
    angle, height = draw.uniform(0.0, 2.0 * np.pi, STARS), draw.uniform(0.0, 1.0, STARS) ** 1.5
    distance = 9.0 + 38.0 * draw.uniform(0.0, 1.0, STARS) ** 0.8
    place = np.stack(
        [distance * np.sin(angle), 0.15 + 0.75 * distance * height, 0.9 * distance * np.cos(angle) - 4.0], axis=1
    )
    return np.concatenate([place, draw.uniform(0.0, 1.0, (STARS, 3))], axis=1).astype(np.float32)


def joint_weights() -> Float32:
    """Return how bright the point of each joint is, shape (J,): head, hands and feet are the brightest."""
    weight = np.full(JOINT_COUNT, 0.45, np.float32)
    weight[_TIPS] = 1.0
    weight[
        [SKELETON.index(name) for name in ("hips", "leftLowerLeg", "rightLowerLeg", "leftLowerArm", "rightLowerArm")]
    ] = 0.7
    return weight
