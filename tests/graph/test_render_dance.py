"""Tests of rendering a path of nodes as one motion: against live dancers and source clips, and invalid input."""

import math

import numpy as np
import pytest

from live.base.motion_parameters import MOTION_SIZE, OBEDIENCE, TURN_ON_SUPPORT
from live.graph.motion_graph import build_graph
from live.graph.render_dance import MAX_SAMPLES, edge_between, render_dance
from live.graph.step_library import build_library
from live.graph.takes import NO_TAKE
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.show.dancers.dancers import Dancers
from live.show.dancers.variation import Variation
from tests.fixtures.made_steps import made_steps
from tests.fixtures.steps_of_the_project import project_steps


@pytest.fixture(scope="module")
def graph():
    return build_graph(build_library(project_steps("walk", "samba", "grapevine")))


def random_path(graph, count, seed):
    """A random path through the graph, from the seed."""
    chance = np.random.default_rng(seed)
    node = int(chance.choice(np.flatnonzero(graph.alive & (graph.library.node_measure == 0))))
    path = [node]
    while len(path) < count:
        node = int(chance.choice(graph.edge_target[graph.edge_start[node] : graph.edge_start[node + 1]]))
        path.append(node)
    return path


def random_edits(graph, path, seed):
    """Turns, corrections, takes and shares for a path."""
    chance = np.random.default_rng(seed)
    turns = chance.uniform(-1.0, 1.0, len(path))
    corrections = chance.uniform(-0.2, 0.2, (len(path), 2))
    takes = graph.takes.draw(np.array(path, np.int32), chance.uniform(0.0, 1.0, len(path)))
    return turns, corrections, takes, chance.choice((0.25, 0.5, 0.75), len(path))


def group_numbers():
    """The motion parameters of one group without variation and without foot lock, shape (1, MOTION_SIZE)."""
    numbers = np.zeros((1, MOTION_SIZE))
    numbers[0, TURN_ON_SUPPORT.first], numbers[0, OBEDIENCE.first] = 1.0, 0.5
    return numbers


def render_live(graph, path, turns, corrections, takes, shares, start, seconds, rate):
    """The same path by the code of the live show, sample by sample: world joints (T, J, 3)."""
    variation = Variation(
        group_numbers(), np.zeros(1, np.int32), seed=1, beats_per_measure=4, window=graph.window
    )  # fmt: skip
    dancers = Dancers(graph, variation, 1)

    def set_measure(danced, n):
        danced.node[0], danced.decided = path[n], True
        danced.correction[0] = (*corrections[n], turns[n])
        danced.on_support[0] = 1.0
        danced.take[0] = takes[n]
        danced.take_share[:, 0] = shares[n] if takes[n] != NO_TAKE else 0.0

    dancers.start(np.array([path[0]], np.int32), np.array([start[:2]]), np.array([start[2]]))
    set_measure(dancers.present, 0)
    poses = []
    for sample in range(int(len(path) * seconds * rate + 1e-6)):
        place = sample / rate / seconds
        measure = int(place)
        if measure > 0 and dancers.decided and len(poses) and int((sample - 1) / rate / seconds) < measure:
            dancers.cross_measure_line()
        if measure + 1 < len(path) and not dancers.decided:
            axes = dancers.present.end_placement()[0]
            x, z, yaw = graph.edge_transform[edge_between(graph, path[measure], path[measure + 1])]
            c, s = math.cos(axes[2]), math.sin(axes[2])
            dancers.coming.placement[0] = axes[0] + x * c + z * s, axes[1] + z * c - x * s, axes[2] + yaw
            set_measure(dancers.coming, measure + 1)
        poses.append(dancers.pose(place - measure, 0.0)[0][0].copy())
    return np.stack(poses)


@pytest.mark.long
def test_rendered_dance_equals_live_dance(graph):
    path = random_path(graph, 6, 3)
    turns, corrections, takes, shares = random_edits(graph, path, 4)
    assert (takes != NO_TAKE).sum() >= 3
    start = (0.4, -1.0, 0.7)
    made = render_dance(
        graph,
        path,
        bpm=110.0,
        turns=turns,
        corrections=corrections,
        takes=(takes, shares),
        start=start,
        hold_feet=False,
    )
    live = render_live(graph, path, turns, corrections, takes, shares, start, 240.0 / 110.0, 60.0)
    joints, _ = forward_kinematics(made.clip.root_position, made.clip.rotation)
    assert abs(len(joints) - len(live)) <= 1
    np.testing.assert_allclose(joints[: len(live)], live[: len(joints)], atol=2e-4)


@pytest.mark.long
def test_motion_outside_blends_is_rigidly_placed_source_clip(graph):
    path, library = random_path(graph, 4, 5), graph.library
    made = render_dance(graph, path, bpm=97.0, hold_feet=False)
    seconds = 240.0 / 97.0
    for n, node in enumerate(path):
        phase = np.linspace(0.0, 0.78, 9)
        at = np.round((n + phase) * seconds * 60.0)
        phase = at / 60.0 / seconds - n
        inside = (phase >= 0.0) & (phase <= 1.0 - graph.window)
        at, phase = at[inside].astype(int), phase[inside]
        sample = library.node_first[node] + phase * (library.node_last[node] - library.node_first[node])
        low = np.floor(sample).astype(int)
        part = (sample - low)[:, None]
        root = (1.0 - part) * library.clip_root[low] + part * library.clip_root[low + 1]
        x, z, yaw = made.placement[n]
        c, s = math.cos(yaw), math.sin(yaw)
        wanted = np.stack(
            [x + root[:, 0] * c + root[:, 2] * s, root[:, 1], z + root[:, 2] * c - root[:, 0] * s], axis=1
        )
        np.testing.assert_allclose(made.clip.root_position[at], wanted, atol=1e-4)
        near = np.round(sample).astype(int)
        np.testing.assert_array_equal(made.clip.contact[at], library.clip_contact[near])


def test_planned_ends_match_motion_and_turns_change_heading(graph):
    path = random_path(graph, 5, 8)
    straight = render_dance(graph, path, bpm=120.0, hold_feet=False)
    made = render_dance(graph, path, bpm=120.0, turns=[0.0, 0.0, 0.0, 0.0, 0.9], hold_feet=False)
    np.testing.assert_allclose(made.clip.root_position[-1, [0, 2]], made.end[-1, :2], atol=1e-3)
    np.testing.assert_allclose(straight.clip.root_position[-1, [0, 2]], straight.end[-1, :2], atol=1e-3)
    assert made.end[-1, 2] - straight.end[-1, 2] == pytest.approx(0.9)
    before = made.clip.sample_count - 121
    np.testing.assert_array_equal(made.clip.root_position[:before], straight.clip.root_position[:before])


def test_two_measure_step_has_no_inner_join():
    graph = build_graph(build_library(made_steps()), threshold=0.2)
    library = graph.library
    first, second = np.flatnonzero(library.node_step == library.steps.index("phrase"))
    sway = int(np.flatnonzero(library.node_step == 0)[0])
    made = render_dance(graph, [sway, first, second, sway], bpm=120.0)
    seconds = 2.0
    np.testing.assert_allclose(made.join[:, 1], [seconds, 3 * seconds])
    np.testing.assert_allclose(made.join[:, 0], made.join[:, 1] - graph.window * seconds)
    np.testing.assert_allclose(made.line_time, seconds * np.arange(5))
    assert made.clip.sample_count == 4 * 120 + 1
    assert len(made.beat_time) == 17


def test_held_feet_stand_still_without_moving_root(graph):
    path = random_path(graph, 6, 11)
    turns = random_edits(graph, path, 12)[0]
    free, held = (render_dance(graph, path, bpm=120.0, turns=turns, hold_feet=hold).clip for hold in (False, True))
    np.testing.assert_array_equal(free.contact, held.contact)
    np.testing.assert_allclose(free.root_position[:, [0, 2]], held.root_position[:, [0, 2]], atol=1e-5)

    def slide(clip):
        joints, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
        feet = joints[:, [[16, 17], [20, 21]]]
        speed = np.hypot(*np.diff(feet, axis=0)[..., (0, 2)].transpose(3, 0, 1, 2)).min(axis=-1) * 60.0
        return speed[clip.contact[1:] & clip.contact[:-1]].mean()

    assert slide(held) < 0.02
    assert slide(held) < 0.5 * slide(free)


def test_sample_rate_does_not_change_dance(graph):
    path = random_path(graph, 3, 2)
    coarse, fine = (
        render_dance(graph, path, bpm=120.0, sample_rate=rate, hold_feet=False).clip for rate in (30.0, 120.0)
    )
    np.testing.assert_allclose(coarse.root_position, fine.root_position[::4], atol=1e-5)
    same = np.abs(np.sum(coarse.rotation * fine.rotation[::4], axis=-1))
    assert same.min() > 1.0 - 1e-5


@pytest.mark.parametrize("bpm", [0.0, -3.0, math.nan, math.inf])
def test_invalid_tempo_is_refused(graph, bpm):
    with pytest.raises(ValueError, match="above 0"):
        render_dance(graph, random_path(graph, 2, 0), bpm=bpm)


def test_inconsistent_arguments_are_refused(graph):
    path = random_path(graph, 3, 0)
    with pytest.raises(ValueError, match="turns"):
        render_dance(graph, path, bpm=120.0, turns=[0.0])
    with pytest.raises(ValueError, match="corrections"):
        render_dance(graph, path, bpm=120.0, corrections=np.full((3, 2), math.nan))
    with pytest.raises(ValueError, match="at least one"):
        render_dance(graph, [], bpm=120.0)
    with pytest.raises(ValueError, match="at least one"):
        render_dance(graph, [graph.library.node_count], bpm=120.0)
    with pytest.raises(ValueError, match="minutes"):
        render_dance(graph, path * MAX_SAMPLES, bpm=120.0)


def test_missing_edge_is_reported():
    graph = build_graph(build_library(made_steps()), threshold=0.2)
    library = graph.library
    first, second = np.flatnonzero(library.node_step == library.steps.index("phrase"))
    with pytest.raises(ValueError, match=r"'sway'.*'phrase 2/2'"):
        render_dance(graph, [0, second], bpm=120.0)
    assert graph.edge_target[edge_between(graph, first, second)] == second


def test_local_rotations_invert_forward_kinematics(graph):
    clip = render_dance(graph, random_path(graph, 2, 1), bpm=120.0).clip
    _, world = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    assert np.abs(np.abs(np.sum(local_rotations(world) * clip.rotation, axis=-1)) - 1.0).max() < 1e-6
