"""Tests of arm clearance in a show: dancers side by side keep apart, groups choose, and drawing changes no state."""

import numpy as np
import pytest

from live.control.registry.registry import REGISTRY
from live.motion.quality.body_contact import ContactRecorder
from live.show.assembly import assemble
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from tests.places import ROOT

PATCH = """
name = "close"
seed = 5
reserve = 0
[clock]
bpm = 112
[[group]]
name = "one"
dancers = 8
steps = ["reach"]
formation = "grid"
size = [2.4, 1.2]
[[group]]
name = "other"
dancers = 4
steps = ["reach"]
formation = "grid"
centre = [0.0, 2.5]
size = [2.4, 1.2]
"""


@pytest.fixture(scope="module")
def loaded():
    return load_from_patch(parse_patch(PATCH, "close.toml"), ROOT / "patches" / "close.toml")


def danced(loaded, *calls, seconds=4.0):
    """The show after `seconds`, its last picture, and the contacts of its pictures."""
    show, recorder = assemble(loaded.patch, loaded.graph), ContactRecorder()
    for address, values in calls:
        assert show.apply(REGISTRY.call(address, values, show.time, "osc"))
    view = show.view()
    for tick in range(1, round(seconds * 64)):
        show.tick(tick / 64)
        if tick % 2 == 0:
            show.fill(view, tick / 64)
            recorder.add(view.joint_position, show.dancers.held_arms(view.time), view.present)
    return show, view, recorder.ratios()


@pytest.mark.long
def test_neighbours_keep_apart_unless_arms_are_left_as_danced(loaded):
    _, _, kept = danced(loaded)
    _, _, left = danced(loaded, ("/dance/motion/arm_clearance", (0.0,)))
    assert left["neighbour_contact_ratio"] > 0.05
    assert kept["neighbour_contact_ratio"] < 0.02
    assert kept["self_contact_ratio"] <= 0.01


@pytest.mark.long
def test_a_group_leaves_its_arms_as_danced(loaded):
    whole, some, none = (
        danced(loaded, *calls, seconds=1.5)[1].joint_position
        for calls in (
            (),
            (("/dance/motion/arm_clearance", (0.0, "one")),),
            (("/dance/motion/arm_clearance", (0.0,)),),
        )
    )
    np.testing.assert_array_equal(some[:8], none[:8])
    np.testing.assert_array_equal(some[8:], whole[8:])
    assert np.abs(whole - none).max() > 0.01


@pytest.mark.long
def test_who_is_off_stage_is_in_nobodys_way(loaded):
    show = danced(loaded, seconds=1.5)[0]
    alone = np.zeros(12, np.bool_)
    seen = show.dancers.pose(0.5, show.time, visible=~alone)[0].copy()
    unseen = show.dancers.pose(0.5, show.time, visible=alone)[0].copy()
    assert np.abs(seen - unseen).max() > 0.01
    np.testing.assert_array_equal(show.dancers.pose(0.5, show.time, visible=~alone)[0], seen)


def test_drawing_changes_no_state(loaded):
    often, seldom = assemble(loaded.patch, loaded.graph), assemble(loaded.patch, loaded.graph)
    view = often.view()
    for tick in range(1, 160):
        often.tick(tick / 64)
        seldom.tick(tick / 64)
        often.fill(view, tick / 64)
    assert often.state_hash() == seldom.state_hash()
