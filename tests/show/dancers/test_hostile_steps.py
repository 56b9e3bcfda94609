"""Tests of steps and moods at their limits: jumps in moods, one key, hands in the trunk, 200 bpm, 24 counts in 5/4."""

import numpy as np
import pytest

from live.base.motion_parameters import MOOD_NAMES
from live.clock.ticks import TICK
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.library.step_folder import StepsError, sketched_steps
from live.motion.quality.body_contact import self_contacts
from live.motion.quality.metrics import StandingFeet
from live.motion.skeleton import SKELETON
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from tests.fixtures.mostly_long import mostly_long
from tests.show.dancers.danced_step import GROUP, PATCH, danced_step, shipped

HIPS = SKELETON.index("hips")
FEET = [SKELETON.index(side + name) for side in ("left", "right") for name in ("Foot", "Toes")]
ENDS = [f"{name} = {end}" for name in MOOD_NAMES for end in (-1.0, 1.0)]


def mean_slide(position):
    """Mean speed over the floor of the feet that stand [m/s], of one dancer (T, J, 3)."""
    feet = StandingFeet(1.0 / TICK)
    for joints in position:
        feet.add(joints[None])
    return feet.speeds().mean()


@pytest.mark.long
def test_a_jump_flies_and_lands_at_every_end_of_every_mood():
    """The flight takes as long, the hips fly the same arc, and the feet land without sliding or going into the floor.

    The mood of time makes movements between beats slower or faster, flights as well: by less than 30 %.
    """
    moods = ["", *ENDS]
    found = danced_step(shipped("jump"), moods=moods)
    lowest = found[:, :, FEET, 1].min(axis=2)
    assert lowest.min() > -0.005
    hips = found[:, :, HIPS, 1]
    flight = (lowest > lowest.min() + 0.05).mean(axis=0)
    for dancer in range(len(moods)):
        share = 0.3 if "time" in moods[dancer] else 0.05
        assert flight[dancer] == pytest.approx(flight[0], rel=share), moods[dancer]
        assert np.ptp(hips[:, dancer]) == pytest.approx(np.ptp(hips[:, 0]), abs=0.06), moods[dancer]
        assert mean_slide(found[:, dancer]) < 0.03, moods[dancer]


ONE_PART = '[chest]\n"1" = "turn left 20"\n'


@mostly_long("part", ['[chest]\n"1" = "turn left 20"', '[left_foot]\n"1" = "out 10"',
                                  '[left_hand]\n"3" = "out 40, up 20"', '[pelvis]\n"2" = "down 10"'],
    quick=[])  # fmt: skip
def test_a_sketch_of_one_key_is_danced_step(part):
    found = danced_step(f'name = "still"\n{part}\n', seconds=3.0)
    assert np.isfinite(found).all()
    assert np.ptp(found[:, 0, FEET], axis=0).max() < 0.02  # nothing says that a foot is lifted
    assert np.linalg.norm(np.diff(found, axis=0), axis=-1).max() < 0.05


IN_THE_TRUNK = """
name = "buried"
[hands]
"1" = "in 20, down 30, back 5"
"2" = "in 25, up 0, forward 0"
"3" = "in 20, down 50, forward 2"
"4" = "in 15, down 20, back 15"
"""


@pytest.mark.long
def test_hands_that_want_to_be_in_the_trunk_stay_outside():
    found = danced_step(IN_THE_TRUNK, seconds=4.0)[:, 0]
    inside = np.mean([self_contacts(one[None]).any() for one in found])
    assert inside < 0.02
    assert np.linalg.norm(np.diff(found, axis=0), axis=-1).max() / TICK < 9.0  # m/s


@mostly_long("name", ["samba", "jump", "mambo", "turn"], quick=[])
def test_steps_at_200_bpm_stay_on_the_floor(name):
    found = danced_step(shipped(name), bpm=200, moods=["", "time = 1.0", "flow = 1.0, energy = 1.0"])
    assert found[:, :, FEET, 1].min() > -0.005
    for dancer in range(found.shape[1]):
        assert mean_slide(found[:, dancer]) < 0.04


def test_24_counts_are_no_whole_measures_of_five():
    text = 'name = "long"\nbeats = 24\nbeats_per_measure = 5\n[chest]\n"1" = "turn left 20"\n'
    with pytest.raises(
        StepsError, match=r"step\.toml:2: beats: 24 beats are not whole measures; make beats a multiple"
    ):
        sketched_steps({"step.toml": text})


def test_25_counts_in_five_are_danced_step():
    keys = "".join(f'"{count}" = "{"out 16" if count % 2 else "home, lift 6"}"\n' for count in range(1, 25, 2))
    text = f'name = "long"\nbeats = 25\nbeats_per_measure = 5\n[left_foot]\n{keys}'
    found = danced_step(text, beats=5, seconds=6.0, moods=["", "energy = -1.0"])
    assert np.isfinite(found).all()
    assert mean_slide(found[:, 0]) < 0.03


def test_the_first_measure_has_the_wanted_side():
    clips = sketched_steps({"step.toml": f'name = "still"\n{ONE_PART}'})
    group = GROUP.format(number=0, step="still", x=0.0, mood="")
    mirrored = group.replace('"g0"', '"g1"').replace('steps = ["still"]', 'like = "g0"\nmirrored = true')
    patch = parse_patch(PATCH.format(bpm=112, beats=4) + group + mirrored, "hostile.toml")
    show = assemble(patch, build_graph(build_library(clips)))
    assert show.graph.library.node_side[show.dancers.node].tolist() == [-1, 1]
