"""MIDI time code, against a generator that counts frames one by one; and as a clock source of the show."""

import math
import random
from collections.abc import Iterator

import pytest

from live.app.bridges import installed_bridges
from live.base.event_queue import EventQueue
from live.bridges.midi_time_code.time_code import FRAMES, SPEEDS, TimeCodeClock, frame_number
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.midi.midi_clock import ClockBeat, ClockEvent, ClockState
from live.clock.time_source import ManualClock
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_streams import MidiTokenizer
from live.show.patch.patch_reader import parse_patch

Time = tuple[int, int, int, int]


def count_frames(rate: int, start: Time) -> Iterator[Time]:
    """The times of all frames from `start` on, counted like a clock; drop frame skips its numbers."""
    hours, minutes, seconds, frames = start
    while True:
        yield hours, minutes, seconds, frames
        frames += 1
        if frames == FRAMES[rate]:
            frames, seconds = 0, seconds + 1
        if seconds == 60:
            seconds, minutes = 0, minutes + 1
        if minutes == 60:
            minutes, hours = 0, hours + 1
        if rate == 2 and seconds == 0 and frames == 0 and minutes % 10:
            frames = 2


def quarter_frames(rate: int, start: Time, count: int, at: float = 0.0) -> list[tuple[float, tuple[int, int]]]:
    """(seconds, message) of `count` quarter frames, starting with the frame `start`."""
    frames = count_frames(rate, start)
    now: Time = start
    messages = []
    for i in range(count):
        if i % 4 == 0:
            frame = next(frames)
        if i % 8 == 0:
            now = frame
        hours, minutes, seconds, number = now
        fields = (number & 15, number >> 4, seconds & 15, seconds >> 4, minutes & 15, minutes >> 4, hours & 15,
                  hours >> 4 | rate << 1)  # fmt: skip
        messages.append((at + i / (4.0 * SPEEDS[rate]), (0xF1, (i % 8) << 4 | fields[i % 8])))
    return messages


def feed(clock: TimeCodeClock, messages: list[tuple[float, tuple[int, int]]]) -> list[ClockEvent]:
    return [news for time, message in messages for news in clock.receive(message, time)]


@pytest.mark.parametrize("rate", [0, 1, 2, 3])
def test_frame_numbers_match_counted_frames(rate: int) -> None:
    frames = count_frames(rate, (0, 8, 58, 0))
    begin = frame_number(0, 8, 58, 0, rate)
    assert begin is not None
    for i in range(4 * 60 * 30):
        assert frame_number(*next(frames), rate) == begin + i


def test_nonexistent_times_are_refused() -> None:
    assert frame_number(0, 1, 0, 1, 2) is None  # dropped
    assert frame_number(0, 10, 0, 1, 2) is not None
    assert frame_number(24, 0, 0, 0, 1) is None
    assert frame_number(0, 0, 0, 25, 1) is None


@pytest.mark.parametrize("rate", [0, 1, 2, 3])
def test_time_code_gives_beats_at_the_set_tempo(rate: int) -> None:
    clock = TimeCodeClock(tempo=120.0, offset=3600.0, beats_per_measure=4)
    news = feed(clock, quarter_frames(rate, (1, 0, 10, 0), 480, at=7.0))
    beats = [item for item in news if isinstance(item, ClockBeat)]
    assert news[0].time < 7.2
    assert isinstance(news[0], ClockState)
    assert beats[0].jump
    assert not any(beat.jump for beat in beats[1:])
    began = frame_number(1, 0, 10, 0, rate)
    assert began is not None
    for beat in beats[8:]:
        song = began / SPEEDS[rate] + (beat.beat_time - 7.0) - 3600.0  # seconds since the first measure
        assert song * 2.0 == pytest.approx(beat.measure * 4 + beat.beat, abs=0.002)
        assert beat.period == pytest.approx(0.5, rel=1e-4)


def test_slow_tape_is_followed() -> None:
    clock = TimeCodeClock(tempo=120.0)
    messages = [(time * 1.05, message) for time, message in quarter_frames(1, (0, 0, 0, 0), 800)]
    beats = [item for item in feed(clock, messages) if isinstance(item, ClockBeat)]
    assert beats[-1].period == pytest.approx(0.525, rel=1e-3)


def test_locate_is_a_jump_and_standstill_is_a_loss() -> None:
    clock = TimeCodeClock(tempo=120.0)
    feed(clock, quarter_frames(1, (0, 0, 0, 0), 160))
    moved = feed(clock, quarter_frames(1, (0, 5, 0, 0), 160, at=1.6))
    jumps = [item for item in moved if isinstance(item, ClockBeat) and item.jump]
    assert len(jumps) == 1
    assert jumps[0].measure == 150
    assert clock.seconds == pytest.approx(301.59, abs=0.01)
    (lost,) = clock.advance(3.6)
    assert isinstance(lost, ClockState)
    assert lost.state == "lost"
    again = feed(clock, quarter_frames(1, (0, 5, 1, 0), 40, at=10.0))
    assert [item.state for item in again if isinstance(item, ClockState)] == ["found"]


def test_full_frame_alone_and_invalid_messages_give_no_events() -> None:
    clock = TimeCodeClock(tempo=120.0)
    assert clock.receive((0xF0, 0x7F, 0x7F, 1, 1, 0x21, 2, 3, 4, 0xF7), 0.0) == []
    assert math.isnan(clock.seconds)
    for message in (
        (),
        (0xF1,),
        (0xF1, 200),
        (0xF0, 0x7F),
        (0xF0, 0x7F, 0, 1, 1, 0x3F, 99, 99, 99, 0xF7),
        (0x90, 1, 1),
    ):
        assert clock.receive(message, 1.0) == []
    assert clock.code.rejected == 1


def test_reversed_time_code_gives_no_beats() -> None:
    clock = TimeCodeClock(tempo=120.0)
    there = quarter_frames(1, (0, 0, 10, 0), 160)
    back = [(2.0 + i * 0.01, message) for i, (_, message) in enumerate(reversed(there))]
    feed(clock, there)
    beats = [item for item in feed(clock, back)[20:] if isinstance(item, ClockBeat)]
    assert beats == []


def show_input(extra: str, *, bridged: bool = True) -> tuple[MidiInput, EventQueue[ControlEvent]]:
    """An input of a show whose patch has these lines, with this bridge or without any, and its events."""
    patch = parse_patch(
        f"""name = "test"\n{extra}\n[[group]]\nname = "all"\ndancers = 1\nsteps = ["walk"]""", "test.toml"
    )
    inbox: EventQueue[ControlEvent] = EventQueue()
    clocks = installed_bridges().midi_clocks(patch, 4) if bridged else {}
    return MidiInput("box", inbox, ManualClock(), clocks=clocks), inbox


@pytest.mark.parametrize(("extra", "bpm"), [("[midi]\ntime_code_bpm = 90", 90.0), ("[clock]\nbpm = 150", 150.0)])
def test_time_code_is_the_source_mtc(extra: str, bpm: float) -> None:
    listens, inbox = show_input(extra)
    listens.beats_per_measure = 3
    for time, message in quarter_frames(1, (0, 0, 1, 0), 400):
        listens.decode(message, time)
    listens.advance(9.0)
    events = inbox.drain()
    assert {event.source for event in events} == {"mtc"}
    states = [event.state for event in events if isinstance(event, SourceChanged)]
    assert states == ["found", "lost"]
    beats = [event for event in events if isinstance(event, BeatHeard)]
    assert beats[-1].period == pytest.approx(60.0 / bpm, rel=1e-3)
    assert {event.beats_per_measure for event in beats} == {3}


def test_offset_of_the_patch_is_the_first_measure() -> None:
    listens, inbox = show_input("[midi]\ntime_code_bpm = 120\ntime_code_offset_s = 3600")
    for time, message in quarter_frames(3, (1, 0, 0, 0), 200):
        listens.decode(message, time)
    first = next(event for event in inbox.drain() if isinstance(event, BeatHeard))
    assert (first.measure, first.jump) == (0, True)


def test_time_code_without_this_bridge_is_ignored() -> None:
    listens, inbox = show_input("[midi]\ntime_code_bpm = 90", bridged=False)
    for time, message in quarter_frames(1, (0, 0, 1, 0), 400):
        listens.decode(message, time)
    listens.decode((0xF0, 0x7F, 0x7F, 1, 1, 0x21, 2, 3, 4, 0xF7), 9.0)
    listens.advance(9.0)
    assert inbox.drain() == []
    assert listens.status()["bad"] == 0


def test_follower_knows_the_source_of_an_old_journal() -> None:
    """A journal in which time code led replays without this folder: the beats are events of it."""
    follower = TimelineFollower(tempo=120.0)
    assert follower.states["mtc"] == "absent"
    follower.select_source("mtc")
    for number in range(40):
        now = number * 0.4
        follower.observe(now + 0.4, 0.4, 1.0, now, source="mtc", beat=number % 4, beats_per_measure=4)
        follower.advance(now)
    assert (follower.source, follower.rejected) == ("mtc", 0)
    assert follower.tempo == pytest.approx(150.0)


@pytest.mark.long
def test_mutated_bytes_leave_the_decoder_working() -> None:
    rng = random.Random(12)
    listens, _ = show_input("")
    good = bytes.fromhex("f8 f1 05 f1 10 f1 21 f0 7f 7f 01 01 21 02 03 04 f7 f1 32 f1 43 f1 50 f1 60 f1 72")
    cutter, time = MidiTokenizer(), 0.0
    for turn in range(400):
        data = bytearray(good)
        for _ in range(turn % 12):
            data[rng.randrange(len(data))] = rng.randrange(256)
        for message in cutter.feed(data):
            time += rng.choice((0.0, 0.001, 0.02))
            listens._decode_safely(message, time)
        listens._advance_safely(time)
    assert (listens.failed, listens.failure) == (0, "")
    assert listens.messages > 3000
