"""Tests of hand holds of answering partners: reach, continuity, determinism and snapshots."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.capture.packed_pose import pack_pose
from live.motion.pose.hand_hold import ARM_JOINTS
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import PatchError, parse_patch
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import PATCH
from tests.show.partner.answering_show import FILE, FOLLOWER, LEADER
from tests.show.partner.holding_show import (
    HELD,
    holding_bank,
    holding_graph,
    holding_patch,
    holding_show,
    palm_positions,
)

STAMP = {"time": 0.0, "source": "osc"}
BODY = [j for j in range(JOINT_COUNT) if j not in ARM_JOINTS[[1, 2, 4, 5]]]
LIVE = HELD + '[[mocap]]\nname = "live"\ndancer = "1"\ndelay_ms = 0.0\n'


class ShowRecorder:
    """Records the rendered poses of a show at each tick, and its hand holds."""

    def __init__(self, show: Show, seconds: float, *, captured: bool = False, drawn: bool = False) -> None:
        (self.show, self.holding), view = (show, show.dancers.partner_response.hand_holds), show.view()  # type: ignore[union-attr]
        positions, rotations, closed, hand = [], [], [], []
        first = round(show.time / TICK) + 1
        for tick in range(first, first + round(seconds / TICK)):
            if captured and tick % 2 == 0:
                _send_leader_pose(show, tick * TICK)
            show.tick(tick * TICK)
            if drawn:
                show.fill(show.view(), (tick + 0.6) * TICK)
            show.fill(view, tick * TICK)
            positions.append(view.joint_position.copy())
            rotations.append(view.joint_rotation.copy())
            share = show.dancers.partner_response.path.weight[FOLLOWER]  # type: ignore[union-attr]
            closed.append(self.holding.closed[0, FOLLOWER] * share)
            hand.append(self.holding.hand[FOLLOWER].copy())
        self.position, self.rotation = np.array(positions), np.array(rotations)
        self.closed, self.hand = np.array(closed), np.array(hand)

    def gaps(self, side: int) -> np.ndarray:
        """Distance of the follower's palm to the held palm, while the hold is closed, (n,) [m]."""
        lead, own = (palm_positions(self.position[:, row], self.rotation[:, row]) for row in (LEADER, FOLLOWER))
        gap = np.linalg.norm(lead[np.arange(len(lead)), self.hand[:, side]] - own[:, side], axis=-1)
        return np.asarray(gap[self.closed[:, side] > 0.98])

    def bones(self) -> np.ndarray:
        """Lengths of the follower's upper arms, forearms (n, 4) [m]."""
        at, joints = self.position[:, FOLLOWER], ARM_JOINTS[[1, 2, 4, 5]]
        return np.linalg.norm(at[:, joints] - at[:, np.asarray(SKELETON.parents)[joints]], axis=-1)

    def kinks(self) -> np.ndarray:
        """The largest change of a joint's velocity of the follower from tick to tick, (n,) [m/s]."""
        return np.asarray(np.linalg.norm(np.diff(self.position[:, FOLLOWER], 2, axis=0), axis=-1).max(axis=1) / TICK)


def _send_leader_pose(show: Show, time: float) -> None:
    """Send a live-motion pose of a leader who dances one of the example steps, arms in front."""
    clip = holding_graph().library.clips[2].clip
    at = round(time * 16.0) % 64
    pose = pack_pose(np.array((-1.0, 0.93, 0.6), np.float32), np.array(clip.rotation[at], np.float32))
    assert show.apply(events.MocapFrame(time=time, source="vmc", performer="live", pose=pose))


def set_hands_fader(show: Show, value: float) -> Show:
    assert show.apply(events.SetPartner(parameter="hands", value=value, **STAMP))
    return show


@mostly_long("captured", [False, True], quick=[])
def test_hands_are_held_within_reach_and_only_arms_move(captured: bool) -> None:
    extra = LIVE if captured else HELD
    held = ShowRecorder(holding_show(extra), 14.0, captured=captured)
    free = ShowRecorder(set_hands_fader(holding_show(extra), 0.0), 14.0, captured=captured)
    for side in range(2):
        assert len(held.gaps(side)) > 64 * 2
        assert held.gaps(side).max() < 0.03
    assert np.array_equal(held.position[:, LEADER], free.position[:, LEADER])
    assert np.array_equal(held.position[:, FOLLOWER][:, BODY], free.position[:, FOLLOWER][:, BODY])
    assert np.abs(held.position - free.position).max() > 0.1
    assert held.bones() == pytest.approx(free.bones(), abs=1e-4)
    assert held.kinks().max() < 2.0 * free.kinks().max() + 0.25
    speed, usual = (np.linalg.norm(np.diff(one.position[:, FOLLOWER], axis=0), axis=-1).max() for one in (held, free))
    assert speed < 1.5 * usual + 1.0 * TICK


@pytest.mark.long
def test_arms_out_of_reach_are_unchanged_and_misses_are_counted() -> None:
    far = HELD.replace("hold_distance = 0.4", "hold_distance = 1.0")
    held = ShowRecorder(holding_show(far, apart=1.7), 9.0)
    free = ShowRecorder(set_hands_fader(holding_show(far, apart=1.7), 0.0), 9.0)
    assert any(example.holds for example in holding_bank(far, 1.7).example_sets[0].units.examples)  # type: ignore[union-attr]
    late = round(6.0 / TICK)
    assert held.show.dancers.partner_response.path.level[FOLLOWER] == 1.0  # type: ignore[union-attr]
    assert held.holding.missed_count > 0
    assert np.array_equal(held.position[late:], free.position[late:])
    assert held.bones() == pytest.approx(free.bones(), abs=1e-4)


@pytest.mark.long
def test_hands_fader_releases_hold_smoothly_and_rendering_changes_nothing() -> None:
    one, other = holding_show(), holding_show()
    drawn = ShowRecorder(other, 12.0, drawn=True)
    assert np.array_equal(ShowRecorder(one, 12.0).position, drawn.position)
    assert one.state_hash() == other.state_hash()
    set_hands_fader(one, 0.0)
    gone = ShowRecorder(one, 2.0)
    assert np.linalg.norm(np.diff(gone.position[:, FOLLOWER], axis=0), axis=-1).max() / TICK < 6.0
    gaps = gone.gaps(1)
    assert gaps[0] < 0.03
    assert gaps[-1] > 0.05


@pytest.mark.long
def test_snapshot_with_held_hands_continues_bit_identically() -> None:
    show = holding_show()
    ShowRecorder(show, 12.0)
    tick = round(show.time / TICK)
    source = Snapshotter(show)
    while (taken := source.capture(tick)) is None:
        tick += 1
        show.tick(tick * TICK)
    again = restore(LoadedShow(FILE, holding_patch(), holding_graph(), answers=holding_bank()), taken.seal())
    assert again.dancers.partner_response.hand_holds.held_count  # type: ignore[union-attr]
    one, other = ShowRecorder(again, 2.0), ShowRecorder(show, 2.0)
    assert np.array_equal(one.position, other.position)
    assert again.state_hash() == show.state_hash()


@pytest.mark.long
def test_partners_without_hold_distance_do_not_hold_hands() -> None:
    plain = HELD.replace("hold_distance = 0.4\n", "")
    bank = holding_bank(plain)
    assert bank is not None
    assert not any(example.holds for example in bank.example_sets[0].units.examples)
    show = holding_show(plain)
    ShowRecorder(show, 5.0)
    assert show.dancers.partner_response.hand_holds.held_count == 0  # type: ignore[union-attr]
    assert bank.digest() != holding_bank().digest()  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("hold_time = 0.5", "hold_time without hold_distance"),
        ('hold_distance = 0.2\nplace = "own"', 'follower with place = "own"'),
        ("hold_distance = 0.0", "greater than or equal to 0.02"),
        ("hands = 1.5", "less than or equal to 1"),
    ],
)
def test_invalid_hold_settings_are_refused_with_line(lines: str, words: str) -> None:
    with pytest.raises(PatchError, match=words) as told:
        parse_patch(f"{PATCH}{HELD.replace('hold_distance = 0.4', lines)}", "test.toml")
    assert "line 30" in str(told.value)


def test_follower_at_own_place_does_not_hold_hands() -> None:
    show = holding_show(HELD.replace('"back & 6"', '"back"'))
    ShowRecorder(show, 5.0)
    assert show.dancers.partner_response is not None
    assert show.dancers.partner_response.path.level[FOLLOWER] == 1.0
    assert show.dancers.partner_response.hand_holds.statistics() == {"held": 0, "out_of_reach": 0}


def test_hands_parameter_of_unknown_partner_is_refused() -> None:
    show = holding_show()
    assert not show.apply(events.SetPartner(parameter="hands", value=0.5, partner="nobody", **STAMP))
    assert show.apply(events.SetPartner(parameter="hands", value=0.5, **STAMP))
    assert show.dancers.partner_response is not None
    assert show.dancers.partner_response.settings[0].hands == 0.5
    with pytest.raises(PersonError):
        show.dancers.partner_response.find("nobody")
