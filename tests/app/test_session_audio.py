"""Audio input of a show: manual settings outlive the device, and a manual restart clears them."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from live.app import session_audio
from live.app.launch_options import LaunchOptions
from live.app.session_audio import AudioChoice, choose_audio, likely_tempo, make_audio, make_show_analysis
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.bar_pointer.state_space import BarPointerModel
from live.clock.follower.manual_control import TrackerHint
from live.clock.tracking.beat_tracker import BeatTracker
from live.control.audio.analysis import AudioAnalysis
from live.control.audio.audio_input import AudioInput
from live.control.events.events import ControlEvent, RestartAudio
from live.show.venue.venue import Latencies
from tests.control.audio.fake_sound import fake_sound_system

LOADED: Any = SimpleNamespace(
    patch=SimpleNamespace(clock=SimpleNamespace(tracker="network", metres=(3, 4), likely_bpm=66.0))
)


class FakeShow:
    """The part of a show used by its audio: its patch has measures of 3 beats."""

    def __init__(self) -> None:
        self.follower = SimpleNamespace(on_hint=None)

    def seed_tracker(self, told: Any) -> None:
        told(TrackerHint("metre", 0.0, 3.0))
        self.follower.on_hint = told


def manual_settings(analysis: AudioAnalysis) -> tuple[float, int]:
    """The manually set interval [frames] and metre, as found by the next samples."""
    analysis.feed(np.zeros((1, 1), np.float32), lambda position: position)
    assert isinstance(analysis.tracker, BeatTracker)
    hand = analysis.tracker.pointer._manual
    return hand.held_interval, hand.held_metre


def test_next_analysis_keeps_manual_settings_of_last_one() -> None:
    show = FakeShow()
    make = make_show_analysis(AudioChoice(), LOADED, cast(Any, show))
    first = make(44_100.0)
    show.follower.on_hint(TrackerHint("tempo", 1.0, 60.0))
    assert manual_settings(first) == (pytest.approx(86.13, abs=0.01), 3)
    make(96_000.0)  # refused at this rate: it never hears anything
    assert manual_settings(make(48_000.0)) == (pytest.approx(86.13, abs=0.01), 3)


def test_the_tracker_expects_what_patch_and_name_say() -> None:
    make = make_show_analysis(AudioChoice(), LOADED, cast(Any, FakeShow()))
    tracker = make(44_100.0).tracker
    assert isinstance(tracker, BeatTracker)
    assert tracker.pointer.model == BarPointerModel.expecting((3, 4), 66.0)
    assert likely_tempo(66.0, Path("song 120 bpm.ogg")) == 66.0
    assert likely_tempo(None, Path("song 120 bpm.ogg")) == 120.0
    assert likely_tempo(None, None) is None


def test_manual_restart_keeps_only_patch_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    system = fake_sound_system(monkeypatch)
    show, inbox = FakeShow(), cast("EventQueue[ControlEvent]", EventQueue())
    source, tell = make_audio(
        AudioChoice(device="stage box"), LOADED, cast(Any, show), Latencies(), inbox, system.clock
    )
    assert isinstance(source, AudioInput)
    source._open(source._watchdog.stop_event)
    assert source._open_stream is not None
    show.follower.on_hint(TrackerHint("tempo", 1.0, 60.0))
    assert manual_settings(source._open_stream.analysis)[0] > 0.0
    tell(RestartAudio(time=2.0, source="key"))
    source.poll()
    assert manual_settings(source._open_stream.analysis) == (0.0, 3)


def test_music_played_elsewhere_is_not_decoded_here(tmp_path, monkeypatch) -> None:
    decoded = []
    monkeypatch.setattr(session_audio, "read_music", lambda path: decoded.append(path) or object())
    song = tmp_path / "song.ogg"
    song.write_bytes(b"not looked at")
    options = LaunchOptions(audio=str(song))
    elsewhere, here = choose_audio(options, LOADED, elsewhere=True), choose_audio(options, LOADED)
    assert decoded == [song]
    assert elsewhere.path == here.path == song
    assert elsewhere.music is elsewhere.music
    assert decoded == [song, song]  # once each


@pytest.mark.parametrize("elsewhere", [False, True])
def test_music_of_patch_that_is_missing_is_refused_before_the_show(tmp_path, elsewhere) -> None:
    loaded = cast(Any, SimpleNamespace(music_path=tmp_path / "gone.ogg"))
    with pytest.raises(PersonError, match=r"gone\.ogg: there is no such file"):
        choose_audio(LaunchOptions(), loaded, elsewhere=elsewhere)


def test_music_that_is_none_is_refused_where_it_is_decoded(tmp_path) -> None:
    song = tmp_path / "song.ogg"
    song.write_bytes(b"no music")
    with pytest.raises(PersonError, match="cannot be read as music"):
        choose_audio(LaunchOptions(audio=str(song)), LOADED)
