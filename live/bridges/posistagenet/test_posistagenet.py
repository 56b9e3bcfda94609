"""Tests of PosiStageNet trackers: packets built from the specification, whole frames and malformed packets."""

import math
import random
import shutil
import socket
import struct
import subprocess
import sys

import pytest

from live.app.bridges import ServiceContext
from live.base.errors import PersonError
from live.base.event_queue import EventQueue, PriorityQueue
from live.bridges.posistagenet import PsnOptions, services
from live.bridges.posistagenet.posistagenet import MAX_PACKET_BYTES, PsnFrames, PsnInput, decode_psn
from live.bridges.posistagenet.psn_service import parse_psn
from live.clock.time_source import ManualClock
from live.control.registry.rejections import Reason, Tally
from live.show.venue.venue import Venue
from tests.control.waiting import wait_for

HERE = (1.5, 0.25, -2.0)
DATA, INFO = 0x6755, 0x6756


def chunk(identity, data, *, nested=False):
    """A chunk: header and data."""
    return struct.pack("<HH", identity, len(data) | (0x8000 if nested else 0)) + data


def header(time=1_000_000, frame=1, packets=1, version=2):
    """The header chunk of a packet: time [µs], version, frame, number of packets in the frame."""
    return chunk(0, struct.pack("<QBBBB", time, version, 3, frame, packets))


def tracker(number, place, *, validity=None, more=b""):
    """A tracker of a data packet."""
    fields = chunk(0, struct.pack("<3f", *place)) + chunk(1, struct.pack("<3f", 0.0, 0.0, 0.0))
    if validity is not None:
        fields += chunk(3, struct.pack("<f", validity))
    return chunk(number, fields + more, nested=True)


def data_packet(*trackers, **facts):
    """A data packet with the positions of trackers."""
    return chunk(DATA, header(**facts) + chunk(1, b"".join(trackers), nested=True), nested=True)


def info_packet(names, system="hall", **facts):
    """An info packet with the names of trackers by number."""
    named = b"".join(chunk(number, chunk(0, name.encode()), nested=True) for number, name in names.items())
    return chunk(INFO, header(**facts) + chunk(1, system.encode()) + chunk(2, named, nested=True), nested=True)


def decode_with_tally(data):
    tally = Tally()
    return decode_psn(data, tally), tally.as_dict()


def test_places_and_names_are_decoded_and_unknown_chunks_skipped():
    strange = chunk(9, b"whatever") + chunk(77, chunk(1, b"abc"), nested=True)
    packet, refused = decode_with_tally(
        data_packet(tracker(3, HERE, validity=1.0, more=strange), tracker(700, HERE), frame=200)
    )
    assert refused == {}
    assert packet.places == {3: HERE, 700: HERE}
    assert (packet.frame, packet.packets, packet.time) == (200, 1, 1_000_000)
    packet, refused = decode_with_tally(info_packet({3: "Anna", 4: "chariot Ω"}))
    assert (packet.names, packet.is_data, refused) == ({3: "Anna", 4: "chariot Ω"}, False, {})


def test_only_invalid_trackers_are_left_out():
    packet, refused = decode_with_tally(
        data_packet(
            tracker(1, HERE, validity=0.0), tracker(2, (math.nan, 0.0, 0.0)), tracker(3, (1e9, 0.0, 0.0)),
            tracker(4, HERE), chunk(5, b"", nested=True),
        )
    )  # fmt: skip
    assert packet.places == {4: HERE}
    assert refused == {Reason.NOT_FINITE: 1, Reason.OUT_OF_RANGE: 1}
    assert decode_with_tally(info_packet({1: "\x07bell", 2: "ok"}))[0].names == {2: "ok"}


GOOD = data_packet(tracker(1, HERE))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", Reason.PACKET_SIZE),
        (bytes(MAX_PACKET_BYTES + 1), Reason.PACKET_SIZE),
        (b"\x55", Reason.TRUNCATED),
        (GOOD[:-1], Reason.ELEMENT_SIZE),
        (GOOD + b"\0", Reason.TRAILING),
        (GOOD + GOOD, Reason.TRAILING),
        (chunk(0x1234, header(), nested=True), Reason.UNKNOWN_TYPE),
        (chunk(DATA, b"", nested=True), Reason.MISSING),
        (chunk(DATA, header()), Reason.WRONG_TYPE),
        (chunk(DATA, header() + chunk(1, tracker(1, HERE)), nested=True), Reason.WRONG_TYPE),
        (chunk(DATA, header(version=1), nested=True), Reason.UNKNOWN_TYPE),
        (chunk(DATA, chunk(0, b"short"), nested=True), Reason.WRONG_TYPE),
        (data_packet(chunk(1, chunk(0, b"1234"), nested=True)), Reason.WRONG_TYPE),
        (data_packet(chunk(1, chunk(0, struct.pack("<3f", *HERE), nested=True), nested=True)), Reason.WRONG_TYPE),
        (data_packet(chunk(1, struct.pack("<HH", 0, 0x7FFF) + bytes(12), nested=True)), Reason.ELEMENT_SIZE),
        (data_packet(chunk(1, b"\0\0", nested=True)), Reason.TRUNCATED),
        (data_packet(*[chunk(1, b"", nested=True)] * 513), Reason.TRAILING),
    ],
    ids=lambda value: str(len(value)) if isinstance(value, bytes) else None,
)
def test_malformed_chunks_cause_packet_refusal(data, reason):
    packet, refused = decode_with_tally(data)
    assert packet is None
    assert refused == {reason: 1}


def test_mutated_packets_give_finite_places_or_refusals():
    chance = random.Random(5)
    good = [data_packet(*(tracker(n, HERE, validity=1.0) for n in range(6))), info_packet({1: "Anna", 2: "Ben"})]
    tally, frames, read_well = Tally(), PsnFrames(Tally()), 0
    for _ in range(2500):
        data = bytearray(chance.choice(good))
        for _ in range(chance.choice((1, 1, 2, 6))):
            data = data or bytearray(1)
            match chance.randrange(3):
                case 0:
                    data[chance.randrange(len(data))] = chance.randrange(256)
                case 1:
                    at = chance.randrange(len(data))
                    data[at : at + 4] = chance.choice((b"\0\0\xff\x7f", b"\0\0\xff\xff", b"\0\0\xc0\x7f", b""))
                case _:
                    del data[chance.randrange(len(data)) :]
        packet = decode_psn(bytes(data), tally)
        if packet is not None:
            read_well += 1
            frames.add(packet)
            assert all(math.isfinite(value) for place in packet.places.values() for value in place)
    assert read_well > 300
    assert tally.total > 500
    assert len(frames.names) <= 128


def test_frames_are_assembled_despite_lost_packets():
    tally = Tally()
    frames = PsnFrames(tally)

    def take(number, time, **facts):
        return frames.add(decode_psn(data_packet(tracker(number, HERE), time=100_000_000 + time, **facts), tally))

    assert take(1, 1000, frame=1, packets=2) == {}
    assert set(take(2, 1000, frame=1, packets=2)) == {1, 2}
    assert take(1, 2000, frame=2, packets=2) == {}
    assert set(take(1, 3000, frame=3, packets=1)) == {1}  # half a frame comes with the next one
    assert take(5, 2000, frame=2, packets=2) == {}  # the other half comes late
    assert tally.as_dict() == {Reason.OUT_OF_RANGE: 1}
    assert set(take(5, 3000 - 20_000_000, frame=9, packets=1)) == {5}  # the server began anew
    assert frames.frames == 3


def test_changed_places_are_queued_by_tracker_name():
    lane, clock = PriorityQueue(), ManualClock()
    hearing = PsnInput("127.0.0.1", 0, "", lane, clock)
    hearing.start()
    sent = 0
    try:
        with socket.socket(type=socket.SOCK_DGRAM) as server:
            for number in range(20):
                clock.set(1.0 + number / 50.0)
                still = data_packet(tracker(1, (number / 10.0, 0.0, 2.0)), tracker(2, HERE), time=number * 20_000)
                for data in (info_packet({1: "Anna"}), still, b"rubbish"):
                    server.sendto(data, ("127.0.0.1", hearing.ports[0]))
                    sent += 1
                assert wait_for(lambda sent=sent: hearing.received == sent, 2.0)
    finally:
        hearing.stop()
    events = list(iter(lane.pop, None))
    anna = [event for event in events if event.tracker == "Anna"]
    assert [event.x for event in anna] == [round(number / 10.0, 4) for number in range(20)]
    assert 3 <= sum(event.tracker == "2" for event in events) <= 5  # it stands still
    assert hearing.status()["frames"] == 20
    assert hearing.rejected.total == 20


MULTICAST = """
import socket
from live.base.event_queue import PriorityQueue
from live.clock.time_source import SystemClock
from live.bridges.posistagenet.posistagenet import GROUP, PsnInput
from live.bridges.posistagenet.test_posistagenet import data_packet, tracker
from tests.control.waiting import wait_for
lane = PriorityQueue()
one, two = (PsnInput(GROUP, 56565, "127.0.0.1", lane, SystemClock()) for _ in range(2))
one.start(), two.start()
with socket.socket(type=socket.SOCK_DGRAM) as server:
    server.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
    server.sendto(data_packet(tracker(4, (1.0, 0.0, 2.0))), (GROUP, 56565))
assert wait_for(lambda: one.received == two.received == 1, 5.0)
one.stop(), two.stop()
event = lane.pop()
print(event.tracker, event.x, event.z)
"""


@pytest.mark.long
def test_two_shows_receive_one_multicast_group():
    """Runs in a private network namespace, so nothing is sent outside."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        pytest.skip("unshare and ip are not installed (apt install util-linux iproute2)")
    up = "ip link set lo up && ip link set lo multicast on && ip route replace 224.0.0.0/4 dev lo && exec"
    command = ["unshare", "-n", "sh", "-c", f'{up} "$0" -c "$1"', sys.executable, MULTICAST]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    if "unshare" in done.stderr or "Operation not permitted" in done.stderr:
        pytest.skip(f"no private network: {done.stderr.strip()}")
    assert done.stdout.split() == ["4", "1.0", "2.0"], done.stderr


def test_listening_addresses_are_parsed():
    assert parse_psn("236.10.10.10:56565") == ("236.10.10.10", 56565, "")
    assert parse_psn("236.10.10.10:56565@192.168.1.5") == ("236.10.10.10", 56565, "192.168.1.5")
    assert parse_psn("236.10.10.10@10.0.0.1") == ("236.10.10.10", 56565, "10.0.0.1")
    assert parse_psn("56565") == ("127.0.0.1", 56565, "")
    for text in ("", "1.2.3.4:x", "1.2.3.4:5@x", "1.2.3.4:5@300.1.1.1"):
        with pytest.raises(PersonError):
            parse_psn(text)


def test_number_of_trackers_is_bounded():
    lane, clock = PriorityQueue(), ManualClock(1.0)
    hearing = PsnInput("127.0.0.1", 0, "", lane, clock)
    for begin in range(0, 400, 50):
        data = data_packet(*(tracker(number, HERE) for number in range(begin, begin + 50)), time=begin)
        hearing.handle(data, ("10.0.0.1", 1), 56565, clock.now())
    assert len(lane) == 128
    assert hearing.rejected.as_dict() == {Reason.MANY_MESSAGES: 400 - 128}


def make_service(options, venue=None):
    """The service of these launch options."""
    context = ServiceContext(
        options=options, engine=None, venue=venue, clock=ManualClock(), add_queue=EventQueue().add_queue,
        osc=("127.0.0.1", 9010), host_names=(), resumes=False,
    )  # fmt: skip
    return services(context).get("psn")


def test_receiver_listens_on_address_of_command_line_or_venue():
    assert make_service(PsnOptions()) is None
    part = make_service(PsnOptions(), Venue.model_validate({"psn": {"at": "127.0.0.1:0"}}))
    part.start()
    part.frame()
    assert part.refused().total() == 0
    assert part.status()["received"] == 0
    part.stop()
    part.stop()


def test_busy_port_is_reported_in_one_line():
    with socket.socket(type=socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        part = make_service(PsnOptions(psn=str(taken.getsockname()[1])))
        with pytest.raises(PersonError, match=r"PosiStageNet cannot listen.*--psn"):
            part.start()
