"""Tests of moods learnt from examples (T143): a change made on purpose is found again, and moves other steps."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.motion_parameters import MOOD_NAMES
from live.graph.library_insert import insert_clips
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.library.recording_file import RecordingError
from live.library.recordings import recorded_steps
from live.library.step_folder import read_step_files, sketched_steps
from live.motion import quaternion
from live.motion.mirror import mirror_step
from live.motion.pose.mood_examples import learnt_ends
from live.motion.pose.mood_pose import ENERGY, FIRST, LAST, PARAMETRIC, WEIGHT
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import step_clips
from live.motion.sketch.sketch_file import SketchError, parse_sketch
from live.show.score.step_names import UnknownStep, find_step
from tests.places import ROOT, SHARED

STEPS = ROOT / "patches" / "steps"
WALKS = SHARED / "mocap" / "walk"
UPPER, LOWER = 0, 1
CHEST, LEFT_ARM, RIGHT_ARM = (SKELETON.index(name) - FIRST for name in ("chest", "leftUpperArm", "rightUpperArm"))


def steps_of(name):
    return step_clips(parse_sketch((STEPS / f"{name}.toml").read_text(encoding="utf-8"), f"{name}.toml"))


def mood(**ends):
    return tuple(ends.get(name, 0.0) for name in MOOD_NAMES)


def changed(step, *, bend, size=1.0, drop=0.0):
    """The step with joints bent about their parents' axes by rotation vectors [rad], smaller or larger, and lower."""
    clip = step.clip
    rotation, root = clip.rotation.astype(np.float64), clip.root_position - np.float32((0.0, drop, 0.0))
    upper = rotation[:, FIRST:LAST]
    begin = round(step.first)
    mean = quaternion.mean_rotation(upper[begin : begin + round(step.measures * step.samples_per_measure)])
    upper = quaternion.scale_about_mean(mean, upper, size)
    for joint, vector in bend.items():
        upper[:, joint] = quaternion.mul(quaternion.from_rotation_vector(np.array(vector)), upper[:, joint])
    rotation[:, FIRST:LAST] = upper
    return replace(step, clip=replace(clip, name=clip.name + ", changed", rotation=rotation.astype(np.float32),
                                      root_position=root))  # fmt: skip


BOW = {CHEST: (0.3, 0.0, 0.0), LEFT_ARM: (0.0, 0.0, -0.2), RIGHT_ARM: (0.0, 0.0, 0.2)}


@pytest.mark.long
def test_a_change_is_found_again_and_other_moods_stay():
    walk = steps_of("walk")
    example = replace(changed(walk[0], bend=BOW, size=0.7, drop=0.04), mood=mood(energy=-1.0))
    ends = learnt_ends([*walk, example])
    expected = np.zeros((LAST - FIRST, 3))
    for joint, vector in BOW.items():
        expected[joint] = vector
    shrunk = (expected * 10 + PARAMETRIC.bend[LOWER, ENERGY]) / 11  # ten parts of one example, one of the tables
    assert ends.bend[LOWER, ENERGY] == pytest.approx(shrunk, abs=0.006)
    assert ends.size[LOWER, ENERGY] == pytest.approx((10 * np.log(0.7) + PARAMETRIC.size[LOWER, ENERGY]) / 11, abs=0.02)
    assert ends.drop[LOWER, ENERGY] == pytest.approx((10 * 0.04 + PARAMETRIC.drop[LOWER, ENERGY]) / 11, abs=1e-3)
    for end, row in ((end, row) for end in (UPPER, LOWER) for row in range(6) if (end, row) != (LOWER, ENERGY)):
        assert (ends.bend[end, row] == PARAMETRIC.bend[end, row]).all()


@pytest.mark.long
def test_examples_of_several_moods_are_told_apart():
    """Three walks: strong, tired, and both at once by half; least squares finds both changes."""
    walk = steps_of("walk")
    strong, tired = {CHEST: (0.1, 0.0, 0.0)}, {CHEST: (0.3, 0.0, 0.0)}
    both = {CHEST: (0.2, 0.0, 0.0)}
    clips = [
        replace(changed(walk[0], bend=strong), mood=mood(weight=1.0)),
        replace(changed(walk[0], bend=tired), mood=mood(energy=-1.0)),
        replace(changed(walk[0], bend=both), mood=mood(weight=0.5, energy=-0.5)),
    ]
    ends = learnt_ends([*walk, *clips])
    assert ends.bend[UPPER, WEIGHT, CHEST, 0] == pytest.approx(0.1, abs=0.02)
    assert ends.bend[LOWER, ENERGY, CHEST, 0] == pytest.approx(0.3, abs=0.02)


@pytest.mark.long
def test_a_mood_is_not_on_one_side():
    walk = steps_of("walk")
    limp = {LEFT_ARM: (0.0, 0.0, -0.4)}
    example = replace(changed(walk[0], bend=limp), mood=mood(energy=-1.0))
    ends = learnt_ends([*walk, example]).bend[LOWER, ENERGY]
    assert ends[LEFT_ARM, 2] == pytest.approx(-ends[RIGHT_ARM, 2], abs=1e-6)
    assert (
        learnt_ends([*walk, example, mirror_step(example)]).bend.tolist() == learnt_ends([*walk, example]).bend.tolist()
    )


@pytest.mark.long
def test_without_the_plain_step_nothing_is_learnt():
    walk = [replace(step, mood=mood(energy=-1.0)) for step in steps_of("walk")]
    assert learnt_ends([*walk, *steps_of("groove")]) is PARAMETRIC


def example_library():
    return [*steps_of("groove"), *steps_of("walk"),
            replace(changed(steps_of("walk")[0], bend=BOW), mood=mood(energy=-1.0))]  # fmt: skip


@pytest.mark.long
def test_examples_are_in_the_library_but_nobody_dances_them():
    library = build_library(example_library())
    graph = build_graph(library)
    examples = np.flatnonzero(library.unjoined)
    assert len(examples) == 1
    assert not graph.alive[examples].any()
    assert not np.isin(graph.edge_target, examples).any()
    assert not np.isin(graph.takes.node, examples).any()
    assert library.moods.bend[LOWER, ENERGY, CHEST, 0] > 0.25
    plain = build_graph(build_library(example_library()[:-1]))
    assert graph.alive.sum() == plain.alive.sum()
    assert graph.edge_count == plain.edge_count


@pytest.mark.long
def test_an_example_that_comes_during_a_show_is_learnt():
    *steps, example = example_library()
    graph = insert_clips(build_graph(build_library(steps)), [example])
    whole = build_graph(build_library([*steps, example]))
    assert (graph.library.moods.bend == whole.library.moods.bend).all()
    assert (graph.leaving == whole.leaving).all()
    assert (graph.edge_target == whole.edge_target).all()


@pytest.mark.long
def test_a_step_of_examples_only_is_said_to_be_missing():
    lost = [replace(step, mood=mood(energy=-1.0)) for step in steps_of("walk")]
    graph = build_graph(build_library([*steps_of("groove"), *lost]))
    assert graph.missing == ("walk: all its clips are examples of moods",)
    with pytest.raises(UnknownStep, match="'walk' has only examples of moods"):
        find_step(graph, "walk")


WALK = (STEPS / "walk.toml").read_text(encoding="utf-8")


@pytest.mark.long
def test_sketches_may_be_examples():
    tired = "mood = { energy = -1, weight = 0.5 }\n" + WALK
    clips = sketched_steps({"walk.toml": WALK, "walk_tired.toml": tired})
    assert {clip.mood for clip in clips} == {(), mood(energy=-1.0, weight=0.5)}
    assert len({clip.clip.name for clip in clips}) == len(clips)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("mood = { courage = 1 }", "mood.courage: unknown; moods are weight, time, space, flow, confidence, energy"),
        ("mood = { energy = 2 }", "mood.energy: read 2"),
        ("mood = { energy = true }", "mood.energy: read True"),
        ("mood = { energy = nan }", "mood.energy: read nan"),
        ('mood = "tired"', "mood: read 'tired'; write a table of weight"),
    ],
)
def test_bad_moods_of_sketches_are_refused(words, says):
    with pytest.raises(SketchError, match=r"walk\.toml:1: ") as error:
        parse_sketch(f"{words}\n{WALK}", "walk.toml")
    assert says in str(error.value)


RECORDING = """
name = "walk"
fps = 120
drop_frames = 1
bpm = {bpm}
first_beat_s = {first}
beats_per_measure = 4
measures = 1
file = "{file}"
"""


def test_bad_moods_of_recordings_are_refused(tmp_path):
    text = RECORDING.format(file="walk.bvh", bpm=100, first=0.2)
    for words in ("{ courage = 1.0 }", "{ energy = 2.0 }", '"tired"', '{ energy = "low" }'):
        (tmp_path / "walk.toml").write_text(f"{text}mood = {words}\n", encoding="utf-8")
        with pytest.raises(
            RecordingError, match=r"walk\.toml, line 10: mood.*energy = -1.0.*weight, time, space, flow"
        ):
            recorded_steps(read_step_files(tmp_path))


@pytest.mark.skipif(not WALKS.is_dir(), reason="recordings are in ../shared/mocap, which is absent")
def test_one_walk_in_two_moods_moves_a_walk_of_another_dancer(tmp_path):
    """Learnt from dancer 131's swaggering walk against dancer 02's: a third dancer's walk, unseen, comes nearer to the
    swaggering posture, more than by the tables."""
    for number, (file, bpm, first, words) in enumerate((
        ("131_01_styled", 100, 3.0, "mood = { confidence = 1.0 }"),
        ("cmu_02_01_walk", 109, 0.2, ""),
    )):  # fmt: skip
        text = RECORDING.format(file=WALKS / f"{file}.bvh", bpm=bpm, first=first)
        (tmp_path / f"{number}.toml").write_text(text + words + "\n", encoding="utf-8")
    styled, plain = recorded_steps(read_step_files(tmp_path))
    learnt = learnt_ends([styled, plain])
    text = RECORDING.format(file=WALKS / "cmu_12_01_walk.bvh", bpm=94, first=0.6)
    (tmp_path / "0.toml").write_text(text, encoding="utf-8")
    (tmp_path / "1.toml").unlink()
    (unseen,) = recorded_steps(read_step_files(tmp_path))

    def posture(step, bend=None):
        begin = round(step.first)
        mean = quaternion.mean_rotation(step.clip.rotation[begin : begin + round(step.samples_per_measure), FIRST:LAST])
        return mean if bend is None else quaternion.mul(quaternion.from_rotation_vector(bend), mean)

    def apart(one):
        other = posture(styled)
        return float(np.mean(np.arccos(np.clip(np.abs(np.sum(one * other, axis=-1)), 0.0, 1.0))))

    own, tables = apart(posture(unseen)), apart(posture(unseen, PARAMETRIC.bend[UPPER, 4].astype(np.float64)))
    assert apart(posture(unseen, learnt.bend[UPPER, 4].astype(np.float64))) < 0.75 * min(own, tables)
