"""BeatNetwork: the kernels against plain numpy, and refused weights."""

import numpy as np
import pytest

from live.clock.tracking.beat_network import BeatNetwork, NetworkWeights
from live.clock.tracking.features import BAND_COUNT
from tests.clock.tracking.made_weights import random_weights, reference


def random_frames(frames: int) -> np.ndarray:
    found = np.random.default_rng(5).gamma(1.0, 1.0, (frames, 2 * BAND_COUNT)).astype(np.float32)
    found[:, BAND_COUNT:] *= np.random.default_rng(6).random((frames, BAND_COUNT)) < 0.3  # rises are mostly 0
    return found


def run(network: BeatNetwork, seen: np.ndarray) -> np.ndarray:
    """(beat, downbeat) per frame."""
    out = []
    for look in seen:
        count = network.step(look)
        out += list(zip(network.beat[:count].tolist(), network.downbeat[:count].tolist(), strict=True))
    return np.array(out)


def test_kernels_match_numpy_reference() -> None:
    arrays, seen = random_weights(), random_frames(60)
    got, expected = run(BeatNetwork(NetworkWeights.from_arrays(arrays)), seen), reference(arrays, seen)
    np.testing.assert_allclose(got[:, 0], expected[:, 1] + expected[:, 2], atol=2e-5)
    np.testing.assert_allclose(got[:, 1], expected[:, 2], atol=2e-5)
    assert got.std(axis=0).min() > 0.01  # the output varies
    assert (got[:, 1] <= got[:, 0]).all()


def test_networks_that_answer_together_give_the_mean_of_their_log_odds() -> None:
    members, seen = [random_weights(seed) for seed in (0, 1, 2)], random_frames(40)
    got = run(BeatNetwork(*(NetworkWeights.from_arrays(arrays) for arrays in members)), seen)
    shares = np.exp(np.mean([np.log(reference(arrays, seen)) for arrays in members], axis=0))
    shares /= shares.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(got[:, 0], shares[:, 1] + shares[:, 2], atol=2e-5)
    np.testing.assert_allclose(got[:, 1], shares[:, 2], atol=2e-5)
    with pytest.raises(ValueError, match="without weights"):
        BeatNetwork()


def test_reset_clears_the_recurrent_state() -> None:
    members = [NetworkWeights.from_arrays(random_weights(seed)) for seed in (0, 1)]
    network, seen = BeatNetwork(*members), random_frames(21)
    first = run(network, seen)
    network.reset()
    np.testing.assert_array_equal(run(network, seen), first)


def test_output_depends_on_earlier_frames() -> None:
    network, seen = BeatNetwork(NetworkWeights.from_arrays(random_weights())), random_frames(20)
    first = run(network, seen)
    assert np.abs(run(network, seen) - first).max() > 1e-3


def test_frame_of_wrong_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="a frame of shape"):
        BeatNetwork(NetworkWeights.from_arrays(random_weights())).step(np.zeros(3, np.float32))


@pytest.mark.parametrize("name", ["dense_w", "gru0_x", "gru1_h", "head_w", "ear1_b", "gru1_c"])
def test_invalid_weights_are_refused(name: str) -> None:
    arrays = random_weights()
    with pytest.raises(ValueError, match="expected"):
        NetworkWeights.from_arrays(arrays | {name: arrays[name][..., :-1]})
    with pytest.raises(ValueError, match="not finite"):
        NetworkWeights.from_arrays(arrays | {name: arrays[name] * np.nan})
    del arrays[name]
    with pytest.raises(KeyError):
        NetworkWeights.from_arrays(arrays)
