"""A show that follows another one's lines reaches the same state, bit for bit, from any starting point."""

import base64
import json
from pathlib import Path

import pytest

from live.clock.ticks import TICK
from live.control.events.events import ControlEvent, PlaceElement, SetLatency, SetTempo, TicksSkipped
from live.show.journal.journal import event_line
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.show import Show
from live.show.state.snapshot import snapshot
from live.supervisor.recovery import Recovery
from live.supervisor.recovery_log import RecoveryLog
from live.supervisor.state_follower import StateFollower
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import GRAPH, PATCH

LAST = 1500
EVENTS: dict[int, ControlEvent] = {
    100: PlaceElement(time=1.5, source="osc", kind="attract", points=((2.0, -1.0),), strength=1.0),
    400: SetTempo(time=6.3, source="osc", tempo=131.0),
    401: SetLatency(time=6.3, source="osc", what="projector", milliseconds=50.0),
    700: TicksSkipped(time=11.0, source="engine", count=30),
    1400: SetTempo(time=22.0, source="osc", tempo=97.0),
}


@pytest.fixture(scope="module")
def loaded() -> LoadedShow:
    return LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)


class LeadingShow:
    """A show that runs and writes lines as an engine does, with a hash of each of its ticks."""

    def __init__(self, loaded: LoadedShow, snapshots: tuple[int, ...] = ()) -> None:
        self.show = loaded.start(seed=5)
        self.lines = [json.dumps({"journal": 2, "origin": 12.5, **loaded.header(self.show, tempo=None)})]
        self.hashes: dict[int, str] = {}
        wanted, tick = list(snapshots), 0
        while tick < LAST:
            tick += 1
            crossed = self.show.tick(tick * TICK)
            self.hashes[tick] = self.show.state_hash()
            if crossed:
                measure = self.show.span.number + 1
                self.lines.append(json.dumps({"tick": tick, "measure": measure, "hash": self.hashes[tick]}))
            if wanted and tick >= wanted[0]:
                wanted.pop(0)
                state = base64.b64encode(snapshot(self.show, tick)).decode()
                self.lines.append(json.dumps({"tick": tick, "snapshot": state}))
            self.lines.append(json.dumps({"tick": tick}))
            if (event := EVENTS.get(tick)) is not None:
                self.lines.append(event_line(tick, event))
                self.show.apply(event)
                if isinstance(event, TicksSkipped):
                    tick += event.count


@pytest.fixture(scope="module")
def leading_show(loaded: LoadedShow) -> LeadingShow:
    return LeadingShow(loaded, (650, 1250))


def follow(loaded: LoadedShow, lines: list[str]) -> tuple[StateFollower, Show]:
    following = StateFollower(loaded)
    for line in lines:
        following.add_line(line)
    return following, Recovery(following).run().show


@mostly_long("end", [90, 405, 720, 1100, 1430], quick=[1, 2])
def test_follower_reaches_state_of_leader_killed_midway(loaded, leading_show, end):
    """`end`: number of lines sent before the leader was killed."""
    following, show = follow(loaded, leading_show.lines[:end])
    assert show.state_hash() == leading_show.hashes[following.tick]
    assert following.differences == 0
    assert following.origin == 12.5


def test_late_follower_begins_with_snapshot_and_reaches_same_state(loaded, leading_show):
    log = RecoveryLog()
    for line in leading_show.lines:
        log.add_line(line)
    lines = list(log.replay_lines())
    assert len(lines) < 20  # header, snapshot, and what came since
    following, show = follow(loaded, lines)
    assert following.tick == LAST
    assert show.state_hash() == leading_show.hashes[LAST]
    assert following.compared >= 1
    assert following.differences == 0


@pytest.mark.long
def test_standby_stays_behind_last_measure_line_until_needed(loaded, leading_show):
    following = StateFollower(loaded)
    for line in leading_show.lines[:600]:
        following.add_line(line)
    while following.advance():
        pass
    measures = [
        json.loads(line)["tick"] for line in leading_show.lines[:600] if "hash" in json.loads(line) and "me" in line
    ]
    assert following.tick == measures[-1]
    Recovery(following).run()
    assert following.tick == json.loads(leading_show.lines[599])["tick"]


def test_differing_state_is_counted_and_repaired_by_next_snapshot(loaded, leading_show):
    following = StateFollower(loaded)
    for line in leading_show.lines[1:]:
        if not following.header:
            following.add_line(leading_show.lines[0])
        following.add_line(line)
        following.run_pending()
        if following.tick == 300 and following.show is not None:  # something this machine does differently
            following.show.apply(
                PlaceElement(time=4.7, source="osc", kind="attract", points=((-4.0, 2.0),), strength=1.0)
            )
    assert following.differences >= 1
    assert following.repaired >= 1
    assert following.show is not None
    assert following.show.state_hash() == leading_show.hashes[LAST]


@pytest.mark.long
def test_event_that_ends_one_engine_does_not_end_next(loaded, leading_show, monkeypatch):
    """An event that raises in the leader is left out and counted by the follower, which continues."""
    apply = Show.apply

    def poisoned(show: Show, event: ControlEvent) -> bool:
        if isinstance(event, SetTempo):
            raise RuntimeError("poison")
        return apply(show, event)

    monkeypatch.setattr(Show, "apply", poisoned)
    following, _ = follow(loaded, leading_show.lines)
    assert following.tick == LAST
    assert following.refused == 2
    assert following.latencies == {"projector": 0.05}


def test_remote_clock_origin_comes_from_earliest_tick(loaded):
    following = StateFollower(loaded)
    for tick, late in ((640, 0.030), (641, 0.004), (642, 0.011)):
        following.add_line(json.dumps({"tick": tick}), arrived=1000.0 + tick * TICK + late)
    assert following.local_origin(lead=TICK) == pytest.approx(1000.0 + 0.004 + TICK)
