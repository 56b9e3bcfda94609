"""Network: the kernels against the same arithmetic in plain numpy, and weights that do not fit."""

import numpy as np
import pytest

from live.clock.tracking.beat_network import BeatNetwork, NetworkWeights
from live.clock.tracking.features import BAND_COUNT
from tests.clock.tracking.made_weights import made_weights, reference


def looks(frames: int) -> np.ndarray:
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


def test_the_kernels_do_what_numpy_does() -> None:
    arrays, seen = made_weights(), looks(60)
    got, expected = run(BeatNetwork(NetworkWeights.from_arrays(arrays)), seen), reference(arrays, seen)
    np.testing.assert_allclose(got[:, 0], expected[:, 1] + expected[:, 2], atol=2e-5)
    np.testing.assert_allclose(got[:, 1], expected[:, 2], atol=2e-5)
    assert got.std(axis=0).min() > 0.01  # it says something
    assert (got[:, 1] <= got[:, 0]).all()


def test_reset_forgets_everything() -> None:
    network, seen = BeatNetwork(NetworkWeights.from_arrays(made_weights())), looks(21)
    first = run(network, seen)
    network.reset()
    np.testing.assert_array_equal(run(network, seen), first)


def test_the_past_matters() -> None:
    network, seen = BeatNetwork(NetworkWeights.from_arrays(made_weights())), looks(20)
    first = run(network, seen)
    assert np.abs(run(network, seen) - first).max() > 1e-3


def test_a_frame_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="a frame of shape"):
        BeatNetwork(NetworkWeights.from_arrays(made_weights())).step(np.zeros(3, np.float32))


@pytest.mark.parametrize("name", ["dense_w", "gru0_x", "gru1_h", "head_w", "ear1_b", "gru1_c"])
def test_weights_that_do_not_fit_together_are_refused(name: str) -> None:
    arrays = made_weights()
    with pytest.raises(ValueError, match="expected"):
        NetworkWeights.from_arrays(arrays | {name: arrays[name][..., :-1]})
    with pytest.raises(ValueError, match="not finite"):
        NetworkWeights.from_arrays(arrays | {name: arrays[name] * np.nan})
    del arrays[name]
    with pytest.raises(KeyError):
        NetworkWeights.from_arrays(arrays)
