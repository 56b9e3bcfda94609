"""Live inputs: shared memory and network streams as this program writes them, cables that are pulled, wrong names."""

import os
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.stage_snapshot import parse_input
from live.base.system.picture_ring import FrameRing, FrameRingReader, ring_path
from live.render.film.network_stream import NetworkStream
from live.render.media.live_input import INPUT_SIZE, LiveInput
from tests.control.waiting import wait_for
from tests.render.film.test_network_stream import free_port

WIDTH, HEIGHT = 64, 36
memory = pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="memory files are at another place here")


def grey(level):
    return np.full((HEIGHT, WIDTH, 3), level, np.uint8)


def level_of(found):
    """Wait for a picture of an input and return its mean level."""
    seen = []

    def look():
        picture = found.picture_at(0.0)
        if picture is not None:
            seen.append(picture)
        return picture is not None

    assert wait_for(look, 10.0), found.problem
    assert seen[-1].shape == (INPUT_SIZE[1], INPUT_SIZE[0], 3)
    return float(seen[-1].mean())


@memory
def test_shared_memory_is_shown_again_after_its_writer_came_back():
    name = f"choreographics-input-{os.getpid()}"
    found = LiveInput(f"shm:{name}")
    assert wait_for(lambda: "tried again" in found.problem, 5.0)
    for level in (200, 90):
        ring = FrameRing(name, (WIDTH, HEIGHT))
        ring.write(grey(level), 0.0)
        assert level_of(found) == pytest.approx(level, abs=2.0)
        assert found.problem == ""
        assert found.picture_at(0.0) is None  # each picture once
        assert found.aspect == pytest.approx(WIDTH / HEIGHT)
        ring.close()
        assert wait_for(lambda: found.problem != "", 5.0)
    found.close()


@memory
def test_ring_reader_refuses_foreign_files():
    name = f"choreographics-foreign-{os.getpid()}"
    path = ring_path(name)
    try:
        for content in (b"no ring", b"CGLPIC01" + b"\xff" * 5000, b"CGLPIC01" + b"\0" * 100):
            path.write_bytes(content)
            with pytest.raises(OSError, match="ring buffer"):
                FrameRingReader(name)
    finally:
        path.unlink()
    with pytest.raises(FileNotFoundError):
        FrameRingReader(name)


@pytest.mark.long
def test_network_stream_of_another_show_is_shown():
    port = free_port()
    found = LiveInput(f"udp://127.0.0.1:{port}")
    sender = NetworkStream(f"udp://127.0.0.1:{port}", size=(320, 180), fps=25)
    picture = np.full((180, 320, 3), 160, np.uint8)
    number = 0

    def received():
        nonlocal number
        sender.write(picture, number)
        number += 1
        return found.received > 0

    assert wait_for(received, 30.0), found.problem
    assert level_of(found) == pytest.approx(160, abs=8.0)
    sender.close()
    found.close()


def test_camera_that_is_not_there_is_told_and_stops_nothing():
    found = LiveInput("camera:63")
    assert wait_for(lambda: "tried again" in found.problem, 5.0)
    assert found.picture_at(1.0) is None
    found.close()
    assert not found._thread.is_alive()


@pytest.mark.parametrize("text", ["", "camera", "camera: ", "shm:", "shm:../etc", "file:///etc/passwd", "concat:a|b"])
def test_wrong_inputs_are_refused_with_a_remedy(text):
    with pytest.raises(PersonError, match=r"no live input.*camera:0"):
        parse_input(text)


def test_inputs_have_kind_and_name():
    assert parse_input("camera:0") == ("camera", "0")
    assert parse_input("shm:stage-2") == ("shm", "stage-2")
    assert parse_input("udp://0.0.0.0:5000") == ("stream", "udp://0.0.0.0:5000")
