"""Copies of a choreography are found, and no split has copies on both sides."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion.texture.frequency_bands import RATE, SampledClip, sample_clip
from live.motion.texture.take_splits import TakeCopy, choreographies, find_copies, make_folds
from tests.motion.texture.made_dance import dance, improvisation


def part(take: SampledClip, first: int, last: int) -> SampledClip:
    return replace(take, root=take.root[first:last], rotation=take.rotation[first:last])


def test_unison_with_a_lag_is_found_among_other_takes() -> None:
    whole = sample_clip(improvisation(20.0, 1))
    other = sample_clip(improvisation(15.0, 2))
    copies = find_copies([part(whole, 48, 400), other, part(whole, 0, 400)])
    assert [(copy.first, copy.second) for copy in copies] == [(0, 2)]
    assert copies[0].lag_s == pytest.approx(-48 / RATE, abs=1.0 / RATE)
    assert copies[0].correlation > 0.95
    dances = choreographies(3, copies)
    assert dances.number.tolist() == [0, 1, 0]
    assert dances.offset[2] - dances.offset[0] == round(copies[0].lag_s * RATE)


def test_walkers_agree_at_every_stride_and_are_no_copies() -> None:
    first, second = (sample_clip(dance(12.0, 0).clip) for _ in range(2))
    t = np.arange(len(first.root)) / RATE
    for take, late in ((first, 0.0), (second, 0.3)):
        take.rotation[:] = (1.0, 0.0, 0.0, 0.0)
        for joint, sign in ((14, 1.0), (18, -1.0)):
            swing = 0.2 * sign * np.sin(2.0 * np.pi * (t - late))
            take.rotation[:, joint, 0], take.rotation[:, joint, 1] = np.cos(swing), np.sin(swing)
    assert find_copies([first, second]) == ()


def test_takes_who_stand_are_no_copies_and_make_folds() -> None:
    still = sample_clip(dance(6.0, 0).clip)
    still.rotation[:] = (1.0, 0.0, 0.0, 0.0)
    assert find_copies([still, still]) == ()


def test_no_fold_has_copies_on_both_sides() -> None:
    chance = np.random.default_rng(3)
    for _ in range(50):
        count = int(chance.integers(2, 14))
        lengths = chance.integers(30, 400, count)
        copies = [
            TakeCopy(int(min(pair)), int(max(pair)), float(chance.uniform(-5.0, 5.0)), 0.9)
            for pair in chance.integers(0, count, (int(chance.integers(0, count)), 2))
            if pair[0] != pair[1]
        ]
        dances = choreographies(count, copies)
        take = np.repeat(np.arange(count), lengths)
        folds = make_folds(lengths.tolist(), dances)
        assert (np.sum([fold.tested for fold in folds], axis=0) <= 1).all()
        if dances.count > 1:
            assert np.all(np.sum([fold.tested for fold in folds], axis=0) == 1)
        for fold in folds:
            assert not (fold.learnt & fold.tested).any()
            if dances.count > 1:
                for copy in copies:
                    sides = [set(fold.tested[take == one].tolist()) for one in (copy.first, copy.second)]
                    assert sides[0] == sides[1]


def test_only_choreography_is_left_out_in_parts_with_a_gap() -> None:
    folds = make_folds([240], choreographies(1, ()))
    assert len(folds) == 4
    for fold in folds:
        near = np.abs(np.flatnonzero(fold.learnt)[:, None] - np.flatnonzero(fold.tested)).min()
        assert near > RATE - 1
