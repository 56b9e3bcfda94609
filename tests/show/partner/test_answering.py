"""Tests of answering partners in a show: timing, continuity, determinism, validation and live input."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.capture.packed_pose import pack_pose
from live.motion.skeleton import SKELETON
from live.show.assembly import assemble
from live.show.loader import LoadedShow
from live.show.partner.response_path import MAX_PULL_SPEED
from live.show.patch.patch_reader import PatchError, parse_patch
from live.show.patch.patch_update import patch_version, prepare_patch, split_deferred
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore
from live.show.view.telemetry import Telemetry
from tests.show.made_show import GRAPH, PATCH
from tests.show.partner.answering_show import (
    DUET,
    FILE,
    FOLLOWER,
    LEADER,
    answering_show,
    bank_of,
    hip_distance,
    max_joint_speed,
    patch_of,
    run,
)

STAMP = {"time": 0.0, "source": "osc"}
ON_PLACE = DUET + 'place = "own"\n'


def set_answering(show: Show, on: bool) -> None:
    assert show.apply(events.SetPartner(parameter="on", value=float(on), **STAMP))


def bone_lengths(position: np.ndarray) -> np.ndarray:
    """Lengths of all bones, (..., J - 1)."""
    parents = np.asarray(SKELETON.parents)[1:]
    return np.linalg.norm(position[..., 1:, :] - position[..., parents, :], axis=-1)


@pytest.mark.long
def test_follower_moves_to_leader_and_answers_on_beat() -> None:
    show = answering_show()
    answering = show.dancers.partner_response
    assert answering is not None
    begun, parts = [], []
    (read,) = answering.leaders.readers.values()
    for _ in range(round(8.5 / TICK)):
        parts.append(run(show, TICK))
        if read.frame_index is not None and read.partner.has_pose:
            frames = read.frame_index - (read.partner.filter.frame_index - read.partner.begin)
            begun.append(frames / read.examples.per_beat)
    lines, start = np.unique(begun)[1:], np.concatenate(parts)
    assert len(lines) > 5
    assert np.abs(lines / 2.0 - np.round(lines / 2.0)).max() * 2.0 * 0.5 <= 0.04 + 1e-9  # two beats, of 0.5 s
    assert answering.path.level[FOLLOWER] == 1.0
    assert hip_distance(start)[0] > 2.5
    before = answering.leaders.unit_count
    position = run(show, 6.0)
    assert np.abs(hip_distance(position)[192:] - 1.0).max() < 0.2  # as in the examples, however far the two go
    assert np.ptp(position[:, FOLLOWER, 0, ::2], axis=0).max() > 0.2
    error = np.abs(bone_lengths(position[:, FOLLOWER]) - np.linalg.norm(SKELETON.offsets[1:], axis=-1)).max(axis=0)
    legs = np.array([name.endswith(("Leg", "Foot", "Toes")) for name in SKELETON.names[1:]])
    assert error[~legs].max() < 1e-4
    assert error[legs].max() < 0.005  # legs with locked feet stretch slightly
    assert answering.leaders.unit_count - before in (5, 6, 7)  # each unit is reported once: 12 beats hold six of two
    # the agent is at the dancer
    assert np.hypot(*(show.state.position[FOLLOWER] - position[-1, FOLLOWER, 0, ::2])) < 0.05


@pytest.mark.long
def test_switching_and_repairing_cause_no_pop() -> None:
    show, quiet = answering_show(ON_PLACE), answering_show(ON_PLACE)
    set_answering(quiet, on=False)
    own = run(quiet, 3.0)
    usual = max(max_joint_speed(own, row) for row in (LEADER, FOLLOWER))
    parts = [run(show, 3.2)]
    for on in (False, True, False, True):
        set_answering(show, on)
        parts.append(run(show, 1.0))
    parts.append(run(show, 2.5))
    assert show.apply(events.SetPartner(parameter="amount", value=0.3, **STAMP))
    parts.append(run(show, 0.5))
    assert show.apply(events.PairPartner(role="leader", who="front & 3", partner="duet", **STAMP))
    parts.append(run(show, 4.5))
    position = np.concatenate(parts)
    assert show.dancers.partner_response is not None
    assert show.dancers.partner_response.path.level[FOLLOWER] == 1.0
    turn = np.pi / 2.0 * 1.5 * 0.8  # half a turn within a measure of 2 s, smoothly, at arm's length
    assert max_joint_speed(position, FOLLOWER) < 2.0 * usual + MAX_PULL_SPEED + turn
    assert np.isfinite(position).all()


def test_rendering_changes_nothing_and_snapshot_continues_bit_identically() -> None:
    one, other = answering_show(ON_PLACE), answering_show(ON_PLACE)
    assert np.array_equal(run(one, 3.0), run(other, 3.0, drawn=True))
    assert one.state_hash() == other.state_hash()
    tick = round(one.time / TICK)
    source = Snapshotter(one)
    while (taken := source.capture(tick)) is None:
        tick += 1
        one.tick(tick * TICK)
    data = taken.seal()
    again = restore(LoadedShow(FILE, patch_of(ON_PLACE), GRAPH, answers=bank_of(ON_PLACE)), data)
    assert np.array_equal(run(again, 2.0), run(one, 2.0))
    assert again.state_hash() == one.state_hash()
    bank = again.dancers.partner_response.bank  # type: ignore[union-attr]
    assert bank is bank_of(ON_PLACE)
    assert (
        next(iter(again.dancers.partner_response.leaders.readers.values())).partner.filter.units
        is bank.example_sets[0].units
    )  # type: ignore[union-attr]
    assert len(data) < 150_000


@pytest.mark.long
def test_follower_stops_answering_when_leader_leaves() -> None:
    show = answering_show(ON_PLACE)
    run(show, 3.5)
    answering = show.dancers.partner_response
    assert answering is not None
    assert answering.path.level[FOLLOWER] == 1.0
    assert show.apply(events.Leave(dancers="1", **STAMP))
    run(show, 4.5)
    assert answering.path.level[FOLLOWER] == 0.0
    assert not answering.path.following.any()
    mine, bare = show.dancers.pose(0.4, show.time)[0][FOLLOWER].copy(), answering
    show.dancers.partner_response = None
    assert np.array_equal(mine, show.dancers.pose(0.4, show.time)[0][FOLLOWER])
    show.dancers.partner_response = bare


@pytest.mark.long
def test_several_followers_answer_one_leader_and_chains_work() -> None:
    extra = (
        '[[partner]]\nname = "class"\nleader = "front & 1"\nfollower = "back"\n'
        '[[partner]]\nname = "chain"\nleader = "back & 6"\nfollower = "front & 2"\nplace = "own"\n'
    )
    show = answering_show(extra)
    position = run(show, 4.0)
    answering = show.dancers.partner_response
    assert answering is not None
    assert np.all(answering.path.level[[1, 5, 6, 7, 8]] == 1.0)
    assert len(answering.leaders.readers) == 2  # a search for each leader
    moved = np.diff(position[-128:, 5:9, 0, ::2], axis=0)
    assert np.allclose(moved, moved[:, :1], atol=1e-5)  # all go as one
    gaps = np.linalg.norm(position[-1, 5:9, None, 0, ::2] - position[-1, None, 5:9, 0, ::2], axis=-1)
    assert gaps[~np.eye(4, dtype=bool)].min() > 0.5


@pytest.mark.long
def test_danced_units_are_reported_and_trigger_reactions() -> None:
    extra = (
        ON_PLACE + '[[react]]\non = "unit:glide"\nwhen = "now"\ncall = "/dance/facing"\nvalues = ["centre", "back"]\n'
    )
    show = answering_show(extra)
    outgoing, view, told = Telemetry(show, positions=0.0, feet=False), show.view(), []
    heard: list[object] = []
    router = show.frame.router
    act = router.handle
    router.handle = lambda event: (heard.append(event), act(event))[1]  # type: ignore[method-assign,func-returns-value]
    for tick in range(1, 64 * 5):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        for what, values in outgoing.frame(view):
            told += [one for name, one in values if name == "unit"] if what == "news" else []
    assert show.dancers.partner_response is not None
    assert [label for _, label, _ in told] == [
        label for _, _, label in show.dancers.partner_response.leaders.recent_units
    ]
    assert {partner for partner, _, _ in told} == {"duet"}
    assert any(name == "glide" and label.startswith("glide/") for _, label, name in told)
    assert any(isinstance(event, events.SetFacing) for event in heard)


@pytest.mark.parametrize(
    ("table", "place", "words"),
    [
        ('leader = "nobody"\nfollower = "back & 6"', "leader", "nobody"),
        ('leader = "front"\nfollower = "front & 2"', "leader", "answer themselves"),
        ('leader = "front"\nfollower = "back"', "follower", "5 lead and 4 answer"),
        ('leader = "left"\nfollower = "back"', "leader", "places"),
        ('leader = "front & 1"\nfollower = "*"', "leader", "answer themselves"),
    ],
)
def test_invalid_partners_are_refused_with_key(table: str, place: str, words: str) -> None:
    patch = parse_patch(f'{PATCH}[[partner]]\nname = "duet"\n{table}\n', "test.toml")
    with pytest.raises(PersonError, match=words) as told:
        assemble(patch, GRAPH, answers=bank_of(DUET))
    assert told.value.key_path[:3] == ("partner", 0, place)
    assert told.value.remedy


def test_partner_cycles_and_double_followers_are_refused() -> None:
    one = '[[partner]]\nname = "one"\nleader = "front & 1"\nfollower = "front & 2"\n'
    two = '[[partner]]\nname = "two"\nleader = "front & 2"\nfollower = "front & 3"\n'
    back = '[[partner]]\nname = "three"\nleader = "front & 3"\nfollower = "front & 1"\n'
    again = '[[partner]]\nname = "again"\nleader = "back & 6"\nfollower = "front & 2"\n'
    answering_show(one + two)
    with pytest.raises(PersonError, match="circle"):
        assemble(parse_patch(PATCH + one + two + back, "t.toml"), GRAPH)
    with pytest.raises(PersonError, match="answers in 'one' and in 'again'"):
        assemble(parse_patch(PATCH + one + again, "t.toml"), GRAPH)
    with pytest.raises(PatchError, match="two partners are called"):
        parse_patch(PATCH + one + one, "t.toml")


def test_invalid_partner_events_are_counted_and_change_nothing() -> None:
    show = answering_show()
    answering = show.dancers.partner_response
    assert answering is not None
    before = list(answering.settings), list(answering.pairs)
    for event in (
        events.PairPartner(role="leader", who="nobody", partner="duet", **STAMP),
        events.PairPartner(role="leader", who="back & 6", partner="duet", **STAMP),
        events.PairPartner(role="follower", who="front", partner="duet", **STAMP),
        events.PairPartner(role="leader", who="path", partner="duet", **STAMP),
        events.PairPartner(role="shadow", who="front", partner="duet", **STAMP),
        events.SetPartner(parameter="on", value=1.0, partner="quartet", **STAMP),
        events.SetPartner(parameter="seed", value=1.0, **STAMP),
    ):
        assert not show.apply(event)
    assert show.refusals.count == 7
    assert (answering.settings, answering.pairs) == before
    assert show.apply(events.SetPartner(parameter="window", value=0.4, **STAMP))
    assert answering.settings[0].window == 0.15  # as far as the patch lets units stretch
    without = assemble(parse_patch(PATCH, "t.toml"), GRAPH)
    assert not without.apply(events.SetPartner(parameter="on", value=1.0, **STAMP))
    with pytest.raises(PatchError, match="there is no partner"):
        parse_patch(PATCH + '[[react]]\non = "unit:x"\ncall = "/dance/clear"\n', "t.toml")
    with pytest.raises(PersonError, match="have a 'polka'"):
        bank_of(DUET + '[[react]]\non = "unit:polka"\ncall = "/dance/clear"\n')


WALKERS = """
[[partner]]
name = "walk"
leader = "path"
follower = "back & 6-7"
steps = ["glide"]
"""


@pytest.mark.long
def test_walkers_follow_drawn_path_and_stop_at_end() -> None:
    show = answering_show(WALKERS)
    answering = show.dancers.partner_response
    assert answering is not None
    run(show, 2.5)
    rows = [FOLLOWER, FOLLOWER + 1]
    begin = show.state.position[rows].astype(np.float64)
    drawn = begin.mean(axis=0) + np.array([(0.25 * n, 0.5 - 0.5 * np.cos(0.5 * n)) for n in range(1, 9)])
    for n, (x, z) in enumerate(drawn.tolist()):
        assert show.apply(events.WalkOn(x=x, z=z, partner="walk", anew=n == 0, **STAMP))
    position = run(show, 8.0)
    assert np.all(answering.path.level[rows] == 1.0)
    hips, ends = position[:, rows, 0, ::2], drawn[-1] + begin - begin.mean(axis=0)
    assert np.hypot(*(hips[-1] - ends).T).max() < 0.25  # each beside the other, as when it began
    past = (hips - ends) @ (drawn[-1] - drawn[-2]) / np.hypot(*(drawn[-1] - drawn[-2]))
    assert past.max() < 0.2  # no walker passes the end
    way = np.vstack([begin.mean(axis=0), drawn])
    own = hips[:, 0] - (begin[0] - begin.mean(axis=0))
    assert np.hypot(*np.moveaxis(own[:, None] - way[None], -1, 0)).min(axis=1).max() < 0.5
    assert not show.apply(events.WalkOn(x=0.0, z=0.0, partner="nobody", **STAMP))
    assert not answering_show().apply(events.WalkOn(x=0.0, z=0.0, **STAMP))


@pytest.mark.long
def test_edited_patch_applies_except_example_bank_changes() -> None:
    show = answering_show(ON_PLACE)
    run(show, 3.0)
    edited = parse_patch(PATCH + ON_PLACE.replace("front & 1", "front & 2") + "amount = 0.5\n", "test.toml")
    kept, waits = split_deferred(edited, show.patch)
    assert (kept, waits) == (edited, ())
    show.hot_swap.offer_patch(prepare_patch(edited.model_dump_json(), show.hot_swap.make_show, show.patch, show.graph))
    asked = events.PatchChanged(patch="", version=patch_version(edited.model_dump_json()), **STAMP)
    assert show.apply(asked)
    position = run(show, 6.5)
    answering = show.dancers.partner_response
    assert answering is not None
    assert show.patch is not patch_of(ON_PLACE)
    assert answering.settings[0].amount == 0.5
    assert answering.pairs[0].leader == 1
    assert answering.path.level[FOLLOWER] == 1.0
    assert np.isfinite(position).all()
    other = parse_patch(PATCH + ON_PLACE + 'unit_beats = 4\n[[partner]]\nname = "b"\nleader="1"\nfollower="2"\n', "t")
    assert split_deferred(other, patch_of(ON_PLACE))[1] == ("partner",)


@pytest.mark.long
def test_live_motion_leader_can_stop_and_resume() -> None:
    show = answering_show(DUET + 'place = "own"\n[[mocap]]\nname = "live"\ndancer = "1"\ndelay_ms = 0.0\n')
    answering = show.dancers.partner_response
    assert answering is not None
    (example,) = (one for one in answering.bank.example_sets[0].units.examples if one.name == "spin")
    held, levels, hands = [], [], []
    view = show.view()
    for tick in range(1, round(9.0 / TICK)):
        time = tick * TICK
        if tick % 2 == 0 and not 4.5 < time < 6.9:
            root = np.array((-3.0, 0.93, 1.5), np.float32)
            turned = np.array(example.follower.rotation[int(time * 60.0) % 120], np.float32)
            pose = pack_pose(root, turned)
            assert show.apply(events.MocapFrame(time=time, source="vmc", performer="live", pose=pose))
        show.tick(time)
        show.fill(view, time)
        held.append(bool(answering.streamed[LEADER]))
        levels.append(answering.path.level[FOLLOWER])
        hands.append(view.joint_position[FOLLOWER].copy())
    assert held[round(4.0 / TICK)]
    assert not held[round(6.8 / TICK)]  # no frame for two seconds: the leader returns to clips
    assert held[-1]
    assert levels[round(4.4 / TICK)] == levels[-1] == 1.0
    speed = np.linalg.norm(np.diff(np.array(hands), axis=0), axis=-1).max() / TICK
    assert speed < 12.0


@pytest.mark.long
def test_lost_leader_pose_is_held_then_released_and_resumed() -> None:
    show = answering_show(ON_PLACE)
    run(show, 3.2)
    answering = show.dancers.partner_response
    assert answering is not None
    assert answering.path.level[FOLLOWER] == 1.0
    seen = show.dancers.drawn_poses
    show.dancers.drawn_poses = lambda rows, *at: tuple(np.full_like(one, np.nan) for one in seen(rows, *at))  # type: ignore[method-assign,assignment]
    position = [run(show, 0.2)]
    assert answering.path.level[FOLLOWER] > 0.9  # held
    position.append(run(show, 3.8))  # two beats, as a dancer of the show may stand, and a measure
    assert answering.path.level[FOLLOWER] == 0.0
    del show.dancers.drawn_poses
    position.append(run(show, 4.0))
    assert answering.path.level[FOLLOWER] == 1.0
    assert np.isfinite(np.concatenate(position)).all()
