"""Crafted and mutated lines of a paired machine that is broken or compromised: no process dies of them."""

import json
import random
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from live import __version__
from live.app.processes.remote_standby import apply_log
from live.app.session_records import resident_megabytes
from live.base.errors import PersonError
from live.base.system.process_control import RESTART_CODE
from live.show.journal.replay import ReplayError
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.supervisor.engine_failover import EngineFailover
from live.supervisor.line_channel import LineChannel
from live.supervisor.network.leadership import HandOver, Pulse, Term
from live.supervisor.network.peer_messages import (
    CannotFollow,
    FollowerState,
    FollowRequest,
    Hello,
    Restart,
    ShowKeys,
    StreamStart,
    format_message,
)
from live.supervisor.network.peers import Link
from live.supervisor.network.remote_standby import MAX_SHOW_BYTES, RemoteStandby
from live.supervisor.network.show_stream import is_show_line
from live.supervisor.process import ProcessManager
from live.supervisor.state_follower import StateFollower
from live.supervisor.supervisor_config import Report, SupervisorConfig
from tests.show.made_show import GRAPH, PATCH
from tests.supervisor.made_machines import free_port, machine, pair_folders

LEADER = Term(1, "leader-1")
HELLO = format_message(Hello(__version__, "leader-1", bytes(32)))
SHOW = [
    json.dumps({"journal": 2, "patch": {"name": "x"}, "seed": 1, "steps_hash": "0" * 16, "origin": 1.5}),
    json.dumps({"tick": 10, "event": {"type": "SetTempo", "time": 0.1, "source": "osc", "tempo": 131.0}}),
    json.dumps({"tick": 64, "measure": 2, "hash": "0123456789abcdef"}),
    json.dumps({"tick": 64, "snapshot": "AAAA"}),
    json.dumps({"tick": 65, "left_out": 2}),
    json.dumps({"tick": 66, "event": {"type": "PatchChanged", "time": 1.0, "source": "patch", "patch": "z:AAAA"}}),
    json.dumps({"tick": 70}),
]
WORDS = [
    HELLO,
    format_message(Pulse(LEADER, True, deputy=True)),
    format_message(HandOver(LEADER)),
    format_message(FollowRequest("abc", 3)),
    format_message(StreamStart("abc", 0, True)),
    format_message(StreamStart("abc", 7, False)),
    format_message(CannotFollow("because")),
    format_message(FollowerState(64, 3, 1)),
    format_message(ShowKeys((("web_key", "k"), ("audience_secret", "00")))),
    format_message(Restart()),
    json.dumps({"alive": "claim", "epoch": 2, "leader": "x", "number": 1, "signature": "00" * 64}),
    json.dumps({"alive": "lead", "epoch": 99}),
]
VALUES: list[object] = [
    None, True, -1, 0, 3, 1 << 70, 1e308, float("nan"), float("inf"), "", "\x00", "a" * 5000, [], {}, [[]],
    {"type": []},
    {"type": "SetTempo", "tempo": "fast"}, {"type": "TicksSkipped", "time": 0.0, "source": "x", "count": 1 << 62}, "-9",
]  # fmt: skip


def mutate_line(chance: random.Random) -> str:
    """An almost valid line: with other values, keys or bytes, or cut off."""
    line = chance.choice(SHOW if chance.random() < 0.6 else WORDS)
    kind = chance.randrange(6)
    if kind < 3:
        told = json.loads(line)
        key = chance.choice([*told, "tick", "event", "alive"])
        told[key] = chance.choice(VALUES)
        return json.dumps(told)
    if kind == 3:
        marks = bytearray(line.encode())
        for _ in range(chance.randrange(1, 8)):
            marks[chance.randrange(len(marks))] = chance.randrange(256)
        return marks.decode("utf-8", "replace")
    if kind == 4:
        return line[: chance.randrange(len(line))]
    return chance.choice(["", "[" * 20_000, '{"tick":' * 5000, "9" * 5000, "null", '{"tick":1}', line])


class PlainChannel(LineChannel):
    """A channel without TLS, for many lines."""

    rejected = False


@pytest.fixture
def standby(tmp_path: Path) -> Iterator[RemoteStandby]:
    pair_folders(tmp_path / "mine", tmp_path / "theirs")
    identity, pairings = machine(tmp_path / "mine")
    orders = SupervisorConfig(
        engine=["false"], show="", follow=("127.0.0.1", free_port()), identity=identity, pairings=pairings
    )
    starter, report = ProcessManager(), Report()
    engines = EngineFailover(orders, starter, report, lambda line: None, {})
    one = RemoteStandby(orders, starter, engines, report, lambda line: None)
    yield one
    one.close()
    starter.close()


def open_leader_link(standby: RemoteStandby, count: int) -> tuple[Link, socket.socket]:
    """A link whose machine leads, and the other end of its socket."""
    peers = standby._peers
    assert peers is not None
    mine, theirs = socket.socketpair()
    wire = PlainChannel(mine, backlog=1 << 20)
    wire.peer = next(iter(peers._trust.peers.values()))  # type: ignore[attr-defined]
    link = Link(f"theirs #{count}", wire, True)  # type: ignore[arg-type]
    peers.links[link.name] = link
    for line in (HELLO, format_message(Pulse(LEADER, True)), format_message(StreamStart("abc", 0, True)), SHOW[0]):
        standby._receive(link, line)
    return link, theirs


@pytest.mark.parametrize("packets", [6000, pytest.param(100_000, marks=pytest.mark.long)])
def test_no_line_of_paired_machine_ends_supervisor(standby, packets):
    chance, before, count, passed = random.Random(1), resident_megabytes()(), 1, []
    standby._engines.on_line = lambda line, kept: passed.append(kept)
    link, theirs = open_leader_link(standby, count)
    for number in range(packets):
        standby._receive(link, mutate_line(chance))
        if number % 50 == 0:
            standby.update(float(number) / 50.0)
        if link.name not in standby._peers.links or standby._leadership.leader != link.name:
            standby._peers.drop(link)
            theirs.close()
            standby._engines.code, standby._leadership.role, standby._leadership.leader = (
                None,
                type(standby._leadership.role).FOLLOWS,
                None,
            )
            standby._leadership.term = Term(0, "")
            count += 1
            link, theirs = open_leader_link(standby, count)
    theirs.close()
    assert count > packets / 300  # what makes no sense ends a link
    assert standby._report.lines_refused > packets / 30
    assert len(passed) > packets / 30  # and what does make sense is still heard
    assert resident_megabytes()() - before <= 200.0


def test_keys_and_orders_count_only_from_the_machine_that_leads(standby):
    standby._with_keys = given_keys
    link, theirs = open_leader_link(standby, 1)
    standby._receive(link, format_message(ShowKeys((("web_key", "right"),))))
    assert standby._engines.show == "right"
    other = Link("other #2", link.channel, False, peer_challenge=bytes(32), peer_name="other")
    standby._peers.links[other.name] = other
    for message in (ShowKeys((("web_key", "wrong"),)), Restart()):
        standby._receive(other, format_message(message))
    assert standby._report.lines_refused == 2
    assert (standby._engines.show, standby._engines.code) == ("right", None)
    standby._receive(link, format_message(Restart()))
    assert standby._engines.code == RESTART_CODE
    standby._receive(link, format_message(ShowKeys((("another", "name"),))))  # what makes no sense ends the link
    assert link.name not in standby._peers.links
    theirs.close()


def given_keys(show, keys):
    if set(keys) != {"web_key"}:
        raise ValueError("keys of a show expected")
    return keys["web_key"]


def test_endless_stream_of_lines_closes_link(standby):
    before = resident_megabytes()()
    link, theirs = open_leader_link(standby, 1)
    event = {"type": "x", "words": "y" * 100_000}
    for tick in range(MAX_SHOW_BYTES // 100_000 + 2):
        standby._receive(link, json.dumps({"tick": tick, "event": event}))
    assert link.name not in standby._peers.links
    theirs.close()
    assert resident_megabytes()() - before <= 200.0


def test_no_line_accepted_by_supervisor_ends_following_engine(standby):
    """Unknown content is refused and counted; an invalid show is reported as a person's error."""
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
    header = json.dumps({"journal": 2, "origin": 1.5, **loaded.header(loaded.start(seed=5), tempo=None)})
    chance, ended, refused = random.Random(2), 0, 0
    following = StateFollower(loaded)
    following.add_line(header)
    standby._engines.log.add_line(header)
    for _ in range(1500):
        line = mutate_line(chance)
        try:
            told = json.loads(line)
        except (ValueError, RecursionError):
            continue
        log = standby._engines.log
        if not isinstance(told, dict) or "alive" in told or not is_show_line(told, begun=True, tick=log.tick):
            continue
        if isinstance(told.get("tick"), int):
            told["tick"] = following.tick + told["tick"] % 3
        following.add_line(json.dumps(told), arrived=1.0)
        try:
            apply_log(following)
        except (PersonError, ReplayError):
            ended += 1
        refused += following.refused
        if ended or following.tick > 400 or chance.random() < 0.01:
            following = StateFollower(loaded)
            following.add_line(header if chance.random() < 0.9 else json.dumps(json.loads(header) | {"seed": "x"}))
            ended = 0
    assert refused > 10
