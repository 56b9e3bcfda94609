"""Tests of the packets in which phones send landmarks."""

import struct

import numpy as np
import pytest

from live.control.camera.phone_landmarks import EMPTY_BYTES, PACKET_BYTES, PhoneCameras, decode_landmarks
from tests.control.camera.phone_packets import made_landmarks, phone_packet


def test_packets_keep_a_person_to_the_promised_precision() -> None:
    sent = made_landmarks(time=1234.5678901)
    packet = phone_packet(sent.time, sent, count=65_535)
    assert len(packet) == PACKET_BYTES == 378
    picture = decode_landmarks(packet)
    found = picture.landmarks
    assert found is not None
    assert (picture.count, picture.time, found.time) == (65_535, sent.time, sent.time)
    assert np.abs(found.picture - sent.picture).max() < 7e-5
    assert np.abs(found.body - sent.body).max() < 6e-5
    assert np.abs(found.visibility - sent.visibility).max() < 0.002
    assert found.presence == pytest.approx(sent.presence, abs=0.002)
    assert found.aspect == pytest.approx(sent.aspect, abs=2e-4)
    assert {found.picture.dtype, found.body.dtype, found.visibility.dtype} == {np.dtype(np.float32)}


def test_packet_without_a_person_is_short() -> None:
    packet = phone_packet(3.25, count=7)
    assert len(packet) == EMPTY_BYTES == 15
    picture = decode_landmarks(packet)
    assert (picture.count, picture.time, picture.landmarks) == (7, 3.25, None)


def test_hostile_packets_are_refused_with_a_reason() -> None:
    good = phone_packet(1.5, made_landmarks())
    head = good[:EMPTY_BYTES]
    for wrong, reason in (
        (b"", "bytes expected"),
        (good[:-1], "bytes expected"),
        (good + b"\0", "bytes expected"),
        (phone_packet(1.5, version=2), "another version"),
        (b"\1\1" + phone_packet(1.5)[2:], "do not agree"),
        (b"\1\0" + good[2:], "do not agree"),
        (b"\1\2" + good[2:], "do not agree"),
        (head[:4] + struct.pack("<d", float("nan")) + good[12:], "capture time"),
        (head[:4] + struct.pack("<d", float("inf")) + good[12:], "capture time"),
        (head[:4] + struct.pack("<d", -1.0) + good[12:], "capture time"),
        (head[:4] + struct.pack("<d", 1e300) + good[12:], "capture time"),
        (head[:13] + struct.pack("<H", 0) + good[15:], "shape"),
        (head[:13] + struct.pack("<H", 65_535) + good[15:], "shape"),
    ):
        with pytest.raises(ValueError, match=reason):
            decode_landmarks(wrong)


def test_any_bytes_are_a_bounded_person_or_refused() -> None:
    chance = np.random.default_rng(7)
    good = np.frombuffer(phone_packet(1.5, made_landmarks()), np.uint8)
    read = 0
    for _ in range(2000):
        data = good.copy()
        data[chance.integers(len(data), size=4)] = chance.integers(256, size=4)
        try:
            found = decode_landmarks(data.tobytes()).landmarks
        except ValueError:
            continue
        read += 1
        assert found is not None
        assert np.isfinite(found.picture).all()
        assert np.abs(found.picture).max() <= 4.0
        assert np.abs(found.body).max() <= 3.2768
        assert found.visibility.max() <= 1.0
    assert read > 1000


def test_packets_go_to_every_handler_in_order() -> None:
    phones, heard = PhoneCameras(), []
    for number in range(2):
        phones.handlers.append(lambda *told, number=number: heard.append((number, *told)))
    phones.take("phone 1", "anna", b"x", 2.0)
    phones.take("phone 2", "ben", b"y", 3.0)
    assert heard == [
        (0, "phone 1", "anna", b"x", 2.0), (1, "phone 1", "anna", b"x", 2.0),
        (0, "phone 2", "ben", b"y", 3.0), (1, "phone 2", "ben", b"y", 3.0),
    ]  # fmt: skip
    assert phones.packets == 2
