"""Nodes follow a leader bit by bit and present its ticks at the moments that it says."""

import json
import math

import pytest

from live import __version__
from live.base.errors import PersonError
from live.control.events.events import MuteAudience, PlaceElement, SetTempo
from live.nodes import messages
from live.nodes.follower import Phase
from live.nodes.messages import Lines, NodeState, Pulse
from live.nodes.operator import Operator
from live.nodes.signed_bus import SignedBus
from live.supervisor.network.identity import Pairings, load_identity
from live.supervisor.recovery_log import RecoveryLog
from tests.nodes.made_cluster import MadeBus, MadeCluster, MadeNode, made_loaded
from tests.show.made_show import PATCH


@pytest.fixture(scope="module")
def loaded():
    return made_loaded()


@pytest.fixture
def cluster(tmp_path):
    return MadeCluster(tmp_path)


def tempo(value):
    return SetTempo(time=0.0, source="osc", tempo=value)


def follows(*nodes):
    return lambda: all(node.follower.phase is Phase.FOLLOWS for node in nodes)


@pytest.mark.long
def test_nodes_with_other_clocks_present_the_same_ticks(tmp_path, loaded):
    """5 ms of jitter, 1 % of loss, 100 ppm of drift, clocks that are 2 s off."""
    cluster = MadeCluster(tmp_path, jitter=0.005, loss=0.01)
    leader = cluster.lead(loaded)
    cluster.run(0.5)
    nodes = [
        MadeNode(cluster, "left", loaded, offset=2.0, drift=1e-4),
        MadeNode(cluster, "right", loaded, offset=-2.0, drift=-1e-4),
    ]
    assert cluster.run(5.0, follows(*nodes)) < 3.0
    begun = cluster.clock.now()
    cluster.run(2.5)
    leader.apply(tempo(131.0))
    cluster.run(3.0)
    for node in nodes:
        wrong = node.wrong_ticks(begun)
        assert len(wrong) <= 0.001 * len(node.presented), wrong
        following = node.follower.following
        assert following.compared >= 2
        assert following.differences == 0
        assert node.follower.joins == 1
        assert node.follower.state().refused == 0


def test_state_is_the_leaders_bit_by_bit(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(1.0, follows(node))
    leader.apply(PlaceElement(time=0.4, source="osc", kind="attract", points=((2.0, -1.0),), strength=1.0))
    cluster.run(1.0)
    leader.running = False
    cluster.run(0.1)  # it runs what the leader has run, not more
    assert node.hash == (leader.tick, leader.show.state_hash())


def test_node_that_is_killed_is_back_with_a_snapshot(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(3.5)
    assert node.follower.phase is Phase.FOLLOWS
    node.stop()
    cluster.run(1.6)
    again = MadeNode(cluster, "left", loaded)
    assert cluster.run(5.0, follows(again)) < 3.0
    cluster.run(0.1)
    leader.running = False
    cluster.run(0.1)
    assert again.hash == (leader.tick, leader.show.state_hash())
    assert again.follower.following.compared <= 2  # it began at the snapshot and not at the beginning


@pytest.mark.long
def test_lost_lines_are_asked_for_again(tmp_path, loaded):
    cluster = MadeCluster(tmp_path, loss=0.1)
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(5.0, follows(node))
    cluster.run(2.0)
    leader.apply(tempo(140.0))
    cluster.run(2.0)
    assert node.follower.joins == 1
    assert node.follower.following.differences == 0
    assert node.follower.following.compared >= 1


@pytest.mark.long
def test_answer_that_comes_twice_begins_the_show_once(cluster, loaded):
    """A slow answer was asked for again, and both come."""
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    answer = leader.nodes._answer_join

    def answer_twice(*asked):
        answer(*asked)
        answer(*asked)

    leader.nodes._answer_join = answer_twice
    assert cluster.run(5.0, follows(node)) < 3.0
    cluster.run(0.5)
    assert node.follower.joins == 1


@pytest.mark.long
def test_node_that_is_cut_off_goes_on_alone_and_returns(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(2.0)
    cluster.network.cut.add(node.place)
    cluster.run(2.0)
    assert node.follower.phase is Phase.ALONE
    assert node.follower.state().why == "the leader is silent"
    drawn = node.presented[-1][1]
    assert drawn.tick == drawn.due  # it dances on
    cluster.network.cut.clear()
    assert cluster.run(3.0, follows(node)) < 2.0
    assert node.follower.joins == 1  # nothing has happened meanwhile: what it has drawn was right
    cluster.run(2.5)
    assert node.follower.following.differences == 0
    leader.running = False
    cluster.run(0.2)
    assert node.hash == (leader.tick, leader.show.state_hash())


@pytest.mark.long
def test_node_that_missed_events_takes_a_snapshot(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(2.0)
    cluster.network.cut.add(node.place)
    cluster.run(1.0)
    leader.apply(tempo(140.0))
    cluster.run(1.0)
    cluster.network.cut.clear()
    back = cluster.clock.now()
    cluster.run(4.0, lambda: follows(node)() and node.follower.joins == 2)
    assert node.follower.joins == 2
    drawn = [shown for at, shown in node.presented if at >= back]
    assert len(drawn) > 0.9 * (cluster.clock.now() - back) / 0.004  # it has drawn all the time
    cluster.run(0.3)
    leader.running = False
    cluster.run(0.2)
    assert node.hash == (leader.tick, leader.show.state_hash())


@pytest.mark.long
def test_picture_goes_on_alone_while_a_snapshot_is_restored(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(2.0, follows(node))
    restoring = []
    node.follower._aside = restoring.append
    node.follower.following.reset_to(None, 0)  # it has lost its state
    node.follower.following.reset_to(loaded.start(seed=9), node.follower._tick)  # and has a wrong one
    cluster.run(4.0, lambda: bool(restoring))
    since = cluster.clock.now()
    cluster.run(0.6)
    leader.apply(tempo(140.0))
    cluster.run(0.6)
    assert node.follower.phase is Phase.ALONE
    assert node.follower.state().why == "the show is taken anew"
    drawn = [shown for at, shown in node.presented if at > since + 0.01]
    assert len(drawn) > 250
    assert all(shown.tick == shown.due for shown in drawn)
    wrong = drawn[0].show
    restoring.pop()()
    cluster.run(1.0, follows(node))
    assert node.presented[-1][1].show is not wrong
    cluster.run(0.1)
    leader.running = False
    cluster.run(0.1)
    assert node.hash == (leader.tick, leader.show.state_hash())
    assert node.follower.joins == 2


@pytest.mark.long
def test_show_is_not_asked_for_again_while_its_answer_comes(cluster, loaded):
    """The answer is the whole show: on a slow network it takes a while."""
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    answer, held = leader.nodes._answer_join, []
    leader.nodes._answer_join = lambda *asked: held.append(asked)
    cluster.run(4.0)
    assert len(held) == 1
    answer(*held.pop())
    cluster.run(1.0, follows(node))
    assert node.follower.phase is Phase.FOLLOWS
    assert node.follower.joins == 1
    assert held == []


@pytest.mark.long
def test_show_is_asked_for_again_if_no_answer_can_come(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    answer, asked = leader.nodes._answer_join, []

    def lose(log, question, now):
        asked.append(cluster.clock.now())
        if len(asked) < 3:
            question._question.end()
        else:
            answer(log, question, now)

    leader.nodes._answer_join = lose
    cluster.run(3.0, follows(node))
    assert node.follower.phase is Phase.FOLLOWS
    assert len(asked) == 3
    assert asked[2] - asked[1] > 0.4


@pytest.mark.long
def test_node_that_missed_what_no_hash_shows_takes_a_snapshot(cluster, loaded):
    """The hash of a measure is that of the dancers: it is right after a late mute, and the picture is not."""
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(2.0)
    cluster.network.cut.add(node.place)
    cluster.run(1.0)
    leader.apply(MuteAudience(time=0.0, source="osc", on=True))
    count = len(leader.hashes)
    cluster.run(2.5)
    assert len(leader.hashes) > count  # a measure began after it
    cluster.network.cut.clear()
    cluster.run(4.0, lambda: follows(node)() and node.follower.joins == 2)
    assert node.follower.joins == 2


@pytest.mark.long
def test_of_two_leaders_the_first_is_kept_until_a_higher_epoch_rules(cluster, loaded):
    first, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(1.0, follows(node))
    other = cluster.lead(loaded)
    cluster.run(1.0)
    assert node.follower._pulse.leader == first.nodes.name
    assert any("two leaders" in words for words in node.said)
    assert node.follower.others > 0
    other.report.epoch = 2
    cluster.run(1.0)
    assert node.follower._pulse.leader == other.nodes.name
    first.report.epoch = 40  # more than a machine can have missed
    cluster.run(0.5)
    assert node.follower._pulse.leader == other.nodes.name


@pytest.mark.long
def test_standby_that_takes_over_is_followed(cluster, loaded):
    """It has the same lines and leads once its leader is dead."""
    first, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(1.0, follows(node))
    heir = cluster.lead(loaded, header=first.log.header)
    heir.report.follows = "the first"
    cluster.run(1.0)
    assert node.follower.others == 0  # a machine that stands by is silent
    cluster.leaders.remove(first)
    cluster.run(0.3)
    heir.report.follows, heir.report.epoch = "", 2
    cluster.run(2.0)
    assert node.follower._pulse.leader == heir.nodes.name
    heir.running = False
    cluster.run(0.2)
    assert node.hash == (heir.tick, heir.show.state_hash())


@pytest.mark.long
def test_machine_that_stands_by_knows_the_show_that_it_followed_last(cluster, loaded):
    """Nodes change over to a leader of the same show sooner than to one of another show."""
    first, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    header = json.dumps(json.loads(first.log.header) | {"seed": 6})
    heir = cluster.lead(loaded, header=header)  # of the show before
    heir.report.follows = "the first"
    cluster.run(0.2)
    heir.log = RecoveryLog()
    heir.log.add_line(first.log.header)  # the next show comes from its leader and not from an engine of its own
    cluster.run(0.8, follows(node))
    heir.report.follows, heir.report.epoch = "", 2
    cluster.run(0.3)
    assert node.follower._pulse.leader == heir.nodes.name
    assert node.follower._pulse.show == first.nodes._show


def test_other_kernels_are_refused_by_name_with_a_remedy(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded, kernels="other")
    with pytest.raises(PersonError, match="node left has the kernels other") as error:
        cluster.run(1.0)
    assert "LIVE_KERNEL_TARGET" in (error.value.remedy or "")
    assert any("node left has the kernels other" in words and "refused" in words for words in leader.said)
    assert node.follower.following is None


def test_other_version_is_refused_by_name(cluster, loaded, monkeypatch):
    cluster.lead(loaded)
    MadeNode(cluster, "left", loaded)
    monkeypatch.setattr("live.nodes.follower.__version__", "0.0.1")
    with pytest.raises(PersonError, match=r"node left has version 0\.0\.1, the leader"):
        cluster.run(1.0)


def test_other_patch_is_refused_with_what_differs(cluster, loaded):
    cluster.lead(loaded)
    MadeNode(cluster, "left", made_loaded(PATCH.replace("dancers = 5", "dancers = 6")))
    with pytest.raises(PersonError, match=r"the leader plays another show: .*different: group"):
        cluster.run(1.0)


@pytest.mark.long
def test_name_of_another_node_is_refused_until_it_has_gone(cluster, loaded):
    cluster.lead(loaded)
    first = MadeNode(cluster, "left", loaded)
    cluster.run(1.0, follows(first))
    cluster.run(0.6)
    second = MadeNode(cluster, "left", loaded)
    cluster.run(1.0)
    assert second.follower.phase is Phase.JOINS
    assert second.follower.why == "another node is called left"
    first.stop()
    cluster.run(5.0, follows(second))
    assert second.follower.phase is Phase.FOLLOWS


def test_node_waits_for_the_next_show(cluster, loaded):
    first, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(1.0, follows(node))
    first.line(json.dumps({"tick": first.tick, "end": True}))
    cluster.run(0.1)
    assert node.follower.phase is Phase.ENDED
    assert node.follower.present(0.0) is None
    cluster.leaders.remove(first)
    cluster.lead(loaded)
    cluster.run(3.0, follows(node))
    assert node.follower.phase is Phase.FOLLOWS


def test_messages_of_strangers_and_damaged_ones_are_dropped_and_counted(cluster, loaded, tmp_path):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(1.0, follows(node))
    stranger = tmp_path / "stranger"
    outside = SignedBus(MadeBus(cluster.network, "stranger"), load_identity(stranger), Pairings(stranger))
    outside.publish(messages.PULSE, messages.encode(Pulse("evil", 9, "x", "y", 0, 0.0, 0.0)))
    cluster.run(0.1)
    assert node.follower._bus.strangers == 1
    assert node.follower._pulse.leader == leader.nodes.name
    inside = SignedBus(MadeBus(cluster.network, "inside"), cluster.identity, cluster.pairings)
    leader.running = False
    cluster.run(0.1)
    number = node.follower._number
    for data in (
        b"", b"\xc1", messages.encode({"leader": "x"}), messages.encode(Lines("s", 1, ())),
        messages.encode(Pulse("evil", 9, "x", "y", 0, 0.0, 0.0))[:-3],
        *(messages.encode(Pulse("evil", 2, "x", "y", 0, number, 0.0)) for number in (math.nan, math.inf, 1e300)),
    ):  # fmt: skip
        inside.publish(messages.PULSE, data)
    inside.publish(messages.STATE, b"\x00")
    inside.publish(messages.LINES, messages.encode(Lines(node.follower._stream, number + 1, ('{"tick":"many"}', "no"))))
    cluster.run(0.1)
    assert node.follower.refused == 10
    assert leader.nodes.refused == 1
    assert node.follower.phase is Phase.FOLLOWS


def test_report_of_a_node_is_bounded_and_printable(cluster, loaded):
    leader = cluster.lead(loaded)
    bus = SignedBus(MadeBus(cluster.network, "left"), cluster.identity, cluster.pairings)
    for why in ("x" * 20_000, "\x1b[2Jlost"):
        bus.publish(messages.STATE, messages.encode(NodeState("left", "p", __version__, "alone", why)))
    cluster.run(0.1)
    assert leader.nodes.refused == 1
    assert leader.report.nodes["left"]["why"] == " [2Jlost"


def test_pairing_that_is_removed_ends_the_trust(tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    other = load_identity(there)
    pairings = Pairings(here)
    pairings.add("there", other.certificate)
    network = MadeCluster(tmp_path / "net").network
    mine = SignedBus(MadeBus(network, "here"), load_identity(here), pairings)
    theirs = SignedBus(MadeBus(network, "there"), other, Pairings(there))
    sealed = theirs.sealed("key", b"data")
    assert mine.opened("key", sealed) == b"data"
    assert mine.opened("other key", sealed) is None
    assert mine.opened("key", sealed[:-1]) is None
    assert pairings.forget("there")
    mine._look_at = 0.0
    mine.refresh()
    assert mine.opened("key", sealed) is None
    assert mine.strangers == 3


def test_pairing_that_cannot_be_read_changes_nothing(tmp_path):
    """A show must not end because a file is damaged while it runs."""
    here, there = tmp_path / "here", tmp_path / "there"
    other, pairings = load_identity(there), Pairings(here)
    pairings.add("there", other.certificate)
    network = MadeCluster(tmp_path / "net").network
    mine = SignedBus(MadeBus(network, "here"), load_identity(here), pairings)
    sealed = SignedBus(MadeBus(network, "there"), other, Pairings(there)).sealed("key", b"data")
    (file,) = here.rglob("there.pem")
    file.write_bytes(b"damaged")
    mine._look_at = 0.0
    mine.refresh()
    assert mine.opened("key", sealed) == b"data"


GATEWAY = {
    "kind": "gateway", "name": "stage-left", "process": "a1b2c3", "version": "0.9", "state": "serves", "why": "",
    "machine": "stage-pc", "clock_ms": 0.25, "late_ms": 3.5, "silent_ms": 12, "load": "40 of 8000 phones",
}  # fmt: skip
STANDBY = {
    "name": "second", "process": "p-1", "state": "ready", "why": "takes over next", "late_ms": 31.2, "silent_ms": 80.0,
    "compared": 9, "different": 0,
}  # fmt: skip


class AskingBus:
    """An operator's bus: while it asks, the cluster runs."""

    def __init__(self, cluster):
        self.cluster = cluster
        self.bus = SignedBus(MadeBus(cluster.network, "operator"), cluster.identity, cluster.pairings)

    def receive(self, key, act):
        self.bus.receive(key, act)

    def ask(self, key, data, act, *, timeout):
        came = []
        self.bus.ask(key, data, lambda data: (act(data), came.append(data)), timeout=timeout)
        self.cluster.run(0.2, lambda: bool(came))


def operator_of(cluster, leader):
    return Operator(AskingBus(cluster)), leader.nodes.name


@pytest.mark.long
def test_operator_sees_all_parts_of_a_show(cluster, loaded):
    leader = cluster.lead(loaded)
    nodes = [MadeNode(cluster, name, loaded, offset=2.0) for name in ("left", "right")]
    leader.report.gateways = [{**GATEWAY, "kind": "reducer", "name": "reducer"}, GATEWAY, {"kind": "gateway"}, GATEWAY]
    leader.report.standbys = [STANDBY, {"name": "old", "process": "", "state": "refused", "why": "v", "silent_ms": 1.0}]
    cluster.run(2.0, follows(*nodes))
    cluster.run(0.6)
    operator, name = operator_of(cluster, leader)
    seen = operator.status(name)
    assert [(node.told.name, node.state, node.told.version) for node in seen.nodes] == [
        ("left", "follows", __version__), ("right", "follows", __version__),
    ]  # fmt: skip
    assert seen.nodes[0].told.offset_ms == pytest.approx(-2000.0, abs=2.0)
    told = {(one.kind, one.name): one for one in seen.members}
    gateway, standby = told["gateway", "stage-left"], told["standby", "second"]
    assert (gateway.version, gateway.machine, gateway.offset_ms, gateway.late_ms) == ("0.9", "stage-pc", 0.25, 3.5)
    assert (standby.version, standby.state, standby.late_ms) == (__version__, "ready", 31.2)
    assert told["standby", "old"].version == ""
    assert [part.kind for part in seen.parts] == ["gateway"] * 2 + ["reducer"] + ["node"] * 2 + ["standby"] * 2
    assert not seen.works  # the one that is refused
    leader.report.standbys.pop()
    assert operator.status(name).works


@pytest.mark.long
def test_parts_are_started_again_one_after_another(cluster, loaded):
    leader = cluster.lead(loaded)
    nodes = [MadeNode(cluster, name, loaded) for name in ("left", "right")]
    second = {**GATEWAY, "process": "d4e5f6"}
    leader.report.gateways, leader.report.standbys = [GATEWAY, second], [STANDBY]
    cluster.run(2.0, follows(*nodes))
    cluster.run(0.6)
    operator, name = operator_of(cluster, leader)
    orders = []

    def order(kind, one, process):
        """A gateway of this name goes; another one comes after a while."""
        orders.append((kind, one, process))
        rows = leader.report.gateways if kind == "gateway" else leader.report.standbys
        row = next(row for row in rows if row["process"] == process)
        rows[rows.index(row)] = {**row, "process": f"new {process}"}

    leader.nodes.on_restart = order
    back = operator.restart(name, ["stage-left", "second"], cluster.run)
    assert next(back).process == "a1b2c3"
    assert orders == [("gateway", "stage-left", "a1b2c3")]
    assert [part.process for part in back] == ["d4e5f6", "p-1"]
    assert [node.follower.restart_asked for node in nodes] == [False, False]
    with pytest.raises(PersonError, match="node left has not come back"):
        list(operator.restart(name, ["left"], cluster.run))  # nothing keeps this one
    assert [node.follower.restart_asked for node in nodes] == [True, False]
    with pytest.raises(PersonError, match="there is no 'middle' in this show; parts: left, right, second, stage-left"):
        next(operator.restart(name, ["middle"], cluster.run))
    with pytest.raises(PersonError, match="the leader is not started again") as error:
        next(operator.restart(name, [name], cluster.run))
    assert "/dance/takeover" in (error.value.remedy or "")


def test_orders_that_are_none_are_counted(cluster, loaded):
    leader, node = cluster.lead(loaded), MadeNode(cluster, "left", loaded)
    cluster.run(1.0, follows(node))
    bus = SignedBus(MadeBus(cluster.network, "operator"), cluster.identity, cluster.pairings)
    key = messages.question_key(leader.nodes.name, messages.COMMAND)
    bus.ask(key, messages.encode("restart all"), lambda data: None, timeout=1.0)
    cluster.run(0.1)
    assert leader.nodes.refused == 1
    assert not node.follower.restart_asked
