"""Pairing over real sockets: the right phrase pairs, a wrong phrase or an intercepting machine fails."""

import asyncio
import hashlib
import secrets
import ssl
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.control.tls import tls13
from live.supervisor.network.identity import Peer
from live.supervisor.network.pairing import PairingServer, Transcript, new_phrase, normalized_phrase, pair_with
from tests.supervisor.made_machines import machine

PHRASE = "lusab-babad-gutih"


async def run_pairing_server(
    folder: Path, then: Callable[[int], Awaitable[None]], phrase: str = PHRASE, within: float = 120.0
) -> tuple[Peer | PersonError, PairingServer]:
    """The result of a machine showing a phrase while `then` uses its port."""
    opened: asyncio.Future[int] = asyncio.get_running_loop().create_future()
    identity, pairings = machine(folder)
    one = PairingServer(identity, pairings, phrase, name="left", on_listening=opened.set_result)
    run = asyncio.create_task(one.run("127.0.0.1", 0, timeout=within))
    try:
        await then(await opened)
        return await run, one
    except PersonError as error:
        run.cancel()
        if run.done() and not run.cancelled() and run.exception() is not None:
            return run.exception(), one  # type: ignore[return-value]
        return error, one


def test_phrase_pairs_two_machines_and_exchanges_certificates(tmp_path: Path):
    mine, my_pairings = machine(tmp_path / "right")

    async def typed(port: int) -> None:
        peer = await pair_with(mine, my_pairings, "127.0.0.1", port, "LUSAB babad  gutih", name="right")
        assert peer.name == "left"

    found, one = asyncio.run(run_pairing_server(tmp_path / "left", typed))
    theirs, their_pairings = machine(tmp_path / "left")
    assert isinstance(found, Peer)
    assert (found.name, found.certificate) == ("right", mine.certificate)
    assert [peer.certificate for peer in my_pairings.read()] == [theirs.certificate]
    assert [peer.certificate for peer in their_pairings.read()] == [mine.certificate]
    assert one.wrong_phrases == 0


def test_three_wrong_phrases_end_pairing_without_result(tmp_path: Path):
    mine, my_pairings = machine(tmp_path / "right")

    async def guesses(port: int) -> None:
        for _ in range(3):
            with pytest.raises(PersonError, match="the phrase is wrong, or the connection is intercepted"):
                await pair_with(mine, my_pairings, "127.0.0.1", port, "babad-babad-babad", name="right")

    found, one = asyncio.run(run_pairing_server(tmp_path / "left", guesses))
    assert isinstance(found, PersonError)
    assert "3 wrong phrases" in found.message
    assert one.wrong_phrases == 3
    assert my_pairings.read() == machine(tmp_path / "left")[1].read() == []


def test_relaying_machine_in_the_middle_pairs_no_machine(tmp_path: Path):
    """It has neither machine's key: its own certificate is in the channel, and the proofs are for another one."""
    mine, my_pairings = machine(tmp_path / "right")
    between, _ = machine(tmp_path / "between")

    async def typed(port: int) -> None:
        async def relay(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            context = tls13(ssl.PROTOCOL_TLS_CLIENT)
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
            there, back = await asyncio.open_connection("127.0.0.1", port, ssl=context)
            writer.write(await there.readline())
            back.write(await reader.readline())
            writer.write(await there.readline())
            for each in (writer, back):
                each.close()

        context = tls13(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(between.path)
        server = await asyncio.start_server(relay, "127.0.0.1", 0, ssl=context)
        async with server:
            with pytest.raises(PersonError, match="the connection is intercepted"):
                await pair_with(
                    mine, my_pairings, "127.0.0.1", server.sockets[0].getsockname()[1], PHRASE, name="right"
                )
        raise PersonError("enough")

    _, one = asyncio.run(run_pairing_server(tmp_path / "left", typed))
    assert my_pairings.read() == machine(tmp_path / "left")[1].read() == []
    assert (one.wrong_phrases, one.invalid_attempts) == (0, 1)  # the signature is of another channel


def test_machine_without_proof_of_its_phrase_is_not_paired(tmp_path: Path):
    """A machine that pretends to show a phrase and reports the typed one as right."""
    mine, my_pairings = machine(tmp_path / "right")
    other, _ = machine(tmp_path / "other")

    async def run() -> None:
        async def pretend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(b'{"pair":1,"name":"left","nonce":"%s"}\n' % secrets.token_hex(32).encode())
            await reader.readline()
            writer.write(b'{"proof":"%s"}\n' % secrets.token_hex(32).encode())
            await writer.drain()
            writer.close()

        context = tls13(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(other.path)
        server = await asyncio.start_server(pretend, "127.0.0.1", 0, ssl=context)
        async with server:
            with pytest.raises(PersonError, match="does not know its own phrase"):
                await pair_with(mine, my_pairings, "127.0.0.1", server.sockets[0].getsockname()[1], PHRASE)

    asyncio.run(run())
    assert my_pairings.read() == []


def test_invalid_messages_are_counted_and_use_no_attempt(tmp_path: Path):
    mine, my_pairings = machine(tmp_path / "right")
    lines = (
        b"\n", b"[]\n", b"{}\n", b"\xff\xfe\n", b"[" * 8000 + b"\n", b"x" * 20000 + b"\n", b"",
        b'{"name":"x","certificate":"00","nonce":"%s","proof":"%s","signature":"%s"}\n'
        % (b"00" * 32, b"00" * 32, b"00" * 64),
    )  # fmt: skip

    async def typed(port: int) -> None:
        context = tls13(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        for line in lines:
            reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
            await reader.readline()
            writer.write(line)
            if not line:
                writer.close()
            assert await reader.read() == b""
            writer.close()
        _, plain = await asyncio.open_connection("127.0.0.1", port)  # no TLS at all
        plain.write(b"GET / HTTP/1.1\r\n\r\n")
        plain.close()
        await pair_with(mine, my_pairings, "127.0.0.1", port, PHRASE, name="right")

    found, one = asyncio.run(run_pairing_server(tmp_path / "left", typed))
    assert isinstance(found, Peer)
    assert (one.wrong_phrases, one.invalid_attempts) == (0, len(lines))


def test_untyped_phrase_expires(tmp_path: Path):
    async def nobody(port: int) -> None:
        pass

    found, _ = asyncio.run(run_pairing_server(tmp_path / "left", nobody, within=0.01))
    assert isinstance(found, PersonError)
    assert "the phrase was not typed in time" in found.message


def test_missing_peer_is_reported(tmp_path: Path):
    mine, my_pairings = machine(tmp_path / "right")
    with pytest.raises(PersonError, match="no machine waits for pairing"):
        asyncio.run(pair_with(mine, my_pairings, "127.0.0.1", 1, PHRASE))


def test_phrases_are_pronounceable_and_have_48_bits():
    phrases = {new_phrase() for _ in range(200)}
    assert len(phrases) == 200
    for phrase in phrases:
        assert [len(word) for word in phrase.split("-")] == [5, 5, 5]
        assert normalized_phrase(phrase.upper().replace("-", "  ")) == phrase.replace("-", "")


def test_proof_covers_all_exchanged_fields(tmp_path: Path):
    """Any field that differs at one end produces another proof."""
    parts = (b"server", b"client", "left", "right", b"nonce one", b"nonce two")
    digests = {Transcript(*parts).digest()}
    for place, part in enumerate(parts):
        other = [*parts]
        other[place] = part[:-1]
        digests.add(Transcript(*other).digest())
    digests.add(Transcript(b"serverc", b"lient", *parts[2:]).digest())
    assert len(digests) == len(parts) + 2
    assert all(len(digest) == hashlib.sha256().digest_size for digest in digests)
