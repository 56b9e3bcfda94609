"""Fixture: a float floor map into which single passes are drawn, in metres."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import moderngl
import numpy as np
import numpy.typing as npt
import pytest

from live.base.stage_snapshot import Camera, Scene, StageView
from live.motion.skeleton import JOINT_COUNT
from live.render.uniforms import FLOOR_MARGIN, FrameUniforms

Colour = tuple[float, float, float, float]
Floats = npt.NDArray[np.float64]
STAGE = (10.0, 8.0)
TEXEL = 0.05
SIZE = round((STAGE[0] + 2 * FLOOR_MARGIN) / TEXEL), round((STAGE[1] + 2 * FLOOR_MARGIN) / TEXEL)


@dataclass(frozen=True, slots=True, eq=False)
class FloorLight:
    """Result of a pass: `light` (H, W, 4), and the position of each texel, `x` and `z` (H, W) [m]."""

    light: Floats
    x: Floats
    z: Floats

    @property
    def brightness(self) -> Floats:
        """Sum of red, green and blue, (H, W)."""
        total: Floats = self.light[..., :3].sum(-1)
        return total

    def at(self, x: float, z: float) -> Floats:
        """Light at a position [m]."""
        row, column = np.abs(self.z[:, 0] - z).argmin(), np.abs(self.x[0] - x).argmin()
        texel: Floats = self.light[row, column]
        return texel


Draw = Callable[..., FloorLight]


@pytest.fixture
def floor(gl_context: moderngl.Context) -> Iterator[Draw]:
    """Draws a pass with a view onto an empty floor map (or onto the colour `under`)."""
    frame = FrameUniforms(gl_context, Scene(STAGE, Camera(), 0, JOINT_COUNT), (64, 64))
    texture = gl_context.texture(SIZE, 4, dtype="f4")
    target = gl_context.framebuffer([texture])
    x = (np.arange(SIZE[0]) + 0.5) * TEXEL - 0.5 * STAGE[0] - FLOOR_MARGIN
    z = (np.arange(SIZE[1]) + 0.5) * TEXEL - 0.5 * STAGE[1] - FLOOR_MARGIN
    places = np.meshgrid(x, z)

    def draw(one_pass: object, view: StageView, under: Colour = (0.0, 0.0, 0.0, 0.0)) -> FloorLight:
        frame.write(view)
        target.use()
        target.clear(color=under)
        _ = gl_context.error  # what making the pass has left, see below, is read before and not taken for its drawing
        one_pass.draw(view)  # type: ignore[attr-defined]
        assert gl_context.error == "GL_NO_ERROR"
        pixels = np.frombuffer(target.read(components=4, dtype="f4", alignment=1), np.float32)
        return FloorLight(pixels.reshape(SIZE[1], SIZE[0], 4).astype(np.float64), *places)

    yield draw
    for thing in (target, texture, frame):
        thing.release()
