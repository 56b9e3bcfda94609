"""Render pass of rings that spread on the floor from the dancers' steps: waves of the water, or rings of light.

A ring begins where a foot comes down; on each beat a small one begins below everybody who stands. All rings are drawn
from where and when they began, so nothing is simulated.
"""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Float64
from live.base.stage_snapshot import FLOOR_MARGIN, StageView
from live.motion.skeleton import SKELETON
from live.render.pass_context import NO_MEMORY, Memory, Moment, PassSetup, ScenePass
from live.render.shader import SHARED_TEXTURES, compile_program, release_all
from live.render.uniforms import rings_are_seen

LASTING: Final = 2.5
"""How long a ring is seen [beats]."""
CAPACITY: Final = 256
"""Largest number of rings; the oldest give way."""
_DOWN, _UP = 0.045, 0.075
"""A foot has come down below the first height of its toes, after it was above the second [m]."""
_FOOT_MEMORY: Final = 8.0
"""Within so many beats each foot has been clearly up or down."""
_ON_BEAT: Final = 0.35
"""Strength of the rings below those who stand."""
_SEGMENTS: Final = 28
_TOES: Final = [SKELETON.index("leftToes"), SKELETON.index("rightToes")]
_TEXELS: Final = {True: 320, False: 768}
"""Texels along the longer side of the map: with software rendering, and on a graphics card."""


class StepRings:
    """The rings of the last beats: x, z [m], the beat on which each began, and its strength."""

    def __init__(self) -> None:
        self.rows: Float64 = np.zeros((CAPACITY, 4))
        """Shape (CAPACITY, 4)."""
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self.rows[:, 2:] = -1e6, 0.0
        self._next, self._beat = 0, None
        self._down: Bool | None = None

    _next: int
    _beat: float | None

    def update(self, view: StageView) -> None:
        """Begin the rings of the steps since the last view; going back in time forgets all."""
        toes = view.joint_position[:, _TOES]
        height = toes[:, :, 1]
        if self._beat is None or self._down is None or len(self._down) != len(height) or view.beat < self._beat:
            self.clear()
            self._down = height < _DOWN
            self._beat = view.beat
            return
        lands = (height < _DOWN) & ~self._down & view.present[:, None]
        self._down = np.where(self._down, height < _UP, height < _DOWN)
        self._add(toes[lands][:, [0, 2]], view.beat, 1.0)
        if np.floor(view.beat) > np.floor(self._beat):
            stands = self._down.all(axis=1) & view.present & ~lands.any(axis=1)
            self._add(toes[stands].mean(axis=1)[:, [0, 2]], float(np.floor(view.beat)), _ON_BEAT)
        self._beat = view.beat

    def _add(self, places: Float32, beat: float, strength: float) -> None:
        places = places[:CAPACITY]
        slots = (self._next + np.arange(len(places))) % CAPACITY
        self.rows[slots, :2], self.rows[slots, 2], self.rows[slots, 3] = places, beat, strength
        self._next = (self._next + len(places)) % CAPACITY

    def seen(self, beat: float) -> Float32:
        """Return x, z [m], age [beats] and strength of the rings that are seen on a beat, the oldest first, shape
        (N, 4)."""
        ordered = np.roll(self.rows, -self._next, axis=0)  # light is added in one order, whichever was the first ring
        age = beat - ordered[:, 2]
        seen = (age >= 0.0) & (age < LASTING)
        rows = ordered[seen]
        rows[:, 2] = age[seen]
        return rows.astype(np.float32)


class RipplePass(ScenePass):
    """Fills the texture `ripple_map`: slopes to the right and to the front, and heights; costs nothing unless seen."""

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        self._program = compile_program(ctx, "ripple_vertex.glsl", "ripple_fragment.glsl", (("SEGMENTS", _SEGMENTS),))
        self._buffer = ctx.buffer(reserve=CAPACITY * 16, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._buffer, "4f/i", "in_ring")])
        self._rings = StepRings()
        stage = making.scene.stage_size
        width, depth = stage[0] + 2 * FLOOR_MARGIN, stage[1] + 2 * FLOOR_MARGIN
        longer = _TEXELS[making.quality.samples == 0]
        size = tuple(max(round(longer * side / max(width, depth)), 8) for side in (width, depth))
        self._texture = ctx.texture((size[0], size[1]), 4, dtype="f2")
        self._texture.repeat_x = self._texture.repeat_y = False
        self._target = ctx.framebuffer([self._texture])

    @staticmethod
    def memory(row: Float64) -> Memory:
        """Return how long rings are seen in a picture with these parameters."""
        return Memory(beats=LASTING + _FOOT_MEMORY) if rings_are_seen(row) else NO_MEMORY

    def active(self, moment: Moment) -> bool:
        """Whether any ring could be seen."""
        if moment.uniforms.rippled:
            return True
        self._rings.clear()
        return False

    def follow(self, moment: Moment) -> None:
        """Begin the rings of the steps since the last moment."""
        if moment.cut:
            self._rings.clear()
        self._rings.update(moment.view)

    def prepare(self, moment: Moment) -> None:
        """Draw the rings, and bind the map for all programs."""
        self.follow(moment)
        rows: npt.NDArray[np.float32] = self._rings.seen(moment.view.beat)
        ctx = self._ctx
        self._target.use()
        self._target.clear()
        if len(rows):
            self._buffer.write(rows)
            ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
            ctx.enable(moderngl.BLEND)
            ctx.blend_func = moderngl.ONE, moderngl.ONE
            self._array.render(moderngl.TRIANGLE_STRIP, vertices=2 * _SEGMENTS + 2, instances=len(rows))
            ctx.disable(moderngl.BLEND)
        self._texture.use(SHARED_TEXTURES["ripple_map"])

    def release(self) -> None:
        """Free everything."""
        release_all(self._array, self._buffer, self._target, self._texture, self._program)
