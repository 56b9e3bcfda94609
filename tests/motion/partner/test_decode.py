"""Tests of the decoder against an exhaustive search of unit sequences and a direct form of the recurrence."""

import itertools

import numpy as np
import pytest

from live.base.errors import PersonError
from live.motion.partner.decoder import decode
from live.motion.partner.point_clouds import Cloud, fit, gap, time_scaled
from live.motion.partner.time_scaled_units import Stretches, legal_durations, make_stretches
from live.motion.partner.units import Units
from tests.motion.partner.made_examples import made_cloud, made_units

K = 0.7


def window(x: Cloud, start: int, duration: int) -> Cloud:
    return Cloud(x.floor[start : start + duration + 1], x.height[start : start + duration + 1], x.rate)


def cells_of(units: Units, stretches: Stretches) -> list[tuple[int, int]]:
    return list(zip(stretches.unit.tolist(), stretches.duration.tolist(), strict=True))


def place_unit(units: Units, x: Cloud, unit: int, start: int, duration: int) -> tuple[float, Cloud]:
    """Distance D of a unit at a start, and its target transformed by M."""
    of = units.examples[int(units.example[unit])]
    begin, length = float(units.start[unit]), float(units.length[unit])
    found = fit(window(x, start, duration), time_scaled(of.control, begin, length, duration))
    return found.distance, time_scaled(of.target, begin, length, duration).transformed(found.turn, found.shift)


def recurrence_score(units: Units, stretches: Stretches, x: Cloud, k: float) -> float:
    """Recurrence (6) and (7) cell by cell; shares only the fit with the kernel."""
    last = x.count - 1
    cells = cells_of(units, stretches)
    scores: dict[tuple[int, int, int], float] = {}
    for t in range(1, last + 1):
        for s, d in cells:
            if d > t:
                continue
            distance, target = place_unit(units, x, s, t - d, d)
            if d == t:
                scores[s, d, t] = distance
                continue
            before = [
                scores[r, c, t - d] + k * gap(place_unit(units, x, r, t - d - c, c)[1], target)
                for r, c in cells
                if (r, c, t - d) in scores
            ]
            if before:
                scores[s, d, t] = min(before) + distance
    return min(score for (_, _, t), score in scores.items() if t == last)


def exhaustive_search(units: Units, stretches: Stretches, x: Cloud, k: float) -> tuple[float, list[tuple[int, int]]]:
    """The best of all cell sequences as long as the input, scored by (5)."""
    last = x.count - 1
    cells = cells_of(units, stretches)
    best, row = np.inf, []
    for length in range(1, last // int(stretches.duration[0]) + 1):
        for chosen in itertools.product(cells, repeat=length):
            if sum(d for _, d in chosen) != last:
                continue
            start, score, before = 0, 0.0, None
            for s, d in chosen:
                distance, target = place_unit(units, x, s, start, d)
                score += distance + (0.0 if before is None else k * gap(before, target))
                start, before = start + d, target
            if score < best:
                best, row = score, list(chosen)
    return best, row


@pytest.mark.parametrize("seed", range(3))
def test_reading_is_best_of_all_sequences(seed: int) -> None:
    units = made_units(seed, 4, seconds=(0.4, 0.7))
    stretches = make_stretches(units, 5.0, 0.1)
    x = made_cloud(np.random.default_rng(100 + seed), 10, 5.0)
    score, row = exhaustive_search(units, stretches, x, K)
    reading = decode(x, stretches, k=K)
    assert reading.score == pytest.approx(score, rel=1e-9)
    assert list(zip(reading.unit.tolist(), reading.duration.tolist(), strict=True)) == row
    assert len(row) >= 2


@pytest.mark.parametrize("k", [0.0, K, 20.0])
def test_score_equals_direct_recurrence(k: float) -> None:
    units = made_units(5, 6)
    stretches = make_stretches(units, 4.0, 0.15)
    x = made_cloud(np.random.default_rng(6), 15, 4.0)
    assert decode(x, stretches, k=k).score == pytest.approx(recurrence_score(units, stretches, x, k), rel=1e-9)


def test_wide_beam_is_exact_and_narrow_beam_never_scores_better() -> None:
    units = made_units(7, 40)
    stretches = make_stretches(units, 7.5, 0.15)
    x = made_cloud(np.random.default_rng(8), 300, 7.5)
    exact = decode(x, stretches, k=K)
    wide = decode(x, stretches, k=K, beam=1e9)
    np.testing.assert_array_equal(wide.unit, exact.unit)
    scores = [decode(x, stretches, k=K, beam=beam).score for beam in (0.01, 0.5, 5.0)]
    assert all(score >= exact.score - 1e-9 for score in scores)
    assert scores[0] > exact.score + 1e-3  # too narrow for the optimum
    assert scores[-1] == pytest.approx(exact.score)


def test_block_size_does_not_change_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    units = made_units(9, 20)
    stretches = make_stretches(units, 7.5, 0.15)
    x = made_cloud(np.random.default_rng(10), 90, 7.5)
    whole = decode(x, stretches, k=K)
    monkeypatch.setattr("live.motion.partner.decoder.BLOCK", 7)
    parts = decode(x, stretches, k=K)
    np.testing.assert_array_equal(parts.unit, whole.unit)
    np.testing.assert_array_equal(parts.duration, whole.duration)
    assert parts.score == pytest.approx(whole.score)


def test_input_from_database_units_is_decoded() -> None:
    """The leader dances consecutive units of the database, stretched, turned and moved as one."""
    units = made_units(11, 8)
    stretches = make_stretches(units, 15.0, 0.15)
    of = units.examples[0]
    start, length = float(units.start[2]), float(units.length[2:5].sum())
    frames = round(length / 60.0 * 15.0)
    x = time_scaled(of.control, start, length, frames).transformed(np.exp(0.8j), 2.0 - 1.0j)
    reading = decode(Cloud(x.floor, x.height, 15.0), stretches, k=K)
    assert reading.unit.tolist() == [2, 3, 4]
    np.testing.assert_allclose(np.angle(reading.turn), 0.8, atol=0.05)
    np.testing.assert_allclose(reading.shift, 2.0 - 1.0j, atol=0.05)


def test_free_ends_are_skipped_without_cost() -> None:
    units = made_units(12, 10)
    stretches = make_stretches(units, 10.0, 0.1)
    x = made_cloud(np.random.default_rng(13), 60, 10.0)
    free = decode(x, stretches, k=K, free_start=6, free_end=6)
    assert free.score <= decode(x, stretches, k=K).score
    assert 0 <= free.start[0] <= 6
    assert 53 <= free.start[-1] + free.duration[-1] <= 59


def test_input_shorter_than_any_unit_is_refused() -> None:
    units = made_units(14, 3)
    stretches = make_stretches(units, 10.0, 0.1)
    with pytest.raises(PersonError, match="no sequence of units"):
        decode(made_cloud(np.random.default_rng(15), 3, 10.0), stretches, k=K)


@pytest.mark.parametrize(
    ("seconds", "rate", "stretch", "expected"),
    [(0.8, 7.5, 0.15, [5, 6, 7]), (0.8, 30.0, 0.15, [20, 21, 22, 23, 24, 25, 26, 27, 28]), (0.33, 4.0, 0.0, [1])],
)
def test_legal_durations_follow_stretch_limit(seconds: float, rate: float, stretch: float, expected: list[int]) -> None:
    assert list(legal_durations(seconds, rate, stretch)) == expected
