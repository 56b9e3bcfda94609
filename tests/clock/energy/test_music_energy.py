"""Energy and structure of music with known sections."""

import tracemalloc

import numpy as np
import pytest

from live.clock.energy.energy_frames import EnergyFrames
from live.clock.energy.k_weighting import k_weight
from live.clock.energy.music_energy import BeatEnergy, MusicEnergy
from tests.clock.energy.club import BEAT, Sound, club
from tests.fixtures.mostly_long import mostly_long


def measure_beats(sound: Sound, rate: int = 44_100, *, block: int = 512, beats: bool = True) -> list[BeatEnergy]:
    energy, found = MusicEnergy(rate), []
    if beats:
        energy.set_beat(0.0, BEAT)
    for start in range(0, len(sound), block):
        found += energy.feed(sound[start : start + block])
    return found


@pytest.mark.parametrize("rate", [22_050, 44_100, 48_000, 192_000])
@pytest.mark.parametrize(("hertz", "lufs"), [(997.0, -3.01), (50.0, -7.6), (8_000.0, 0.3)])
def test_loudness_matches_bs1770(rate: int, hertz: float, lufs: float) -> None:
    """A full sine of 997 Hz in one channel has -3.01 LUFS (BS.1770-5, annex 1)."""
    frames, sound = EnergyFrames(rate), np.sin(2 * np.pi * hertz * np.arange(2 * rate) / rate).astype(np.float32)
    start = 0
    while start < len(sound):
        start += frames.feed(sound, start)
    expected = lufs if hertz == 997.0 else -0.691 - 3.01 + 10 * np.log10(k_weight(np.array([hertz]))[0])
    assert frames.pop_features().loudness == pytest.approx(expected, abs=0.35)
    assert expected == pytest.approx(lufs, abs=0.05)


@pytest.mark.long
def test_k_weighting_matches_the_filters() -> None:
    """Against the filters run sample by sample."""
    from live.clock.energy.k_weighting import HIGH_PASS, SHELF

    for hertz in (40.0, 200.0, 1_000.0, 3_000.0, 12_000.0):
        out = np.sin(2 * np.pi * hertz * np.arange(24_000) / 48_000.0)
        for above, below in (SHELF, HIGH_PASS):
            x, out = out, np.zeros_like(out)
            for n in range(len(x)):
                out[n] = sum(above[k] * x[n - k] - (below[k] * out[n - k] if k else 0.0) for k in range(3) if n >= k)
        gain = np.mean(np.square(out[12_000:])) / 0.5
        assert k_weight(np.array([hertz]))[0] == pytest.approx(gain, rel=0.01)


@pytest.mark.parametrize("kind", ["groove", "half", "break"])
@mostly_long("rate", [22_050, 48_000], quick=[0])
def test_steady_groove_has_no_build_up_or_drop(kind: str, rate: int) -> None:
    beats = measure_beats(club([(kind, 96)], rate), rate)
    assert len(beats) in (95, 96)
    assert not any(beat.drop for beat in beats)
    assert max(beat.build for beat in beats) < 0.4


@pytest.mark.parametrize("length", [8, 16])
@mostly_long("gain", [0.03, 0.3], quick=[1])
def test_build_up_and_its_drop_are_detected(length: int, gain: float) -> None:
    begin = 48
    beats = measure_beats(club([("groove", 32), ("break", 16), ("build", length), ("groove", 32)], gain=gain))
    building = [n for n, beat in enumerate(beats) if beat.build >= 0.5]
    assert building[0] >= begin + 2
    assert building[0] <= begin + 0.7 * length
    assert building[-1] == begin + length - 1
    assert [n for n, beat in enumerate(beats) if beat.drop] == [begin + length]


def test_bass_return_is_a_drop_after_break_only() -> None:
    beats = measure_beats(club([("groove", 24), ("break", 8), ("groove", 24), ("silence", 24), ("groove", 16)]))
    assert [n for n, beat in enumerate(beats) if beat.drop] == [32]


@pytest.mark.long
def test_relative_loudness_is_independent_of_gain() -> None:
    parts = [("groove", 32), ("break", 16), ("groove", 16)]
    loud, soft = measure_beats(club(parts, gain=0.3)), measure_beats(club(parts, gain=0.02))
    for one, other in zip(loud, soft, strict=True):
        assert one.loudness == pytest.approx(other.loudness, abs=0.1)
        assert one.loudness_db - other.loudness_db == pytest.approx(23.5, abs=0.5)
    assert np.mean([beat.loudness for beat in loud[8:32]]) > 0.9
    assert np.mean([beat.loudness for beat in loud[34:48]]) < 0.6
    assert np.mean([beat.low for beat in loud[34:48]]) < 0.1 < 0.8 < np.mean([beat.low for beat in loud[8:32]])


def test_onset_density_is_counted_per_beat() -> None:
    beats = measure_beats(club([("half", 64)]))
    density = np.mean([beat.density for beat in beats[8:]])
    assert 0.9 <= density <= 1.6  # a hi-hat on each beat, a bass drum on every fourth


def test_silence_and_invalid_samples_give_zero_energy() -> None:
    for sound in (np.zeros(200_000), np.full(200_000, np.nan), np.full(200_000, 1e30)):
        beats = measure_beats(sound.astype(np.float32))
        assert {(beat.loudness, beat.density, beat.low, beat.build, beat.drop) for beat in beats} == {
            (0, 0, 0, 0, False)
        }


def test_energy_is_independent_of_block_size() -> None:
    sound = club([("groove", 8), ("break", 4)])
    assert measure_beats(sound, block=64) == measure_beats(sound, block=4096) == measure_beats(sound, block=10_007)


def test_beat_boundaries_follow_reported_beats() -> None:
    energy, found = MusicEnergy(44_100.0), []
    sound = club([("groove", 24)])
    reported = {n: 0.31 + n * 0.4 for n in range(1, 26)}  # 150 bpm, reported 0.1 s ahead
    for start in range(0, len(sound), 512):
        for n in [n for n, time in reported.items() if time < start / 44_100.0 + 0.1]:
            energy.set_beat(reported.pop(n), 0.4)
        found += energy.feed(sound[start : start + 512])
    begins = [beat.begin for beat in found[3:]]
    assert begins == pytest.approx([begins[0] + 0.4 * n for n in range(len(begins))])
    assert (begins[0] - 0.31) / 0.4 == pytest.approx(round((begins[0] - 0.31) / 0.4), abs=1e-6)


def test_invalid_beat_reports_do_not_stop_analysis() -> None:
    energy = MusicEnergy(44_100.0)
    rng = np.random.default_rng(9)
    ended = 0
    for _ in range(200):
        energy.set_beat(
            float(rng.normal(energy.position, 3.0)), float(rng.choice([0.0, -1.0, np.nan, 0.2, 0.5, 2.9, 1e9]))
        )
        ended += len(energy.feed(np.zeros(4096, np.float32)))
    assert 3 <= ended <= 200 * 4096 / 44_100.0 / 0.15


def test_feeding_blocks_retains_no_memory() -> None:
    """Only numpy's FFT allocates temporarily (34 kB)."""
    energy, block = MusicEnergy(44_100.0), np.random.default_rng(0).normal(0.0, 0.1, 512).astype(np.float32)
    for _ in range(200):
        energy.feed(block)
    tracemalloc.start()
    try:
        for _ in range(1000):  # until Python's free lists are traced by tracemalloc
            energy.feed(block)
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        for _ in range(500):
            energy.feed(block)
        kept, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert kept - before < 2000
    assert peak - before < 40_000
