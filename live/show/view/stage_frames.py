"""Frames of the stage for pages, in binary: positions and headings, or joints, of all dancers at one tick.

A frame is u8 kind, u8 flags, u16 count, u32 tick, then int16, all little-endian. Kind 1: x, z [mm], heading
[1/10,000 turn] and state of each dancer (0: not on the stage, else the number of their group, from 1). Kind 2: the
joints of each dancer, x, y, z [mm]. What is too far away for an int16 stands at its border. Kind 3, the waveform of the
music: count is the number of peaks a second, tick their number, and each peak a u8. Kind 5, a PDF: tick is its length,
and its bytes follow. (Kind 4 is the projected picture.)
"""

import struct
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int32

POSITIONS, JOINTS, WAVEFORM, DOCUMENT = 1, 2, 3, 5
"""Kinds of frames."""
CHOSEN: Final = 1
"""Flag of a frame with joints of chosen dancers only, in the order in which they were asked for."""
MAX_JOINT_DANCERS: Final = 450
"""Maximum number of dancers in a frame with joints: a packet has 64 KiB."""
MAX_POSITION_DANCERS: Final = 8000
_HEAD: Final = struct.Struct("<BBHI")
_LIMIT: Final = 32767


def _int16(values: npt.NDArray[np.floating]) -> bytes:
    whole: npt.NDArray[np.int16] = np.clip(np.rint(values), -_LIMIT, _LIMIT).astype("<i2")
    return whole.tobytes()


def positions_frame(tick: int, place: Float32, heading: Float32 | Float64, state: Int32) -> bytes:
    """Return the frame of A dancers, `MAX_POSITION_DANCERS` at most: `place` (A, 2) [m], `heading` (A,) [rad],
    `state` (A,): 0 for those who are not on the stage, else the number of their group, from 1."""
    count = min(len(place), MAX_POSITION_DANCERS)
    rows = np.empty((count, 4), np.float64)
    rows[:, :2] = place[:count] * 1e3
    rows[:, 2] = heading[:count] * (10_000 / (2.0 * np.pi))
    rows[:, 3] = state[:count]
    return _HEAD.pack(POSITIONS, 0, count, tick & 0xFFFFFFFF) + _int16(rows)


def joints_frame(tick: int, joints: Float32, dancers: list[int] | None = None) -> bytes:
    """Return the frame of joints (A, J, 3) [m]: of all, or of these dancers (from 1; numbers of nobody are left out),
    `MAX_JOINT_DANCERS` at most."""
    rows = None if not dancers else [each - 1 for each in dancers if type(each) is int and 1 <= each <= len(joints)]
    found = (joints if rows is None else joints[rows])[:MAX_JOINT_DANCERS]
    flags = 0 if rows is None else CHOSEN
    return _HEAD.pack(JOINTS, flags, len(found), tick & 0xFFFFFFFF) + _int16(found * 1e3)


def waveform_frame(rate: int, peaks: npt.NDArray[np.uint8]) -> bytes:
    """Return the frame of a waveform (n,) with `rate` peaks a second."""
    return _HEAD.pack(WAVEFORM, 0, rate, len(peaks)) + peaks.tobytes()


def document_frame(pdf: bytes) -> bytes:
    """Return the frame of a PDF."""
    return _HEAD.pack(DOCUMENT, 0, 0, len(pdf)) + pdf
