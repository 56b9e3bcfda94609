"""Groups that follow another group: beats later (canon), or mirrored (T147)."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.motion_parameters import MIRRORED
from live.clock.ticks import TICK
from live.control.events import events
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from tests.fixtures.made_steps import made_steps
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import PATCH, made_show

PLAIN = "[motion]\nwarp_beats = 0\namplitude = 0\nfoot_lock = false\narm_clearance = 0\n"


def follower_group(beats=0, *, mirrored=False):
    """A third group that follows the front group, in a show whose dancers do not vary."""
    return f"""
[[group]]
name = "echo"
dancers = 3
like = "front"
beats_later = {beats}
mirrored = {str(mirrored).lower()}
centre = [0.0, 3.0]
size = [6.0, 1.0]
"""


def joint_heights(show, seconds, script=()):
    """Joint heights of the first dancer of `front` and of `echo` at every tick, and their steps by measure."""
    view, rows, steps = show.view(), [], []
    library = show.graph.library
    for tick in range(1, round(seconds / TICK)):
        for when, act in script:
            if tick == when:
                act(show)
        if show.tick(tick * TICK):
            steps.append([library.steps[library.node_step[show.dancers.node[row]]] for row in (0, 9)])
        show.fill(view, tick * TICK)
        rows.append(view.joint_position[[0, 9], :, 1].copy())
    return np.array(rows), steps


@mostly_long("beats", [1, 2, 5], quick=[0])
def test_canon_repeats_each_pose_after_given_beats(beats):
    show = made_show(PLAIN + follower_group(beats))
    rows, _ = joint_heights(show, 24.0)
    later = round(beats * 0.5 / TICK)  # at 120 bpm
    begin = 64 * 6
    lead, follow = rows[begin : len(rows) - later, 0], rows[begin + later :, 1]
    assert np.abs(lead - follow).max() < 0.005
    assert np.abs(rows[begin:, 0] - rows[begin:, 1]).max() > 0.03  # and not at once


@pytest.mark.long
def test_called_step_reaches_follower_after_its_delay():
    show = made_show(follower_group(8))
    call = events.CallStep(time=0.0, source="test", name="spin", measures=1.0, group="front")
    _, steps = joint_heights(show, 20.0, [(300, lambda s: s.apply(call))])
    front, follow = zip(*steps, strict=True)
    assert follow[2:] == front[:-2]
    assert "spin" in front


@pytest.mark.long
def test_own_sequence_detaches_follower_until_clear():
    show = made_show(follower_group(4))
    show.apply(events.SetSequence(time=0.0, source="test", steps="glide", group="echo"))
    _, steps = joint_heights(show, 12.0, [(500, lambda s: s.apply(events.Clear(time=s.time, source="test")))])
    front, follow = zip(*steps, strict=True)
    assert set(follow[1:3]) == {"glide"}
    assert follow[-1] == front[-2]


@pytest.mark.long
def test_mirrored_group_dances_mirror_clips_and_leader_originals():
    steps = made_steps()
    images = [replace(clip, mirrored=True) for clip in steps]
    graph = build_graph(build_library([*steps, *images]), threshold=0.2)
    show = assemble(parse_patch(PATCH + follower_group(mirrored=True), "test.toml"), graph)
    assert show.variation[MIRRORED][0] == -1.0
    assert show.variation[MIRRORED][9] == 1.0
    side = show.graph.library.node_side
    rows, steps = joint_heights(show, 12.0)
    assert all(one == other for one, other in steps)
    assert np.isfinite(rows).all()
    assert side[show.dancers.node[0]] == -1
    assert side[show.dancers.node[9]] == 1


@pytest.mark.parametrize(
    ("group", "words"),
    [
        ('like = "front"\nsteps = ["sway"]', "has steps and like = "),
        ('like = "nobody"', "no other group is called that"),
        ('like = "echo"', "no other group is called that"),
        ("", "has nothing to dance"),
        ('steps = ["sway"]\nbeats_later = 2', "need like"),
        ('like = "front"\nsoloists = 4', "4 soloists and only 3 dancers"),
    ],
)
def test_invalid_follower_group_is_refused_with_reason(group, words):
    with pytest.raises(PatchError, match=words):
        parse_patch(PATCH + f'\n[[group]]\nname = "echo"\ndancers = 3\n{group}\n', "test.toml")
