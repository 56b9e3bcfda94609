import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion.editing.facing import heading_of
from live.motion.editing.turn_insertion import insert_rotation
from live.motion.mirror import mirror_clip, mirror_step
from tests.motion.editing.made_steps import random_clip, sketched_step


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_clip_mirrored_twice_stays_unchanged(seed: int) -> None:
    clip = random_clip(seed)
    again = mirror_clip(mirror_clip(clip))
    assert np.array_equal(again.root_position, clip.root_position)
    assert np.array_equal(again.rotation, clip.rotation)
    assert np.array_equal(again.contact, clip.contact)
    assert not np.array_equal(mirror_clip(clip).rotation, clip.rotation)


@pytest.mark.long
@settings(max_examples=10, deadline=None)
@given(st.sampled_from(("walk", "kick", "samba")), st.floats(-3.0, 3.0))
def test_mirroring_reverses_inserted_rotation(name: str, angle: float) -> None:
    step = sketched_step(name)
    one = insert_rotation(mirror_step(step), angle).clip
    other = mirror_clip(insert_rotation(step, -angle).clip)
    assert np.allclose(one.root_position, other.root_position, atol=1e-5)
    assert np.allclose(np.cos(heading_of(one.rotation[:, 0]) - heading_of(other.rotation[:, 0])), 1.0, atol=1e-5)
