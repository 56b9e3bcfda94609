"""What passes are given: what they are made with, the moment that is drawn, and the surfaces that are seen in it."""

from dataclasses import dataclass
from typing import Final, Protocol

import moderngl

from live.base.stage_snapshot import Scene, StageView
from live.render.adaptive_quality import Quality
from live.render.dancers.dancer_batch import Crowd
from live.render.uniforms import FrameBlock

HDR: Final = "f2"
"""Between passes light is kept in half floats, compressed (`finish.glsl`): x / (1 + its brightest colour)."""


@dataclass(frozen=True, slots=True, eq=False)
class Making:
    """What passes are made with."""

    ctx: moderngl.Context
    scene: Scene
    quality: Quality
    size: tuple[int, int]
    """Width and height of the picture [pixels]."""
    patient: bool = False
    """Whether pictures of videos are waited for, as in a film that may take its time."""
    bare: bool = False
    """Whether dancers are drawn without a stage, on nothing: pictures with alpha (`passes/matte_pass.py`)."""


@dataclass(slots=True, eq=False)
class Moment:
    """The frame that is drawn; one object, filled anew for each."""

    view: StageView
    frame: FrameBlock
    crowd: Crowd
    floor: moderngl.Texture
    """Over the floor's map: light of the elements, and what shadows take away."""
    beats: float = 0.0
    """Beats since the picture before, 0 or more."""
    cut: bool = True
    """Whether there is no picture before: whatever passes remember of one means nothing now."""

    def amount(self, place: int) -> float:
        """A number of the picture's row now, by its place."""
        return float(self.frame.row[place])


@dataclass(slots=True, eq=False)
class Surfaces:
    """What is seen where, one texel for each pixel; only in frames in which an active pass `needs_surfaces`."""

    depth: moderngl.Texture
    """Depth as OpenGL has it, 0 to 1; 1 where no dancer is."""
    shape: moderngl.Texture
    """rgb: normal in world axes * 0.5 + 0.5, a: sheen."""
    who: moderngl.Texture
    """r, g: low and high byte of the dancer's number from 1 on, 0 for none; b: her group."""


class ScenePass:
    """Something in the scene beside the dancers: subclasses say what they draw, the rest draws nothing.

    In the order of calls within a frame. All are asked only while `active`.
    """

    def active(self, moment: Moment) -> bool:
        """Whether it draws anything now."""
        return True

    def over_active(self, moment: Moment) -> bool:
        """Whether `over` draws anything now: then a picture on the processor takes the way through half floats."""
        return False

    def cast(self) -> None:
        """Draw shadows into the bound layers of the floor, whether active or not."""

    def prepare(self, moment: Moment) -> None:
        """Draw into textures of its own, before the picture."""

    def surfaces(self, moment: Moment) -> None:
        """Draw opaque surfaces, to be lit later, with depth: cover and shape as `gbuffer_fragment.glsl` has them."""

    def lit(self, moment: Moment) -> None:
        """Draw the same surfaces lit at once, compressed, with depth (multisampled pictures)."""

    def over(self, moment: Moment) -> None:
        """Draw light over the lit scene, compressed; blended by the pass itself, tested against depth, not written.

        Light adds when blended with ONE, ONE_MINUS_SRC_COLOR: in the compressed range that is nearly a sum.
        """

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""

    def release(self) -> None:
        """Free everything."""


class PicturePass(Protocol):
    """Makes a picture of the picture: one of `[picture] passes`, in its order."""

    needs_surfaces: bool
    """Whether `draw` reads the surfaces."""

    def active(self, moment: Moment) -> bool:
        """Whether it changes anything now; an inactive pass costs nothing."""

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source`, compressed light, changed, into `target`."""

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""

    def release(self) -> None:
        """Free everything."""
