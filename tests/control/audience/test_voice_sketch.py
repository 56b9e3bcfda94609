"""Tests of sketches of voices: those of several gateways give together what one gateway would; hostile bytes."""

import itertools
import math

import numpy as np
import pytest

from live.control.audience.participant_state import Voices
from live.control.audience.phone_protocol import ATTRACT, REPEL
from live.control.audience.voice_sketch import (
    CELL,
    MAX_CELLS,
    MAX_SKETCH_BYTES,
    UNIT,
    VoiceSketch,
    grid_of,
    merge,
)

HALF = (6.0, 4.0)


def crowd(chance, count):
    """Places (x, z) [m], modes, parts of a voice and seconds since the last message of `count` phones."""
    centres = chance.uniform((-5, -3), (5, 3), (4, 2))
    kind = chance.choice(4, count, p=(0.4, 0.3, 0.2, 0.1))
    place = np.clip(chance.normal(centres[kind], 0.6), (-6, -4), (6, 4))
    return (
        place,
        np.where(kind == 1, REPEL, ATTRACT),
        chance.choice((1.0, 1.0, 0.5, 1 / 3), count),
        chance.uniform(0, 4, count),
    )


def voices_of(place, mode, share, age, rows, half=HALF):
    voices = Voices(len(rows) + 8)
    voices.update_rules((), (), half)
    for number in rows:
        row = voices.add(int(number) + 1, 0, allowed=True)
        (voices.x[row], voices.z[row]), voices.mode[row], voices.share[row] = place[number], mode[number], share[number]
        voices.message_time[row] = 10.0 - age[number]
        voices.shake_time[row] = 10.0 if number % 3 == 0 else -1.0
    return voices


@pytest.mark.parametrize("shards", [1, 4, 16])
def test_merged_sketches_of_shards_give_the_force_of_one_gateway(shards):
    chance = np.random.default_rng(40 + shards)
    for count in (3, 40, 6000):
        people = crowd(chance, count)
        whole = voices_of(*people, np.arange(count)).sketch(10.0).force()
        shard = chance.integers(shards, size=count)
        parts = [voices_of(*people, np.flatnonzero(shard == k)).sketch(10.0).encode() for k in range(shards)]
        assert max(map(len, parts)) <= MAX_SKETCH_BYTES <= 5000
        force = merge(grid_of(HALF), map(VoiceSketch.decode, parts)).force()
        assert len(force.places) == len(whole.places) >= 1
        for found, wanted in zip(force.places, whole.places, strict=True):
            assert math.hypot(found.x - wanted.x, found.z - wanted.z) <= 0.05
            assert found.weight == pytest.approx(wanted.weight, rel=0.02)
            assert found.mode == wanted.mode
        assert force.share == pytest.approx(whole.share, rel=0.02)
        assert force.shaken == pytest.approx(whole.shaken, rel=1e-3)


def test_merging_does_not_depend_on_order_or_grouping():
    chance, grid = np.random.default_rng(7), grid_of(HALF)
    people = crowd(chance, 300)
    whole = voices_of(*people, np.arange(300)).sketch(10.0)
    parts = [voices_of(*people, rows).sketch(10.0) for rows in np.array_split(chance.permutation(300), 4)]
    told = [VoiceSketch.decode(part.encode()) for part in parts]
    wanted = merge(grid, told)
    for order in itertools.permutations(told):
        a, b, c, d = order
        for grouped in (merge(grid, order), merge(grid, (merge(grid, (a, b)), merge(grid, (c, d))))):
            assert np.array_equal(grouped.sums, wanted.sums)
            assert (grouped.people, grouped.shaken) == (wanted.people, wanted.shaken)
    exact = merge(grid, parts)  # before it is put into bytes nothing is rounded
    assert np.array_equal(exact.sums, whole.sums)
    assert exact.force() == whole.force()


def test_sketch_of_a_full_stage_is_small_and_nearly_exact():
    for half in ((6.0, 4.0), (20.0, 11.3), (0.3, 0.2)):
        grid = grid_of(half)
        assert grid.cells <= MAX_CELLS
        assert grid.cell >= CELL
        chance = np.random.default_rng(3)
        place = chance.uniform((-half[0], -half[1]), half, (20_000, 2))
        sketch = VoiceSketch.of_voices(
            grid, place[:, 0], place[:, 1], np.full(20_000, UNIT), chance.choice((1, 2), 20_000).astype(np.int8),
            20_000 * UNIT, 5 * UNIT,
        )  # fmt: skip
        data = sketch.encode()
        assert len(data) <= MAX_SKETCH_BYTES
        again = VoiceSketch.decode(data)
        assert again.total() == pytest.approx(sketch.total(), rel=1e-3)
        for found, wanted in zip(again.force().places, sketch.force().places, strict=True):
            assert math.hypot(found.x - wanted.x, found.z - wanted.z) < 0.05
        assert VoiceSketch.decode(again.encode()).encode() == again.encode()


def test_hostile_bytes_are_refused():
    good = voices_of(*crowd(np.random.default_rng(1), 50), np.arange(50)).sketch(10.0).encode()
    sizes = {len(good) - 1: good[:-1], len(good) + 1: good + b"\0", 3: good[:3], 5001: good + bytes(5001)}
    for data in (*sizes.values(), b"", bytes((2, *good[1:])), bytes([good[0]]) + bytes(len(good) - 1)):
        with pytest.raises(ValueError, match="expected"):
            VoiceSketch.decode(data)
    flags = 33
    for half in (np.nan, np.inf, -1.0, 1e9):
        with pytest.raises(ValueError, match="half sizes"):
            VoiceSketch.decode(good[:1] + np.float64(half).tobytes() + good[9:])
    count = sum(value.bit_count() for value in good[flags : flags + 150])
    for weight in (np.nan, np.inf, -1.0, 0.0):
        bad = good[: flags + 150] + np.float16(weight).tobytes() + good[flags + 152 :]
        assert len(bad) == len(good) == flags + 150 + 4 * count
        with pytest.raises(ValueError, match="weights"):
            VoiceSketch.decode(bad)
    chance = np.random.default_rng(5)
    for _ in range(300):
        data = bytearray(good)
        for at in chance.integers(len(good), size=4):
            data[at] = chance.integers(256)
        try:
            VoiceSketch.decode(bytes(data)).force()
        except ValueError:
            continue


def test_another_stage_is_left_out_and_a_share_reduces_voices_and_people_alike():
    people = crowd(np.random.default_rng(2), 100)
    sketch = voices_of(*people, np.arange(100)).sketch(10.0)
    other = voices_of(*people, np.arange(100), half=(5.0, 5.0)).sketch(10.0)
    assert np.array_equal(merge(sketch.grid, (sketch, other)).sums, sketch.sums)
    half = sketch.scaled(0.5)
    assert half.total() == pytest.approx(sketch.total() / 2, rel=1e-3)
    assert half.force().share == pytest.approx(sketch.force().share, rel=2e-3)
