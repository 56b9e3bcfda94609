"""PauseDetector: music that stops is detected within a second; regular rests are not taken for silence."""

import pytest

from live.clock.silence import PauseDetector

HOP = 0.0116


def detect_changes(pieces: list[tuple[float, float]]) -> list[tuple[str, float]]:
    """(state, when [s]) of each change, for pieces of (seconds, level)."""
    pauses, found, position, before = PauseDetector(), [], 0.0, "sound"
    for seconds, level in pieces:
        end = position + seconds
        while position < end - 0.5 * HOP:
            position += HOP
            state = pauses.step(level, position)
            if state != before:
                found.append((state, position))
            before = state
    return found


def test_stopped_music_is_a_pause_and_then_silence() -> None:
    changes = detect_changes([(5.0, 0.1), (3.0, 1e-4), (1.0, 0.1)])
    assert [state for state, _ in changes] == ["pause", "silence", "sound"]
    assert [time for _, time in changes] == pytest.approx([5.8, 6.2, 8.0], abs=2 * HOP)


@pytest.mark.parametrize("bpm", [28.0, 40.0, 50.0, 60.0])
def test_slow_clicks_are_music_and_their_end_is_detected(bpm: float) -> None:
    rest = 60.0 / bpm - 0.05
    changes = detect_changes([*[(0.05, 0.3), (rest, 1e-4)] * 8, (4.0, 1e-4)])
    taught = 4 * 60.0 / bpm
    end = 7 * 60.0 / bpm + 0.05
    late = [(state, time) for state, time in changes if time > taught]
    assert [state for state, _ in late] == ["pause", "silence"]
    assert end < late[0][1] <= end + max(0.8, 1.25 * rest) + 3 * HOP


def test_single_long_rest_does_not_delay_next_pause() -> None:
    changes = detect_changes([(5.0, 0.1), (1.0, 1e-4), (3.0, 0.1), (2.0, 1e-4)])
    assert [state for state, _ in changes] == ["pause", "sound", "pause", "silence"]
    assert changes[2][1] == pytest.approx(9.8, abs=3 * HOP)


def test_old_rests_do_not_delay_a_pause() -> None:
    changes = detect_changes([*[(0.05, 0.3), (1.45, 1e-4)] * 8, (15.0, 0.1), (2.0, 1e-4)])
    assert changes[-1][0] == "silence"
    assert changes[-2][1] == pytest.approx(8 * 1.5 + 15.8, abs=4 * HOP)


def test_nan_level_counts_as_silence() -> None:
    assert detect_changes([(1.0, 0.1), (1.0, float("nan"))])[0][0] == "pause"
