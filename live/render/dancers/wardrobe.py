"""What dancers wear, for the shaders: each dancer's colours, and the cut of their costume and shoes.

A dancer has `WARDROBE_TEXELS` texels of four bytes: the materials as square roots of linear RGB and sheen; group and
chance; then the cut as numbers from 0 to 1, which `shaders/surface` reads as lengths on the body in the rest
pose. All costumes are drawn by the same few lines there, so that a software renderer does not pay for each of them.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int32
from live.base.body.appearance import BY_CHANCE, COSTUME, COSTUMES, HAIR_COLOUR, SHOES, SHOES_WORN
from live.base.body.appearance import SKIN as SKIN_TONE
from live.base.picture_parameters import PART_COUNT

CLOTH: Final = 0
SECOND: Final = 1
SKIN: Final = 2
HAIR: Final = 3
SHOE: Final = 4
MATERIALS: Final = 5
IDENTITY: Final = 5
"""Texel after the materials: the dancer's group (no square root), and three random numbers."""
CUT: Final = 6
"""First of three texels: neckline, straps, open front, sleeves; hem, its slope, midriff, legs; shoes, instep, sole,
materials."""
WARDROBE_TEXELS: Final = 9
"""Texels per dancer in the wardrobe texture."""

SHIRT: Final = 6
"""Not a texel: the white shirt in an open front."""


@dataclass(frozen=True, slots=True)
class CostumeCut:
    """The cut of a costume on the body in the rest pose [m]; arms point sideways at a height of 1.38."""

    neck: float
    """Height of the neckline in front, 1.20 to 1.45; the lower it is, the deeper is the back."""
    strap: float
    """Half the width of the neckline, to 0.2; narrow: straps on the shoulders."""
    sleeve: float
    """How far from the middle sleeves end, 0.12 (none) to 0.70 (wrist)."""
    hem: float
    """Height at which the top ends in the middle, 0.60 to 1.20."""
    slope: float
    """How much higher the hem is towards the hips in front, 0 to 1; 0: level."""
    midriff: float
    """Height above the hem to which the body is bare, 0 to 0.3; 0: the top ends at the hem."""
    leg: float
    """Height at which legs of trousers or tights end, 0 to 1; above the hem: bare legs."""
    top: int = CLOTH
    """Material above the hem, …"""
    bottom: int = SECOND
    """… and below it."""
    open_front: float = 0.0
    """Half the width of an open front over a white shirt, 0 to 0.1."""


@dataclass(frozen=True, slots=True)
class ShoeCut:
    """The cut of shoes [m]."""

    height: float
    """Height to which they reach, 0 to 0.5; 0: none."""
    instep: float
    """How much of the instep is open, 0 to 1."""
    sole: float
    """Height of the white sole, 0 to 0.1."""
    colour: tuple[float, float, float] | None
    """Linear RGB; None: the second colour of the costume."""
    sheen: float


COSTUME_CUTS: Final[dict[str, CostumeCut]] = {
    "leotard": CostumeCut(1.318, 0.086, 0.124, 0.808, 0.60, 0.0, 0.108),
    "unitard": CostumeCut(1.345, 0.090, 0.655, 0.60, 0.0, 0.0, 0.108, bottom=CLOTH),
    "trousers": CostumeCut(1.410, 0.150, 0.310, 0.985, 0.0, 0.0, 0.085),
    "dress": CostumeCut(1.305, 0.092, 0.124, 0.760, 0.0, 0.0, 1.0),
    "skirt": CostumeCut(1.385, 0.130, 0.480, 0.975, 0.0, 0.0, 0.770, top=SECOND, bottom=CLOTH),
    "jacket": CostumeCut(1.450, 0.060, 0.650, 0.880, 0.0, 0.0, 0.085, open_front=0.075),
    "bare": CostumeCut(1.310, 0.110, 0.124, 0.975, 0.0, 0.215, 0.720, bottom=CLOTH),
}
"""By the names of `live.base.body.appearance.COSTUMES`."""
SHOE_CUTS: Final[dict[str, ShoeCut]] = {
    "barefoot": ShoeCut(0.0, 0.0, 0.0, None, 0.14),
    "ballet": ShoeCut(0.072, 0.75, 0.0, (0.72, 0.42, 0.36), 0.55),
    "pumps": ShoeCut(0.066, 0.85, 0.0, (0.02, 0.016, 0.018), 0.9),
    "sneakers": ShoeCut(0.094, 0.0, 0.024, None, 0.2),
    "boots": ShoeCut(0.330, 0.0, 0.012, (0.035, 0.024, 0.018), 0.5),
}
"""By the names of `live.base.body.appearance.SHOES`."""

_SHEEN: Final = (0.30, 0.30, 0.14, 0.35, 0.3)
_SKIN_TONES: Final = np.array([(0.075, 0.034, 0.021), (0.20, 0.098, 0.058), (0.38, 0.205, 0.130), (0.60, 0.375, 0.270)])
_HAIR_TONES: Final = np.array(
    [(0.010, 0.008, 0.008), (0.065, 0.032, 0.015), (0.17, 0.070, 0.028), (0.42, 0.27, 0.11), (0.70, 0.68, 0.65)]
)
_SATURATION: Final = 1.25
"""Saturation of cloth relative to the group's colour, because light on it makes it paler."""
PLAIN_CLOTHES: Final = (0.2, 1.0, 0.8, 0.8, 0.8, 0.0)
"""Variation of colours among the dancers of a group, sheen, colour of what is not in the group's colour, and how far it
takes it."""
_SEED: Final = 7


def dancer_colours(
    group: Int32, colours: Float32, clothes: Float32 | None = None, appearance: Int32 | None = None
) -> npt.NDArray[np.uint8]:
    """Return the texels of A dancers, 0 to 255, shape (A, WARDROBE_TEXELS, 4).

    group (A,) indexes `colours` (G, 3) and `clothes` (G, 6), like `PLAIN_CLOTHES`, modulo their length; `appearance`
    (A, APPEARANCE_SIZE), see `live.base.body.appearance`. The same dancer always looks the same.
    """
    draw = np.random.default_rng(_SEED).random((len(group), 4))
    kinds = np.array([PLAIN_CLOTHES], np.float32) if clothes is None else clothes
    said = kinds[group % len(kinds)].astype(np.float64)
    differ, shine, accent, amount = said[:, :1], said[:, 1:2], said[:, 2:5], said[:, 5:]
    cloth = colours[group % len(colours)].astype(np.float64)
    grey = cloth @ np.array([0.2126, 0.7152, 0.0722])
    cloth = np.maximum(grey[:, None] + _SATURATION * (cloth - grey[:, None]), 0.0)
    cloth *= 0.61 + np.minimum(1.3 * differ, 0.7) * (draw[:, :1] - 0.5)
    turn = 0.5 * differ * (draw[:, 1:2] - 0.5)  # a little of the neighbouring hue
    cloth = np.where(
        turn > 0.0, (1.0 - turn) * cloth + turn * cloth[:, [1, 2, 0]], (1.0 + turn) * cloth - turn * cloth[:, [2, 0, 1]]
    )
    second = cloth * np.array([0.34, 0.33, 0.36])
    second += amount * (accent - second)
    worn = np.full((len(group), 6), BY_CHANCE) if appearance is None else appearance
    costume, shoes = (np.maximum(worn[:, column], 0) for column in (COSTUME, SHOES_WORN))
    out = np.zeros((len(group), WARDROBE_TEXELS, 4))
    out[:, CLOTH, :3], out[:, SECOND, :3] = cloth, second
    out[:, SKIN, :3] = _tone(_SKIN_TONES, _share(worn[:, SKIN_TONE], np.sqrt(draw[:, 2])))
    out[:, HAIR, :3] = _tone(_HAIR_TONES, _share(worn[:, HAIR_COLOUR], 0.25 * draw[:, 3] ** 2))
    colour = _SHOES[shoes]
    out[:, SHOE, :3] = np.where(colour[:, :1] >= 0.0, colour[:, :3], second)
    out[:, :MATERIALS, :3] = np.sqrt(np.clip(out[:, :MATERIALS, :3], 0.0, 1.0))
    out[:, :MATERIALS, 3] = np.array(_SHEEN)
    out[:, SHOE, 3] = colour[:, 3]
    out[:, CLOTH : SECOND + 1, 3] *= np.minimum(shine, 1.0 / max(_SHEEN))
    out[:, IDENTITY, 0], out[:, IDENTITY, 1:] = (group % PART_COUNT) / 255.0, draw[:, [1, 2, 3]]
    out[:, CUT : CUT + 2] = _COSTUMES[costume, :2]
    out[:, CUT + 2] = _COSTUMES[costume, 2] + _SHOE_TEXELS[shoes]
    return np.ascontiguousarray(np.rint(np.minimum(out, 1.0) * 255.0), np.uint8)


def _share(said: Int32, chance: Float64) -> Float64:
    """Return the place between the first and the last tone, 0 to 1: as said (A,) of 0 to 255, or by chance (A,)."""
    return np.where(said == BY_CHANCE, chance, said / 255.0)


def _tone(tones: Float64, share: Float64) -> Float64:
    """Return colours (A, 3) between `tones` (T, 3), which are evenly spaced."""
    at = share * (len(tones) - 1)
    return np.stack([np.interp(at, np.arange(len(tones)), tones[:, channel]) for channel in range(3)], axis=1)


def _costume_texels(cut: CostumeCut) -> list[tuple[float, float, float, float]]:
    """Return the three texels of a costume; the ranges are those of `surface.glsl`."""
    return [
        ((cut.neck - 1.20) / 0.25, cut.strap / 0.2, cut.open_front / 0.1, cut.sleeve / 0.7),
        ((cut.hem - 0.60) / 0.60, cut.slope, cut.midriff / 0.3, cut.leg),
        (0.0, 0.0, 0.0, (cut.top + 8 * cut.bottom) / 255.0),
    ]


_COSTUMES: Final = np.array([_costume_texels(COSTUME_CUTS[name]) for name in COSTUMES])
_SHOE_TEXELS: Final = np.array(
    [(cut.height / 0.5, cut.instep, cut.sole / 0.1, 0.0) for cut in (SHOE_CUTS[name] for name in SHOES)]
)
_SHOES: Final = np.array(
    [(*(cut.colour or (-1.0, 0.0, 0.0)), cut.sheen) for cut in (SHOE_CUTS[name] for name in SHOES)]
)
