"""Orders on their way to the process that plays the music: measure lines, many or corrected, and music to decode."""

import json
import socket
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from live.app.processes import audio_main
from live.app.processes.audio_client import AudioClient, prepare_music
from live.app.processes.audio_main import AudioWorker, EventSender
from live.base.event_queue import EventQueue
from live.clock.map_clock import MapClock
from live.clock.measure_map import MeasureMap, steady_map
from live.clock.time_source import SystemClock
from live.control.audio.music_file import MusicFileError
from live.control.events.events import ControlEvent
from live.show.venue.venue import Latencies


class Ends:
    """Both ends of the channel; the process' end reads when the test says so."""

    def __init__(self) -> None:
        ours, self.theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.theirs.setblocking(False)
        show: Any = SimpleNamespace(follower=SimpleNamespace(on_hint=None), seed_tracker=lambda told: None)
        inbox = cast("EventQueue[ControlEvent]", EventQueue())
        self.client = AudioClient(ours.detach(), {}, show, Latencies(), inbox, SystemClock(0.0), resumed=None)
        self.worker = AudioWorker(EventSender(self.theirs))
        self.worker._measures = self.known = MapClock(None, 60.0)

    def close(self) -> None:
        self.client.stop()
        self.theirs.close()

    def read(self) -> int:
        """Have the process read all that is there; return the number of packets."""
        count = 0
        while True:
            try:
                order = self.theirs.recv(1 << 16)
            except BlockingIOError:
                return count
            self.worker.handle_order(json.loads(order))
            count += 1


@pytest.fixture
def ends() -> Iterator[Ends]:
    made = Ends()
    yield made
    made.close()


def test_a_day_of_music_arrives_in_parts_though_the_channel_is_full_meanwhile(ends: Ends) -> None:
    measures = steady_map(120.0, 0.25, 4, 20_000)
    ends.client.set_measures(measures)
    ends.client.frame()
    assert not ends.known.is_known
    frames = 0
    while not ends.known.is_known:
        ends.read()
        ends.client.frame()
        frames += 1
        assert frames < 100
    assert frames > 1  # it did not fit at once
    assert list(ends.known.until(19.3)) == list(MapClock(measures, 60.0).until(19.3))


def test_corrected_lines_replace_the_former_ones_and_the_same_ones_are_not_sent(ends: Ends) -> None:
    for measures in (steady_map(120.0, 0.0, 4, 700), steady_map(100.0, 0.5, 3, 40)):
        ends.client.set_measures(measures)
        ends.client.frame()
        assert ends.read() == -(-len(measures.lines) // 500)
        assert list(ends.known.until(9.0)) == list(MapClock(measures, 60.0).until(9.0))
        ends.client.set_measures(MeasureMap(measures.lines))
        ends.client.frame()
        assert ends.read() == 0
    ends.client.set_measures(None)
    ends.client.frame()
    ends.read()
    assert not ends.known.is_known


class _SilentPlayer:
    """A player without a device that tells its music."""

    def __init__(self, music: Any, *_arguments: Any, **_settings: Any) -> None:
        self.music = music

    def start(self, *, begun: float) -> None:
        """Start nothing."""


PLAN = {
    "origin": 0.0, "latency": [0.0, 0.0], "begun": 1.0, "metres": [4], "likely_bpm": None, "tracker": "network",
    "output": None, "one_at": None, "device": None, "channels": "1",
}  # fmt: skip


def test_music_is_decoded_once_while_the_show_is_built(ends: Ends, tmp_path: Path, monkeypatch: Any) -> None:
    decoded: list[Path] = []
    music = SimpleNamespace(duration=60.0)
    monkeypatch.setattr(audio_main, "read_music", lambda path: decoded.append(path) or music)
    monkeypatch.setattr(audio_main, "MusicPlayer", _SilentPlayer)
    song = tmp_path / "song.ogg"
    prepare_music(ends.client._socket.fileno(), song)
    assert ends.read() == 1
    assert decoded == [song]
    ends.worker.handle_order({"start": PLAN | {"music": str(song)}})
    assert isinstance(ends.worker._source, _SilentPlayer)
    assert ends.worker._source.music is music
    assert decoded == [song]


@pytest.mark.parametrize("prepared", ["other.ogg", "broken.ogg"])
def test_music_that_was_not_prepared_is_decoded_at_the_start(
    ends: Ends, tmp_path: Path, monkeypatch: Any, prepared: str
) -> None:
    def read(path: Path) -> Any:
        if path.name == "broken.ogg":
            raise MusicFileError("it is broken")
        return SimpleNamespace(duration=60.0, path=path)

    monkeypatch.setattr(audio_main, "read_music", read)
    monkeypatch.setattr(audio_main, "MusicPlayer", _SilentPlayer)
    prepare_music(ends.client._socket.fileno(), tmp_path / prepared)
    ends.read()
    ends.worker.handle_order({"start": PLAN | {"music": str(tmp_path / "song.ogg")}})
    assert isinstance(ends.worker._source, _SilentPlayer)
    assert ends.worker._source.music.path == tmp_path / "song.ogg"


def test_broken_music_is_refused_at_the_start(ends: Ends, tmp_path: Path) -> None:
    (tmp_path / "broken.ogg").write_bytes(b"no music")
    prepare_music(ends.client._socket.fileno(), tmp_path / "broken.ogg")
    ends.read()
    ends.worker.handle_order({"start": PLAN | {"music": str(tmp_path / "broken.ogg")}})
    told = json.loads(ends.client._socket.recv(1 << 16))
    assert "broken.ogg cannot be read as music" in told["refused"]
