"""Training data and network: features as in the engine, labels on the beats, JAX's network equal to the engine's."""

import numpy as np
import pytest

from live.clock.tracking.beat_network import DELAY, BeatNetwork, NetworkWeights
from live.clock.tracking.features import BAND_COUNT, HOP, Spectrum
from tests.clock.clicks import groove
from training.examples import Stream
from training.features import LOG_FLOOR, Item, bands_of, reverse
from training.labels import label, measures

RATE = 44_100


def made_item(seconds: float = 12.0, bpm: float = 120.0, **facts: object) -> Item:
    sound = groove(bpm, RATE, seconds)
    beats = np.arange(0.0, seconds - 0.6, 60.0 / bpm)
    places = (np.arange(beats.size) + 2) % 4 + 1
    return Item("a", "groove", np.log(bands_of(sound) + LOG_FLOOR).astype(np.float16), beats, places, dict(facts))


def engine_bands(sound: np.ndarray) -> np.ndarray:
    spectrum, out, start = Spectrum(RATE), [], 0
    while start < sound.size:
        start += spectrum.feed(sound, start)
        if spectrum.wanted == 0:
            spectrum.analyse()
            out.append(spectrum.bands.copy())
    return np.array(out)


def test_features_equal_the_bands_of_the_engine() -> None:
    sound = groove(120, RATE, 2.0)
    np.testing.assert_allclose(bands_of(sound), engine_bands(sound), atol=1e-6)


def test_a_reversed_recording_has_the_bands_and_beats_of_its_sound_backwards() -> None:
    frames = 300
    sound = groove(120, RATE, 5.0)[: frames * 512]
    beats, places = np.array([0.5, 1.0, 3.0]), np.array([4, 1, 1], np.int32)
    bands = np.log(bands_of(sound) + LOG_FLOOR).astype(np.float16)
    found = reverse(Item("a", "groove", bands, beats, places, {"ignore": [[2.0, 2.5]]}))
    expected = np.log(bands_of(sound[::-1].copy()) + LOG_FLOOR)
    inner = slice(8, -8)  # windows within the sound
    off = np.abs(found.log_bands[inner].astype(float) - expected[inner])[expected[inner] > -9.0]
    assert np.percentile(off, 99) < 0.05
    seconds = frames * HOP
    np.testing.assert_allclose(found.beats, [seconds - 3.0, seconds - 1.0, seconds - 0.5])
    assert found.places.tolist() == [1, 1, 4]
    np.testing.assert_allclose(found.facts["ignore"], [[seconds - 2.5, seconds - 2.0]])


def test_label_lies_on_the_frame_of_its_beat() -> None:
    item = made_item()
    found = label(item, 0.0, 1.0, item.log_bands.shape[0])
    moments = (np.arange(item.log_bands.shape[0]) + 1) * HOP - DELAY
    for time, place in zip(item.beats[1:], item.places[1:], strict=True):
        frame = np.argmin(np.abs(moments - time))
        column = 2 if place == 1 else 1
        assert found.classes[frame, column] > 0.7
        assert found.classes[frame + 5, 0] == 1.0
        assert np.argmax(found.classes[frame - 2 : frame + 3, column]) == 2
    np.testing.assert_allclose(found.classes.sum(axis=1), 1.0, atol=1e-6)


def test_time_stretch_keeps_label_delay_after_attack() -> None:
    """At any speed, the label lies the same time after the frame that contains the attack."""
    item = made_item()
    for step in (0.8, 1.0, 1.25):
        found = label(item, 37.5, step, 500)
        beat = item.beats[6]
        attack = ((beat + 0.020) / HOP - 1.0 - 37.5) / step
        centre = attack + (DELAY - 0.020) / HOP
        near = np.arange(round(centre) - 4, round(centre) + 5)
        shares = 1.0 - found.classes[near, 0]
        assert np.average(near, weights=shares) == pytest.approx(centre, abs=0.1)


def test_measures_are_counted_across_meter_change_and_pickup() -> None:
    item = made_item()
    places = np.array([3, 4, 1, 2, 3, 4, 1, 2, 3, 1, 2, 3, 1, 2], np.int32)
    item = Item("a", "b", item.log_bands, np.arange(14) * 0.5, places, {})
    expected = [-2 / 4, -1 / 4, 0, 1 / 4, 2 / 4, 3 / 4, 1, 4 / 3, 5 / 3, 2, 7 / 3, 8 / 3, 3, 10 / 3]
    np.testing.assert_allclose(measures(item), expected)


def test_ignored_spans_and_unknown_downbeats_have_low_weights() -> None:
    item = made_item(ignore=[[4.0, 6.0]], has_downbeat=False)
    found = label(item, 0.0, 1.0, item.log_bands.shape[0])
    at = int(5.0 / HOP)
    assert found.known[at, 0] == pytest.approx(0.3)
    assert found.known[at, 2:].max() == 0.0
    assert found.known[:, 1].max() == 0.0
    assert found.known[int(3.0 / HOP), 0] == 1.0


@pytest.mark.long
def test_unaltered_stream_is_independent_of_piece_length() -> None:
    item = made_item()
    whole, pieces = Stream([item], 1, altered=False), Stream([item], 1, altered=False)

    def fill(stream: Stream, count: int) -> np.ndarray:
        look = np.zeros((count, 2 * BAND_COUNT), np.float32)
        stream.fill(look, *(np.zeros((count, size), np.float32) for size in (3, 4, 4)))
        return look

    expected = fill(whole, 900)
    np.testing.assert_allclose(
        np.concatenate([fill(pieces, 1), fill(pieces, 402), fill(pieces, 497)]), expected, atol=1e-5
    )


@pytest.mark.long
def test_same_seed_gives_the_same_examples() -> None:
    def look(seed: int) -> np.ndarray:
        out = np.zeros((300, 2 * BAND_COUNT), np.float32)
        Stream([made_item()], seed).fill(out, *(np.zeros((300, size), np.float32) for size in (3, 4, 4)))
        return out

    np.testing.assert_array_equal(look(3), look(3))
    assert np.abs(look(3) - look(4)).max() > 0.1


def test_jax_network_equals_engine_network() -> None:
    pytest.importorskip("jax", reason="the extra `train` is not installed")
    from training import network

    weights = network.initial(2)
    looks = np.random.default_rng(5).gamma(1.0, 1.0, (40, 1, 2 * BAND_COUNT)).astype(np.float32)
    logits = np.asarray(network.forward(weights, looks, network.state(1))[0], np.float64)[:, 0]
    expected = np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)
    engine = BeatNetwork(NetworkWeights.from_arrays({name: np.asarray(value) for name, value in weights.items()}))
    got = []
    for look in looks[:, 0]:
        count = engine.step(look)
        got += list(zip(engine.beat[:count].tolist(), engine.downbeat[:count].tolist(), strict=True))
    np.testing.assert_allclose(np.array(got)[:, 0], 1.0 - expected[:, 0], atol=2e-5)
    np.testing.assert_allclose(np.array(got)[:, 1], expected[:, 2], atol=2e-5)


def test_custom_gru_gradient_equals_automatic_gradient() -> None:
    jax = pytest.importorskip("jax", reason="the extra `train` is not installed")
    from training import network

    rng = np.random.default_rng(1)
    given = [jax.numpy.asarray(rng.normal(0, 0.5, shape), "float32") for shape in ((4, 12), (4,), (6, 3, 12), (3, 4))]
    share = jax.numpy.asarray(rng.normal(size=(6, 3, 4)), "float32")
    made = jax.grad(lambda *a: (network.gru(*a) * share).sum(), argnums=(0, 1, 2, 3))(*given)
    true = jax.grad(lambda *a: (network._gru_forward(*a)[0] * share).sum(), argnums=(0, 1, 2, 3))(*given)
    for one, other in zip(made, true, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)
