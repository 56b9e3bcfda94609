"""The real bus over loopback: paired machines hear each other, others do not."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from live.base.errors import PersonError
from live.nodes.bus import LONGEST_AT_ONCE, ZenohBus, ZenohQuestion, configuration
from live.nodes.signed_bus import SignedBus
from live.supervisor.network.identity import Pairings, load_identity
from tests.supervisor.made_machines import free_port

pytest.importorskip("zenoh", reason="Eclipse Zenoh is not installed: pip install 'choreographics-live[nodes]'")


class Place:
    """A machine with keys of its own, and its end of the bus."""

    def __init__(self, folder, name):
        self.identity, self.pairings = load_identity(folder / name), Pairings(folder / name)
        self.bus = None
        self.heard, self.event = [], threading.Event()

    def pair(self, name, other):
        self.pairings.add(name, other.identity.certificate)

    def open(self, **how):
        self.bus = SignedBus(ZenohBus(self.identity, self.pairings, **how), self.identity, self.pairings)
        return self.bus

    def hear(self, data):
        self.heard.append(data)
        self.event.set()


@pytest.fixture
def places(tmp_path):
    leader, node, stranger = (Place(tmp_path, name) for name in ("leader", "node", "stranger"))
    leader.pair("node", node)
    node.pair("leader", leader)
    stranger.pair("leader", leader)  # it knows the leader, which does not know it
    yield leader, node, stranger
    for place in (stranger, node, leader):
        if place.bus is not None:
            place.bus.close()


def publish_until(bus, place, data, seconds):
    """Publish again and again until a place has heard it; return whether it has in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        bus.publish("live/test", data)
        if place.event.wait(0.05):
            return True
    return False


def test_paired_machines_exchange_messages_and_others_do_not(places):
    leader, node, stranger = places
    port = free_port()
    for place in (node, stranger):  # before the leader: they try again until it is there
        place.open(connect=[("127.0.0.1", port)]).receive("live/test", place.hear)
    bus = leader.open(listen=("127.0.0.1", port))
    bus.serve("live/ask/me", lambda asked: asked.answer(b"answer to " + asked.data))
    assert publish_until(bus, node, b"line", 20.0)
    assert set(node.heard) == {b"line"}
    answers, ended = [], threading.Event()
    node.bus.ask("live/ask/me", b"question", answers.append, timeout=60.0, end=ended.set)
    assert ended.wait(20.0)
    assert answers == [b"answer to question"]
    ended.clear()
    node.bus.ask("live/ask/nobody", b"question", answers.append, timeout=60.0, end=ended.set)
    assert ended.wait(20.0)  # long before the time that it would have had
    assert len(answers) == 1
    kept, ends, asked = [], [], threading.Event()
    bus.serve("live/ask/slow", lambda question: (kept.append(question), asked.set()))
    end = time.monotonic() + 20.0
    while not asked.is_set() and time.monotonic() < end:  # until the node knows that it is answered there
        ends.append(threading.Event())
        node.bus.ask("live/ask/slow", b"question", answers.append, timeout=60.0, end=ends[-1].set)
        asked.wait(0.2)
    assert asked.is_set()
    bus.close()
    assert all(end.wait(20.0) for end in ends)  # whoever was asked has gone
    assert stranger.heard == []
    assert stranger.bus.strangers == 0  # TLS has refused it: nothing reaches it at all


class SlowQuery:
    """A query whose asker takes nothing: a long answer waits for it."""

    payload = None

    def __init__(self):
        self.asker, self.replied = threading.Event(), []

    def reply(self, key, data, **how):
        if len(data) > LONGEST_AT_ONCE:
            assert self.asker.wait(10.0)
        self.replied.append(len(data))

    def drop(self):
        pass


def test_whoever_answers_does_not_wait_for_a_slow_asker():
    slow, other = SlowQuery(), SlowQuery()
    with ThreadPoolExecutor(1) as senders:
        ZenohQuestion(slow, "key", senders).answer(bytes(LONGEST_AT_ONCE + 1))
        ZenohQuestion(other, "key", senders).answer(b"time")
        assert (slow.replied, other.replied) == ([], [4])
        slow.asker.set()
    assert slow.replied == [LONGEST_AT_ONCE + 1]


def test_process_beside_a_leader_reaches_the_nodes_through_the_leader(places):
    """The relay of the operator's page is a client of the leader's bus."""
    leader, node, _ = places
    port = free_port()
    leader.open(listen=("127.0.0.1", port))
    node.open(connect=[("127.0.0.1", port)]).receive("live/test", node.hear)
    how = {"connect": [("127.0.0.1", port)], "client": True}
    beside = SignedBus(ZenohBus(leader.identity, leader.pairings, **how), leader.identity, leader.pairings)
    heard, event = [], threading.Event()
    beside.receive("live/back", lambda data: (heard.append(data), event.set()))
    try:
        assert publish_until(beside, node, b"page", 20.0)
        end = time.monotonic() + 20.0
        while not event.is_set() and time.monotonic() < end:
            node.bus.publish("live/back", b"click", bulk=True)
            event.wait(0.05)
        assert set(heard) == {b"click"}
    finally:
        beside.close()


def test_port_that_is_taken_is_a_persons_error(places):
    leader, node, _ = places
    port = free_port()
    leader.open(listen=("127.0.0.1", port))
    with pytest.raises(PersonError, match=rf"cannot be opened at 127\.0\.0\.1:{port}"):
        node.open(listen=("127.0.0.1", port))


def test_configuration_trusts_pinned_certificates_and_searches_only_if_asked(places):
    leader, _, _ = places
    quiet = configuration(leader.identity, leader.pairings, listen=None, connect=[("::1", 9022)], scout=False)
    assert quiet["scouting"]["multicast"]["enabled"] is False
    assert quiet["scouting"]["gossip"]["enabled"] is False
    assert quiet["connect"]["endpoints"] == ["tls/[::1]:9022"]
    assert quiet["transport"]["link"]["protocols"] == ["tls"]
    assert quiet["transport"]["link"]["tls"]["enable_mtls"] is True
    searching = configuration(leader.identity, leader.pairings, listen=("0.0.0.0", 9022), connect=[], scout=True)
    assert searching["scouting"]["multicast"]["enabled"] is True
    assert searching["listen"]["endpoints"] == ["tls/0.0.0.0:9022"]
