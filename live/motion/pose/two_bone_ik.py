"""Two-bone inverse kinematics for arms and legs, vectorized over samples."""

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion

SOFTNESS = 0.012
"""Last share of a limb's length that is approached asymptotically, so that an overextended limb does not snap
straight."""


def two_bone(
    root: Float,
    target: Float,
    pole: Float,
    *,
    upper: float,
    lower: float,
    softness: float = SOFTNESS,
) -> tuple[Float, Float]:
    """Return positions (..., 3) of the middle joint and the end of a limb from `root` towards `target`.

    `pole` (..., 3) is the direction in which the middle joint points. `upper` and `lower` [m] are the bone lengths. The
    end is exactly on the target while its distance lies between `|upper - lower|` and `1 - softness` of the total
    length; beyond that it falls short smoothly. A target at the root bends the limb away from the pole.
    """
    whole = upper + lower
    soft = softness * whole
    reach = target - root
    distance = np.linalg.norm(reach, axis=-1, keepdims=True)
    pole = quaternion.unit(pole)
    fallback = quaternion.unit(_any_normal(pole))
    direction = np.where(distance > 1e-6, reach / np.maximum(distance, 1e-6), fallback)
    start = whole - soft
    length = np.where(distance > start, whole - soft * np.exp(-np.clip((distance - start) / soft, 0.0, 50.0)), distance)
    length = np.maximum(length, abs(upper - lower) + 1e-4)
    along = (upper * upper - lower * lower + length * length) / (2.0 * length)
    aside = np.sqrt(np.maximum(upper * upper - along * along, 0.0))
    across = pole - direction * np.sum(pole * direction, axis=-1, keepdims=True)
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.where(size > 1e-6, across / np.maximum(size, 1e-6), quaternion.unit(_any_normal(direction)))
    return root + along * direction + aside * across, root + length * direction


def hinge_axis(root: Float, target: Float, pole: Float) -> Float:
    """Return the unit normal (..., 3) of the plane in which a limb from `root` to `target` bends towards `pole`.

    Both bones lie in that plane. The normal determines their twist even where a bone is parallel to the pole.
    """
    normal = np.cross(target - root, pole)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.where(size > 1e-9, normal / np.maximum(size, 1e-9), quaternion.unit(_any_normal(pole)))


def bone_rotation(direction: Float, hinge: Float, rest_direction: Float, rest_hinge: Float) -> Float:
    """Return world rotations (..., 4) that take `rest_direction` to `direction` and `rest_hinge` to `hinge`.

    The hinge need not be normal to the direction; `rest_direction` and `rest_hinge` (3,) must be.
    """
    along = quaternion.unit(direction)
    normal = hinge - along * np.sum(hinge * along, axis=-1, keepdims=True)
    size = np.linalg.norm(normal, axis=-1, keepdims=True)
    normal = np.where(size > 1e-6, normal / np.maximum(size, 1e-6), quaternion.unit(_any_normal(along)))
    posed = quaternion.from_columns(along, np.cross(normal, along), normal)
    rest = quaternion.from_columns(rest_direction, np.cross(rest_hinge, rest_direction), rest_hinge)
    return quaternion.mul(posed, quaternion.inverse(rest))


def _any_normal(vector: Float) -> Float:
    """Return some vector (..., 3) normal to `vector`."""
    size = np.linalg.norm(vector, axis=-1, keepdims=True)
    vector = np.where(size > 1e-9, vector, (0.0, 1.0, 0.0))
    least = np.eye(3)[np.argmin(np.abs(vector), axis=-1)]
    return np.cross(vector, least)
