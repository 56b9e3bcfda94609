"""What is sent by the VMC protocol: a dancer as a performer's program sends her, in bundles that fit into a datagram.

The engine's skeleton has the rest pose that the protocol's bones are counted from (a T-pose that faces forward), so its
local rotations are sent as they are, in Unity's left-handed axes: x is turned over.
"""

import struct
from collections.abc import Iterator
from typing import Final

import numpy as np
import numpy.typing as npt

from live.control.osc.osc_encode import bundles, encode
from live.motion.skeleton import JOINT_COUNT, SKELETON

Float = npt.NDArray[np.floating]

_UNITY: Final = np.array((-1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0))
"""Signs of place x, y, z and rotation x, y, z, w."""
_ROWS: Final = struct.Struct(">7f")
_HEADS: Final = [
    encode("/VMC/Ext/Bone/Pos", (name[0].upper() + name[1:], *[0.0] * 7))[: -_ROWS.size] for name in SKELETON.names
]
_STANDS: Final = (
    encode("/VMC/Ext/OK", (1, 3, 0, 1)),
    encode("/VMC/Ext/Root/Pos", ("root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
)
_OFFSETS: Final = SKELETON.offsets.astype(np.float64)


def vmc_packets(hips: Float, rotation: Float, time: float) -> Iterator[bytes]:
    """Datagrams that say a pose: `hips` (3,) [m] and local rotations (J, 4) (w, x, y, z), at `time` [s]."""
    rows = np.empty((JOINT_COUNT, 7))
    rows[:, :3] = _OFFSETS
    rows[0, :3] = hips
    rows[:, 3:6], rows[:, 6] = rotation[:, 1:], rotation[:, 0]
    bones = (head + _ROWS.pack(*row) for head, row in zip(_HEADS, (rows * _UNITY).tolist(), strict=True))
    yield from bundles((*_STANDS, *bones, encode("/VMC/Ext/T", (float(time),))))
