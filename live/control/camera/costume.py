"""Colours of a person's costume: what tells one dancer from another after they have crossed."""

from typing import Final

import numpy as np

from live.base.arrays import Float64, UInt8
from live.motion.capture.landmarks import LANDMARK_NAMES

PARTS: Final = 4
"""Chest, belly, thighs, shins."""
_LEAST_SEEN: Final = 0.5
"""Least visibility of the landmarks of a part."""
_BRIGHTNESS_WEIGHT: Final = 0.35
"""Weight of brightness beside hue and saturation: light on a stage changes from place to place."""


def _at(*names: str) -> list[int]:
    return [LANDMARK_NAMES.index(name) for name in names]


_TORSO: Final = _at("leftShoulder", "rightShoulder", "leftHip", "rightHip")
_LEGS: Final = (_at("leftHip", "leftKnee", "leftAnkle"), _at("rightHip", "rightKnee", "rightAnkle"))
_ALONG: Final = np.linspace(0.2, 0.8, 5)


def costume_colours(picture: UInt8, landmarks: Float64, visibility: Float64) -> Float64:
    """Return the mean colours of a person's parts, (PARTS, 3), as two opponent colours and brightness; NaN where a part
    is not seen.

    `picture` (H, W, 3); `landmarks` (L, 2) [pixels]; `visibility` (L,).
    """
    colours = np.full((PARTS, 3), np.nan)
    left, right, hip_left, hip_right = landmarks[_TORSO]
    if visibility[_TORSO].min() >= _LEAST_SEEN:
        for part, share in enumerate(((0.15, 0.3, 0.45), (0.6, 0.75, 0.9))):
            down = np.array(share)[:, None, None]
            across = _ALONG[None, :, None]
            begin, end = left + down * (hip_left - left), right + down * (hip_right - right)
            colours[part] = _mean_colour(picture, (begin + across * (end - begin)).reshape(-1, 2))
    for part, (upper, lower) in enumerate(((0, 1), (1, 2)), start=2):
        seen = [leg for leg in _LEGS if min(visibility[leg[upper]], visibility[leg[lower]]) >= _LEAST_SEEN]
        if seen:
            points = [
                landmarks[leg[upper]] + _ALONG[:, None] * (landmarks[leg[lower]] - landmarks[leg[upper]])
                for leg in seen
            ]
            colours[part] = _mean_colour(picture, np.concatenate(points))
    return colours


def _mean_colour(picture: UInt8, points: Float64) -> Float64:
    """Return the median colour at `points` (n, 2) [pixels], as two opponent colours and brightness."""
    height, width = picture.shape[:2]
    x = np.clip(points[:, 0].astype(np.intp), 0, width - 1)
    y = np.clip(points[:, 1].astype(np.intp), 0, height - 1)
    red, green, blue = np.median(picture[y, x].astype(np.float64) / 255.0, axis=0)
    total = red + green + blue + 0.05
    return np.array([(red - green) / total, (red + green - 2.0 * blue) / total, _BRIGHTNESS_WEIGHT * total / 3.0])


def colour_difference(first: Float64, second: Float64) -> float:
    """Return how different two costumes look, from 0; NaN if no part of both was seen. Both (PARTS, 3)."""
    apart = np.linalg.norm(first - second, axis=1)
    seen = np.isfinite(apart)
    return float(apart[seen].mean()) if seen.any() else float("nan")


def blend_colours(old: Float64, new: Float64, share: float) -> Float64:
    """Return the colours `old` moved towards `new` by `share`; parts that one of them lacks come from the other."""
    mixed = old + share * (new - old)
    return np.where(np.isnan(old), new, np.where(np.isnan(new), old, mixed))
