"""Tests of names of found steps: sketches, whose movement is known, and the law of the mirror."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.graph.vocabulary.measures import measures_of
from live.graph.vocabulary.step_names import StepFacts, describe_step, name_steps, standing_heights, step_facts
from live.library.step_folder import load_folder
from live.motion.mirror import mirror_clip, swap_sides
from live.motion.skeleton import MIRROR, SKELETON
from live.show.patch.patch_search_path import PATCHES
from tests.fixtures.made_steps import made_clip

HEIGHTS = (0.93, 0.09)


def facts_of(step, clip=None):
    """Facts of a step's clip."""
    clip = step.clip if clip is None else clip
    lines = (step.first + np.arange(step.measures + 1) * step.samples_per_measure) / clip.sample_rate
    measures = measures_of([clip], [lines], step.beats_per_measure)
    return step_facts(measures, 0, step.measures), standing_heights(measures)


@pytest.fixture(scope="module")
def sketches():
    return load_folder(Path(PATCHES / "steps"))


@pytest.mark.parametrize(
    ("made", "name"),
    [
        (made_clip("a"), "stand"),
        (made_clip("a", way=(0.0, 0.4)), "step forward"),
        (made_clip("a", way=(0.0, -0.4)), "step back"),
        (made_clip("a", way=(0.8, 0.1)), "travel left"),
        (made_clip("a", way=(-0.4, 0.1)), "step right"),
        (made_clip("a", turn=np.pi / 2), "quarter turn left"),
        (made_clip("a", turn=-np.pi), "half turn right"),
        (made_clip("a", turn=2 * np.pi), "full turn left"),
        (made_clip("a", measures=2, turn=np.pi), "full turn left"),
        (made_clip("a", arm=-1.3), "stand, arms high"),
        (made_clip("a", arm=0.0), "stand, arms wide"),
    ],
)
def test_names_say_what_is_danced(made, name):
    assert describe_step(*facts_of(made)) == name


@pytest.mark.long
def test_a_mirrored_step_has_the_mirrored_name(sketches):
    """Left and right are exchanged, and nothing else: for every sketch in every direction."""
    told = 0
    for step in sketches:
        name = describe_step(*facts_of(step))
        other = describe_step(*facts_of(step, mirror_clip(step.clip)))
        assert other == swap_sides(name), step.clip.name
        told += name != other
    assert told > 20


def test_sketches_that_travel_are_named_by_their_direction(sketches):
    for step in sketches:
        size, _, where = step.direction.partition(" ")
        facts, heights = facts_of(step)
        if size == "long" and abs(facts.turn) < 0.5 and facts.distance_m > 0.6:
            assert where in describe_step(facts, heights).split(",")[0], (step.step, step.direction)


def test_jumps_kicks_and_low_steps():
    facts, heights = facts_of(made_clip("a"))
    jump = facts.pose.copy()
    jump[6:9, :, 1] += 0.25
    assert describe_step(replace(facts, pose=jump), heights) == "jump in place"
    kick = facts.pose.copy()
    kick[6:9, SKELETON.index("rightFoot"), 1] += 0.8
    assert describe_step(replace(facts, pose=kick), heights) == "stand, kick right"
    low = facts.pose.copy()
    low[:, SKELETON.index("hips"), 1] -= 0.25
    assert describe_step(replace(facts, pose=low), heights) == "stand, low"
    low[:, SKELETON.index("hips"), 1] -= 0.4
    assert describe_step(replace(facts, pose=low), heights) == "stand on the floor"


def test_equal_names_are_numbered_and_taken_ones_left_out():
    facts, _ = facts_of(made_clip("a", way=(0.0, 0.4)))
    still, _ = facts_of(made_clip("b"))
    assert name_steps([facts, still, facts, facts], HEIGHTS) == [
        "step forward", "stand", "step forward 2", "step forward 3",
    ]  # fmt: skip
    assert name_steps([facts, facts], HEIGHTS, ["Step_Forward 2", "STEP-forward"]) == [
        "step forward 3", "step forward 4",
    ]  # fmt: skip


def test_names_do_not_depend_on_where_the_step_was_danced():
    made = made_clip("a", way=(0.3, 0.5), turn=0.3, arm=-1.0)
    facts, heights = facts_of(made)
    moved = replace(made.clip, root_position=made.clip.root_position + np.array((3.0, 0.0, -2.0), np.float32))
    again, _ = facts_of(made, moved)
    assert isinstance(again, StepFacts)
    assert again.pose == pytest.approx(facts.pose, abs=1e-5)
    assert describe_step(again, heights) == describe_step(facts, heights)
    assert list(MIRROR) != list(range(len(MIRROR)))
