"""ActivationStream: frame times, independence of block size and rate, plain onsets on clicks."""

import tracemalloc

import numpy as np
import pytest

from live.clock.tracking.beat_network import DELAY, Activation, ActivationStream, BeatNetwork, NetworkWeights
from live.clock.tracking.features import HOP, Samples
from tests.clock.clicks import clicks, groove
from tests.clock.tracking.made_weights import random_weights
from tests.clock.tracking.plain_onsets import OnsetActivation
from tests.fixtures.mostly_long import mostly_long

RATE = 44_100


def run_stream(sound: Samples, activation: Activation, rate: int = RATE, block: int = 512) -> np.ndarray:
    """(position, beat, downbeat) of all frames, shape (frames, 3)."""
    hearing, out = ActivationStream(rate, activation), []
    for first in range(0, sound.size, block):
        count = hearing.feed(sound[first : first + block])
        out.append(np.stack([hearing.position[:count], hearing.beat[:count], hearing.downbeat[:count]], axis=1))
    return np.concatenate(out)


def test_every_frame_has_its_time() -> None:
    frames = run_stream(groove(120, RATE, 2.0), BeatNetwork(NetworkWeights.from_arrays(random_weights())))
    np.testing.assert_allclose(frames[:, 0], (np.arange(len(frames)) + 1) * HOP - DELAY, atol=1e-12)
    assert len(frames) == 2 * RATE // 512 // 2 * 2


@pytest.mark.parametrize("block", [7, 441, 88_200])
def test_activations_are_independent_of_block_size(block: int) -> None:
    sound, network = groove(120, RATE, 2.0), BeatNetwork(NetworkWeights.from_arrays(random_weights()))
    expected = run_stream(sound, network)
    network.reset()
    np.testing.assert_array_equal(run_stream(sound, network, block=block), expected)


@mostly_long("rate", [22_050, 48_000, 192_000], quick=[0, 1])
def test_plain_onsets_find_clicks_at_any_rate(rate: int) -> None:
    sound, times = clicks(120, rate, 6.0)
    frames = run_stream(sound, OnsetActivation(), rate)
    for time in times[4:-1]:
        near = np.abs(frames[:, 0] - time) < 0.1
        assert abs(frames[near][np.argmax(frames[near, 1]), 0] - time) < 0.025
        assert frames[near, 1].max() > 0.5
    between = np.abs((frames[:, 0] - times[0] + 0.25) % 0.5 - 0.25) > 0.1
    assert np.mean(frames[between & (frames[:, 0] > 1.0), 1]) < 0.2


def test_activations_are_independent_of_loudness() -> None:
    sound = groove(120, RATE, 8.0)
    loud, quiet = (
        run_stream(sound, OnsetActivation()),
        run_stream(sound * np.float32(10.0 ** (-35.0 / 20.0)), OnsetActivation()),
    )
    late = loud[:, 0] > 4.0
    assert np.corrcoef(loud[late, 1], quiet[late, 1])[0, 1] > 0.99


def test_reset_clears_state_but_keeps_time() -> None:
    hearing = ActivationStream(RATE, BeatNetwork(NetworkWeights.from_arrays(random_weights())))
    sound = groove(120, RATE, 1.0)[: 512 * 80]
    first = hearing.feed(sound)
    before = hearing.beat[:first].copy()
    hearing.feed(np.zeros(512 * 20, np.float32))
    hearing.reset()
    count = hearing.feed(sound)
    np.testing.assert_allclose(hearing.beat[:count], before, atol=1e-6)
    assert hearing.position[0] == pytest.approx(101 * HOP - DELAY)


def test_feed_retains_no_memory() -> None:
    """Only numpy's FFT allocates temporarily (67 kB)."""
    hearing, sound = (
        ActivationStream(RATE, BeatNetwork(NetworkWeights.from_arrays(random_weights()))),
        groove(120, RATE, 3.0),
    )
    for start in range(0, RATE, 512):
        hearing.feed(sound[start : start + 512])
    tracemalloc.start()
    kept, peaks = [], []
    for start in range(RATE, 3 * RATE, 512):
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        hearing.feed(sound[start : start + 512])
        after, peak = tracemalloc.get_traced_memory()
        kept.append(after - before)
        peaks.append(peak - before)
    tracemalloc.stop()
    assert np.median(kept) < 256  # numbers of Python, no array
    assert max(peaks) < 70_000


def test_multichannel_sound_is_refused() -> None:
    with pytest.raises(ValueError, match="one channel"):
        ActivationStream(RATE, OnsetActivation()).feed(np.zeros((512, 2), np.float32))
