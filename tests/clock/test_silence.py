"""Quiet: silence, rests that belong to the music, and the pauses that do not."""

from live.clock.silence import BEAT_THRESHOLD, PAUSE, SILENT_AFTER, SilenceDetector

HOP = 0.01


def test_silence_begins_after_a_while_and_ends_at_once() -> None:
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


def test_music_without_rests_is_paused_soon() -> None:
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


def test_clicks_with_rests_between_them_are_listened_to_all_the_time() -> None:
    """At 50 bpm: from the second click on the rest is known; the rest of a stop is longer."""
    quiet = SilenceDetector(HOP)
    for click in range(6):
        for frame in range(120):
            quiet.step(0.5 if frame < 3 else 0.0)
            assert click == 0 or quiet.expects_beats
    for _ in range(120):
        quiet.step(0.0)
    assert not quiet.expects_beats


def test_a_room_that_murmurs_far_below_the_music_is_a_silence_unless_it_beats() -> None:
    for chance, silent in ((0.0, True), (BEAT_THRESHOLD + 0.1, False)):
        quiet = SilenceDetector(HOP)
        for _ in range(800):
            quiet.step(0.2, 0.0)
        for frame in range(200):
            quiet.step(0.01, chance if frame % 50 == 0 else 0.0)
        assert quiet.silent == silent


def test_music_that_goes_on_softly_is_music_again_after_a_while() -> None:
    quiet = SilenceDetector(HOP)
    for _ in range(800):
        quiet.step(0.2, 0.0)
    for _ in range(4000):
        quiet.step(0.012, 0.0)
    assert not quiet.silent
