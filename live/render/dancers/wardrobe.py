"""What each dancer wears: cloth in the group's colour, tights, skin and hair, no two dancers quite alike."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.picture import GROUPS

Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

CLOTH: Final = 0
TIGHTS: Final = 1
SKIN: Final = 2
HAIR: Final = 3
MATERIALS: Final = 4
WHO: Final = 4
"""After her clothes: the dancer's group (as it is, no square root), and three numbers by chance."""
TEXELS: Final = 5
"""Texels of a dancer in the wardrobe texture."""

_SHEEN: Final = (0.30, 0.30, 0.14, 0.35)
_DARK_SKIN, _PALE_SKIN = (0.20, 0.098, 0.058), (0.56, 0.33, 0.225)
_BLACK_HAIR, _BROWN_HAIR = (0.012, 0.009, 0.008), (0.070, 0.035, 0.016)
_DEPTH: Final = 1.25
"""Cloth is deeper in colour than the light of its group, because light on it makes it paler again."""
_VARIETY: Final = 0.2
_SEED: Final = 7


def dress(
    group: Int32, colours: Float32, variety: Float32 | None = None, sheen: Float32 | None = None
) -> npt.NDArray[np.uint8]:
    """Colours of A dancers as square roots of linear RGB and sheen, 0 to 255, shape (A, 5 texels, 4).

    group (A,) indexes `colours` (G, 3), and `variety` and `sheen` (G,) if given, wrapping round: how much the colours
    of its dancers differ (0.2 is usual), how much their clothes shine (1). The same dancer always looks the same.
    """
    draw = np.random.default_rng(_SEED).random((len(group), 4))
    differ = np.full((len(group), 1), _VARIETY) if variety is None else variety[group % len(variety)][:, None]
    shine = np.ones((len(group), 1)) if sheen is None else sheen[group % len(sheen)][:, None]
    cloth = colours[group % len(colours)].astype(np.float64)
    grey = cloth @ np.array([0.2126, 0.7152, 0.0722])
    cloth = np.maximum(grey[:, None] + _DEPTH * (cloth - grey[:, None]), 0.0)
    cloth *= 0.61 + np.minimum(1.3 * differ, 0.7) * (draw[:, :1] - 0.5)
    turn = 0.5 * differ * (draw[:, 1:2] - 0.5)  # a little of the neighbouring hue
    cloth = np.where(
        turn > 0.0, (1.0 - turn) * cloth + turn * cloth[:, [1, 2, 0]], (1.0 + turn) * cloth - turn * cloth[:, [2, 0, 1]]
    )
    out = np.empty((len(group), TEXELS, 4))
    out[:, CLOTH, :3] = cloth
    out[:, TIGHTS, :3] = cloth * np.array([0.34, 0.33, 0.36])
    out[:, SKIN, :3] = _between(_DARK_SKIN, _PALE_SKIN, np.sqrt(draw[:, 2:3]))
    out[:, HAIR, :3] = _between(_BLACK_HAIR, _BROWN_HAIR, draw[:, 3:4] ** 2)
    out[:, :MATERIALS, :3] = np.sqrt(np.clip(out[:, :MATERIALS, :3], 0.0, 1.0))
    out[:, :MATERIALS, 3] = np.array(_SHEEN)
    out[:, CLOTH : TIGHTS + 1, 3] *= np.minimum(shine, 1.0 / max(_SHEEN))
    out[:, WHO, 0], out[:, WHO, 1:] = (group % GROUPS) / 255.0, draw[:, [1, 2, 3]]
    return np.ascontiguousarray(np.rint(out * 255.0), np.uint8)


def _between(
    a: tuple[float, float, float], b: tuple[float, float, float], part: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    return np.array(a) * (1.0 - part) + np.array(b) * part
