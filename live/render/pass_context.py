"""Interfaces of render passes, and their inputs: construction data, the frame to draw, and its surface textures."""

from dataclasses import dataclass
from typing import Final, Protocol

import moderngl

from live.base.arrays import Float64
from live.base.stage_snapshot import Scene, StageView
from live.render.adaptive_quality import Quality
from live.render.camera import Size
from live.render.dancers.dancer_batch import DancerBatch
from live.render.uniforms import FrameUniforms

HDR: Final = "f2"
"""Texture format between passes: half floats, compressed (`finish.glsl`): x / (1 + its brightest colour)."""


@dataclass(frozen=True, slots=True, eq=False)
class PassSetup:
    """Construction data for passes."""

    ctx: moderngl.Context
    scene: Scene
    quality: Quality
    size: Size
    """Width and height of the picture, or of the part of it that is drawn [pixels]."""
    blocking_video: bool = False
    """Whether to wait for pictures of videos, as in an offline film."""
    transparent: bool = False
    """Whether dancers are drawn without a stage, in pictures with alpha (`passes/alpha_pass.py`)."""


@dataclass(slots=True, eq=False)
class Moment:
    """The frame to draw; one object, reused for every frame."""

    view: StageView
    uniforms: FrameUniforms
    batch: DancerBatch
    floor: moderngl.Texture
    """The floor's map: light of the elements, and shadows."""
    rectangle: tuple[int, int, int, int] = (0, 0, 0, 0)
    """Left, bottom, width and height of where in the drawn picture dancers and items may be [pixels]."""
    beats: float = 0.0
    """Beats since the previous picture, 0 or more."""
    cut: bool = True
    """Whether this picture does not continue the previous one; passes must drop their history."""

    def parameter(self, place: int) -> float:
        """Return a value of the picture's parameter row, by index."""
        return float(self.uniforms.row[place])


@dataclass(frozen=True, slots=True)
class Memory:
    """How much of the show before a picture a pass remembers; longer ago is without effect."""

    seconds: float = 0.0
    """Moments of the last seconds, which have to be followed."""
    beats: float = 0.0
    """Moments of the last beats, which have to be followed."""
    half_life: float = 0.0
    """Beats after which half of the light of earlier pictures is left; they have to be drawn. 0: none is."""


NO_MEMORY: Final = Memory()


@dataclass(slots=True, eq=False)
class Surfaces:
    """Surface textures (G-buffer), one texel per pixel; only drawn if an active pass `needs_surfaces`."""

    depth: moderngl.Texture
    """OpenGL depth, 0 to 1; 1 where there is no dancer."""
    shape: moderngl.Texture
    """rgb: normal in world axes * 0.5 + 0.5, a: sheen."""
    identity: moderngl.Texture
    """r, g: low and high byte of the dancer's number from 1 on, 0 for none; b: the dancer's group."""


class ScenePass:
    """Base class for everything in the scene except the dancers. Its methods draw nothing.

    The methods are in the order of calls within a frame. They are only called while `active`, unless stated.
    """

    box: Float64 | None = None
    """Box around its opaque surfaces, shape (2, 3): lowest and highest x, y, z [m]; None: it has none now."""

    only_adds: bool = False
    """Whether all that it draws is light that is added, so that its place in the order does not matter."""

    @property
    def problems(self) -> list[str]:
        """Messages about failed files; the last good state is drawn."""
        return []

    def active(self, moment: Moment) -> bool:
        """Whether the pass draws anything now."""
        return True

    def light_active(self, moment: Moment) -> bool:
        """Whether `draw_lit` draws anything now; then a software picture uses half floats."""
        return False

    def draw_shadows(self) -> None:
        """Draw shadows into the bound layers of the floor; also called while inactive."""

    def draw_mirrored(self) -> None:
        """Draw what the floor mirrors into the bound target, upside down; also called while inactive."""

    def follow(self, moment: Moment) -> None:
        """Take in a moment that is not drawn, for what later pictures remember of it."""

    def prepare(self, moment: Moment) -> None:
        """Draw into the pass's own textures, before the picture."""

    def draw_surfaces(self, moment: Moment) -> None:
        """Draw opaque surfaces with depth for deferred shading: cover and shape as in `gbuffer_fragment.glsl`."""

    def draw_lit(self, moment: Moment) -> None:
        """Draw the same surfaces with depth and forward shading, compressed (multisampled pictures)."""

    def draw_light(self, moment: Moment) -> None:
        """Draw light over the lit scene, compressed; the pass sets blending, tests depth and writes none.

        Blending with ONE, ONE_MINUS_SRC_COLOR adds light: in the compressed range that is nearly a sum.
        """

    def resize(self, size: Size) -> None:
        """Set a new size of what is drawn [pixels]."""

    def release(self) -> None:
        """Free everything."""


class PicturePass(Protocol):
    """Post-processing pass: one of `[picture] passes`, in their order."""

    needs_surfaces: bool
    """Whether `draw` reads the surfaces."""

    def active(self, moment: Moment) -> bool:
        """Whether the pass changes anything now; an inactive pass costs nothing."""

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw the processed `source` (compressed light) into `target`."""

    def resize(self, size: Size) -> None:
        """Set a new size of what is drawn [pixels]."""

    def release(self) -> None:
        """Free everything."""
