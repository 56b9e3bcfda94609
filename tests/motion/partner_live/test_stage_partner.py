"""Tests of reading a stage leader in beats: independent of tempo, held on request, stops and NaN handled."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion.partner.sketched_examples import PARTNER_DISTANCE, sketched_pairs
from live.motion.partner.units import Hold, Units, retime_to_beats
from live.motion.partner_live.stage_partner import RECORDING_RATE, LeaderReader, PartnerExamples, frames_per_beat
from tests.fixtures.made_steps import made_steps
from tests.motion.partner.made_examples import made_units

TEMPO = 120.0


def examples_of(units: Units) -> PartnerExamples:
    per_beat = frames_per_beat(TEMPO)
    timed = retime_to_beats(units, unit_beats=2, samples=frames_per_beat(TEMPO, RECORDING_RATE), period=60.0 / TEMPO)
    return PartnerExamples(timed, unit_beats=2, per_beat=per_beat, tempo=TEMPO, stretch=0.15)


EXAMPLES = examples_of(made_units(5, 12))


def read_units(order: list[int], *, ticks_per_beat: float = 32.0) -> tuple[LeaderReader, list[str]]:
    """Reader after a leader danced these units in order, with so many ticks a beat, and the labels it decided."""
    read, labels = LeaderReader(EXAMPLES), []
    (example,) = EXAMPLES.units.examples
    for tick in range(int(ticks_per_beat * 2 * len(order))):
        danced = tick / ticks_per_beat
        if read.frames_due(danced):
            unit = order[int(danced / 2.0)]
            at = EXAMPLES.units.start[unit] + danced % 2.0 / 2.0 * EXAMPLES.units.length[unit]
            cloud = example.live_control.at(np.array([at]))
            read.process_frame(cloud.floor[0], cloud.height[0], danced, 0.04)
            labels += [read.decided_label] if read.decided_label else []
    return read, labels


def test_retimed_units_have_equal_length_and_same_content() -> None:
    units = made_units(7, 6)
    (example,) = units.examples
    whole = replace(example, holds=(Hold(0, 1, float(example.cuts[1]), float(example.cuts[3])),), beats=example.cuts)
    timed = retime_to_beats(replace(units, examples=(whole,)), unit_beats=2, samples=20, period=0.5)
    assert np.allclose(timed.length, 40.0)
    assert np.allclose(timed.seconds, 1.0)
    (new,) = timed.examples
    for n, (start, own) in enumerate(zip(timed.start, units.start, strict=True)):
        for part in (0.0, 0.3, 0.99):
            at = new.control.at(np.array([start + 40.0 * part])).floor
            assert np.allclose(at, example.control.at(np.array([own + units.length[n] * part])).floor, atol=2e-3)
    assert np.allclose(new.beats, new.cuts)
    assert (new.holds[0].begin, new.holds[0].end) == (new.cuts[1], new.cuts[3])


@pytest.mark.long
def test_units_are_recognized_at_any_tempo() -> None:
    order = [2, 3, 4, 5, 6, 7, 8, 9]
    for ticks in (32.0, 64.0 * 60.0 / 90.0, 64.0 * 60.0 / 200.0, 9.0):
        _, labels = read_units(order, ticks_per_beat=ticks)
        right = [f"made/{unit + 1}" for unit in order]
        assert sum(label in labels for label in right[1:]) >= len(right) - 2, ticks


def test_still_leader_is_detected_and_nan_is_ignored() -> None:
    read, _ = read_units([3, 7, 1])
    before, latest = read.root.copy(), read.partner.filter.frame_index
    floor, height = read._points, read._heights
    for n in range(1, 6):
        read.process_frame(floor * np.nan, height, 6.0 + n / read.examples.per_beat, 0.04)
    assert read.still_frames >= 5.0
    assert read.partner.filter.frame_index == latest
    assert np.array_equal(read.root, before)
    read.process_frame(floor, height, 6.0 + 6 / read.examples.per_beat, 0.04)
    assert read.still_frames >= 6.0  # the leader stands still
    read.process_frame(floor + 0.01, height, 6.0 + 7 / read.examples.per_beat, 0.04)
    assert read.still_frames == 0.0


def test_held_answer_stays_until_release() -> None:
    read, _ = read_units([3, 7, 1])
    read.hold(0.25)
    assert not read.answering
    assert np.array_equal(read.root[0], read.root[2])
    held = read.root.copy()
    for tick in range(64 * 3):
        if read.frames_due(tick / 32.0):
            read.process_frame(read._points + 0.01 * np.sin(tick), read._heights, tick / 32.0, 0.04)
    assert read.partner.has_pose
    assert not read.answering
    assert np.array_equal(read.root, held)
    read.release()
    assert read.answering


def test_sketched_pairs_keep_their_distance() -> None:
    units = sketched_pairs(made_steps(), unit_beats=2)
    assert units.count >= 12
    for one in units.examples:
        between = one.target.floor.mean(axis=1) - one.control.floor.mean(axis=1)
        assert np.abs(np.abs(between) - PARTNER_DISTANCE).max() < 0.25, one.name
