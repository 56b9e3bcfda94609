"""The simulated band: seeded, ordered, within bounds, and as irregular as configured."""

from itertools import islice, pairwise

import numpy as np
import pytest

from live.control.events.events import BeatHeard, SourceChanged
from live.rehearse.simulated_band import MAX_BPM, MIN_BPM, Irregularities, SimulatedBand

CALM = Irregularities(stop=0.0, fill=0.0, wrong_downbeat=0.0, tempo_jump=0.0, drift=0.0)


def test_same_seed_plays_the_same_and_another_differs():
    first, again, other = (list(islice(SimulatedBand(seed).events(), 400)) for seed in (5, 5, 6))
    assert first == again
    assert first != other


def test_regular_band_keeps_tempo_and_counts_beats():
    beats = list(islice(SimulatedBand(1, bpm=120.0, beats_per_measure=3, irregularities=CALM).beats(), 300))
    assert [beat.beat for beat in beats] == [0, 1, 2] * 100
    assert all(beat.detected_as == beat.beat and not beat.fill and beat.rest_before == 0.0 for beat in beats)
    assert np.diff([beat.time for beat in beats]).mean() == pytest.approx(0.5, rel=0.005)


def test_band_events_are_ordered_and_plausible():
    events = list(islice(SimulatedBand(2, irregularities=Irregularities(0.1, 0.2, 0.1, 0.1)).events(), 4000))
    times = [event.time for event in events]
    assert times == sorted(times)
    beats = [event for event in events if isinstance(event, BeatHeard)]
    assert all(60.0 / MAX_BPM * 0.9 < beat.period < 60.0 / MIN_BPM * 1.1 for beat in beats)
    assert all(0.0 <= beat.confidence <= 1.0 for beat in beats)


def test_irregularities_occur_at_their_configured_rates():
    band = SimulatedBand(3, irregularities=Irregularities(stop=0.1, fill=0.2, wrong_downbeat=0.1, tempo_jump=0.05))
    beats = list(islice(band.beats(), 4 * 2000))
    assert 150 < band.counts["stop"] < 250
    assert 330 < band.counts["fill"] < 470
    assert 70 < band.counts["leap"] < 130
    wrong = np.mean([beat.detected_as != beat.beat for beat in beats])
    assert 0.2 < wrong < 0.7
    assert sum(beat.rest_before > 0.0 for beat in beats) == pytest.approx(band.counts["stop"], abs=1)


def test_silence_is_reported_and_ends():
    events = list(islice(SimulatedBand(4, irregularities=Irregularities(stop=0.3)).events(), 3000))
    states = [event.state for event in events if isinstance(event, SourceChanged)]
    assert states[0] == "found"
    assert states.count("silent") > 5
    assert all(a != b for a, b in pairwise(states))
