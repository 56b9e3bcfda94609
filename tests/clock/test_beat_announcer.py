"""BeatAnnouncer: each beat once and ahead of time; corrections of announced beats; grid jumps."""

import math
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

from live.clock.beat_announcer import BIAS, LOOK_AHEAD, MAX_LATENESS, BeatAnnouncer
from live.clock.beat_estimate import BeatEstimate

HOP = 0.0116
DELAY = 3 * HOP


def run(beats_at: Any, seconds: float = 10.0, period: float = 0.5, metre: int = 4) -> list[BeatEstimate]:
    """Beats announced for a pointer whose grid at time t [s] is beats_at(t) + k · period."""
    announcer, found = BeatAnnouncer(), []
    for frame in range(int(seconds / HOP)):
        moment = frame * HOP
        past = (moment - beats_at(moment)) % period
        number = math.floor((moment - beats_at(moment)) / period)
        pointer: Any = SimpleNamespace(
            interval=period / HOP, period=period / HOP, to_next=(period - past) / HOP, beat=number % metre, metre=metre,
            line_evidence=SimpleNamespace(runner_up=(2, 0.25)),
        )  # fmt: skip
        beat = announcer.beat(pointer, moment, moment + DELAY, HOP, 0.9)
        if beat is not None:
            found.append(beat)
    return found


def test_each_beat_is_announced_once_ahead_with_its_number() -> None:
    found = run(lambda t: 0.2)
    assert len(found) == 20
    for number, beat in enumerate(found[1:]):
        assert abs(beat.position - (0.7 + 0.5 * number + BIAS)) < 1e-6
        assert LOOK_AHEAD - 2 * HOP < beat.position - beat.fed <= LOOK_AHEAD
        assert beat.beat == (number + 1) % 4
        assert (beat.beats_per_measure, beat.runner_up, beat.runner_up_share) == (4, 2, 0.25)
        assert math.isnan(beat.replaces)


def test_moved_future_beat_is_corrected() -> None:
    found = run(lambda t: 0.2 if t < 4.62 else 0.215)  # the beat at 4.7 s has just been announced
    (beat,) = (beat for beat in found if not math.isnan(beat.replaces))
    assert beat.fed < beat.replaces
    assert abs(beat.replaces - (4.7 + BIAS)) < 1e-6
    assert abs(beat.position - beat.replaces - 0.015) < 1e-6


def test_announced_beats_keep_minimum_spacing() -> None:
    found = run(lambda t: 0.2 + 0.17 * math.floor(t / 1.3), 20.0)
    first = [beat.position for beat in found if math.isnan(beat.replaces)]
    assert all(b - a > 0.24 for a, b in pairwise(first))
    assert len(first) > 30


def test_skipped_beat_is_announced_if_just_passed() -> None:
    found = run(lambda t: 0.2 if t < 2.957 else -0.045)  # beats at 2.7, 3.2 become beats at 2.955, 3.455
    (late,) = (beat for beat in found if beat.fed > beat.position)
    assert abs(late.position - (2.955 + BIAS)) < 1e-6
    assert late.fed - late.position <= MAX_LATENESS
    gone = run(lambda t: 0.2 if t < 3.0 else -0.045)  # here the beat is too old
    assert all(beat.fed < beat.position for beat in gone)
