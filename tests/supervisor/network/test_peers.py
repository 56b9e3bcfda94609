"""Links to other machines over real TLS on loopback: accepted peers, refused peers, and attacks by strangers."""

import contextlib
import datetime
import socket
import ssl
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from live.supervisor.network import identity as identity_module
from live.supervisor.network import peers as module
from live.supervisor.network.identity import load_identity
from live.supervisor.network.leadership import Claim, Term
from live.supervisor.network.peer_messages import SignedClaim, parse_message, read_line, signed_claim, verified
from live.supervisor.network.peers import MAX_HANDSHAKES, Link, Peers
from live.supervisor.network.tls import TrustStore
from live.supervisor.process import ProcessManager
from tests.control.waiting import wait_for
from tests.supervisor.made_machines import machine, network, pair_folders


class Side:
    """One machine's links and the lines received on them."""

    def __init__(self, config: Path, *, leads: bool, upstream: int | None = None) -> None:
        self.identity, self.pairings = machine(config)
        self.door = socket.create_server(("127.0.0.1", 0)) if leads else None
        self.port = 0 if self.door is None else int(self.door.getsockname()[1])
        self.starter = ProcessManager()
        self.said: list[str] = []
        self.heard: list[str] = []
        self.nobody = 0
        there = None if upstream is None else ("127.0.0.1", upstream)
        self.peers = Peers(
            self.starter, self.identity, self.pairings, listener=self.door, upstream=there, say=self.said.append
        )
        self.peers.on_line = lambda link, line: self.heard.append(line)
        self.peers.on_link = lambda link: link.channel.send_line(f"hello from {link.name}")
        self.peers.on_refused = self._count

    def _count(self) -> None:
        self.nobody += 1

    def turn(self) -> None:
        self.peers.update(self.starter.poll())

    def close(self) -> None:
        self.peers.close()
        self.starter.close()


@pytest.fixture
def sides() -> Iterator[Callable[..., Side]]:
    made: list[Side] = []

    def make(config: Path, **how: object) -> Side:
        made.append(Side(config, **how))  # type: ignore[arg-type]
        return made[-1]

    yield make
    for side in made:
        side.close()


def wait_until(what: Callable[[], bool], *turning: Side, seconds: float = 10.0) -> bool:
    def done() -> bool:
        for side in turning:
            side.turn()
        return what()

    return wait_for(done, seconds)


def only_link(side: Side) -> Link:
    (link,) = side.peers.links.values()
    return link


def test_paired_machines_connect_and_know_each_other_by_name(tmp_path, sides):
    pair_folders(tmp_path / "left", tmp_path / "right")
    left = sides(tmp_path / "left", leads=True)
    right = sides(tmp_path / "right", leads=False, upstream=left.port)
    assert wait_until(lambda: bool(left.heard and right.heard), left, right)
    assert (only_link(left).peer.name, only_link(right).peer.name) == ("right", "left")
    assert only_link(left).channel.socket.version() == "TLSv1.3"
    words = "x" * 300_000
    only_link(right).channel.send_line(words)
    assert wait_until(lambda: words in left.heard, left, right)
    left.peers.drop(only_link(left))
    assert wait_until(lambda: len(right.heard) > 1, left, right)  # it comes again


def test_two_processes_of_one_user_need_no_pairing(tmp_path, sides):
    left = sides(tmp_path / "left", leads=True)
    right = sides(tmp_path / "left", leads=False, upstream=left.port)
    assert wait_until(lambda: bool(left.heard and right.heard), left, right)
    assert only_link(left).peer.name == "this machine"


@pytest.mark.parametrize("who_knows", ["left", "right", "nobody"])
def test_machine_not_paired_on_both_sides_receives_nothing(tmp_path, sides, who_knows):
    (one, ones), (two, twos) = machine(tmp_path / "left"), machine(tmp_path / "right")
    if who_knows == "left":
        ones.add("right", two.certificate)
    elif who_knows == "right":
        twos.add("left", one.certificate)
    left = sides(tmp_path / "left", leads=True)
    right = sides(tmp_path / "right", leads=False, upstream=left.port)
    assert wait_until(lambda: left.peers.strangers > 1 and bool(right.said), left, right)
    assert left.heard == right.heard == []
    assert not left.peers.links
    assert any("pair" in words for words in right.said)
    assert left.said == []  # strangers are no reason to talk


def test_machine_in_the_middle_receives_nothing_of_show(tmp_path, sides):
    """It takes the leader's place for the follower, with a certificate and a key of its own."""
    pair_folders(tmp_path / "left", tmp_path / "right")
    pair_folders(tmp_path / "between", tmp_path / "another")
    own, pairings = machine(tmp_path / "between")
    pairings.add("right", machine(tmp_path / "right")[0].certificate)
    between = sides(tmp_path / "between", leads=True)
    right = sides(tmp_path / "right", leads=False, upstream=between.port)
    assert wait_until(lambda: bool(right.said) and between.peers.strangers > 0, between, right)
    assert between.heard == right.heard == []
    assert "its certificate is not paired" in right.said[0]
    assert own.fingerprint not in right.said[0]


def test_replayed_connection_is_refused(tmp_path, sides):
    """A recording of every byte of a follower's connection, claims included, is sent to the leader again."""
    pair_folders(tmp_path / "left", tmp_path / "right")
    left = sides(tmp_path / "left", leads=True)
    record = bytearray()
    with socket.create_server(("127.0.0.1", 0)) as tap:
        right = sides(tmp_path / "right", leads=False, upstream=tap.getsockname()[1])
        thread = threading.Thread(target=relay_and_record, args=(tap, left.port, record), daemon=True)
        thread.start()
        assert wait_until(lambda: bool(left.heard and right.heard), left, right)
        only_link(right).channel.send_line('{"alive":"claim","epoch":2}')
        assert wait_until(lambda: len(left.heard) > 1, left, right)
        right.close()
        right.peers.links.clear()
        assert wait_until(lambda: not left.peers.links, left)
        thread.join(20)
    heard, strangers = [*left.heard], left.peers.strangers
    with socket.create_connection(("127.0.0.1", left.port)) as again:
        again.sendall(bytes(record))
        assert wait_until(lambda: left.peers.strangers > strangers, left)
    assert left.heard == heard
    assert not left.peers.links


def relay_and_record(tap: socket.socket, port: int, record: bytearray) -> None:
    """Relay between one client and a port, recording the client's bytes."""
    client, _ = tap.accept()
    server = socket.create_connection(("127.0.0.1", port))
    client.settimeout(0.02)
    server.settimeout(0.02)
    with client, server:
        while True:
            for source, target in ((client, server), (server, client)):
                try:
                    data = source.recv(1 << 16)
                except TimeoutError:
                    continue
                except OSError:
                    return
                if not data:
                    return
                if source is client:
                    record += data
                target.sendall(data)


@pytest.mark.long
def test_silent_sockets_are_limited_and_do_not_block_others(tmp_path, sides, monkeypatch):
    monkeypatch.setattr(module, "HANDSHAKE_WITHIN", 0.3)
    pair_folders(tmp_path / "left", tmp_path / "right")
    left = sides(tmp_path / "left", leads=True)
    with contextlib.ExitStack() as stack:
        for _ in range(3 * MAX_HANDSHAKES):
            stack.enter_context(socket.create_connection(("127.0.0.1", left.port)))
        most = 0

        def knock() -> bool:
            nonlocal most
            most = max(most, len(left.peers._handshakes))
            return left.peers.strangers >= 3 * MAX_HANDSHAKES

        assert wait_until(knock, left)
        assert most <= MAX_HANDSHAKES
        right = sides(tmp_path / "right", leads=False, upstream=left.port)
        assert wait_until(lambda: bool(left.heard and right.heard), left, right)


@pytest.mark.long
def test_closed_port_is_reported_and_silent_machine_is_not(tmp_path, sides):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    right = sides(tmp_path / "right", leads=False, upstream=port)
    assert wait_until(lambda: right.nobody > 0, right)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        other = sides(tmp_path / "right", leads=False, upstream=silent.getsockname()[1])
        begun = time.monotonic()
        assert wait_until(lambda: time.monotonic() - begun > 0.5, other)
        assert other.nobody == 0


@pytest.mark.long
def test_pairing_and_forgetting_apply_during_show(tmp_path, sides, monkeypatch):
    monkeypatch.setattr(module, "LOOK_EVERY", 0.0)
    left = sides(tmp_path / "left", leads=True)
    right = sides(tmp_path / "right", leads=False, upstream=left.port)
    assert wait_until(lambda: left.peers.strangers > 0, left, right)
    pair_folders(tmp_path / "left", tmp_path / "right")
    assert wait_until(lambda: bool(left.heard and right.heard), left, right)
    assert left.pairings.forget("right")
    assert wait_until(lambda: not left.peers.links, left, right)
    assert "right is not paired any more" in left.said


def test_certificate_expiring_during_show_is_reported_and_show_continues(tmp_path, sides, monkeypatch):
    """Also for a connection that begins after the expiry."""
    monkeypatch.setattr(identity_module, "VALID", datetime.timedelta(seconds=-2))
    monkeypatch.setattr(module, "LOOK_EVERY", 0.0)
    load_identity(network(tmp_path / "right"))
    monkeypatch.undo()
    monkeypatch.setattr(module, "LOOK_EVERY", 0.0)
    pair_folders(tmp_path / "left", tmp_path / "right")
    left = sides(tmp_path / "left", leads=True)
    right = sides(tmp_path / "right", leads=False, upstream=left.port)
    assert wait_until(lambda: bool(left.heard and right.heard), left, right)
    assert wait_until(lambda: bool(left.said and right.said), left, right)
    assert left.said[0].startswith("the certificate of right expired on ")
    assert "the show goes on" in left.said[0]
    assert (left.peers.expired, right.peers.expired) == ("right", "this machine")
    assert left.peers.links


def test_claim_is_valid_once_for_one_receiver_and_connection(tmp_path):
    (left, lefts), (right, _) = machine(tmp_path / "left"), machine(tmp_path / "right")
    term, challenge = Term(2, "right-1"), bytes(32)
    line = signed_claim(right, left.as_peer(), challenge, 1, Claim(term))
    claim = parse_message(read_line(line))
    assert isinstance(claim, SignedClaim)
    sender = right.as_peer()
    assert verified(claim, sender, left, challenge, 0) == Claim(term)
    assert verified(claim, sender, left, challenge, 1) is None  # said once more
    assert verified(claim, sender, left, bytes(31) + b"\1", 0) is None  # on another connection
    assert verified(claim, sender, right, challenge, 0) is None  # to another machine
    assert verified(claim, left.as_peer(), left, challenge, 0) is None  # by another one
    other = SignedClaim(Term(99, "right-1"), 1, claim.signature)
    assert verified(other, sender, left, challenge, 0) is None  # another epoch
    assert not lefts.read()


def test_broken_handshakes_are_dropped_before_authentication(tmp_path, sides):
    """150 broken first messages of TLS: each is dropped, and the next machine connects."""
    import random

    pair_folders(tmp_path / "left", tmp_path / "right")
    left = sides(tmp_path / "left", leads=True)
    hello = client_hello(*machine(tmp_path / "right"))
    chance = random.Random(7)
    for _ in range(150):
        data = bytearray(hello)
        for _ in range(chance.randrange(1, 12)):
            data[chance.randrange(len(data))] = chance.randrange(256)
        with socket.create_connection(("127.0.0.1", left.port)) as stranger:
            with contextlib.suppress(OSError):
                stranger.sendall(bytes(data[: chance.randrange(1, len(data) + 1)]))
            left.turn()
    assert wait_until(lambda: left.peers.strangers >= 150, left, seconds=30)
    assert left.heard == []
    right = sides(tmp_path / "right", leads=False, upstream=left.port)
    assert wait_until(lambda: bool(left.heard and right.heard), left, right)


def client_hello(identity: object, pairings: object) -> bytes:
    """The first bytes of a paired machine."""
    mine, theirs = socket.socketpair()
    with theirs, TrustStore(identity, pairings).wrap(mine, server=False) as secure:  # type: ignore[arg-type]
        with contextlib.suppress(ssl.SSLWantReadError):
            secure.do_handshake()
        return theirs.recv(1 << 16)
