"""Tests of missing step messages: the ballet of the thesis with attributes, and poses that are too far apart."""

from dataclasses import replace

import numpy as np
import pytest

from live.graph.motion_graph import build_graph
from live.graph.search.path_diagnostics import find_missing
from live.graph.search.sequence import NoPath, find_sequence, parse_sequence
from live.graph.search.sequence_spec import specify
from live.graph.step_library import build_library
from live.motion.mirror import mirror_step
from tests.fixtures.made_steps import made_clip


def ballet():
    """Couru from and to both poses but not leftward from Sous-sus; Échappé ends in Plié; Spring Point transfers."""
    spring = replace(
        made_clip("Spring Point"), begin_pose="Plié", end_pose="Plié", weight_transfer=True, leading_foot="left"
    )
    return [
        replace(made_clip("Échappé"), begin_pose="Sous-sus", end_pose="Plié"),
        replace(made_clip("Couru", direction="long left"), begin_pose="Plié", end_pose="Sous-sus"),
        replace(made_clip("Couru", direction="long right"), begin_pose="Sous-sus", end_pose="Sous-sus"),
        spring,
    ]


def missing_steps(clips, text, *, threshold=0.2, foot_rule=False, start=None):
    graph = build_graph(build_library(clips), threshold=threshold, prune=False)
    spec = specify(graph.library, parse_sequence(text, graph.library), foot_rule=foot_rule)
    found = find_missing(graph, spec, start=start)
    try:
        assert (found == []) == (find_sequence(graph, spec, start=start).cost == 0)
    except NoPath:
        assert found
    return found


def test_missing_variation_is_described_by_pose_and_direction():
    (one,) = missing_steps(ballet(), "couru right, couru left")
    assert one.row() == {
        "from": "Couru",
        "to": "Couru",
        "needs": "no Couru that starts in Sous-sus and travels left: record one (or Couru that ends in Plié)",
    }
    assert (one.measure, one.distance) == (2, pytest.approx(0.0, abs=1e-6))
    assert missing_steps(ballet(), "echappe, couru left, couru right x3") == []


def test_repeated_step_requires_other_foot():
    (one,) = missing_steps(ballet(), "spring point x5")
    assert one.needs == ("no Spring Point that is begun with the right foot: record one (its mirror image will do)")
    assert one.measure == 2
    clips = ballet()
    assert missing_steps([*clips, mirror_step(clips[3])], "spring point x5") == []
    other = replace(clips[3], leading_foot="")
    assert "that is begun on the other side" in missing_steps([*clips[:3], other], "spring point x2")[0].needs


def test_missing_direction_is_reported():
    (one,) = missing_steps(ballet(), "echappe, couru long forward, couru right")
    assert one.row() == {
        "from": "Échappé", "to": "Couru", "needs": "no Couru that travels long forward: record one",
    }  # fmt: skip
    assert "no Couru that is danced in place: record one" in missing_steps(ballet(), "couru in place")[0].needs


def test_leading_foot_required_by_direction_is_reported():
    """T134, where the library gives the leading foot."""
    clips = ballet()
    clips[1] = replace(clips[1], leading_foot="left")
    assert missing_steps(clips, "echappe, couru left") == []
    (one,) = missing_steps(clips, "echappe, couru left", foot_rule=True)
    assert one.needs == "no Couru that travels left and leads with the right foot: record one"
    (one,) = missing_steps(clips[:2], "echappe, couru", foot_rule=True)
    assert one.needs.startswith("no Couru that leads with the right foot where it travels left")


def test_distant_poses_are_reported_with_distance_and_nearest_clips():
    high, low = made_clip("reach", arm=-1.2), made_clip("sway")
    lower = made_clip("reach", arm=-0.6)
    (one,) = missing_steps([low, high, lower], "sway, reach", threshold=0.05)
    assert one.pair == (0, 2)
    assert one.distance > 0.05
    assert one.needs.startswith("no reach that begins as sway ends: record one, or allow 0.")
    assert "the nearest, 'sway' and 'reach', are" in one.needs
    assert one.needs.endswith("cm apart where 5 cm may be")
    allowed = float(one.needs.split("allow ")[1].split(" m")[0])
    assert missing_steps([low, high, lower], "sway, reach", threshold=allowed) == []


@pytest.mark.long
def test_repeated_gap_is_reported_once_in_long_sequence():
    found = missing_steps(ballet(), "couru right, couru left, " * 3000 + "couru right")
    assert [one.measure for one in found] == [2]


def test_dead_end_before_free_measure_is_reported():
    """A step without successor may end a dance; before a measure of any step it is reported."""
    clips = [*ballet(), replace(made_clip("bow"), begin_pose="Sous-sus", end_pose="the floor")]
    assert missing_steps(clips, "couru left, couru right, bow") == []
    (one,) = missing_steps(clips, "bow, *")
    assert (one.source, one.target) == ("bow", None)
    assert one.needs.startswith("no step that starts in the floor: record one (or bow that ends in ")


def test_gap_after_start_node_is_reported():
    found = missing_steps(ballet(), "couru left", start=2)
    assert (found[0].measure, found[0].source) == (1, "Couru")
    assert missing_steps(ballet(), "couru left", start=0) == []


def test_free_measure_shorter_than_any_step_is_reported():
    clips = [made_clip("phrase", measures=2)]
    graph = build_graph(build_library(clips), threshold=0.2)
    for text, words in (("*", "end where the dance ends"), ("*,phrase", "end where phrase begins")):
        (one,) = find_missing(graph, specify(graph.library, parse_sequence(text, graph.library)))
        assert one.needs == f"no step is short enough to {words}: record one of 1 measure"


@pytest.mark.parametrize("seed", range(5))
def test_recording_reported_steps_makes_sequence_feasible(seed):
    """With random attributes, adding the requested clips one by one makes the sequence feasible in the end."""
    chance = np.random.default_rng(seed)
    poses = ("", "plié", "sous-sus", "relevé")
    clips = [
        replace(
            made_clip(name), begin_pose=str(chance.choice(poses)), end_pose=str(chance.choice(poses)),
            weight_transfer=bool(chance.integers(2)), leading_foot=str(chance.choice(["left", "right"])),
        )
        for name in ("a", "b", "c") for _ in range(2)
    ]  # fmt: skip
    text = ",".join(chance.choice(["a", "b", "c"], 12))
    for _ in range(12):
        found = missing_steps(clips, text)
        if not found:
            return
        library = build_library(clips)
        u, v = (library.clips[library.node_clip[n]] for n in found[0].pair)
        foot = {"left": "right", "right": "left"}[u.leading_foot] if "foot" in found[0].needs else v.leading_foot
        clips.append(replace(v, begin_pose=u.end_pose or v.begin_pose, leading_foot=foot))
    raise AssertionError("twelve recordings later it still cannot be danced")
