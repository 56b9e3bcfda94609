"""Round-trip measurement on simulated devices with known delays."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.base.errors import PersonError
from live.control.audio.latency_sweep import Recording, measure, sweep_train
from tests.fixtures.mostly_long import mostly_long

TRAIN = sweep_train(48_000.0, 8)
BLOCK = 512


def simulate_recording(
    delay: float,
    *,
    rate: float = 48_000.0,
    gain: float = 0.1,
    noise: float = 0.0,
    echo: float = 0.0,
    jitter: float = 0.0,
    ppm: float = 0.0,
    out_block: int = 1024,
    seed: int = 0,
) -> Recording:
    """A recording in which a sample written at t is recorded at t + delay, at any callback times."""
    rng = np.random.default_rng(seed)
    seconds = len(TRAIN.sound) / TRAIN.sample_rate
    begin, true_rate = 7.0, rate * (1.0 + ppm * 1e-6)
    times = np.arange(int((seconds + 0.5) * rate)) / true_rate - delay  # of the train, for each sample of the input
    own = np.arange(len(TRAIN.sound)) / TRAIN.sample_rate
    sound = gain * np.interp(times, own, TRAIN.sound, 0.0, 0.0)
    sound += echo * gain * np.interp(times - 0.021, own, TRAIN.sound, 0.0, 0.0)
    sound += rng.normal(0.0, noise, sound.size)
    frames = np.arange(BLOCK, sound.size, BLOCK)
    heard = [(int(f), begin + f / true_rate + rng.exponential(jitter + 1e-9)) for f in frames]
    blocks = np.arange(0, len(TRAIN.sound), out_block)
    played = [(int(f), begin + f / TRAIN.sample_rate + rng.exponential(jitter + 1e-9)) for f in blocks]
    return Recording(sound.astype(np.float32), rate, heard, played)


@pytest.mark.long
@settings(max_examples=12, deadline=None)
@given(delay=st.floats(-0.03, 1.3), rate=st.sampled_from([22_050.0, 44_100.0, 48_000.0, 96_000.0]))
def test_known_delay_is_measured_exactly(delay: float, rate: float) -> None:
    trip = measure(TRAIN, simulate_recording(delay, rate=rate))
    assert trip.seconds == pytest.approx(delay, abs=5e-5)
    assert trip.spread < 5e-5
    assert trip.detected == trip.total == 8


@mostly_long(
    "how",
    [
        {"noise": 0.02},
        {"echo": 0.7},
        {"gain": -0.001},
        {"ppm": 120.0},
        {"jitter": 0.01},
        {"jitter": 0.01, "noise": 0.02, "echo": 0.5, "ppm": -80.0, "rate": 44_100.0},
    ],
    ids=str,
    quick=[0, 3],
)
def test_disturbances_change_measured_delay_under_one_millisecond(
    how: dict[str, float],
) -> None:
    assert measure(TRAIN, simulate_recording(0.0874, **how)).seconds == pytest.approx(0.0874, abs=1e-3)


def test_silence_is_refused_with_a_remedy() -> None:
    with pytest.raises(PersonError, match="the recording is silent") as caught:
        measure(TRAIN, simulate_recording(0.05, gain=0.0))
    assert caught.value.remedy


def test_noise_alone_is_refused_with_a_remedy() -> None:
    with pytest.raises(PersonError, match="sweeps were heard") as caught:
        measure(TRAIN, simulate_recording(0.05, gain=0.0, noise=0.1))
    assert caught.value.remedy


def test_nan_samples_count_as_silence() -> None:
    recording = simulate_recording(0.05)
    sound = recording.sound.copy()
    sound[::17] = np.nan
    assert measure(TRAIN, replace(recording, sound=sound)).seconds == pytest.approx(0.05, abs=1e-3)


def test_drifting_delay_is_refused() -> None:
    recording = simulate_recording(0.05)
    wandering = [(f, t + 0.015 * (n // 130)) for n, (f, t) in enumerate(recording.input_stamps)]
    with pytest.raises(PersonError, match=r"apart|only"):
        measure(TRAIN, replace(recording, input_stamps=wandering))
