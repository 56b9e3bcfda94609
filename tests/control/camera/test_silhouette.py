"""Silhouettes: the mask as an upright picture of constant size, and rings in memory that open only when asked for."""

import json
import math
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from live.base.system.picture_ring import FrameRingReader, ring_path
from live.control.camera.camera_process import CameraPlan, CameraProcess
from live.control.camera.performers import Sighting
from live.control.camera.pose_models import ModelPose, Region, crop
from live.control.camera.seen_person import Person
from live.control.camera.silhouette import (
    HELD_S,
    HIPS,
    PIXELS_PER_METRE,
    SIZE,
    SilhouetteRings,
    draw_silhouette,
    pixels_per_metre,
    ring_names,
)
from live.motion.capture.landmarks import LANDMARK_COUNT, LANDMARK_NAMES, Landmarks

UInt8 = npt.NDArray[np.uint8]
memory = pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="memory files are at another place here")
PERFORMER = f"test {os.getpid()} Zoë"
RING = f"camera-test-{os.getpid()}-Zoe"
PICTURE = (480, 640)


def seen_body(
    per_metre: float = 100.0, hips: tuple[float, float] = (300.0, 250.0), region: Region | None = None
) -> ModelPose:
    """A body in the camera's picture: a bar of 0.4 by 1.6 m, its hips 0.9 m above its lower end, with a right arm 0.6 m
    long. The mask is what a model that makes no mistake says of the region."""
    region = region or Region(hips[0], hips[1], 2.6 * per_metre, 0.0)
    picture = np.zeros((*PICTURE, 3), np.uint8)
    for left, top, right, low in ((-0.2, -0.7, 0.2, 0.9), (-0.8, -0.5, -0.2, -0.3)):
        rows = slice(round(hips[1] + top * per_metre), round(hips[1] + low * per_metre))
        picture[rows, round(hips[0] + left * per_metre) : round(hips[0] + right * per_metre)] = 255
    body = np.zeros((LANDMARK_COUNT, 3))
    for name, x, y in (("nose", 0.0, -0.6), ("leftHip", 0.1, 0.0), ("rightHip", -0.1, 0.0), ("leftHeel", 0.1, 0.9)):
        body[LANDMARK_NAMES.index(name)] = x, y, 0.0
    places = body[:, :2] * per_metre + hips
    mask = 10.0 * crop(picture, region, 256)[:, :, 0] - 5.0
    return ModelPose(places, body, np.ones(LANDMARK_COUNT), 1.0, region, region, mask.astype(np.float32))


def drawn(pose: ModelPose, scale: float) -> UInt8:
    picture = np.full((SIZE[1], SIZE[0], 3), 77, np.uint8)
    draw_silhouette(pose, scale, picture)
    assert (picture[:, :, 0] == picture[:, :, 1]).all()
    assert (picture[:, :, 0] == picture[:, :, 2]).all()
    return picture[:, :, 0]


def expected() -> UInt8:
    """The same body, drawn where it has to be."""
    picture = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    for left, top, right, low in ((-0.2, -0.7, 0.2, 0.9), (-0.8, -0.5, -0.2, -0.3)):
        x, y = np.round(np.array(((left, top), (right, low))) * PIXELS_PER_METRE + HIPS).astype(int).T
        picture[y[0] : y[1], x[0] : x[1]] = 255
    return picture


def overlap(first: UInt8, second: UInt8) -> float:
    """Intersection over union of two silhouettes."""
    one, other = first > 127, second > 127
    return float((one & other).sum() / (one | other).sum())


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.8, math.pi / 2, 3.0])
def test_silhouette_is_upright_whatever_the_regions_rotation(angle: float) -> None:
    pose = seen_body(region=Region(310.0, 240.0, 300.0, angle))
    picture = drawn(pose, 100.0)
    assert overlap(picture, expected()) > 0.95
    assert picture[round(HIPS[1]), round(HIPS[0])] == 255
    assert picture[0].max() == picture[:, 0].max() == picture[:, -1].max() == 0


@pytest.mark.parametrize(
    ("per_metre", "hips"), [(60.0, (120.0, 150.0)), (100.0, (320.0, 240.0)), (150.0, (400.0, 250.0))]
)
def test_person_keeps_their_size_near_and_far(per_metre: float, hips: tuple[float, float]) -> None:
    pose = seen_body(per_metre, hips)
    assert pixels_per_metre(pose) == pytest.approx(per_metre, rel=1e-6)
    assert overlap(drawn(pose, pixels_per_metre(pose)), expected()) > 0.94


def test_edge_is_soft_and_nothing_is_invented_beside_the_mask() -> None:
    pose = seen_body()
    grey = drawn(pose, 100.0)
    edge = (grey > 0) & (grey < 255)
    assert 0 < edge.sum() < 0.1 * (grey > 0).sum()
    pose.mask[:] = 9.0  # the whole region is body: a square, which ends where the region ends
    square = drawn(pose, 200.0) > 127
    side = pose.region.size * PIXELS_PER_METRE / 200.0
    assert square.any(axis=0).sum() == pytest.approx(side, abs=2.0)
    assert square.any(axis=1).sum() == pytest.approx(side, abs=2.0)
    pose.mask[:] = np.nan
    assert drawn(pose, 100.0).max() == 0


def test_ring_names_are_allowed_and_distinct() -> None:
    names = ring_names(["anna", "Zoë", "Zoe", "an/../na", "x" * 64, "x" * 63 + "y", "日本"])
    assert names["anna"] == "camera-anna"
    assert (names["Zoë"], names["Zoe"]) == ("camera-Zoe", "camera-Zoe-2")
    assert len(set(names.values())) == len(names)
    for each in names.values():
        ring_path(each)


@pytest.fixture
def rings() -> Iterator[SilhouetteRings]:
    rings = SilhouetteRings([PERFORMER])
    yield rings
    rings.close()


@memory
def test_ring_holds_the_silhouette_and_is_black_when_nobody_is_seen(rings: SilhouetteRings) -> None:
    assert rings.names == [RING]
    assert ring_path(RING).stat().st_mode & 0o077 == 0, "for this user alone"
    reader = FrameRingReader(RING)
    assert reader.size == SIZE
    first = reader.read()
    assert first is not None
    assert first.max() == 0
    rings.show(PERFORMER, 0, Person(1, seen_body(), 1.0, 0.0), now=1.05)
    picture = reader.read()
    assert picture is not None
    assert overlap(picture[:, :, 1], expected()) > 0.95
    rings.darken_unseen(1.05 + 0.9 * HELD_S)
    assert reader.read() is None, "a gap as short as that is not seen"
    rings.darken_unseen(1.05 + 1.1 * HELD_S)
    black = reader.read()
    assert black is not None
    assert black.max() == 0
    rings.darken_unseen(9.0)
    assert reader.read() is None, "black once"
    rings.show(PERFORMER, 0, Person(1, seen_body(), 9.0, 0.0), now=9.0)
    rings.close()
    last = reader.read()
    assert last is not None
    assert last.max() == 0, "whoever keeps the last picture keeps black"
    assert not reader.is_open
    assert not ring_path(RING).exists()
    reader.close()


@memory
def test_second_camera_takes_over_only_when_the_first_has_lost_them(rings: SilhouetteRings) -> None:
    reader = FrameRingReader(RING)
    rings.show(PERFORMER, 0, Person(1, seen_body(), 1.0, 0.0), now=1.0)
    assert reader.read() is not None
    rings.show(PERFORMER, 1, Person(7, seen_body(60.0), 1.1, 0.0), now=1.1)
    assert reader.read() is None
    rings.show(PERFORMER, 1, Person(7, seen_body(60.0), 1.5, 0.0), now=1.5)
    picture = reader.read()
    assert picture is not None
    assert overlap(picture[:, :, 0], expected()) > 0.9, "with the size that the second camera sees"
    reader.close()


@memory
def test_rings_follow_another_patchs_performers(rings: SilhouetteRings) -> None:
    kept, other = FrameRingReader(RING), f"other {os.getpid()}"
    rings.rename([PERFORMER, other])
    assert rings.names == [RING, f"camera-other-{os.getpid()}"]
    assert kept.is_open
    rings.rename([other])
    assert not kept.is_open
    assert rings.names == [f"camera-other-{os.getpid()}"]
    rings.show(PERFORMER, 0, Person(1, seen_body(), 1.0, 0.0), now=1.0)  # a picture that was on its way
    kept.close()


@memory
def test_foreign_file_is_told_and_left_alone() -> None:
    path = ring_path(RING)
    path.write_text("somebody's own file")
    try:
        rings = SilhouetteRings([PERFORMER])
        assert "no ring buffer" in rings.problem
        assert rings.names == []
        rings.close()
        assert path.read_text() == "somebody's own file"
    finally:
        path.unlink()


@memory
def test_silhouette_of_a_killed_process_is_shown_to_nobody() -> None:
    """The file stays behind with a body in it; who opens it later must not see her."""
    code = (
        "import sys, numpy as np; from live.base.system.picture_ring import FrameRing; "
        f"r = FrameRing({RING!r}, (40, 48), private=True); r.write(np.full((48, 40, 3), 255, np.uint8), 1.0); "
        "print('ready', flush=True); sys.stdin.read()"
    )
    child = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdout is not None
    assert child.stdin is not None
    try:
        assert child.stdout.readline() == b"ready\n"
        reader = FrameRingReader(RING)
        assert reader.is_open
        child.send_signal(signal.SIGKILL)
        child.wait(10)
        assert not reader.is_open, "a reader who was there knows at once"
        reader.close()
        with pytest.raises(OSError, match="killed"):
            FrameRingReader(RING)
        again = SilhouetteRings([PERFORMER])  # the next camera process begins black
        fresh = FrameRingReader(RING)
        picture = fresh.read()
        assert picture is not None
        assert picture.max() == 0
        fresh.close()
        again.close()
        assert not ring_path(RING).exists()
    finally:
        child.kill()
        child.wait(10)
        child.stdin.close()
        child.stdout.close()
        ring_path(RING).unlink(missing_ok=True)


class Channel:
    """The process's end of a channel to no show."""

    def __init__(self, silhouette: bool) -> None:
        camera = CameraPlan(name="front", kind="film", place="/nowhere.mp4", silhouette=silhouette)
        self.plan: dict[str, Any] = {
            "cameras": [camera.as_packet()], "performers": [PERFORMER], "most": 1, "origin": 0.0, "model": "full",
        }  # fmt: skip


def _landmarks_of_a_dancer() -> Landmarks:
    """What the model saw of one of the project's own dancers."""
    (told, *_) = json.loads((Path(__file__).parent / "mediapipe_landmarks.json").read_text())
    picture, body = (np.array(told[key], np.float32) for key in ("picture", "body"))
    seen = np.array(told["visibility"], np.float32)
    return Landmarks(time=1.0, picture=picture, body=body, visibility=seen, presence=1.0, aspect=4 / 3)


@memory
@pytest.mark.parametrize("asked", [False, True])
def test_nothing_is_published_unless_asked(asked: bool) -> None:
    process = CameraProcess(Channel(asked))  # type: ignore[arg-type]
    worker = process.workers[0]
    landmarks = _landmarks_of_a_dancer()
    places = landmarks.picture.astype(np.float64) * PICTURE[::-1]
    body, region = landmarks.body.astype(np.float64), Region(320.0, 240.0, 400.0, 0.0)
    mask = np.full((256, 256), 9.0, np.float32)
    pose = ModelPose(places, body, np.ones(LANDMARK_COUNT), 1.0, region, region, mask)
    process.publish(worker, [Person(1, pose, 1.0, 0.0)])
    assert ring_path(RING).exists() == asked
    assert process.facts().get("silhouettes") == ([RING] if asked else None)
    if asked:
        reader = FrameRingReader(RING)
        black = reader.read()
        assert black is not None
        assert black.max() == 0, "a person without a performer's name is not published"
        assert process.performers.update(0, None, [Sighting(1, landmarks)], now=1.03)
        process.publish(worker, [Person(1, pose, 0.9, 0.0)])
        assert reader.read() is None, "a picture in which the show did not take them for a performer"
        process.publish(worker, [Person(1, pose, 1.0, 0.0)])
        picture = reader.read()
        assert picture is not None
        assert picture.max() == 255
        reader.close()
        process._silhouettes.close()  # type: ignore[union-attr]
    assert not ring_path(RING).exists()
