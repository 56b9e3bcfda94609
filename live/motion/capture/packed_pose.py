"""Packed poses: the engine's skeleton at one moment as 192 ASCII characters, for poses sent over a network.

Hips as three float32 [m], little endian; then each joint's local rotation as its three smallest components, 15 bits
each and 2 bits for the index of the omitted one, big endian: 144 bytes, base64. The engine uses the pose only after
packing, so a live show and its replay from the journal use identical bits. The rotation error is 0.009 degrees at most.
"""

import base64
import binascii
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32
from live.motion.capture.capture_kernels import QUANTIZATION_STEPS, read_rotations
from live.motion.skeleton import JOINT_COUNT

PACKED_LENGTH: Final = 192
"""Number of characters of a packed pose."""
MAX_COORDINATE: Final = 1000.0
"""Largest distance of the hips from the origin along an axis [m]."""
_HIPS_BYTES: Final = 12
_KEPT_COMPONENTS: Final = np.array([(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)], np.intp)
"""The components that are kept when the first, second, … is omitted."""


def pack_pose(hips: npt.ArrayLike, rotation: npt.ArrayLike) -> str:
    """Pack the pose with `hips` (3,) [m] and local unit quaternions `rotation` (J, 4) (w, x, y, z).

    Raises ValueError for an invalid pose: not finite, hips beyond `MAX_COORDINATE`, or rotations of zero length.
    """
    root, turned = np.asarray(hips, np.float64), np.asarray(rotation, np.float64)
    if root.shape != (3,) or turned.shape != (JOINT_COUNT, 4):
        raise ValueError(f"hips {root.shape} and rotation {turned.shape}: (3,) and ({JOINT_COUNT}, 4) expected")
    return pack_poses(root[None], turned[None])[0]


def pack_poses(hips: npt.NDArray[np.floating], rotation: npt.NDArray[np.floating]) -> list[str]:
    """Pack P poses, hips (P, 3) and rotations (P, J, 4), each as `pack_pose` does, in less time."""
    root, turned = hips.astype(np.float64), rotation.astype(np.float64)
    length = np.linalg.norm(turned, axis=-1, keepdims=True)
    if not (np.abs(root) <= MAX_COORDINATE).all() or not ((length > 1e-3) & (length < 1e3)).all():
        raise ValueError("the pose contains an invalid position or rotation")
    turned = (turned / length).reshape(-1, 4)
    rows = np.arange(len(turned))
    left_out = np.abs(turned).argmax(axis=1)
    kept = (
        np.take_along_axis(turned, _KEPT_COMPONENTS[left_out], axis=1)
        * np.where(turned[rows, left_out] < 0.0, -1.0, 1.0)[:, None]
    )
    steps = (np.rint(kept * (np.sqrt(2.0) * QUANTIZATION_STEPS)).astype(np.int64) + QUANTIZATION_STEPS).astype(
        np.uint64
    )
    bits = left_out.astype(np.uint64) << np.uint64(45)
    for place, shift in enumerate((30, 15, 0)):
        bits |= steps[:, place] << np.uint64(shift)
    letters = bits.astype(">u8").view(np.uint8).reshape(len(root), JOINT_COUNT, 8)[:, :, 2:].reshape(len(root), -1)
    places = root.astype("<f4").view(np.uint8).reshape(len(root), -1)
    return [base64.b64encode(row.tobytes()).decode("ascii") for row in np.concatenate([places, letters], axis=1)]


def unpack_pose(text: str) -> tuple[Float32, Float32]:
    """Return hips (3,) [m] and local unit quaternions (J, 4) of a packed pose; raises ValueError if it is invalid."""
    if len(text) != PACKED_LENGTH:
        raise ValueError(f"a packed pose has {PACKED_LENGTH} characters, this has {len(text)}")
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError) as error:
        raise ValueError(f"a packed pose is damaged: {error}") from None
    if len(data) != _HIPS_BYTES + 6 * JOINT_COUNT:
        raise ValueError("a packed pose is damaged: bytes are missing")
    hips = np.frombuffer(data, "<f4", 3).astype(np.float32)
    if not (np.abs(hips) <= MAX_COORDINATE).all():
        raise ValueError("a packed pose has its hips out of range")
    rotation = np.empty((JOINT_COUNT, 4), np.float32)
    read_rotations(rotation, np.frombuffer(bytearray(data[_HIPS_BYTES:]), np.uint8))
    return hips, rotation
