"""Parts of the left hand in the rest pose [m]."""

from itertools import pairwise
from typing import Final

import numpy as np

from live.render.body.fingers import FINGERS, Finger, Vector
from live.render.body.implicit_surface import Ellipsoid, Loft

_UP: Final = (0.0, 1.0, 0.0)


def _finger(finger: Finger) -> Loft:
    """A straight finger from its knuckle: thicker at its joints, with a flat nail."""
    first, *_, tip = finger.places
    lengths = np.cumsum([0.0, *(np.linalg.norm(np.subtract(b, a)) for a, b in pairwise(finger.places))])
    middle, last = lengths[1] / lengths[3], lengths[2] / lengths[3]
    w, h = finger.wide, finger.thick
    rows = (
        (0.0, h * 1.12, w * 1.05, w * 1.05, 0.0),
        (0.55 * middle, h * 1.00, w * 0.97, w * 0.97, 0.0),
        (middle, h, w, w, 0.0),
        (0.5 * (middle + last), h * 0.90, w * 0.93, w * 0.93, 0.0),
        (last, h * 0.90, w * 0.94, w * 0.94, 0.0),
        (0.5 * (1.0 + last), h * 0.86, w * 0.90, w * 0.90, 0.0),
        (1.0 - 0.45 * w / lengths[3], h * 0.62, w * 0.68, w * 0.68, 0.0),
    )
    end = np.add(first, np.subtract(tip, first) * (1.0 - 0.45 * w / lengths[3]))
    scaled = tuple((row[0] / rows[-1][0], *row[1:]) for row in rows)
    return Loft(first, (float(end[0]), float(end[1]), float(end[2])), _UP, scaled, 0.006)


def _phalanx(start: Vector, end: Vector, sizes: tuple[float, float, float]) -> Loft:
    rows = tuple((0.5 * number, size, size * 1.08, size * 1.08, 0.0) for number, size in enumerate(sizes))
    return Loft(start, end, _UP, rows, 0.006)


def _thumb() -> tuple[Loft, ...]:
    (base, first, second, tip), h = FINGERS[0].places, FINGERS[0].thick
    end = np.add(second, np.subtract(tip, second) * 0.86)
    last = (float(end[0]), float(end[1]), float(end[2]))
    return (
        Loft(base, first, _UP, ((0.0, 0.0125, 0.014, 0.014, 0.0), (1.0, h * 1.12, h * 1.15, h * 1.15, 0.0)), 0.016),
        _phalanx(first, second, (h * 1.12, h * 0.98, h * 1.02)),
        _phalanx(second, last, (h * 1.02, h * 0.98, h * 0.62)),
    )


HAND: Final[tuple[Loft | Ellipsoid, ...]] = (
    Loft(
        (0.668, 1.380, -0.010),
        (0.770, 1.379, -0.007),
        _UP,
        (
            (0.00, 0.0185, 0.0250, 0.0250, 0.0),
            (0.30, 0.0165, 0.0300, 0.0320, 0.0),
            (0.70, 0.0145, 0.0375, 0.0395, 0.0),
            (1.00, 0.0110, 0.0370, 0.0380, 0.0),
        ),
        0.018,
    ),
    Ellipsoid((0.712, 1.368, 0.018), (0.030, 0.013, 0.016), 0.014),  # ball of the thumb
    Ellipsoid((0.712, 1.369, -0.034), (0.034, 0.011, 0.012), 0.014),  # ball of the little finger
    Ellipsoid((0.735, 1.364, -0.006), (0.026, 0.006, 0.014), 0.012, hollow=True),  # hollow of the hand
    *_thumb(),
    *(_finger(finger) for finger in FINGERS[1:]),
    *(
        Ellipsoid((x, y + finger.thick * 0.72, z), (0.009, 0.005, 0.0065), 0.007)  # knuckles
        for finger in FINGERS[1:]
        for x, y, z in finger.places[:1]
    ),
)
"""Palm, thumb and fingers, in blending order."""
