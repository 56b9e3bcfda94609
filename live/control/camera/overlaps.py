"""People who overlap in a picture: the one in front is taken out of it, so that the one behind can be seen.

A pose model for one person (Bazarevsky et al. 2020) takes the most prominent one in its region, for both regions of two
who cross. Its own silhouette of the one in front says which pixels are not the other's.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from PIL import Image

from live.base.arrays import Bool, Float64, UInt8
from live.control.camera.pose_models import ModelPose
from live.motion.capture.landmarks import LANDMARK_NAMES

_LEAST_LOGIT: Final = -1.0
"""Pixels of a silhouette from this logit on count: its edge too is not the other's."""
_GROWN: Final = 2
"""By how many of its pixels a silhouette is grown at its edge."""
_MOST_COVERED: Final = 0.6
"""A pose with a larger share of its landmarks on others' silhouettes is the hole that they left, and nobody."""
_MOST_COVERED_TRUNK: Final = 0.85
"""The same for a larger share of its trunk."""
_BODY: Final = slice(11, 33)
"""Landmarks below the head."""
_TRUNK: Final = [LANDMARK_NAMES.index(name) for name in ("leftShoulder", "rightShoulder", "leftHip", "rightHip")]
_DOWN: Final = np.linspace(0.0, 1.0, 4)[:, None, None]
_ACROSS: Final = np.linspace(0.0, 1.0, 4)[None, :, None]


def silhouettes(size: tuple[int, int], poses: Sequence[ModelPose]) -> Bool:
    """Return which pixels of a picture of `size` (width, height) the people of `poses` cover, (H, W)."""
    width, height = size
    covered = np.zeros((height, width), np.bool_)
    for pose in poses:
        inside = pose.mask >= _LEAST_LOGIT
        if not inside.any():
            continue
        mask = inside.copy()
        mask[_GROWN:] |= inside[:-_GROWN]
        mask[:-_GROWN] |= inside[_GROWN:]
        mask[:, _GROWN:] |= inside[:, :-_GROWN]
        mask[:, :-_GROWN] |= inside[:, _GROWN:]
        region = pose.region
        reach = 0.5 * region.size * (abs(math.cos(region.angle)) + abs(math.sin(region.angle)))
        left, top = max(math.floor(region.x - reach), 0), max(math.floor(region.y - reach), 0)
        right, low = min(math.ceil(region.x + reach), width), min(math.ceil(region.y + reach), height)
        if right <= left or low <= top:
            continue
        edge = len(mask)
        scale = edge / region.size
        c, s = scale * math.cos(region.angle), scale * math.sin(region.angle)
        x, y = left - region.x, top - region.y
        placed = Image.fromarray(mask.view(np.uint8)).transform(
            (right - left, low - top), Image.Transform.AFFINE,
            (c, s, c * x + s * y + 0.5 * edge, -s, c, c * y - s * x + 0.5 * edge), Image.Resampling.NEAREST,
        )  # fmt: skip
        covered[top:low, left:right] |= np.asarray(placed).astype(np.bool_)
    return covered


def without(picture: UInt8, covered: Bool) -> UInt8:
    """Return a picture (H, W, 3) with its mean colour where it is `covered` (H, W)."""
    red, green, blue = picture[::8, ::8].reshape(-1, 3).mean(axis=0).astype(int).tolist()
    image = Image.fromarray(picture)
    image.paste((red, green, blue), mask=Image.fromarray(covered.view(np.uint8) * np.uint8(255)))
    return np.asarray(image)


def is_covered(pose: ModelPose, covered: Bool) -> bool:
    """Whether most of a pose, or nearly all of its trunk, lies where the picture was `covered` (H, W): such a pose is
    the hole that was left, or guessed."""
    left, right, hip_left, hip_right = pose.picture[_TRUNK]
    trunk = (left + _DOWN * (hip_left - left)) * (1.0 - _ACROSS) + (right + _DOWN * (hip_right - right)) * _ACROSS
    return (
        float(_at(pose.picture[_BODY], covered).mean()) > _MOST_COVERED
        or float(_at(trunk.reshape(-1, 2), covered).mean()) > _MOST_COVERED_TRUNK
    )


def _at(points: Float64, covered: Bool) -> Bool:
    """Return whether points (n, 2) [pixels] are covered; those outside of the picture are."""
    height, width = covered.shape
    x, y = points[:, 0].astype(np.intp), points[:, 1].astype(np.intp)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    return np.asarray(~inside | covered[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)])
