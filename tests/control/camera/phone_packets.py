"""Landmark packets as the phone's page makes them, for tests."""

import struct

import numpy as np

from live.motion.capture.landmarks import LANDMARK_COUNT, Landmarks


def made_landmarks(time: float = 1.5, seed: int = 1) -> Landmarks:
    """A person by chance."""
    chance = np.random.default_rng(seed)
    return Landmarks(
        time=time,
        picture=chance.uniform(-0.5, 1.5, (LANDMARK_COUNT, 2)).astype(np.float32),
        body=chance.uniform(-1.2, 1.2, (LANDMARK_COUNT, 3)).astype(np.float32),
        visibility=chance.uniform(0.0, 1.0, LANDMARK_COUNT).astype(np.float32),
        presence=0.75,
        aspect=4.0 / 3.0,
    )


def phone_packet(time: float, landmarks: Landmarks | None = None, *, count: int = 1, version: int = 1) -> bytes:
    """The packet of a picture, value by value."""
    if landmarks is None:
        return struct.pack("<BBHdBH", version, 0, count, time, 0, 0)
    data = struct.pack(
        "<BBHdBH", version, 1, count, time, round(255 * landmarks.presence), round(4096 * landmarks.aspect)
    )
    for place, body, seen in zip(landmarks.picture, landmarks.body, landmarks.visibility, strict=True):
        data += struct.pack("<hh", *(round(8192 * float(value)) for value in place))
        data += struct.pack("<hhh", *(round(10_000 * float(value)) for value in body))
        data += struct.pack("<B", round(255 * float(seen)))
    return data
