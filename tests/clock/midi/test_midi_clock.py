"""MIDI clock input: accuracy and robustness, over seeded streams with sender and cable jitter."""

import math

import pytest

from live.clock.midi.clock_report import ClockErrors, ClockReport, TrueBeat, clock_errors, replay
from live.clock.midi.midi_clock import ClockBeat, ClockEvent, ClockState, MidiClock
from tests.clock.midi_streams import Stream, make_stream, ramp, steady, steps, swing
from tests.fixtures.mostly_long import mostly_long

PULSE = (0xF8,)


def evaluate_stream(stream: Stream) -> tuple[ClockReport, ClockErrors]:
    report = replay(stream.events)
    errors = clock_errors(report.beats, [TrueBeat(time, beat % 4, bpm) for time, beat, bpm in stream.beats])
    assert errors is not None
    return report, errors


@mostly_long(
    ("bpm", "kind", "jitter", "frame", "tempo_bar"),
    [
        (96.0, "uniform", 0.001, 0.0, 0.1),
        (131.0, "half-normal", 0.002, 0.0, 0.1),
        (174.0, "uniform", 0.005, 0.0, 0.3),
        (61.0, "exponential", 0.005, 0.0, 0.3),
        (140.0, "uniform", 0.0003, 0.001, 0.1),
        (96.0, "uniform", 0.0, 0.010, 0.3),
        (127.27, "uniform", 0.0, 0.010, 0.3),
        (118.0, "stalls", 0.001, 0.0, 0.1),
    ],
    quick=[0, 3, 6],
)
def test_steady_clock_is_accurate_after_eight_beats(
    bpm: float, kind: str, jitter: float, frame: float, tempo_bar: float
) -> None:
    _, errors = evaluate_stream(make_stream(steady(bpm), seconds=18.0, kind=kind, jitter=jitter, frame=frame, seed=3))
    assert errors.found == 1.0
    assert errors.measure_right == 1.0
    assert errors.extra == 0
    assert errors.phase_p95_ms <= 3.0
    assert errors.ahead_p95_ms <= 3.0
    assert errors.tempo_p95_bpm <= tempo_bar


@pytest.mark.parametrize("to", [76.8, 96.0, 150.0, 240.0, 60.0])
def test_tempo_step_is_followed_within_a_beat_without_loss(to: float) -> None:
    report, errors = evaluate_stream(make_stream(steps((0.0, 120.0), (6.0, to)), seconds=12.0, jitter=0.001, seed=1))
    assert report.lost == 0
    assert errors.step_beats <= 1
    assert errors.measure_right == 1.0


@pytest.mark.long
def test_tempo_ramp_and_swing_are_followed() -> None:
    _, on_ramp = evaluate_stream(make_stream(ramp(120.0, 174.0, 6.0, 16.0), seconds=20.0, jitter=0.001))
    _, on_swing = evaluate_stream(make_stream(swing(96.0, 0.12, 20.0), seconds=40.0, kind="half-normal", jitter=0.002))
    assert on_ramp.phase_p95_ms <= 3.0
    assert on_swing.phase_p95_ms <= 3.0
    assert on_ramp.measure_right == on_swing.measure_right == 1.0


@pytest.mark.parametrize(("kind", "jitter"), [("uniform", 0.001), ("exponential", 0.003)])
def test_lost_pulses_are_counted_by_time(kind: str, jitter: float) -> None:
    gaps = ((5.0, 5.05), (8.0, 8.3), (11.0, 13.0))
    report, errors = evaluate_stream(
        make_stream(steady(128.0), seconds=18.0, kind=kind, jitter=jitter, dropouts=gaps, seed=2)
    )
    sent = sum(128.0 / 60.0 * 24.0 * (end - begin) for begin, end in gaps)
    assert abs(report.lost - sent) <= 3.0
    assert errors.measure_right == errors.found == 1.0
    assert [state.state for state in report.states] == ["found", "started", "lost", "found"]


def feed(clock: MidiClock, messages: list[tuple[float, tuple[int, ...]]]) -> list[ClockEvent]:
    news: list[ClockEvent] = []
    for time, message in messages:
        news += clock.receive(message, time)
    return news


def pulses(begin: float, count: int, period: float = 0.5 / 24.0) -> list[tuple[float, tuple[int, ...]]]:
    return [(begin + i * period, PULSE) for i in range(count)]


def beats_in(news: list[ClockEvent]) -> list[ClockBeat]:
    return [item for item in news if isinstance(item, ClockBeat)]


def test_start_takes_effect_at_next_pulse_as_a_jump() -> None:
    clock = MidiClock()
    before = beats_in(feed(clock, pulses(0.0, 24)))
    assert before
    assert not any(beat.anchored for beat in before)
    assert {(beat.beat, beat.measure) for beat in before} == {(-1, -1)}
    after = beats_in(feed(clock, [(0.495, (0xFA,)), *pulses(0.5, 25)]))
    assert (after[0].jump, after[0].beat, after[0].measure) == (True, 0, 0)
    assert after[0].beat_time == pytest.approx(0.5, abs=1e-3)
    assert not any(beat.jump for beat in after[1:])
    assert (after[-1].beat, after[-1].measure) == (2, 0)
    assert after[-1].beat_time == pytest.approx(1.5, abs=1e-3)


def test_continue_resumes_from_the_stop_position() -> None:
    clock = MidiClock()
    feed(clock, [(0.0, (0xFA,)), *pulses(0.01, 24 * 5 + 12)])  # five beats and a half are played
    news = feed(clock, [(2.8, (0xFC,)), *pulses(3.0, 30), (3.7, (0xFB,)), *pulses(3.8, 13)])
    jump = next(beat for beat in beats_in(news) if beat.jump)
    assert (jump.beat, jump.measure) == (2, 1)  # the coming beat is the seventh
    assert jump.beat_time == pytest.approx(3.8 + 12 * 0.5 / 24.0, abs=2e-3)


@pytest.mark.parametrize("running", [False, True])
def test_song_position_counts_sixteenths(running: bool) -> None:
    clock = MidiClock(beats_per_measure=3)
    feed(clock, [(0.0, (0xFA,)), *pulses(0.01, 48)])
    position = 7 * 12 + 4  # measure 8 of three beats, second beat
    messages: list[tuple[float, tuple[int, ...]]] = [(1.015, (0xF2, position % 128, position // 128))]
    if not running:
        messages = [(1.012, (0xFC,)), *messages, (1.018, (0xFB,))]
    jump = next(beat for beat in beats_in(feed(clock, [*messages, *pulses(1.02, 10)])) if beat.jump)
    assert (jump.beat, jump.measure) == (1, 7)
    assert jump.beat_time == pytest.approx(1.02, abs=0.011)


def test_start_while_running_restarts_the_song() -> None:
    clock = MidiClock()
    feed(clock, [(0.0, (0xFA,)), *pulses(0.01, 100)])
    again = feed(clock, [(2.09, (0xFA,)), (2.091, (0xFA,)), *pulses(2.1, 7)])
    assert [beat.jump for beat in beats_in(again)] == [True, False]
    assert beats_in(again)[0].beat == beats_in(again)[0].measure == 0
    assert not any(isinstance(item, ClockState) for item in again)


def test_ended_clock_is_lost_within_a_second_unless_stopped() -> None:
    clock = MidiClock()
    feed(clock, [(0.0, (0xFA,)), *pulses(0.01, 48)])
    assert clock.advance(1.4) == []
    assert [type(item) for item in clock.advance(1.6)] == [ClockState]
    assert clock.advance(1.7) == []
    stopped = MidiClock()
    feed(stopped, [(0.0, (0xFA,)), *pulses(0.01, 48), (1.1, (0xFC,))])
    assert stopped.advance(10.0) == []


def test_ended_active_sensing_is_a_loss_after_330_ms() -> None:
    clock = MidiClock()
    feed(clock, [*pulses(0.0, 10), (0.2, (0xFE,))])
    assert clock.advance(0.52) == []
    (lost,) = clock.advance(0.54)
    assert isinstance(lost, ClockState)
    assert lost.state == "lost"
    assert clock.advance(0.9) == []


def test_clock_resumes_after_loss_without_jump() -> None:
    clock = MidiClock()
    feed(clock, [(0.0, (0xFA,)), *pulses(0.01, 96)])
    clock.advance(2.6)
    news = feed(clock, pulses(0.01 + 4.0, 24))
    assert news[0] == ClockState(4.01, "found")
    assert not any(beat.jump for beat in beats_in(news))
    assert (beats_in(news)[-1].beat, beats_in(news)[-1].measure) == (1, 2)


@pytest.mark.parametrize("message", [(), (0x40,), (0xF2, 1), (0xF2, 200, 1)])
def test_invalid_messages_are_counted(message: tuple[int, ...]) -> None:
    clock = MidiClock()
    assert clock.receive(message, 1.0) == []
    assert clock.receive(PULSE, math.nan) == []
    assert clock.rejected == 2


def test_backward_times_and_floods_give_finite_beats() -> None:
    clock = MidiClock()
    feed(clock, [(0.0, (0xFA,)), *pulses(1.0, 50), *pulses(0.5, 50), *((2.0, PULSE) for _ in range(3000))])
    reported = beats_in(feed(clock, pulses(3.0, 200)))
    assert all(math.isfinite(beat.beat_time) and 0.1 < beat.period < 4.0 for beat in reported)


def test_same_stream_gives_identical_beats() -> None:
    stream = make_stream(steady(133.0), seconds=6.0, kind="exponential", jitter=0.003, seed=7)
    assert replay(stream.events).beats == replay(stream.events).beats


def test_recording_with_gap_of_weeks_is_replayed_quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Timestamps may count from machine start, and a recording may have been left running."""
    looks: list[float] = []
    real = MidiClock.advance

    def advance(self: MidiClock, now: float) -> list[ClockEvent]:
        looks.append(now)
        return real(self, now)

    monkeypatch.setattr(MidiClock, "advance", advance)
    report = replay([(begin + n * 0.02, (0xF8,)) for begin in (5e6, 9e6) for n in range(60)])
    assert len(looks) < 300
    assert len(report.beats) < 21_000
    assert [state.state for state in report.states] == ["found", "lost", "found"]
    assert report.states[1].time == pytest.approx(5e6 + 59 * 0.02 + 0.5, abs=0.2)
