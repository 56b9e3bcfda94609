"""MIDI clock output of a Timeline, checked with the MIDI clock decoder."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from live.clock.midi.midi_clock import ClockBeat, MidiClock
from live.clock.midi.pulse_schedule import PulseSchedule
from live.clock.timeline import Timeline

Sent = list[tuple[float, bytes]]


def simulate_sender(
    timeline_at: Callable[[float], Timeline], seconds: float, schedule: PulseSchedule | None = None
) -> Sent:
    """Messages of a sender that polls every 10 ms, with their due times."""
    schedule = schedule or PulseSchedule()
    now, sent = 0.0, []
    while now < seconds:
        timeline = timeline_at(now)
        due = schedule.next_pulse(timeline, now)
        if due.time > now + 0.010:
            now += 0.010
            continue
        now = max(now, due.time)
        sent += [(due.time, message) for message in due.messages]
        schedule.mark_sent(timeline)
    return sent


def pulse_times(sent: Sent) -> list[float]:
    return [time for time, message in sent if message == b"\xf8"]


def test_pulses_are_even_and_song_starts_at_a_measure_line() -> None:
    timeline = Timeline(tempo=120.0, beat_origin=0.5)  # the next line is 1.75 s away
    sent = simulate_sender(lambda _now: timeline, 6.0)
    times = pulse_times(sent)
    assert times == pytest.approx([i / 48.0 for i in range(len(times))], abs=1e-9)
    starts = [time for time, message in sent if message == b"\xfa"]
    assert starts == pytest.approx([1.75])
    assert sent[sent.index((starts[0], b"\xfa")) + 1][1] == b"\xf8"
    assert not any(message[0] in (0xFB, 0xFC, 0xF2) for _, message in sent)


def test_tempo_changes_cause_no_drift() -> None:
    timelines = [Timeline(tempo=100.0)]

    def at(now: float) -> Timeline:
        if now - timelines[-1].time_origin > 0.02:
            timelines.append(timelines[-1].with_tempo(100.0 + 7.0 * ((len(timelines) * 37) % 11 - 5), now))
        return timelines[-1]

    times = pulse_times(simulate_sender(at, 20.0))
    beat = timelines[-1].beat_at(20.0)
    assert abs(len(times) - beat * 24.0) <= 1.0
    assert all(later > earlier for earlier, later in pairwise(times))


def test_jump_is_sent_as_stop_position_and_continue() -> None:
    first = Timeline(tempo=120.0)
    second = first.with_downbeat_at(4.9)  # a beat and a fifth of one before a line: the line moves
    sent = simulate_sender(lambda now: first if now < 4.95 else second, 8.0)
    words = [message for _, message in sent if message[0] != 0xF8]
    assert [message[0] for message in words] == [0xFA, 0xFC, 0xF2, 0xFB]
    decoder = MidiClock()
    beats = [n for time, message in sent for n in decoder.receive(message, time) if isinstance(n, ClockBeat)]
    last = beats[-1]
    assert second.phase_at(last.beat_time + 1e-6) == pytest.approx(last.beat, abs=0.01)
    assert second.measure_at(last.beat_time + 1e-6) == last.measure


def test_decoder_recovers_the_beats_of_the_timeline() -> None:
    timeline = Timeline(tempo=97.0, beats_per_measure=3, time_origin=0.1)
    decoder = MidiClock(beats_per_measure=3)
    sent = simulate_sender(lambda _now: timeline, 10.0)
    beats = [n for time, message in sent for n in decoder.receive(message, time) if isinstance(n, ClockBeat)]
    for beat in beats[4:]:
        number = timeline.beat_at(beat.beat_time)
        assert number == pytest.approx(round(number), abs=1e-3)
        assert round(number) % 3 == beat.beat
        assert beat.period == pytest.approx(60.0 / 97.0, rel=1e-6)


def test_relocate_sends_position_and_continue() -> None:
    schedule = PulseSchedule()
    timeline = Timeline(tempo=120.0)
    simulate_sender(lambda _now: timeline, 5.0, schedule)
    schedule.relocate()
    messages = schedule.next_pulse(timeline, 5.01).messages
    for _ in range(6):
        if len(messages) > 1:
            break
        schedule.mark_sent(timeline)
        messages = schedule.next_pulse(timeline, 5.1).messages
    assert [message[0] for message in messages] == [0xF2, 0xFB, 0xF8]


def test_song_position_wraps_at_a_measure_line() -> None:
    schedule = PulseSchedule()
    timeline = Timeline(tempo=300.0)
    schedule.next_pulse(timeline, 0.0)
    schedule.mark_sent(timeline)
    located, time = b"", 3600.01  # 18 000 beats later: a jump, and the position at the next sixteenth
    for _ in range(7):
        due = schedule.next_pulse(timeline, time)
        located = next((message for message in due.messages if message[0] == 0xF2), located)
        if located:
            break
        schedule.mark_sent(timeline)
        time = due.time
    beat = (located[1] + 128 * located[2]) / 4
    assert beat % 4 == pytest.approx(timeline.phase_at(due.time + 1e-9), abs=1e-6)
