from dataclasses import replace

import numpy as np
import pytest

from live.motion.editing.foot_correction import find_feet
from live.motion.editing.variation import LOWER, UPPER, combine
from live.motion.skeleton import SKELETON
from tests.motion.editing.made_steps import random_step, sketched_step


def test_upper_body_starts_at_spine() -> None:
    below = {"spine"}
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0 and SKELETON.names[parent] in below:
            below.add(SKELETON.names[joint])
    assert {SKELETON.names[j] for j in UPPER} == below
    assert sorted(UPPER + LOWER) == list(range(SKELETON.joint_count))


def test_legs_and_arms_come_from_different_steps() -> None:
    lower, upper = random_step(1), random_step(2)
    both = combine(lower, upper)
    assert np.array_equal(both.clip.rotation[:, LOWER], lower.clip.rotation[:, LOWER])
    assert np.array_equal(both.clip.rotation[:, UPPER], upper.clip.rotation[:, UPPER])
    assert np.array_equal(both.clip.root_position, lower.clip.root_position)
    assert np.array_equal(both.clip.contact, lower.clip.contact)
    assert np.array_equal(find_feet(both.clip).ball, find_feet(lower.clip).ball)


def test_step_combined_with_itself_stays_unchanged() -> None:
    step = sketched_step("samba")
    assert np.array_equal(combine(step, step).clip.rotation, step.clip.rotation)


def test_different_tempos_are_aligned_by_measure() -> None:
    lower = sketched_step("walk")
    clip = lower.clip
    part = slice(None, None, 2)
    slow = replace(
        lower,
        clip=replace(
            clip,
            rotation=np.ascontiguousarray(clip.rotation[part]),
            root_position=np.ascontiguousarray(clip.root_position[part]),
            contact=np.ascontiguousarray(clip.contact[part]),
        ),
        first=lower.first / 2,
        samples_per_measure=lower.samples_per_measure / 2,
    )
    assert np.abs(np.sum(combine(lower, slow).clip.rotation * clip.rotation, axis=-1)).min() > 0.9999


def test_shorter_tail_holds_last_pose() -> None:
    lower, upper = random_step(1), random_step(2)
    cut = {name: getattr(upper.clip, name)[:-4].copy() for name in ("rotation", "root_position", "contact")}
    both = combine(lower, replace(upper, clip=replace(upper.clip, **cut)))
    assert np.array_equal(both.clip.rotation[-1, UPPER], upper.clip.rotation[-5, UPPER])


def test_different_steps_are_refused() -> None:
    with pytest.raises(ValueError, match="'step' and 'other' are different steps"):
        combine(random_step(1), random_step(2, "other"))
