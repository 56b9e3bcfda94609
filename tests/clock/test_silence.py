"""SilenceDetector: silence, musical rests, and pauses."""

from live.clock.silence import BEAT_THRESHOLD, PAUSE, SILENT_AFTER, SilenceDetector

HOP = 0.01


def test_silence_starts_after_a_delay_and_ends_at_once() -> None:
    quiet = SilenceDetector(HOP)
    assert not quiet.has_sound
    quiet.step(0.1)
    steps = 0
    while not quiet.silent:
        assert quiet.step(1e-4) == 0.0
        steps += 1
    assert abs(steps * HOP - SILENT_AFTER) < 0.02
    assert quiet.has_sound
    assert abs(quiet.step(0.1) - SILENT_AFTER) < 0.02
    assert not quiet.silent


def test_continuous_music_is_paused_soon_after_stopping() -> None:
    quiet = SilenceDetector(HOP)
    for _ in range(500):
        quiet.step(0.1)
    for _ in range(int(PAUSE / HOP) - 1):
        quiet.step(0.0)
    assert quiet.expects_beats
    quiet.step(0.0)
    quiet.step(0.0)
    quiet.step(0.0)
    assert not quiet.expects_beats


def test_clicks_with_rests_are_not_paused() -> None:
    """At 50 bpm: the rest length is known from the second click on; a stop is longer than a rest."""
    quiet = SilenceDetector(HOP)
    for click in range(6):
        for frame in range(120):
            quiet.step(0.5 if frame < 3 else 0.0)
            assert click == 0 or quiet.expects_beats
    for _ in range(120):
        quiet.step(0.0)
    assert not quiet.expects_beats


def test_soft_background_is_silence_unless_beats_are_detected() -> None:
    for chance, silent in ((0.0, True), (BEAT_THRESHOLD + 0.1, False)):
        quiet = SilenceDetector(HOP)
        for _ in range(800):
            quiet.step(0.2, 0.0)
        for frame in range(200):
            quiet.step(0.01, chance if frame % 50 == 0 else 0.0)
        assert quiet.silent == silent


def test_soft_music_is_sound_again_after_a_delay() -> None:
    quiet = SilenceDetector(HOP)
    for _ in range(800):
        quiet.step(0.2, 0.0)
    for _ in range(4000):
        quiet.step(0.012, 0.0)
    assert not quiet.silent
