"""Render pass for dancers of particles: points of light on the skin that move as a function of the beat."""

from typing import Any

import moderngl
import numpy as np

from live.base.body.catalogue import BODIES
from live.base.stage_snapshot import Scene, StageView
from live.render.body.body_lookup import bodies_of, mesh_of
from live.render.body.body_mesh import LIGHT
from live.render.dancers.dancer_batch import DancerBatch
from live.render.dancers.particle_points import BodyPoints, build_points, points_on
from live.render.pass_context import PassSetup
from live.render.shader import compile_program, release_all, set_uniform

PERIOD = 96.0
"""Period of the points' motion [beats]."""


class ParticlePass:
    """Draws particles over the bound target, which must not write depth."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._count = making.quality.points
        self._program = compile_program(ctx, "particle_vertex.glsl", "particle_fragment.glsl", (("SOFT", 0),))
        scene = making.scene
        self._buffers = {name: ctx.buffer(_pack(_points(scene, name, self._count))) for name in bodies_of(scene)}

    def draw(self, crowd: DancerBatch, view: StageView) -> None:
        """Draw all dancers with the particle style."""
        set_uniform(self._program, "beat", view.beat % PERIOD)
        most = min(crowd.quality.points, self._count)  # points are sorted by their random number
        shown = min(int(crowd.styles.share * self._count) + 1, most)
        self._ctx.enable(moderngl.PROGRAM_POINT_SIZE)
        crowd.draw_geometry(self._program, "particles", self._vertices, moderngl.POINTS, shown)
        self._ctx.disable(moderngl.PROGRAM_POINT_SIZE)

    def _vertices(self, body: str) -> tuple[Any, ...]:
        names = ("in_position", "in_normal", "in_chance", "in_joint", "in_weight")
        return self._buffers[body], "3f 3f 4f 4u1 4f1", *names

    def release(self) -> None:
        """Free everything."""
        release_all(*self._buffers.values(), self._program)


def _points(scene: Scene, name: str, count: int) -> BodyPoints:
    return build_points(count, name) if name in BODIES else points_on(mesh_of(scene, name, LIGHT), count)


def _pack(points: BodyPoints) -> bytes:
    count = len(points.position)
    kinds = [("position", "f4", 3), ("normal", "f4", 3), ("chance", "f4", 4), ("joint", "u1", 4), ("weight", "u1", 4)]
    data = np.zeros(count, np.dtype(kinds))
    data["position"], data["normal"], data["chance"] = points.position, points.normal, points.random
    data["joint"], data["weight"] = points.joint, np.rint(points.weight * 255.0)
    return data.tobytes()
