"""Tests of the ring buffer between the audio callback and the analysis."""

import tracemalloc

import numpy as np

from live.control.audio.block_stamps import STAMPS
from live.control.audio.device_stream import RingBuffer


def test_written_samples_are_read_once_in_order() -> None:
    ring, sound, read = RingBuffer(1000, 2), np.arange(9000, dtype=np.float32), []
    sizes = np.random.default_rng(0).integers(1, 250, 60)
    start = 0
    for size in sizes:
        block = sound[start : start + size]
        ring.write(np.stack([block, -block], axis=1), 0.0)
        start += size
        read.append(ring.read().copy())
    both = np.concatenate(read)
    assert np.array_equal(both[:, 0], sound[:start])
    assert np.array_equal(both[:, 1], -sound[:start])
    assert ring.overrun == 0


def test_late_reader_loses_oldest_samples_and_counts_overrun() -> None:
    ring = RingBuffer(1000, 1)
    for start in range(0, 5000, 100):
        ring.write(np.arange(start, start + 100, dtype=np.float32)[:, None], start / 1000.0)
    assert ring.read()[:, 0].tolist() == list(range(4500, 5000))
    assert ring.overrun == 4500
    assert ring.read().shape == (0, 1)


def test_stamps_hold_frame_counts_and_times() -> None:
    ring = RingBuffer(1000, 1)
    ring.write(np.zeros((64, 1), np.float32), 1.0)
    ring.write(np.zeros((64, 1), np.float32), 2.0)
    assert [ring.stamps.pop(), ring.stamps.pop(), ring.stamps.pop()] == [(64, 1.0), (128, 2.0), None]


def test_block_longer_than_ring_keeps_its_end() -> None:
    ring = RingBuffer(10, 1)
    ring.write(np.arange(25, dtype=np.float32)[:, None], 0.0)
    assert ring.read()[:, 0].tolist() == [20, 21, 22, 23, 24]


def test_late_reader_receives_newest_stamps() -> None:
    ring = RingBuffer(1000, 1)
    for n in range(2 * STAMPS):
        ring.write(np.zeros((8, 1), np.float32), float(n))
    times = []
    while (stamp := ring.stamps.pop()) is not None:
        times.append(stamp)
    assert times == [(8 * (n + 1), float(n)) for n in range(STAMPS + STAMPS // 2, 2 * STAMPS)]


def test_ring_allocates_no_memory_per_block() -> None:
    ring, block = RingBuffer(48_000, 2), np.zeros((512, 2), np.float32)
    for _ in range(100):
        ring.write(block, 0.0)
        ring.read()
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        for _ in range(200):
            ring.write(block, 0.0)
            ring.read()
            ring.stamps.pop()
        now, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert now - before < 1000
    assert peak - before < block.nbytes  # not one block, for a moment, either
