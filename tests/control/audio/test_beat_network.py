"""Tests of the bundled beat-network weights: size, damage, and beats of a plain groove."""

from importlib.resources import files

import numpy as np
import pytest

from live.clock.tracking.aubio_tracker import AubioTracker
from live.clock.tracking.beat_network import ActivationStream, BeatNetwork
from live.control.audio import analysis
from live.control.audio.analysis import WEIGHTS, WEIGHTS_BACKWARDS, beat_weights, make_tracker
from tests.clock.clicks import groove

RATE = 44_100


@pytest.mark.parametrize("name", [*WEIGHTS, *WEIGHTS_BACKWARDS])
def test_the_weights_are_small(name: str) -> None:
    assert len(files("live.clock.tracking").joinpath(name).read_bytes()) <= 300_000


@pytest.mark.parametrize("cut", [0, 3, 1000, -30, "middle"])
def test_damaged_weights_fall_back_to_aubio_with_note(monkeypatch: pytest.MonkeyPatch, cut: int | str) -> None:
    data = bytearray(files("live.clock.tracking").joinpath("weights.npz").read_bytes())
    if isinstance(cut, int):
        del data[cut:]
    else:
        data[len(data) // 2] ^= 0xFF

    class Damaged:
        def joinpath(self, _name: str) -> "Damaged":
            return self

        def read_bytes(self) -> bytes:
            return bytes(data)

    monkeypatch.setattr(analysis, "files", lambda _: Damaged())
    beat_weights.cache_clear()
    try:
        tracker, note = make_tracker("network", RATE)
    finally:
        beat_weights.cache_clear()
    assert isinstance(tracker, AubioTracker)
    assert "the beat network's weights cannot be read" in note


def test_network_detects_beats_of_a_groove() -> None:
    bpm = 110.0
    sound = groove(bpm, RATE, 14.0)
    hearing = ActivationStream(RATE, BeatNetwork(*beat_weights()))
    count = hearing.feed(sound)
    late = hearing.position[:count] > 6.0
    phase = hearing.position[:count][late] * bpm / 60.0
    on = np.abs(phase - np.round(phase)) < 0.06
    strength = hearing.beat[:count][late]
    assert strength[on].mean() > 2.0 * strength[~on].mean()
    assert (hearing.downbeat[:count] <= hearing.beat[:count]).all()
