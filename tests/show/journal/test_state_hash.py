"""Tests of the state hash: any changed bit changes the hash; memory layout does not."""

import numpy as np

from live.show.journal.state_hash import hash_of


def test_single_bit_changes_hash() -> None:
    state = np.arange(6.0)
    other = state.copy()
    other[3] = np.nextafter(other[3], 9.0)
    assert hash_of(state) == hash_of(state.copy())
    assert hash_of(state) != hash_of(other)
    assert hash_of(np.array([0.0])) != hash_of(np.array([-0.0]))


def test_strided_array_has_hash_of_contiguous_array() -> None:
    wide = np.arange(12, dtype=np.int32).reshape(3, 4)
    assert hash_of(wide[:, ::2]) == hash_of(np.ascontiguousarray(wide[:, ::2])) != hash_of(wide[:, 1::2])
