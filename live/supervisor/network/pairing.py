"""Pairing of two machines: they exchange certificates once, confirmed by a phrase that a person types.

The channel is TLS 1.3 to the machine that shows the phrase. Its certificate is not known yet, so an attacker may be in
between. Therefore each side proves that it knows the phrase by an HMAC over everything that must be the same at both
ends: the server's certificate as the *channel* has it (the binding `tls-server-end-point` of RFC 5929; an attacker has
another one, without the server's key), the client's certificate, names and fresh nonces of both. This is the scheme of
SCRAM (RFC 5802). The client proves first, so a false client has one guess per attempt, and MAX_WRONG_PHRASES of them. A
false server gets one proof to guess at offline: the phrase has 48 bits and is stretched by scrypt (RFC 7914, 32 MiB and
some hundredths of a second per guess), so 2^47 guesses are needed within the minutes in which the phrase is valid. It
is never used again. A PAKE would need no such bound, but no maintained library has one, and our own would be the
greater risk.

The phrase consists of proquints (D. S. Wilkerson, "A Proposal for Proquints", arXiv:0901.4016): five pronounceable
letters for 16 bits each.
"""

import asyncio
import contextlib
import hashlib
import hmac
import json
import secrets
import socket
import ssl
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from cryptography.hazmat.primitives.kdf.scrypt import Scrypt

from live.base.errors import PersonError
from live.control.tls import tls13
from live.supervisor.network.identity import Identity, Pairings, Peer, safe_name

PORT: Final = 9021
PHRASE_LIFETIME: Final = 300.0
"""Seconds for which a phrase is valid."""
ANSWERS_WITHIN: Final = 15.0
"""Seconds that one attempt may take."""
HANDSHAKE_WITHIN: Final = 5.0
MAX_WRONG_PHRASES: Final = 3
"""Wrong attempts after which a phrase is no longer valid."""
AT_ONCE: Final = 8
"""Most attempts at the same time; further connections are refused."""
MAX_LINE_BYTES: Final = 8192
"""Most bytes of a line."""
QUINTS: Final = 3
_CONSONANTS: Final = "bdfghjklmnprstvz"
_VOWELS: Final = "aiou"
CONTEXT: Final = b"choreographics-live pairing 1"


def new_phrase() -> str:
    """Return a new phrase: 48 bits as three pronounceable words."""
    return "-".join(_quint(secrets.randbits(16)) for _ in range(QUINTS))


def _quint(bits: int) -> str:
    c, v = _CONSONANTS, _VOWELS
    return c[bits >> 12] + v[bits >> 10 & 3] + c[bits >> 6 & 15] + v[bits >> 4 & 3] + c[bits & 15]


def normalized_phrase(typed: str) -> str:
    """Return the lower-case letters of a typed phrase; nothing else counts."""
    return "".join(mark for mark in typed.lower() if mark.isalpha())


@dataclass(frozen=True, slots=True)
class Transcript:
    """Values that must be the same at both ends."""

    server: bytes
    """Certificates, DER."""
    client: bytes
    server_name: str
    client_name: str
    server_nonce: bytes
    client_nonce: bytes

    def digest(self) -> bytes:
        """Return a hash over all parts; each part is hashed first, so that the boundaries count."""
        parts = (
            CONTEXT, self.server, self.client, self.server_name.encode(), self.client_name.encode(), self.server_nonce,
            self.client_nonce,
        )  # fmt: skip
        return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).digest()

    def proofs(self, phrase: str) -> tuple[bytes, bytes]:
        """Return the proofs of client and server that they know the phrase. Takes some hundredths of a second."""
        digest = self.digest()
        key = Scrypt(salt=digest, length=32, n=1 << 15, r=8, p=1).derive(normalized_phrase(phrase).encode())
        return tuple(hmac.digest(key, side + digest, "sha256") for side in (b"client", b"server"))  # type: ignore[return-value]


class ProtocolError(Exception):
    """A received message violates the protocol."""


@dataclass
class PairingServer:
    """The side that shows the phrase. `run` returns the paired machine; PersonError if there is none."""

    identity: Identity
    pairings: Pairings
    phrase: str
    name: str = field(default_factory=socket.gethostname)
    on_listening: Callable[[int], None] = lambda port: None
    """Called with the port once it is open."""
    wrong_phrases: int = 0
    """Wrong phrases so far."""
    invalid_attempts: int = 0
    """Connections that did not follow the protocol."""

    async def run(self, host: str | None, port: int, *, timeout: float = PHRASE_LIFETIME) -> Peer:
        """Wait for the other machine on the addresses of `host` (None: all addresses of this machine)."""
        self._paired: asyncio.Future[Peer] = asyncio.get_running_loop().create_future()
        self._now, self._scrypt = 0, asyncio.Lock()
        context = tls13(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(self.identity.path)
        try:
            server = await asyncio.start_server(
                self._attempt, host, port, ssl=context, ssl_handshake_timeout=HANDSHAKE_WITHIN,
                ssl_shutdown_timeout=1.0, limit=MAX_LINE_BYTES, backlog=AT_ONCE,
            )  # fmt: skip
        except OSError as error:
            raise PersonError(f"cannot listen at port {port}: {error.strerror}", "choose another port") from None
        self.on_listening(server.sockets[0].getsockname()[1])
        try:
            return await asyncio.wait_for(self._paired, timeout)
        except TimeoutError:
            raise PersonError("no machine was paired: the phrase was not typed in time", "live pair") from None
        finally:
            server.close()

    async def _attempt(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._now >= AT_ONCE:
            writer.transport.abort()
            return
        self._now += 1
        try:
            async with asyncio.timeout(ANSWERS_WITHIN):
                await self._serve(reader, writer)
        except (ProtocolError, TimeoutError, OSError):
            self.invalid_attempts += 1
        except PersonError as error:
            if not self._paired.done():
                self._paired.set_exception(error)
        finally:
            self._now -= 1
            writer.close()
            with contextlib.suppress(OSError, TimeoutError):
                await writer.wait_closed()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonce = secrets.token_bytes(32)
        await _send(writer, pair=1, name=self.name, nonce=nonce.hex())
        told = await _receive(reader)
        certificate, theirs = _bytes(told, "certificate"), _bytes(told, "nonce", 32)
        proof, signature = _bytes(told, "proof", 32), _bytes(told, "signature", 64)
        name = told.get("name")
        if not isinstance(name, str) or len(name) > 255 or self._paired.done():
            raise ProtocolError
        peer = Peer(safe_name(name), certificate)
        transcript = Transcript(self.identity.certificate, certificate, self.name, name, nonce, theirs)
        if not _signed(peer, signature, transcript.digest()):
            raise ProtocolError
        async with self._scrypt:
            if self.wrong_phrases >= MAX_WRONG_PHRASES or self._paired.done():
                raise ProtocolError
            client, server = await asyncio.to_thread(transcript.proofs, self.phrase)
            if not hmac.compare_digest(client, proof):
                self.wrong_phrases += 1
                await _send(writer, wrong=MAX_WRONG_PHRASES - self.wrong_phrases)
                if self.wrong_phrases >= MAX_WRONG_PHRASES:
                    raise PersonError(
                        f"{MAX_WRONG_PHRASES} wrong phrases: this one is no longer valid", "live pair shows another one"
                    )
                return
            if certificate == self.identity.certificate:
                raise PersonError("that is this machine itself: processes of one user on one machine need no pairing")
            kept = self.pairings.add(peer.name, certificate)
            await _send(writer, proof=server.hex())
            if not self._paired.done():
                self._paired.set_result(kept)


async def pair_with(
    identity: Identity, pairings: Pairings, host: str, port: int, phrase: str, *, name: str | None = None
) -> Peer:
    """The side where the phrase is typed; return the paired machine. PersonError if pairing fails."""
    name = name or socket.gethostname()
    context = tls13(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE  # the phrase authenticates the server
    try:
        async with asyncio.timeout(2 * ANSWERS_WITHIN):
            reader, writer = await asyncio.open_connection(
                host, port, ssl=context, ssl_handshake_timeout=HANDSHAKE_WITHIN, limit=MAX_LINE_BYTES
            )
            try:
                return await _exchange(identity, pairings, phrase, name, reader, writer)
            finally:
                writer.close()
                with contextlib.suppress(OSError, TimeoutError):
                    await writer.wait_closed()
    except (OSError, TimeoutError) as error:
        why = getattr(error, "strerror", None) or "no answer"
        raise PersonError(f"no machine waits for pairing at {host}:{port}: {why}", "live pair there") from None
    except ProtocolError:
        raise PersonError(
            f"the machine at {host}:{port} does not wait for pairing, or the connection is intercepted"
        ) from None


async def _exchange(
    identity: Identity, pairings: Pairings, phrase: str, name: str, reader: asyncio.StreamReader,
    writer: asyncio.StreamWriter,
) -> Peer:  # fmt: skip
    told = await _receive(reader)
    theirs, there = _bytes(told, "nonce", 32), told.get("name")
    secure = writer.get_extra_info("ssl_object")
    certificate = None if secure is None else secure.getpeercert(binary_form=True)
    if told.get("pair") != 1 or not isinstance(there, str) or len(there) > 255 or certificate is None:
        raise ProtocolError
    nonce = secrets.token_bytes(32)
    transcript = Transcript(certificate, identity.certificate, there, name, theirs, nonce)
    client, server = await asyncio.to_thread(transcript.proofs, phrase)
    await _send(
        writer, name=name, certificate=identity.certificate.hex(), nonce=nonce.hex(), proof=client.hex(),
        signature=identity.sign(transcript.digest()).hex(),
    )  # fmt: skip
    answer = await _receive(reader)
    if "wrong" in answer:
        raise PersonError(
            "the phrase is wrong, or the connection is intercepted; nothing was paired",
            "look at the other machine, and type its phrase once more",
        )
    if not hmac.compare_digest(server, _bytes(answer, "proof", 32)):
        raise PersonError(
            "the other machine does not know its own phrase: the connection is intercepted; nothing was paired"
        )
    try:
        return pairings.add(there, certificate)
    except ValueError:
        raise ProtocolError from None


def _signed(peer: Peer, signature: bytes, data: bytes) -> bool:
    try:
        return peer.verify(signature, data)
    except ValueError:  # not a certificate
        return False


async def _send(writer: asyncio.StreamWriter, **values: Any) -> None:
    writer.write(json.dumps(values, separators=(",", ":")).encode() + b"\n")
    await writer.drain()


async def _receive(reader: asyncio.StreamReader) -> dict[str, Any]:
    try:
        told = json.loads(await reader.readline())
    except (ValueError, RecursionError):  # too long, no JSON, or nested too deeply
        raise ProtocolError from None
    if not isinstance(told, dict):
        raise ProtocolError
    return told


def _bytes(message: dict[str, Any], key: str, length: int | None = None) -> bytes:
    try:
        found = bytes.fromhex(message[key])
    except (KeyError, TypeError, ValueError):
        raise ProtocolError from None
    if length is not None and len(found) != length:
        raise ProtocolError
    return found
