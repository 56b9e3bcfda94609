"""Made variations in a show: the dance is the same but for trunks, arms and heads, again and from a journal."""

import re

import numpy as np
import pytest

from live.base.errors import PersonError
from live.library import step_folder
from live.motion.editing.variation import LOWER, UPPER
from live.show.loader import LoadedShow, load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.selection.graph_update import library_hash
from tests.places import ROOT

PATCH = """
name = "varied"
seed = 5
reserve = 0
variations = 2
[clock]
bpm = 112
[motion]
arms = 1
[[group]]
name = "all"
dancers = 6
steps = ["walk", "samba", "jump"]
"""
HERE = ROOT / "patches" / "varied.toml"


def load(text: str = PATCH, **options) -> LoadedShow:
    return load_from_patch(parse_patch(text, "varied.toml"), HERE, **options)


def danced(loaded: LoadedShow, seconds: float = 9.0):
    """Nodes at each tick, joints (P, A, J, 3) of some pictures, and the state's hash at the end."""
    show, nodes, joints = loaded.start(), [], []
    view = show.view()
    for tick in range(1, round(seconds * 64)):
        show.tick(tick / 64)
        nodes.append(show.dancers.node.copy())
        if tick % 4 == 0:
            show.fill(view, tick / 64)
            joints.append(view.joint_position.copy())
    return np.array(nodes), np.array(joints), show.state_hash()


@pytest.fixture(scope="module")
def varied():
    return danced(load())


@pytest.mark.long
def test_steps_places_and_feet_are_those_of_the_show_without(varied):
    nodes, joints, _ = varied
    plain_nodes, plain, _ = danced(load(re.sub("variations = 2|arms = 1", "", PATCH)))
    assert np.array_equal(nodes, plain_nodes)
    assert np.abs(joints - plain)[:, :, LOWER].max() < 1e-5
    apart = np.linalg.norm(joints - plain, axis=-1)[:, :, UPPER]
    assert 0.005 < apart.mean() < 0.1
    assert apart.max() < 0.5


@pytest.mark.long
def test_dancers_of_one_step_differ_from_each_other():
    """Two who dance the same measure hold their hands differently."""
    loaded = load(PATCH.replace('"walk", "samba", "jump"', '"jump"').replace("[motion]", "[motion]\nwarp_beats = 0"))
    nodes, joints, _ = danced(loaded, 6.0)
    hands = joints[-40:] - joints[-40:, :, :1]
    same = nodes[-1] == nodes[-1][0]
    assert same.sum() >= 2
    assert np.linalg.norm(hands[:, same] - hands[:, same][:, :1], axis=-1).max() > 0.05


@pytest.mark.long
def test_show_is_the_same_with_variations_made_anew(varied, monkeypatch, tmp_path):
    """The law of determinism: patch, steps and seed give the same bits, from the cache and without it."""
    cache = step_folder.VARIATIONS.__class__
    monkeypatch.setattr(cache, "entry_path", lambda cache, code, sources: tmp_path / "none.npz")
    monkeypatch.setattr(cache, "store", lambda cache, path, arrays: None)
    assert danced(load())[2] == varied[2]


@pytest.mark.long
def test_replay_finds_them_by_the_names_of_the_journal():
    loaded = load()
    header = loaded.header(loaded.start(), tempo=None)
    again = load(names=header["steps"])
    assert library_hash(again.graph.library) == header["steps_hash"]
    assert sum(" | " in name and ", variation 2" in name for name in header["steps"]) == len(header["steps"]) // 3


@pytest.mark.long
def test_they_are_no_steps_to_choose_and_follow_nothing():
    graph = load().graph
    made = graph.library.node_variation
    assert made.sum() == 2 * (~made).sum()
    assert not graph.alive[made].any()
    assert not made[graph.edge_target].any()
    assert not graph.missing


@pytest.mark.parametrize(
    ("value", "words"),
    [("9", "less than or equal to 8"), ("-1", "0"), ("1.5", "valid integer"), ('"three"', "valid integer")],
)
def test_wrong_numbers_are_refused_with_their_place(value, words):
    with pytest.raises(PersonError) as error:
        load(PATCH.replace("variations = 2", f"variations = {value}"))
    assert "line 5" in str(error.value)
    assert "variations" in str(error.value)
    assert words in str(error.value)
