"""Tests of faces and hands in shows: limits, no jumps, blinks, breath, gaze laws, hand shapes, holds, same bits."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from live.base.body.expression import (
    BLINK_LEFT,
    BREATH,
    BROW,
    CURL,
    EFFORT,
    GAZE_PITCH,
    GAZE_YAW,
    MOUTH_OPEN,
    SMILE,
    SPREAD,
)
from live.base.body.hand_shapes import HOLD, RELAXED, SHAPES, shape_index
from live.base.motion_parameters import PUBLIC_GAZE
from live.base.motion_parameters import SMILE as SMILE_PARAMETER
from live.base.picture_parameters import EYE
from live.clock.ticks import TICK
from live.control.events import events
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.library.step_folder import load_folder
from live.motion import quaternion
from live.motion.expression.dance_kernels import ENERGY, HEAD_JOINT, HEAD_YAW, LEAD_S, TURN
from live.motion.expression.drawing_kernels import DOWN_LIMIT, UP_LIMIT, YAW_LIMIT
from live.motion.expression.face_kernels import BREATH_PHASE, BREATH_RATE, EXERTION, KIND, LEAD, SACCADE_AGE, TARGET
from live.motion.expression.gaze_kernels import AHEAD, PUBLIC
from live.motion.mirror import mirror_step
from live.motion.pose.hand_hold import NOBODY
from live.motion.skeleton import SKELETON
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import Snapshotter, restore
from tests.fixtures.made_steps import made_clip
from tests.places import ROOT
from tests.show.capture.test_mocap import frame as performer_frame
from tests.show.made_show import made_show
from tests.show.state.test_snapshot import MADE

STAMP = {"time": 0.0, "source": "test"}
SALSA = """
name = "expression"
seed = 7
reserve = 0
[clock]
bpm = 112
[motion]
head = {head}
[[group]]
name = "all"
dancers = 12
soloists = 1
steps = ["samba", "turn", "walk", "kick", "turn", "jump"]
travel_step = "walk"
choose = "random"
size = [8.0, 5.0]
"""


@functools.cache
def graph():
    """A graph of some of the project's steps."""
    wanted = {"samba", "turn", "walk", "kick", "jump"}
    clips = [clip for clip in load_folder(ROOT / "patches" / "steps") if clip.step in wanted]
    return build_graph(build_library(clips), threshold=0.2)


def expression_of(show):
    return show.expression


def run(show, seconds, do=None):
    """Faces, hands, head rotations and positions, and states after each tick: dictionary of arrays (T, A, ...)."""
    view, found = show.view(), {name: [] for name in ("face", "hand", "head", "place", "number", "choice")}
    view.detailed = True
    state = expression_of(show)
    for tick in range(1, round(seconds / TICK)):
        for event in (do or {}).get(tick, ()):
            assert show.apply(event)
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        for name, array in (
            ("face", view.face), ("hand", view.hand), ("head", view.joint_rotation[:, HEAD_JOINT]),
            ("place", view.joint_position[:, HEAD_JOINT]), ("number", state.number), ("choice", state.choice),
        ):  # fmt: skip
            found[name].append(array.copy())
    return {name: np.array(rows) for name, rows in found.items()}


@functools.cache
def dance(head=1.0):
    """A minute of random steps with turns, heads spotting the public by `head`."""
    return run(assemble(parse_patch(SALSA.format(head=head), "expression.toml"), graph()), 60.0)


@pytest.mark.long
def test_eyes_lids_and_mouths_keep_their_limits():
    face, hand = dance()["face"], dance()["hand"]
    assert np.abs(face[..., GAZE_YAW]).max() <= YAW_LIMIT + 1e-6
    assert face[..., GAZE_PITCH].min() >= -DOWN_LIMIT - 1e-6
    assert face[..., GAZE_PITCH].max() <= UP_LIMIT + 1e-6
    for column, low in ((BLINK_LEFT, 0), (MOUTH_OPEN, 0), (EFFORT, 0), (BROW, -1), (SMILE, -1), (BREATH, -1)):
        assert low <= face[..., column].min() <= face[..., column].max() <= 1.0
    assert hand[..., CURL].min() >= -0.01
    assert hand[..., CURL].max() <= 1.01
    assert face[..., GAZE_YAW].std() > 0.1  # and they do move
    assert face[..., EFFORT].max() > 0.3


@pytest.mark.long
def test_nothing_jumps():
    """Eyes are no quicker than a person's (1000 degrees a second, the fastest saccades), lids close in 0.08 s."""
    face, hand = dance()["face"], dance()["hand"]
    speed = np.abs(np.diff(face, axis=0)).max(axis=(0, 1)) / TICK
    most = {GAZE_YAW: 17.5, GAZE_PITCH: 17.5, BLINK_LEFT: 20.0, BROW: 2.0, MOUTH_OPEN: 2.0, SMILE: 2.0, BREATH: 5.0}
    for column, bound in most.items():
        assert speed[column] < bound, column
    assert speed[EFFORT] < 3.0
    assert np.abs(np.diff(hand, axis=0)).max() / TICK < 8.0


@pytest.mark.long
def test_blinks_come_fifteen_to_twenty_times_a_minute_and_not_in_unison():
    closed = dance()["face"][..., BLINK_LEFT] > 0.5
    starts = closed[1:] & ~closed[:-1]
    rates = starts.sum(axis=0)  # in a minute
    assert 14.0 < rates.mean() < 22.0
    assert rates.min() >= 9
    assert rates.max() <= 30
    lengths = closed.sum(axis=0) * TICK / rates  # more than half closed
    assert 0.1 < lengths.mean() < 0.2
    assert closed.sum(axis=1).max() <= closed.shape[1] // 2


@pytest.mark.long
def test_eyes_hold_the_public_while_the_head_turns():
    """The vestibulo-ocular law: gaze in the world stays on its target, whatever the head does below the limits."""
    found = dance(head=0.5)
    w, x, y, z = found["head"].astype(np.float64).transpose(2, 0, 1)
    forward = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
    yaw, pitch = found["face"][..., GAZE_YAW], found["face"][..., GAZE_PITCH]
    local = np.stack([np.sin(yaw) * np.cos(pitch), np.sin(pitch), np.cos(yaw) * np.cos(pitch)], axis=-1)
    gaze = quaternion.rotate(found["head"].astype(np.float64), local)
    eyes = found["place"] + quaternion.rotate(found["head"].astype(np.float64), np.array([0.0, 0.07, 0.085]))
    way = found["number"][..., TARGET : TARGET + 3] - eyes
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    off = np.degrees(np.arccos(np.clip((gaze * way).sum(axis=-1), -1.0, 1.0)))
    steady = (found["choice"][..., KIND] == PUBLIC) & (found["number"][..., SACCADE_AGE] > 0.25)
    steady &= (np.abs(yaw) < 0.6 * YAW_LIMIT) & (np.abs(pitch) < 0.6 * UP_LIMIT)
    steady &= np.abs(found["number"][..., LEAD]) < 0.6
    steady &= (forward * way).sum(axis=-1) > 0.6
    turned = np.degrees(np.arccos(np.clip((forward[1:] * forward[:-1]).sum(axis=-1), -1.0, 1.0))) / TICK
    moving = steady[1:] & (turned > 30.0)  # degrees a second
    assert moving.sum() > 200
    assert np.percentile(off[1:][moving], 95) < 3.5  # with the small saccades of a fixation
    assert np.percentile(off[steady], 50) < 2.0


@pytest.mark.long
def test_eyes_lead_the_head_in_turns():
    found = dance(head=0.0)
    w, x, y, z = found["head"].astype(np.float64).transpose(2, 0, 1)
    heading = np.unwrap(np.arctan2(2 * (x * z + w * y), 1 - 2 * (x * x + y * y)), axis=0)
    ahead = round(0.15 / TICK)
    coming = heading[ahead:] - heading[:-ahead]
    eyes, kind = found["face"][:-ahead, :, GAZE_YAW], found["choice"][:-ahead, :, KIND]
    fast = (np.abs(coming) > 0.5) & (kind == AHEAD) & (found["number"][:-ahead, :, SACCADE_AGE] > 0.2)
    assert fast.sum() > 100
    assert np.mean(np.sign(eyes[fast]) == np.sign(coming[fast])) > 0.95


@pytest.mark.long
def test_breath_follows_effort_and_the_measure():
    found = dance()
    rate, worn = found["number"][-1, :, BREATH_RATE] * 60.0, found["number"][-1, :, EXERTION]
    assert 10.0 < rate.min() <= rate.max() < 48.0
    assert worn.mean() > 0.15
    # breathed in at measure lines: of the breaths of the last half, most are full near a line
    phase = found["number"][len(found["number"]) // 2 :, :, BREATH_PHASE]
    turns = np.argwhere((phase[1:] < 0.2) & (phase[:-1] > 0.8))
    beat = (turns[:, 0] + 1 + len(found["number"]) // 2) * TICK * 112.0 / 60.0
    off = np.abs((beat / 4.0) % 1.0 - 0.5)  # 0.5 at a line, 0 in the middle of a measure
    assert (off > 0.3).mean() > 0.7


def test_faces_smile_when_they_are_asked_to():
    show = made_show()
    before = run(show, 4.0)["face"][-1, :, SMILE]
    address = SMILE_PARAMETER.address
    show.apply(events.SetParameter(address=address, value=(0.9,), group="front", **STAMP))
    view = show.view()
    view.detailed = True
    for tick in range(256, 512):
        show.tick(tick * TICK)
    show.fill(view, 511 * TICK)
    front = show.group == 0
    assert (view.face[front, SMILE] - before[front]).min() > 0.4
    assert np.abs(view.face[~front, SMILE] - before[~front]).max() < 0.2


@pytest.mark.long
def test_without_public_gaze_nobody_looks_at_the_public():
    show = made_show(f"[motion]\n{PUBLIC_GAZE.patch.partition('.')[2]} = 0.0\n")
    assert not (run(show, 10.0)["choice"][..., KIND] == PUBLIC).any()


# -- hands -----------------------------------------------------------------------------------------------------------


def settled(show, seconds=1.0, start=1):
    view = show.view()
    view.detailed = True
    last = start + round(seconds / TICK)
    for tick in range(start, last):
        show.tick(tick * TICK)
    show.fill(view, (last - 1) * TICK)
    return view.hand.copy()


def curls(name):
    return SHAPES[shape_index(name)]


def test_group_has_its_hand_shape():
    hand = settled(made_show('[motion]\nhand_shape = "fist"\n'))
    assert np.abs(hand - curls("fist")).max() < 0.02


def test_hands_are_relaxed_with_a_natural_cascade():
    hand = settled(made_show())
    mean = hand.mean(axis=(0, 1))
    assert (np.diff(mean[1:5]) > 0.015).all()  # from index to little finger
    assert np.abs(mean - SHAPES[RELAXED]).max() < 0.15
    assert hand[..., 1].std() > 0.005  # no two alike


def test_person_asks_for_hands_for_some_measures():
    show = made_show()
    settled(show, 0.5)
    assert show.apply(events.SetHands(group="front", shape="Jazz", measures=1.0, **STAMP))
    during = settled(show, 1.0, start=33)
    front = show.group == 0
    assert np.abs(during[front] - curls("jazz")).max() < 0.02
    assert np.abs(during[~front, :, SPREAD]).max() < 0.5
    after = settled(show, 3.0, start=97)
    assert np.abs(after[front] - curls("jazz")).max() > 0.3


def test_clear_and_auto_give_hands_back():
    for end in (events.Clear(**STAMP), events.SetHands(group="*", shape="auto", **STAMP)):
        show = made_show()
        assert show.apply(events.SetHands(group="*", shape="fist", measures=100.0, **STAMP))
        assert settled(show)[..., CURL].min() > 0.8
        assert show.apply(end)
        assert settled(show, start=65)[..., CURL].max() < 0.6


@pytest.mark.parametrize(("group", "shape"), [("*", "mitten"), ("nobody here", "fist")])
def test_unknown_hands_are_refused(group, shape):
    show = made_show()
    assert not show.apply(events.SetHands(group=group, shape=shape, **STAMP))
    assert show.refusals.count == 1
    assert (expression_of(show).asked == -1).all()


def test_step_says_what_hands_do_and_its_mirror_image_swaps_them():
    step = replace(made_clip("sway"), hands=((0.0, "fist", ""), (2.0, "flat", "jazz")))
    library = build_library([step, mirror_step(step)])
    fist, flat, jazz = map(shape_index, ("fist", "flat", "jazz"))
    assert library.node_hands[0, :8].tolist() == [[fist, -1]] * 8
    assert library.node_hands[0, 8:].tolist() == [[flat, jazz]] * 8
    assert library.node_hands[1, 8:].tolist() == [[jazz, flat]] * 8
    patch = 'name = "x"\n[[group]]\nname = "a"\ndancers = 3\nsteps = ["sway"]\n[motion]\nmirror = "never"\n'
    show = assemble(parse_patch(patch, "x.toml"), build_graph(build_library([step])))
    show_time = round((60.0 / show.timeline.tempo) * 1.9 / TICK)
    found = settled(show, show_time * TICK)[:3]
    assert np.abs(found[:, 0] - curls("fist")).max() < 0.02
    assert np.abs(found[:, 1] - curls("fist")).max() > 0.3
    found = settled(show, show_time * TICK, start=show_time + 1)[:3]
    assert np.abs(found[:, 0] - curls("flat")).max() < 0.02
    assert np.abs(found[:, 1] - curls("jazz")).max() < 0.02


PAIRS = """
name = "pairs"
seed = 5
reserve = 0
[clock]
bpm = 112
[[group]]
name = "couples"
dancers = 8
partners = "facing"
steps = ["walk"]
size = [8.0, 3.0]
"""


@pytest.mark.long
def test_hands_close_round_the_partners_hand():
    walks = build_graph(build_library([c for c in load_folder(ROOT / "patches" / "steps") if c.step == "walk"]))
    show = assemble(parse_patch(PAIRS, "pairs.toml"), walks)
    view, held_seen = show.view(), 0
    view.detailed = True
    for tick in range(1, 64 * 12):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        arms = show.dancers.held_arms(tick * TICK)
        if arms is None:
            continue
        whole, none = arms.share > 0.999, arms.share == 0.0
        held_seen += int(whole.sum())
        if whole.any():
            assert np.abs(view.hand[whole] - SHAPES[HOLD]).max() < 0.01
        assert (view.hand[none][:, 2] < 0.5).all()
    assert held_seen > 1000
    # the partner is looked at, and no dancer looks at nobody
    choice = expression_of(show).choice
    assert (choice[:, 1] >= NOBODY).all()


@pytest.mark.long
def test_captured_performer_turns_and_works_as_recorded():
    """Heading of the head and energy are those of the performer, not of the unseen steps."""
    show = made_show('[[mocap]]\nname = "live"\ndancer = "1"\n[motion]\nfoot_point = 1.0\n')
    view, headings = show.view(), []
    view.detailed = True
    for tick in range(1, 400):
        show.apply(performer_frame(tick * TICK - 0.004))
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        if tick > 200:
            w, x, y, z = view.joint_rotation[0, HEAD_JOINT].astype(np.float64)
            drawn = np.arctan2(2 * (x * z + w * y), 1 - 2 * (x * x + y * y))
            measured = show.expression._measured[0]
            off = np.angle(np.exp(1j * (measured[HEAD_YAW] - drawn)))
            headings.append((off, measured[TURN], measured[ENERGY]))
    off, turn, energy = np.array(headings).T
    assert np.abs(off).max() < 0.06
    assert turn == pytest.approx(0.4 * LEAD_S, abs=0.03)  # it turns by 0.4 rad in a second
    assert 0.01 < energy.mean() < 5.0
    feet = [SKELETON.index(side + joint) for side in ("left", "right") for joint in ("Foot", "Toes")]
    poses = show.dancers.pose(show.span.fraction(show.clock.beat), 399 * TICK)
    assert np.array_equal(view.joint_rotation[0, feet], poses[1][0, feet])  # and the feet, too


@pytest.mark.long
def test_lost_poses_change_nothing():
    """Poses that are no numbers, as those of a leader whose stream breaks, reach neither faces nor the state."""
    show = made_show('[[mocap]]\nname = "live"\ndancer = "1"\n')
    view = show.view()
    view.detailed = True
    seen = show.dancers.drawn_poses
    for tick in range(1, 300):
        if tick == 200:
            show.dancers.drawn_poses = lambda rows, *at: tuple(np.full_like(one, np.nan) for one in seen(rows, *at))
        show.apply(performer_frame(tick * TICK - 0.004))
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
    assert np.isfinite(view.face).all()
    assert np.isfinite(show.expression.number).all()


# -- state -----------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_expression_at_a_time_is_the_same_at_any_frame_rate():
    often, seldom = made_show(), made_show()
    views = often.view(), seldom.view()
    for view in views:
        view.detailed = True
    for tick in range(1, 200):
        for show in (often, seldom):
            show.tick(tick * TICK)
        often.fill(views[0], tick * TICK)
        often.fill(views[0], (tick + 0.4) * TICK)
    often.fill(views[0], 199.7 * TICK)
    seldom.fill(views[1], 199.7 * TICK)
    assert views[0].face.tobytes() == views[1].face.tobytes()
    assert views[0].hand.tobytes() == views[1].hand.tobytes()
    assert often.state_hash() == seldom.state_hash()


def test_restored_show_goes_on_with_the_same_faces():
    def on(show, first, last):
        for tick in range(first, last):
            show.tick(tick * TICK)

    show, tick = MADE.start(), 64 * 4
    assert show.apply(events.SetHands(group="front", shape="jazz", measures=4.0, **STAMP))
    on(show, 1, tick + 1)
    source = Snapshotter(show)
    while (taken := source.capture(tick)) is None:
        tick += 1
        on(show, tick, tick + 1)
    fresh = restore(MADE, taken.seal())
    for one in (show, fresh):
        on(one, tick + 1, tick + 64 * 4)
    assert expression_of(show).number.tobytes() == expression_of(fresh).number.tobytes()
    assert expression_of(show).hands.tobytes() == expression_of(fresh).hands.tobytes()


def test_frozen_picture_keeps_its_faces():
    show = made_show()
    view = show.view()
    view.detailed = True
    for tick in range(1, 64):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
    face = view.face.copy()
    assert show.apply(events.FreezePicture(on=True, **STAMP))
    for tick in range(64, 128):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
    assert view.face.tobytes() == face.tobytes()


def test_dancers_who_are_small_in_the_picture_rest():
    show = made_show()
    view = show.view()
    for tick in range(1, 128):
        show.tick(tick * TICK)
    show.fill(view, 127 * TICK)
    assert view.face.any(axis=1).all()
    show.desk.parameters.picture[EYE] = (0.0, 2.0, 60.0)
    show.fill(view, 127 * TICK)
    assert not view.face.any()
    assert np.array_equal(view.hand, np.broadcast_to(SHAPES[RELAXED], view.hand.shape))
    view.detailed = True
    show.fill(view, 127 * TICK)
    assert view.face.any(axis=1).all()


def test_tripped_stage_leaves_faces_still():
    show = made_show()
    settled(show)
    show.apply(events.BreakerTripped(name="expression", why="test", **STAMP))
    before = expression_of(show).number.copy()
    for tick in range(65, 128):
        show.tick(tick * TICK)
    assert expression_of(show).number.tobytes() == before.tobytes()
