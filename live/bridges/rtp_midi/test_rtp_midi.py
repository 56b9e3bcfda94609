"""Tests of MIDI over RTP: sessions as Apple's systems start them, payloads of RFC 6295, and malformed packets."""

import random
import socket
import struct

import pytest

from live.app.bridges import installed_bridges
from live.base.fault_isolation import FAULTS
from live.bridges.rtp_midi.rtp_midi import MAX_SESSIONS, SESSION_TIMEOUT, BadPacket, RtpMidi, RtpPort, midi_bytes
from live.control.midi.midi_ports import UnknownPort, find_port, open_port
from live.control.midi.midi_system import MidiUnavailable
from tests.control.midi.test_threads_go_on import FirstCallFailure
from tests.control.waiting import wait_for

MAC = ("192.168.1.7", 50_000)
SSRC, TOKEN = 0xF51EAE12, 0x58A5EF79


def exchange(what: bytes, token: int = TOKEN, source: int = SSRC) -> bytes:
    return b"\xff\xff" + what + struct.pack(">III", 2, token, source) + b"mbp\0"


def packet(number: int, payload: bytes, source: int = SSRC) -> bytes:
    return struct.pack(">BBHII", 0x80, 0x61, number, 12345, source) + payload


def session() -> RtpMidi:
    rtp = RtpMidi(0x01020304, "us")
    for control in (True, False):
        answers, _ = rtp.handle(exchange(b"IN"), MAC, 0.0, control=control)
        assert answers == [bytes.fromhex("ffff4f4b 00000002 58a5ef79 01020304") + b"us\0"]
    assert rtp.participants == ("mbp",)
    return rtp


def receive_messages(rtp: RtpMidi, datagram: bytes, now: float = 1.0) -> list[bytes]:
    return rtp.handle(datagram, MAC, now, control=False)[1]


def encode_time(units: int) -> bytes:
    """A delta time in 7 bits per byte, the highest first."""
    found = [units & 127]
    while units := units >> 7:
        found.insert(0, 128 | units & 127)
    return bytes(found)


def encode_payload(messages: list[bytes], rng: random.Random, *, running: bool) -> bytes:
    """A payload by RFC 6295, 3.2 and figures 2 to 4: with or without times, running status, long or short header."""
    body, last, timed = b"", 0, rng.random() < 0.5
    for index, message in enumerate(messages):
        if index or timed:
            body += encode_time(rng.choice((0, 1, 127, 128, 20_000, 2_000_000, 200_000_000)))
        skips = running and message[0] == last and rng.random() < 0.7
        body += message[1:] if skips else message
        last = message[0] if message[0] < 0xF0 else last if message[0] >= 0xF8 else 0
    flags = 0x20 * timed | 0x40 * (rng.random() < 0.3)
    if len(body) > 15 or rng.random() < 0.2:
        return bytes((0x80 | flags | len(body) >> 8, len(body) & 255)) + body
    return bytes((flags | len(body),)) + body


def test_session_starts_answers_clock_sync_and_ends() -> None:
    rtp = session()
    asked = b"\xff\xffCK" + struct.pack(">IB3xQQQ", SSRC, 0, 777, 0, 0)
    ((answer,), _) = rtp.handle(asked, MAC, 2.5, control=False)
    assert answer == b"\xff\xffCK" + struct.pack(">IB3xQQQ", 0x01020304, 1, 777, 25_000, 0)
    assert len(answer) == len(asked)
    assert rtp.handle(b"\xff\xffCK" + struct.pack(">IB3xQQQ", SSRC, 2, 777, 25_000, 900), MAC, 2.6, control=False) == (
        [],
        [],
    )
    assert rtp.rejected == 0
    rtp.handle(exchange(b"BY", source=1), MAC, 3.0, control=True)
    rtp.handle(exchange(b"BY"), ("192.168.1.8", 50_000), 3.0, control=True)
    assert (rtp.participants, rtp.rejected) == (("mbp",), 2)
    assert rtp.handle(exchange(b"BY", token=0), MAC, 3.0, control=True) == ([], [])  # as macOS says it
    assert receive_messages(rtp, packet(1, b"\x03\x90\x3c\x40")) == []


def test_recovery_journal_is_ignored() -> None:
    """One note, and a recovery journal of one channel with its chapter of notes."""
    rtp = session()
    payload = bytes.fromhex("43 90 3e 5b") + bytes.fromhex("20 00 01 00 00 08 81 f1 be 5b")
    assert receive_messages(rtp, packet(7, payload)) == [b"\x90\x3e\x5b"]


def test_payloads_decode_to_the_encoded_messages() -> None:
    rng = random.Random(3)
    pool = [
        b"\x90\x3c\x40", b"\x90\x3e\x41", b"\x80\x3c\x00", b"\xb3\x07\x11", b"\xb3\x08\x12", b"\xc0\x05", b"\xd1\x06",
        b"\xe0\x00\x40", b"\xf8", b"\xfa", b"\xf2\x01\x02", b"\xf1\x05", b"\xf6", b"\xf0\x7f\x01\x02\xf7",
    ]  # fmt: skip
    rtp = session()
    for number in range(600):
        messages = [rng.choice(pool) for _ in range(rng.randrange(12))]
        assert receive_messages(rtp, packet(number, encode_payload(messages, rng, running=number % 2 == 0))) == messages
    assert (rtp.rejected, rtp.lost) == (0, 0)


def test_segmented_exclusive_message_is_joined_or_cancelled() -> None:
    rtp = session()
    assert receive_messages(rtp, packet(1, b"\x04\xf0\x01\x02\xf0")) == []
    assert receive_messages(rtp, packet(2, b"\x05\xf8\x00\xf7\x03\xf0")) == [b"\xf8"]
    assert receive_messages(rtp, packet(3, b"\x03\xf7\x04\xf7")) == [b"\xf0\x01\x02\x03\x04\xf7"]
    assert receive_messages(rtp, packet(4, b"\x03\xf0\x01\xf0")) == []
    assert receive_messages(rtp, packet(5, b"\x03\xf7\x02\xf4")) == []
    assert receive_messages(rtp, packet(6, b"\x03\x90\x3c\x40")) == [b"\x90\x3c\x40"]


def test_lost_packets_end_notes_and_late_packets_are_ignored() -> None:
    rtp = session()
    note = b"\x03\x90\x3c\x40"
    assert len(receive_messages(rtp, packet(0xFFFF, note))) == 1
    assert len(receive_messages(rtp, packet(0, note))) == 1
    found = receive_messages(rtp, packet(3, note))
    assert found == [*(bytes((0xB0 | channel, 123, 0)) for channel in range(16)), b"\x90\x3c\x40"]
    assert rtp.lost == 2
    assert receive_messages(rtp, packet(3, note)) == receive_messages(rtp, packet(1, note)) == []
    assert rtp.rejected == 2


def test_unknown_or_excess_senders_are_refused_and_silent_expire() -> None:
    rtp = session()
    assert rtp.handle(packet(1, b"\x01\xf8"), ("192.168.1.8", 50_000), 1.0, control=False) == ([], [])
    assert rtp.handle(packet(1, b"\x01\xf8"), (MAC[0], 50_001), 1.0, control=False) == ([], [])
    assert rtp.handle(packet(1, b"\x01\xf8", source=5), MAC, 1.0, control=False) == ([], [])
    assert rtp.handle(packet(1, b"\x01\xf8"), MAC, 1.0, control=True) == ([], [])
    refused, _ = rtp.handle(exchange(b"IN", source=9), MAC, 1.0, control=False)  # not on the port of control before
    assert refused[0][2:4] == b"NO"
    answers = [rtp.handle(exchange(b"IN", source=n), MAC, 1.0, control=True)[0][0][2:4] for n in range(MAX_SESSIONS)]
    assert answers == [b"OK"] * (MAX_SESSIONS - 1) + [b"NO"]
    assert rtp.rejected == 6
    rtp.handle(b"", MAC, 2.0 + SESSION_TIMEOUT, control=True)
    assert rtp.participants == ()
    assert rtp.handle(exchange(b"IN", source=99), MAC, 3.0 + SESSION_TIMEOUT, control=True)[0][0][2:4] == b"OK"


@pytest.mark.parametrize("payload", ["", "80", "03903c", "02903c", "013c", "0490", "03f00102", "23ffffffff7f", "61ff"])
def test_broken_payloads_raise_bad_packet(payload: str) -> None:
    with pytest.raises(BadPacket):
        midi_bytes(bytes.fromhex(payload))


def test_mutated_datagrams_are_counted_as_rejected() -> None:
    rng, rtp = random.Random(4), session()
    good = [exchange(b"IN"), exchange(b"BY"), packet(1, b"\x83\x05\x90\x3c\x40\x00\x3d\x41"), packet(2, b"\x01\xf8")]
    good.append(b"\xff\xffCK" + struct.pack(">IB3xQQQ", SSRC, 0, 777, 0, 0))
    for _ in range(4000):
        data = bytearray(rng.choice(good)) if rng.random() < 0.8 else bytearray(rng.randbytes(rng.randrange(40)))
        for _ in range(rng.randrange(4)):
            if data:
                data[rng.randrange(len(data))] = rng.randrange(256)
        datagram = bytes(data[: rng.randrange(len(data) + 1)]) if rng.random() < 0.3 else bytes(data)
        answers, messages = rtp.handle(datagram, MAC, 1.0, control=rng.random() < 0.3)
        assert len(answers) <= 1
        assert all(message[0] >= 0x80 for message in messages)
    assert rtp.rejected > 500
    assert len(rtp._sessions) <= MAX_SESSIONS


def test_session_runs_over_sockets() -> None:
    for _ in range(20):  # two ports side by side that are free
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            number = probe.getsockname()[1]
        try:
            port = open_port("input", f"rtp:127.0.0.1:{number}", installed_bridges().midi_schemes())
            break
        except OSError:
            continue
    assert isinstance(port, RtpPort)
    found: list[bytes] = []
    port.listen(lambda message: found.append(bytes(message)))
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as data,
    ):
        for sock, to in ((control, number), (data, number + 1)):
            sock.settimeout(20.0)
            sock.sendto(exchange(b"IN"), ("127.0.0.1", to))
            assert sock.recv(100)[2:4] == b"OK"
        data.sendto(packet(1, b"\x06\x90\x3c\x40\x00\x3e\x41"), ("127.0.0.1", number + 1))
        assert wait_for(lambda: found == [b"\x90\x3c\x40", b"\x90\x3e\x41"], 5.0)
    port.close()
    assert not port.exists
    with pytest.raises(ValueError, match="is for input only"):
        open_port("output", f"rtp:127.0.0.1:{number}", installed_bridges().midi_schemes())


def test_thread_survives_exception(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1] & ~1
    before = FAULTS.total
    port = RtpPort("input", f"rtp:127.0.0.1:{number}")
    handle = FirstCallFailure(port.protocol.handle)
    monkeypatch.setattr(port.protocol, "handle", handle)
    port.listen(lambda message: None)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.sendto(b"\xff\xff nonsense", ("127.0.0.1", number))
        assert wait_for(lambda: FAULTS.total == before + 1, 5.0)
        out.sendto(b"\xff\xff nonsense", ("127.0.0.1", number))
        assert wait_for(lambda: handle.calls == 2, 5.0)
    assert port.exists
    port.close()


def test_name_is_unknown_without_this_bridge() -> None:
    name = "rtp:127.0.0.1:5004"
    assert find_port("input", name, installed_bridges().midi_schemes()) == name
    with pytest.raises((UnknownPort, MidiUnavailable)):
        find_port("input", name)
