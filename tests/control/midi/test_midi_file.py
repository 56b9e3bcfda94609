"""Tests of MIDI files: tempo map as clock, broken files refused, same events at any frame rate."""

import math
import random
from pathlib import Path

import mido
import numpy as np
import pytest

from live.app.services.midi_service import MidiFileService
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.base.motion_parameters import LARGER
from live.clock.time_source import ManualClock
from live.control.events.events import BeatHeard, ControlEvent, NotesHeard, SetParameter
from live.control.midi.midi_file import read_song
from live.show.engine import Engine
from live.show.view.status import Status
from tests.control.midi.midi_files import write_song
from tests.show.made_show import made_show

MAP = """
[[midi.map]]
cc = 7
control = "/dance/motion/larger"
[[react]]
to = "note_energy"
sets = "amplitude"
low = 0.0
high = 0.5
"""


def test_pulses_and_notes_follow_the_tempo_map(tmp_path: Path) -> None:
    song = read_song(write_song(tmp_path / "song.mid"))
    assert (song.tempo, song.length) == (100.0, pytest.approx(16 * 0.6 + 16 * 0.4))
    pulses = [time for time, message in song.messages if message == b"\xf8"]
    beats = np.where(np.arange(33) < 16, np.arange(33) * 0.6, 9.6 + (np.arange(33) - 16) * 0.4)
    expected = np.interp(np.arange(32 * 24) / 24, np.arange(33), beats)
    assert np.allclose(pulses, expected, rtol=0, atol=1e-9)
    struck = [time for time, message in song.messages if message[0] == 0x90 and message[1] == 48 and message[2]]
    assert np.allclose(struck, beats[:32], rtol=0, atol=1e-9)
    assert (song.messages[0][1], song.messages[-1][1]) == (b"\xfa", b"\xfc")
    # mido's own player counts the same seconds
    file = mido.MidiFile(tmp_path / "song.mid")
    assert file.length == pytest.approx(song.length)


class SongRun:
    """A show that a MIDI file leads, driven at given frame times."""

    def __init__(self, path: Path, times: list[float]) -> None:
        self.show = made_show(MAP, tempo=100.0)
        self.events: list[ControlEvent] = []
        clock, inbox = ManualClock(), EventQueue[ControlEvent]()
        status = Status(self.show, rejected=dict, memory=lambda: 0.0)
        engine = Engine(self.show, clock=clock, inbox=inbox, status=status, stall=math.inf)
        engine.event_listeners.append(self.events.append)
        self.part = MidiFileService(path, self.show, engine)
        self.beats = []
        for time in times:
            clock.set(time)
            engine.frame(lambda view: None)
            self.beats.append(self.show.timeline.beat_at(time))
        engine.run_to(17.0)
        self.final = self.show.state_hash()


@pytest.mark.long
def test_song_gives_same_events_at_any_frame_rate(tmp_path: Path) -> None:
    path = write_song(tmp_path / "song.mid")
    rng = random.Random(2)
    uneven, time = [], 0.0
    while time < 16.5:
        time += rng.uniform(0.001, 0.09)
        uneven.append(time)
    even = [n / 30 for n in range(495)]
    one, other = SongRun(path, even), SongRun(path, uneven)
    assert one.events == other.events
    assert one.final == other.final
    truth = np.interp(even, [0.0, 9.6, 16.0], [0.0, 16.0, 32.0])
    late = (np.array(one.beats) - truth)[(np.array(even) > 2.0) & (np.array(even) < 15.9)]
    assert np.abs(late).max() < 0.12  # where it turns to another tempo
    assert np.percentile(np.abs(late), 90) < 0.01
    kinds = {type(event) for event in one.events}
    assert {BeatHeard, NotesHeard, SetParameter} <= kinds
    larger = [event for event in one.events if isinstance(event, SetParameter)]
    assert [(event.address, event.value, event.time) for event in larger] == [
        ("/dance/motion/larger", (0.5,), pytest.approx(16.0))
    ]
    assert one.show.variation.values[0, LARGER.first] == 0.5
    loud = [event.energy for event in one.events if isinstance(event, NotesHeard)]
    told_late = 0.5 ** (2.5 / 16.0)  # it is told within a sixteenth of a second, at 2.5 beats a second
    assert told_late * 71 / 127 <= max(loud) <= 71 / 127
    assert one.part.status() == {"file": "song.mid", "at_s": 16.0, "length_s": 16.0}


def test_resumed_engine_receives_only_later_events(tmp_path: Path) -> None:
    path = write_song(tmp_path / "song.mid")
    show = made_show(MAP, tempo=100.0)
    status = Status(show, rejected=dict, memory=lambda: 0.0)
    engine = Engine(show, clock=ManualClock(), inbox=EventQueue(), status=status, stall=math.inf)
    MidiFileService(path, show, engine, resume_tick=64 * 8)
    (tell,) = engine.event_sources
    assert all(event.time > 8.0 for event in tell(8.5))


def test_invalid_midi_file_is_refused_in_one_line(tmp_path: Path) -> None:
    def refused(data: bytes) -> str:
        path = tmp_path / "bad.mid"
        path.write_bytes(data)
        with pytest.raises(PersonError) as caught:
            read_song(path)
        assert "\n" not in str(caught.value)
        return str(caught.value)

    good = write_song(tmp_path / "song.mid").read_bytes()
    assert "bad.mid" in refused(b"")
    assert "bad.mid" in refused(b"RIFF" + good)
    assert "bad.mid" in refused(good[:100])
    assert "format 2" in refused(good[:9] + b"\x02" + good[10:])
    assert "time code" in refused(good[:12] + b"\xe7\x28" + good[14:])
    empty = mido.MidiFile()
    empty.tracks.append(mido.MidiTrack([mido.MetaMessage("track_name", name="nothing")]))
    empty.save(tmp_path / "empty.mid")
    assert "0 s long" in refused((tmp_path / "empty.mid").read_bytes())
    with pytest.raises(PersonError, match="No such file"):
        read_song(tmp_path / "none.mid")


def test_mutated_midi_files_are_read_or_refused(tmp_path: Path) -> None:
    good, rng = write_song(tmp_path / "song.mid", bars=2).read_bytes(), random.Random(8)
    path, songs = tmp_path / "m.mid", 0
    for _ in range(120):
        data = bytearray(good)
        for _ in range(rng.randrange(1, 5)):
            at = rng.randrange(len(data))
            if rng.random() < 0.7:
                data[at] = rng.randrange(256)
            else:
                del data[at : at + rng.randrange(4)]
        path.write_bytes(data)
        try:
            song = read_song(path)
        except PersonError:
            continue
        songs += 1
        times = [time for time, _ in song.messages]
        assert times == sorted(times)
        assert math.isfinite(song.length)
    assert 10 < songs < 120
