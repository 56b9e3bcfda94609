"""Soundtrack of a film: click on the beats, taps at foot contacts, panning, level limits, reproducibility."""

import numpy as np
import pytest

from live.render.film.streams import FilmSound
from live.show.dancers.footfalls import BALL, HEEL, FootfallDetector
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import read_patch
from live.show.patch.patch_search_path import find_patch
from live.show.sound.soundtrack import (
    ACCENT_HZ,
    BEAT_HZ,
    CLICK_LEVEL,
    MAX_VOICES,
    MUSIC_LEVEL,
    RATE,
    Soundtrack,
    click_voices,
    tap_voices,
)
from tests.fixtures.mostly_long import mostly_long

TAP = find_patch("tap")
BEAT = 60.0 / 108.0
SOLO = {"warp_beats": 0.0, "amplitude": 0.0}


def tap_show(*, dancers=1, at=(0.0, 0.0), **motion):
    """A show of the tap patch: one group, on the beat, without movement on the floor."""
    patch = read_patch(TAP)
    place = {"formation": "grid", "centre": at, "facing": "public"}
    group = patch.group[2].model_copy(update={"dancers": dancers, **place})
    motion = patch.motion.model_copy(update=SOLO | motion)
    return load_from_patch(
        patch.model_copy(update={"group": (group,), "element": (), "segment": (), "motion": motion}), TAP
    ).start()


def run(show, seconds, *, fps=40, **sound):
    """The mixed sound of that time, the footfalls and the soundtrack."""
    mixed, falls, view, tick = Soundtrack(show, sound.pop("music", None), **sound), [], show.view(), 0
    feet = FootfallDetector(show)
    pieces, made = [], 0
    for frame in range(round(seconds * fps)):
        while (tick + 1) / 64 <= frame / fps + 1 / 64:
            tick += 1
            show.tick(tick / 64)
        show.fill(view, max(frame / fps + 1 / 64, tick / 64))
        mixed.frame(view)
        falls += feet.detect(view)
        pieces.append(mixed.film.read(made, round((frame + 1) / fps * RATE) - made))
        made += len(pieces[-1])
    return np.concatenate(pieces), falls, mixed


def energy(samples, begin, end):
    """Mean square of the samples from `begin` to `end` [s]."""
    part = samples[round(begin * RATE) : round(end * RATE)]
    return float((part.astype(np.float64) ** 2).mean())


@pytest.mark.long
def test_click_sounds_only_on_beats_with_accented_downbeat():
    samples, _, _ = run(tap_show(), 5.0, click=True, taps=False)
    expected = np.zeros_like(samples)
    accent, other = click_voices(RATE)
    for beat in range(9):
        begin = round(beat * BEAT * RATE)
        voice = (other if beat % 3 else accent)[: max(len(samples) - begin, 0)]
        expected[begin : begin + len(voice)] += CLICK_LEVEL * voice[:, None]
    assert np.allclose(samples, expected, atol=1e-6)
    for voice, hertz in ((accent, ACCENT_HZ), (other, BEAT_HZ)):
        spectrum = np.abs(np.fft.rfft(voice, 1 << 15))
        assert np.argmax(spectrum) * RATE / (1 << 15) == pytest.approx(hertz, rel=0.02)


@pytest.mark.long
def test_every_footfall_sounds_on_its_count():
    """The time step touches the floor on every third of a beat; between and before the taps it is quiet."""
    samples, falls, _ = run(tap_show(), 5.0, click=False, taps=True)
    thirds = np.arange(9, 26) * BEAT / 3  # from the second measure on
    times = np.array([fall.time for fall in falls])
    for third in thirds:
        assert np.abs(times - third).min() < 0.010, third / BEAT
        assert energy(samples, third - 0.008, third + 0.012) > 8.0 * energy(samples, third - 0.035, third - 0.012)
    off = np.abs(times[:, None] - np.arange(60) * BEAT / 3).min(axis=1)
    assert off.max() < 0.03
    assert {fall.foot for fall in falls} == {0, 1}
    assert {BALL, HEEL} <= {fall.part for fall in falls}


@pytest.mark.long
def test_footfalls_are_independent_of_frame_rate():
    many, few = (run(tap_show(), 4.0, fps=fps, click=False, taps=True)[1] for fps in (120, 30))
    landings = [{(round(f.time / BEAT * 3), f.foot) for f in falls if 0.5 < f.time < 3.8} for falls in (many, few)]
    assert landings[0] == landings[1]
    assert len(landings[0]) > 15


@pytest.mark.long
def test_taps_are_panned_and_attenuated_by_dancer_position():
    def sides(at):
        return (run(tap_show(at=at), 2.0, click=False, taps=True)[0].astype(np.float64) ** 2).mean(axis=0)

    left, right = sides((-5.0, 0.0)), sides((5.0, 0.0))
    assert left[0] > 4.0 * left[1]
    assert right[1] > 4.0 * right[0]
    assert left.sum() == pytest.approx(right.sum(), rel=0.1)
    assert sides((0.0, 3.0)).sum() > 1.2 * sides((0.0, -3.0)).sum()


@pytest.mark.long
def test_many_dancers_are_louder_but_limited():
    one, _, _ = run(tap_show(), 2.0, click=False, taps=True)
    many, _, mixed = run(tap_show(dancers=60, warp_beats=0.03), 2.0, click=True, taps=True)
    assert np.abs(many).max() <= 1.0 + CLICK_LEVEL
    assert energy(many, 1.0, 2.0) > energy(one, 1.0, 2.0)
    assert len(mixed._voice_ends) <= MAX_VOICES
    assert mixed.dropped_taps > 0  # 60 pairs of feet are more than can sound at once


def test_soundtrack_is_reproducible_and_taps_differ_by_seed():
    first, again = (run(tap_show(dancers=3, warp_beats=0.05), 2.0, click=True, taps=True)[0] for _ in range(2))
    assert np.array_equal(first, again)
    same, other = tap_voices(1, RATE), tap_voices(2, RATE)
    assert np.array_equal(same[0][0], tap_voices(1, RATE)[0][0])
    assert not np.array_equal(same[0][0], other[0][0])
    assert all(np.abs(voice).max() == pytest.approx(1.0) for part in same for voice in part)


@mostly_long(("rate", "channels"), [(44100, 1), (22050, 2)], quick=[0])
def test_music_keeps_its_rate_and_level_under_click(rate, channels):
    tone = (0.5 * np.sin(np.arange(3 * rate) * 0.05)).astype(np.float32)
    music = FilmSound.from_samples(np.repeat(tone[:, None], channels, axis=1), rate)
    show = tap_show()
    mixed, view = Soundtrack(show, music, click=True, taps=False), show.view()
    for tick in range(1, 65):
        show.tick(tick / 64)
        show.fill(view, tick / 64)
        mixed.frame(view)
    samples = mixed.film.read(0, rate)
    assert mixed.film.rate == rate
    assert samples.shape == (rate, 2)
    quiet = slice(round(0.1 * rate), round(0.5 * rate))
    assert np.allclose(samples[quiet], MUSIC_LEVEL * tone[quiet, None], atol=1e-6)
    loud = round(BEAT * rate) + 5
    assert np.abs(samples[loud : loud + 50] - MUSIC_LEVEL * tone[loud : loud + 50, None]).max() > 0.5 * CLICK_LEVEL
