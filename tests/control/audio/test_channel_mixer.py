"""Tests of channel selection and mixing: many channels, mute channels and opposite polarity."""

import contextlib

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.errors import PersonError
from live.control.audio.channel_mixer import ChannelMixer, Channels

RATE = 48_000.0
BLOCK = 512


@pytest.mark.parametrize(
    ("words", "numbers"),
    [("3", (2,)), ("5,6", (4, 5)), (" 5 + 6 ", (4, 5)), ("all", ()), ([5, 6], (4, 5)), ("1", (0,))],
)
def test_channel_numbers_start_at_one(words: str | list[int], numbers: tuple[int, ...]) -> None:
    assert Channels.parse(words).numbers == numbers


@pytest.mark.parametrize("words", ["", "0", "left", "1,1", "-1", "999", "1,", [], [0], [True], "1.5"])
def test_invalid_channel_lists_are_refused(words: str | list[int]) -> None:
    with pytest.raises(PersonError, match="channels"):
        Channels.parse(words)


@given(st.text(max_size=12))
def test_any_text_gives_channels_or_a_person_error(words: str) -> None:
    with contextlib.suppress(PersonError):
        assert Channels.parse(str(Channels.parse(words))) == Channels.parse(words)


def test_missing_channels_fall_back_to_existing_channels() -> None:
    five_six = Channels.parse("5,6")
    assert five_six.select(32) == (4, 5)
    assert five_six.select(2) == (0, 1)
    assert five_six.missing(2) == "no channel 5, 6 among 2"
    assert five_six.missing(5) == "no channel 6 among 5"
    assert Channels.parse("all").select(32) == tuple(range(32))
    assert Channels().missing(1) == ""
    assert Channels().select(1) == (0,)


def mix_blocks(sound: npt.NDArray[np.float32], chosen: tuple[int, ...]) -> npt.NDArray[np.float32]:
    mixer = ChannelMixer(chosen, RATE, BLOCK)
    return np.concatenate([mixer.mix(sound[at : at + BLOCK]).copy() for at in range(0, len(sound), BLOCK)])


def noise(channels: int, seconds: float = 4.0) -> npt.NDArray[np.float32]:
    return (
        np.random.default_rng(3).normal(0.0, 0.1, (int(seconds * RATE) // BLOCK * BLOCK, channels)).astype(np.float32)
    )


def rms(sound: npt.NDArray[np.float32]) -> float:
    return float(np.sqrt(np.mean(np.square(sound[-48_000:], dtype=np.float64))))


def test_one_chosen_channel_of_32_is_unchanged() -> None:
    sound = noise(32)
    assert np.array_equal(mix_blocks(sound, (16,)), sound[:, 16])


def test_two_identical_channels_mix_to_their_mean() -> None:
    sound = np.repeat(noise(1), 2, axis=1)
    assert np.allclose(mix_blocks(sound, (0, 1)), sound[:, 0], atol=1e-6)


@pytest.mark.parametrize("hum", [0.0, 3e-4])
def test_mute_channel_does_not_halve_the_level(hum: float) -> None:
    sound = noise(2)
    sound[:, 1] *= hum / 0.1
    assert rms(mix_blocks(sound, (0, 1))) == pytest.approx(rms(sound[:, 0]), rel=0.01)
    assert rms(mix_blocks(np.pad(noise(1), ((0, 0), (7, 24))), tuple(range(32)))) == pytest.approx(0.1, rel=0.02)


def test_muted_channel_is_faded_out_without_a_click() -> None:
    t = np.arange(int(8.0 * RATE) // BLOCK * BLOCK) / RATE
    tone = (0.5 * np.sin(2.0 * np.pi * 200.0 * t)).astype(np.float32)
    sound = np.stack([tone, tone * (t < 2.0)], axis=1)
    heard = mix_blocks(sound, (0, 1))
    assert rms(heard) == pytest.approx(rms(tone), rel=0.01)
    after = int(2.1 * RATE)
    assert np.abs(np.diff(heard[after:])).max() < 1.1 * np.abs(np.diff(tone)).max()


def test_pair_with_opposite_polarity_is_not_cancelled() -> None:
    sound = noise(1) * np.array([1.0, -1.0], np.float32)
    assert rms(mix_blocks(sound, (0, 1))) == pytest.approx(0.1, rel=0.02)


def test_nan_channel_is_silent_and_counted() -> None:
    sound = noise(2)
    sound[:, 1] = np.nan
    sound[100:120, 0] = np.inf
    mixer = ChannelMixer((0, 1), RATE, len(sound))
    heard = mixer.mix(sound)
    assert np.isfinite(heard).all()
    assert mixer.bad_samples == len(sound) + 20
    assert rms(mixer.mix(sound)) == pytest.approx(0.1, rel=0.02)
