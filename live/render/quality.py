"""How much a picture may cost: one tier for software rendering, one for graphics cards and films without haste."""

from dataclasses import dataclass, replace
from typing import Final

import moderngl

from live.render.body.body_mesh import DISTANT, FINE, LIGHT

_SOFTWARE: Final = ("llvmpipe", "softpipe", "swrast", "software rasterizer", "swiftshader", "microsoft basic render")
_MEDIUM_ABOVE: Final = 120
"""With more dancers than this even a graphics card draws the light body, and the coarse one far away."""


@dataclass(frozen=True, slots=True)
class Quality:
    """What the passes ask before they allocate and draw."""

    samples: int
    """Multisampling of the picture. 0: surfaces first, each pixel lit once, edges smoothed after, all in 8 bits;
    more: lit while drawn, in half floats, with glow around what is bright."""
    near_level: int
    """Body of the nearest dancers."""
    near_count: int
    """How many dancers at most get the near body; the others get `far_level`."""
    far_level: int
    floor_map: int
    """Texels along the longer side of the floor's map of shadows and elements (cast at twice that)."""
    mirror_divisor: int
    """The dancers' mirror images in the floor are drawn at 1/n of the picture's size."""
    left_out: tuple[str, ...] = ()
    """Passes that are not drawn, whatever is asked for."""
    scale: float = 1.0
    """The scene is drawn at this share of the picture's size each way, and stretched."""
    far_from: float = 12.0
    """Nobody nearer to the camera than this [m] gets the far body, however many they are."""
    points: int = 3000
    """Points of light on a dancer who is drawn as particles, at most."""
    ribbon_pieces: int = 96
    """Pieces of each ribbon that are drawn; fewer make it shorter."""
    ghost_level: int = LIGHT
    """Body of the ghosts of trails."""


SOFTWARE: Final = Quality(0, LIGHT, 12, DISTANT, 256, 3, ("bloom",))
"""Without a graphics card: 50 dancers at 1280x720 in real time on two cores."""
CARD: Final = Quality(4, FINE, 120, LIGHT, 768, 2)
"""For a graphics card, or for films that may take their time."""


def is_software(ctx: moderngl.Context) -> bool:
    """Whether pictures are computed by the processor, from the renderer's own name."""
    name = str(ctx.info["GL_RENDERER"]).lower()
    return any(word in name for word in _SOFTWARE)


def choose(ctx: moderngl.Context, dancer_count: int, samples: int | None) -> Quality:
    """The tier for this driver; `samples` overrides its multisampling (lowered to what the driver can).

    Raises ValueError if `samples` is negative.
    """
    if samples is not None and samples < 0:
        raise ValueError(f"samples {samples}: 0 or more")
    quality = SOFTWARE if is_software(ctx) else CARD
    if quality is CARD and dancer_count > _MEDIUM_ABOVE:
        quality = replace(quality, near_level=LIGHT, near_count=400, far_level=DISTANT)
    wanted = quality.samples if samples is None else samples
    return replace(quality, samples=min(wanted, int(ctx.max_samples)))
