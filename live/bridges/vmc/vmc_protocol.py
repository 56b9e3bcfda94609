"""VMC (Virtual Motion Capture protocol) reader and writer: poses of performers and dancers as OSC over UDP.

Messages, in bundles or not: `/VMC/Ext/Bone/Pos name px py pz qx qy qz qw` with Unity's names of human bones, the offset
from the parent [m] and the local rotation; `/VMC/Ext/Root/Pos` likewise for the body's position; `/VMC/Ext/OK` for the
tracking state; `/VMC/Ext/T` for the sender's time [s]. The reader ignores unknown messages and surplus arguments. It
refuses and counts messages with missing or wrong arguments, each on its own. Its work is linear in the packet's length,
and no input raises an exception.

The engine's skeleton has the protocol's rest pose (a T-pose that faces forward), so local rotations are sent unchanged.
Unity's axes are left-handed, so x is mirrored in both directions.

Source: sh-akira/VirtualMotionCaptureProtocol, performer to marionette.
"""

import math
import struct
from collections.abc import Iterator
from typing import Final, Protocol

import numpy as np

from live.base.arrays import Float
from live.control.osc.osc_codec import MAX_BUNDLE_DEPTH, OscRejected, Value, bundles, decode, encode
from live.control.registry.rejections import Reason, Tally
from live.motion.skeleton import JOINT_COUNT, SKELETON

MAX_PACKET_BYTES: Final = 16384
MAX_ELEMENTS: Final = 256
MAX_OFFSET: Final = 100.0
"""Maximum distance of a bone from its parent [m]."""
UNIT_RANGE: Final = (0.81, 1.21)
"""Range of squared lengths accepted as a unit quaternion."""
UNUSED_BONE: Final = -1
"""Marks bones that the engine's skeleton lacks: eyes, jaw, fingers."""
_FINGERS: Final = ("Thumb", "Index", "Middle", "Ring", "Little")
_UNUSED_NAMES: Final = (
    "LeftEye", "RightEye", "Jaw", "LastBone",
    *(
        side + finger + part
        for side in ("Left", "Right")
        for finger in _FINGERS
        for part in ("Proximal", "Intermediate", "Distal")
    ),
)  # fmt: skip
BONES: Final[dict[str, int]] = {name.casefold(): index for index, name in enumerate(SKELETON.names)} | dict.fromkeys(
    (name.casefold() for name in _UNUSED_NAMES), UNUSED_BONE
)
"""Joint of the engine's skeleton by the bone's name in lower case."""

Bone = tuple[float, float, float, float, float, float, float]
"""Offset from the parent x, y, z [m] and rotation w, x, y, z, in the engine's axes."""

_BUNDLE: Final = b"#bundle\0"
_SIZE: Final = struct.Struct(">i")
_POSE: Final = struct.Struct(">7f")
_BONE: Final = b"/VMC/Ext/Bone/Pos\0\0\0,sfffffff\0\0\0"


def _padded(name: str) -> bytes:
    return name.encode() + b"\0" * (4 - len(name) % 4)


_BY_BYTES: Final = {
    _padded(name[0].upper() + name[1:]): BONES[name.casefold()] for name in (*SKELETON.names, *_UNUSED_NAMES)
}


class Listener(Protocol):
    """Receiver of a packet's content."""

    def bone(self, joint: int, bone: Bone) -> None:
        """Receive the pose of a joint of the engine's skeleton."""
        ...

    def root(self, bone: Bone) -> None:
        """Receive the body's position."""
        ...

    def tracked(self, on: bool) -> None:
        """Receive whether the data is valid."""
        ...

    def sender_time(self, time: float) -> None:
        """Receive the sender's time [s]."""
        ...


def decode_vmc(data: bytes, listener: Listener, tally: Tally) -> None:
    """Decode a packet for `listener`; refused messages are counted."""
    if not 0 < len(data) <= MAX_PACKET_BYTES:
        tally.count(Reason.PACKET_SIZE)
        return
    if len(data) & 3:
        tally.count(Reason.ALIGNMENT)
        return
    count = 0
    try:
        for start, stop in _messages(data, 0, len(data), 0):
            count += 1
            if count > MAX_ELEMENTS:
                raise OscRejected(Reason.MANY_MESSAGES)
            if data.startswith(_BONE, start):
                joint = _BY_BYTES.get(data[start + len(_BONE) : stop - _POSE.size])
                if joint is not None:
                    if joint != UNUSED_BONE:
                        _pass_bone(joint, _POSE.unpack_from(data, stop - _POSE.size), listener, tally)
                    continue
            _pass_message(data[start:stop], listener, tally)
    except OscRejected as error:
        tally.count(error.reason)


def _messages(data: bytes, start: int, stop: int, depth: int) -> Iterator[tuple[int, int]]:
    """Return begin and end of each message in a packet; OscRejected if a bundle is broken."""
    if data[start] != 0x23:  # "#"
        yield start, stop
        return
    if depth >= MAX_BUNDLE_DEPTH:
        raise OscRejected(Reason.DEPTH)
    if stop - start < 16:
        raise OscRejected(Reason.TRUNCATED)
    if data[start : start + 8] != _BUNDLE:
        raise OscRejected(Reason.ADDRESS)
    place = start + 16
    while place < stop:
        (size,) = _SIZE.unpack_from(data, place)  # all lengths are multiples of 4, so four bytes are present
        place += 4
        if size <= 0 or size & 3 or size > stop - place:
            raise OscRejected(Reason.ELEMENT_SIZE)
        yield from _messages(data, place, place + size, depth + 1)
        place += size


def _pass_bone(joint: int | None, values: tuple[float, ...], listener: Listener, tally: Tally) -> None:
    """Pass on a bone, or the root (None), if its numbers are valid."""
    x, y, z, i, j, k, w = values
    square = i * i + j * j + k * k + w * w
    if not math.isfinite(x + y + z + square):
        tally.count(Reason.NOT_FINITE)
        return
    if not UNIT_RANGE[0] <= square <= UNIT_RANGE[1] or max(abs(x), abs(y), abs(z)) > MAX_OFFSET:
        tally.count(Reason.OUT_OF_RANGE)
        return
    size = math.sqrt(square)
    bone = (-x, y, z, w / size, i / size, -j / size, -k / size)
    if joint is None:
        listener.root(bone)
    else:
        listener.bone(joint, bone)


def _pass_message(data: bytes, listener: Listener, tally: Tally) -> None:
    """Handle any other message, or a bone in an unusual encoding."""
    try:
        message = decode(data)[0]
    except OscRejected as error:
        tally.count(error.reason)
        return
    values = message.arguments
    match message.address:
        case "/VMC/Ext/Bone/Pos" | "/VMC/Ext/Root/Pos":
            pose = _pose(values, tally)
            if pose is None:
                return
            if message.address == "/VMC/Ext/Root/Pos":
                _pass_bone(None, pose, listener, tally)
                return
            joint = BONES.get(str(values[0]).casefold())
            if joint is None:
                tally.count(Reason.NAME)
            elif joint != UNUSED_BONE:
                _pass_bone(joint, pose, listener, tally)
        case "/VMC/Ext/OK":
            _pass_state(values, listener, tally)
        case "/VMC/Ext/T":
            if not values:
                tally.count(Reason.MISSING)
            elif type(values[0]) is not float:
                tally.count(Reason.WRONG_TYPE)
            else:
                listener.sender_time(values[0])
        case address if not address.startswith("/VMC/"):
            tally.count(Reason.UNKNOWN_ADDRESS)


def _pose(values: tuple[Value, ...], tally: Tally) -> tuple[float, ...] | None:
    """Return the seven numbers after a name; None, counted, if they are missing."""
    if len(values) < 8:
        tally.count(Reason.MISSING)
        return None
    pose = tuple(value for value in values[1:8] if type(value) is float)
    if len(pose) < 7 or type(values[0]) is not str:
        tally.count(Reason.WRONG_TYPE)
        return None
    return pose


def _pass_state(values: tuple[Value, ...], listener: Listener, tally: Tally) -> None:
    """Handle `OK loaded [calibration mode [tracking]]`: invalid if not loaded, calibrating, or poorly tracked."""
    if not values:
        tally.count(Reason.MISSING)
    elif any(type(value) is not int for value in values[:4]):
        tally.count(Reason.WRONG_TYPE)
    else:
        calibrates = len(values) > 1 and values[1] in (1, 2)
        loses = len(values) > 3 and values[3] == 0
        listener.tracked(values[0] == 1 and not calibrates and not loses)


_UNITY: Final = np.array((-1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0))
"""Signs of position x, y, z and rotation x, y, z, w."""
_ROWS: Final = struct.Struct(">7f")
_HEADS: Final = [
    encode("/VMC/Ext/Bone/Pos", (name[0].upper() + name[1:], *[0.0] * 7))[: -_ROWS.size] for name in SKELETON.names
]
_STATE_MESSAGES: Final = (
    encode("/VMC/Ext/OK", (1, 3, 0, 1)),
    encode("/VMC/Ext/Root/Pos", ("root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
)
_OFFSETS: Final = SKELETON.offsets.astype(np.float64)


def vmc_packets(hips: Float, rotation: Float, time: float) -> Iterator[bytes]:
    """Return the datagrams of a pose: `hips` (3,) [m] and local rotations (J, 4) (w, x, y, z), at `time` [s]."""
    rows = np.empty((JOINT_COUNT, 7))
    rows[:, :3] = _OFFSETS
    rows[0, :3] = hips
    rows[:, 3:6], rows[:, 6] = rotation[:, 1:], rotation[:, 0]
    bones = (head + _ROWS.pack(*row) for head, row in zip(_HEADS, (rows * _UNITY).tolist(), strict=True))
    yield from bundles((*_STATE_MESSAGES, *bones, encode("/VMC/Ext/T", (float(time),))))
