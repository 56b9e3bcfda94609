"""Tests of partners: pairs travel and turn together at arm's length, hold hands and release holds."""

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.library.step_folder import load_folder
from live.motion.pose.hand_hold import ARM_JOINTS, LEFT, NOBODY
from live.motion.pose.hand_hold_kernels import PALM
from live.motion.quaternion import rotate
from live.show.assembly import assemble
from live.show.dancers.partners import Partners
from live.show.group.casting import Casting
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from tests.places import ROOT

STEPS = ROOT / "patches" / "steps"
ARM = 0.8
PATCH = """
name = "pairs"
seed = 5
reserve = 0
[clock]
bpm = 112
[stage]
width = 12
depth = 8
[[group]]
name = "couples"
dancers = 9
partners = "facing"
steps = ["walk"]
centre = [0.0, -0.8]
size = [8.0, 3.0]
[[group]]
name = "others"
dancers = 4
steps = ["walk"]
centre = [0.0, 3.0]
size = [8.0, 1.0]
"""


@pytest.fixture(scope="module")
def graph():
    """A graph of all walks and their mirror images."""
    return build_graph(build_library([clip for clip in load_folder(STEPS) if clip.step == "walk"]), threshold=0.16)


def script():
    """A scene that travels and turns: attractors at several places and changed headings."""
    places = [(-3.0, 1.0), (3.0, -1.5), (0.0, 2.0), (2.5, 2.0)]
    for n, (x, z) in enumerate(places):
        yield (
            n * 8.0,
            events.PlaceElement(
                time=n * 8.0, source="test", kind="attract", points=((x, z),), strength=0.7, measures=3.0
            ),
        )
    for n, degrees in enumerate((60, -45, 150)):
        yield 4.0 + n * 9.0, events.SetFacing(time=0.0, source="test", facing=str(degrees), group="couples")


class ShowRecorder:
    """Runs a show to its end and records hips, headings and hand gaps."""

    def __init__(self, show, seconds, acts=()):
        self.show, waiting = show, sorted(acts, key=lambda act: act[0])
        self.hips, self.gaps, self.headings, self.nodes = [], [], [], []
        view = show.view()
        for tick in range(1, round(seconds / TICK)):
            while waiting and waiting[0][0] <= tick * TICK:
                assert show.apply(waiting.pop(0)[1])
            if show.tick(tick * TICK):
                self.headings.append(show.dancers.present.end_heading())
                self.nodes.append(show.dancers.node.copy())
            self.hips.append(show.dancers.drawn_hips.copy())
            if tick % 8 == 0:
                show.fill(view, tick * TICK)
                self.gaps.append(palm_gaps(show, view))
        self.hips, self.headings, self.nodes = np.array(self.hips), np.array(self.headings), np.array(self.nodes)

    def distances(self):
        """Distance between the partners of each pair at each tick [m], (ticks, P)."""
        partners = self.show.motion.partners
        return np.hypot(*np.moveaxis(self.hips[:, partners.follower] - self.hips[:, partners.leader], -1, 0))


def palm_gaps(show, view):
    """For each closed hold, the distance between its palms and between the shoulders of its arms [m]."""
    hands, gaps = show.dancers.hands, []
    for row, slot in zip(*np.nonzero(hands.state[0] > 0.97), strict=True):
        palms, shoulders = [], []
        pairs = zip((row, hands.partner[row, slot]), hands.hand[row, slot], strict=True)
        for dancer, hand in pairs:
            joint, sign = ARM_JOINTS[2 + 3 * hand], 1.0 if hand == LEFT else -1.0
            turn = view.joint_rotation[dancer, joint].astype(float)
            palms.append(view.joint_position[dancer, joint] + rotate(turn, np.array([sign * float(PALM), 0.0, 0.0])))
            shoulders.append(view.joint_position[dancer, ARM_JOINTS[3 * hand]])
        gaps.append((np.linalg.norm(palms[0] - palms[1]), np.linalg.norm(shoulders[0] - shoulders[1])))
    return gaps


@pytest.fixture(
    scope="module", params=["facing", *(pytest.param(kind, marks=pytest.mark.long) for kind in ("beside", "shadow"))]
)
def pair_run(request, graph):
    """The scene with pairs of each kind."""
    patch = parse_patch(PATCH.replace('"facing"', f'"{request.param}"'), "test.toml")
    return ShowRecorder(assemble(patch, graph), 32.0, script())


@pytest.mark.long
def test_pairs_stay_at_arms_length_while_they_travel_and_turn(pair_run):
    distance = pair_run.distances()
    assert distance.shape[1] == 4
    assert np.ptp(pair_run.hips[:, :8], axis=0).max() > 2.0  # they did travel
    turned = np.abs(np.diff(np.unwrap(pair_run.headings[:, 0])))
    assert turned.sum() > 2.0
    assert np.abs(distance - ARM).max() < 0.15


def test_followers_dance_on_their_leaders_feet_and_those_who_look_the_same_way_their_steps(pair_run):
    partners, library = pair_run.show.motion.partners, pair_run.show.dancers.graph.library
    lead, follow = pair_run.nodes[:, partners.leader], pair_run.nodes[:, partners.follower]
    side = library.node_side[lead]
    assert len(lead) > 10
    if partners.mirrored.any():
        assert (library.node_side[follow] == -side).mean() > 0.95
    else:
        assert (library.node_side[follow] == side).all()  # else their hips sway against each other
        assert (lead == follow).mean() > 0.9


def test_no_dancer_passes_between_partners(pair_run):
    partners = pair_run.show.motion.partners
    for lead, follow in zip(partners.leader, partners.follower, strict=True):
        one, other = pair_run.hips[:, lead], pair_run.hips[:, follow]
        way = other - one
        for row in set(range(13)) - {lead, follow}:
            to = pair_run.hips[:, row] - one
            along = np.clip((to * way).sum(-1) / (way**2).sum(-1), 0.0, 1.0)
            assert np.hypot(*(to - along[:, None] * way).T).min() > 0.2


def test_hands_meet_within_reach(pair_run):
    gaps = np.array([gap for row in pair_run.gaps for gap in row])
    assert len(gaps) > 500
    near = gaps[:, 1] < 0.85  # both arms reach: 0.6 m each, less what fades
    assert near.mean() > 0.5
    assert np.quantile(gaps[near, 0], 0.95) < 0.01


def test_odd_dancer_has_no_partner_and_pairs_keep_facing(pair_run):
    show, partners = pair_run.show, pair_run.show.motion.partners
    assert partners.leader.tolist() == [0, 2, 4, 6]
    assert partners.partner[8:].tolist() == [NOBODY] * 5
    ends = show.dancers.present.end_heading()
    off = ends[partners.follower] - partners.follower_headings(ends[partners.leader])
    assert np.abs(np.arctan2(np.sin(off), np.cos(off))).max() < np.radians(25.0)


@pytest.mark.long
def test_partners_who_turn_beside_each_other_stay_on_the_same_feet(graph):
    """The outer partner's way is longer, but a correction bridges that: no reason to dance the mirror image."""
    show = assemble(parse_patch(PATCH.replace('"facing"', '"beside"'), "test.toml"), graph)
    waiting = sorted(script(), key=lambda act: act[0])
    partners, side, apart = show.motion.partners, graph.library.node_side, []
    for tick in range(1, 720):
        while waiting and waiting[0][0] <= tick * TICK:
            assert show.apply(waiting.pop(0)[1])
        if show.tick(tick * TICK):
            node = show.dancers.node
            assert (side[node[partners.follower]] == side[node[partners.leader]]).all()
        apart.append(
            np.hypot(*(show.dancers.drawn_hips[partners.follower] - show.dancers.drawn_hips[partners.leader]).T)
        )
    assert np.abs(show.dancers.present.end_heading()[partners.leader]).min() > np.radians(30.0)  # they did turn
    assert np.abs(np.array(apart) - ARM).max() < 0.12


def test_same_show_has_same_hash(graph):
    hashes = []
    for _ in range(2):
        show = assemble(parse_patch(PATCH, "test.toml"), graph)
        ShowRecorder(show, 6.0, script())
        hashes.append(show.state_hash())
    assert hashes[0] == hashes[1]


@pytest.mark.long
def test_leaving_partner_releases_hands_and_remaining_dancers_form_pair(graph):
    show = assemble(parse_patch(PATCH, "test.toml"), graph)
    ShowRecorder(show, 4.5)
    hands, partners = show.dancers.hands, show.motion.partners
    assert (hands.state[0, :8:2] > 0.97).all()
    now, beat = round(4.5 / TICK), round(60.0 / 112.0 / TICK)
    for event in (
        events.Regroup(time=4.5, source="test", dancers="2", group="others"),
        events.Leave(time=4.5, source="test", dancers="5", gate="*"),
    ):
        assert show.apply(event)
    for tick in range(now, now + beat):
        show.tick(tick * TICK)
    assert hands.state[0, 0].max() == 0.0
    assert hands.state[0, 4].max() == 0.0
    assert (hands.state[0, 2] > 0.97).all()
    for tick in range(now + beat, now + beat + 4 * 64):
        show.tick(tick * TICK)
    assert partners.partner[[0, 5, 8]].tolist() == [5, 0, NOBODY]


def casting(text=PATCH):
    """Partners and their casting, without a show."""
    patch = parse_patch(text, "test.toml")
    cast = Casting(patch)
    return Partners(patch, cast), cast


def test_other_pairs_are_kept_when_dancer_leaves():
    partners, _ = casting()
    there = np.ones(13, np.bool_)
    partners.form_pairs(there)
    there[0] = False
    partners.form_pairs(there)
    assert partners.partner.tolist() == [-1, 8, 3, 2, 5, 4, 7, 6, 1, -1, -1, -1, -1]
    assert partners.timing_source().tolist() == [0, 1, 2, 2, 4, 4, 6, 6, 1, 9, 10, 11, 12]


def test_aligned_ends_are_at_arms_length_with_same_midpoint():
    partners, _ = casting()
    partners.form_pairs(np.ones(13, np.bool_))
    rng = np.random.default_rng(2)
    stand, heading = rng.uniform(-3.0, 3.0, (13, 2)), rng.uniform(-3.0, 3.0, 13)
    partners.adjust_targets(stand, heading, stand.copy(), heading.copy(), np.zeros(13, np.bool_))
    lead, follow = partners.leader, partners.follower
    stand[follow] = stand[lead] + partners.follower_offsets(heading[lead])
    partners.adjust_targets(stand, heading, stand.copy(), heading.copy(), np.zeros(13, np.bool_))
    partners.set_follower_targets(stand[lead], heading[lead], stand, heading)
    ends = stand + rng.uniform(-0.1, 0.1, stand.shape)
    before = ends.copy()
    partners.align_ends(ends, coming=True)
    assert ends[follow] - ends[lead] == pytest.approx(partners.follower_offsets(heading[lead]))
    assert ends[follow] + ends[lead] == pytest.approx(before[follow] + before[lead])
    alone = partners.partner < 0
    assert (ends[alone] == before[alone]).all()


def test_patch_with_invalid_partner_settings_is_refused():
    for wrong in ('partners = "above"', "arm_length = 2.0", 'hands = "three"'):
        with pytest.raises(PatchError):
            parse_patch(PATCH.replace('partners = "facing"', wrong), "test.toml")
