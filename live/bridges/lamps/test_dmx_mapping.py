"""Tests of DMX output: channel rows by the beat, and packets of E1.31 and Art-Net 4 byte by byte."""

import socket
import struct

import numpy as np
import pytest

from live.bridges.lamps.dmx_mapping import DEFAULT_CHANNELS, LEVEL, Channel, DmxMapping, channel_count
from live.bridges.lamps.dmx_output import ArtnetSender, DmxOutput, SacnSender, Universe
from live.clock.time_source import ManualClock, SystemClock
from live.clock.timeline import Timeline
from live.control.helper_process import HelperProcess
from live.control.registry.registry import REGISTRY
from tests.control.waiting import wait_for

TIMELINE = Timeline(120.0, beats_per_measure=4)  # a beat is half a second


def make_mapping(*channels, half=(6.0, 4.0)):
    chart = DmxMapping(channels, half)
    return chart, lambda now: chart.row(TIMELINE, now).tolist()


def test_flashes_start_full_on_beat_and_fade_linearly():
    chart, row = make_mapping(
        Channel(1, "beat"), Channel(2, "measure", beats=2.0), Channel(3, "steps"), Channel(4, "tempo")
    )
    assert row(0.0)[:4] == [255, 255, 0, 120]
    assert row(0.125)[:2] == [round(255 * 0.75), round(255 * 0.875)]
    assert row(1.0)[:2] == [255, 0]
    assert row(2.0)[:2] == [255, 255], "the measure comes again after four beats"
    chart.flash("steps", 2.5, 0.5)
    assert [row(time)[2] for time in (1.24, 1.25, 1.5, 1.8)] == [0, 128, 64, 0]


def test_values_span_full_range_and_blackout_zeroes_level():
    control = REGISTRY[LEVEL].arguments[0]
    chart, row = make_mapping(Channel(1, LEVEL), Channel(10, "/dance/light/key/colour"), Channel(20, LEVEL, fine=True))
    chart.update_values({LEVEL: (("", (control.maximum,)),), "/dance/light/key/colour": (("", (1.0, 0.0, 0.5)),)})
    top = REGISTRY["/dance/light/key/colour"].arguments[0].maximum
    assert row(0.0)[0] == 255
    assert row(0.0)[9:12] == [round(255 / top), 0, round(127.5 / top)]
    chart.update_values({LEVEL: (("", (0.3,)),)})
    coarse, fine = row(0.0)[19:21]
    assert 256 * coarse + fine == round(65535 * 0.3 / control.maximum)
    chart.update_values({"/dance/blackout": (("", (True,)),)})
    assert row(0.0)[0] == 0 == row(0.0)[19]
    chart.update_values({"/dance/blackout": (("", (False,)),)})
    assert row(0.0)[0] > 0


def test_dancer_position_maps_to_whole_stage():
    chart, row = make_mapping(Channel(101, "dancer", dancer=3))
    for place, wanted in (((-6.0, -4.0), (0, 0)), ((6.0, 4.0), (65535, 65535)), ((99.0, 0.0), (65535, 32768))):
        chart.update_positions(np.array([(1, 2.0, 2.0, 0.0), (3, *place, 0.0)], np.float32))
        assert struct.unpack(">HH", bytes(row(0.0)[100:104])) == wanted


def test_only_numeric_values_have_channels():
    assert channel_count("/dance/light/key/colour") == 3
    assert [channel_count(each) for each in ("/dance/go", "/dance/clock/source", "/nobody", "", "dancers")] == [0] * 5
    taken = [
        channel.channel + n for channel in DEFAULT_CHANNELS for n in range(channel_count(channel.sends))
    ]  # the chart of who has none
    assert len(set(taken)) == len(taken)
    assert max(taken) <= 512


@pytest.fixture
def receiver():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        sock.settimeout(20.0)
        yield sock


def read_sacn(data):
    """Universe, sequence, priority, stream-terminated flag, and row of an E1.31 data packet (E1.31-2018, table 4-1)."""
    assert data[:16] == b"\x00\x10\x00\x00ASC-E1.17\x00\x00\x00"
    length, vector = struct.unpack_from(">HI", data, 16)
    assert length == 0x7000 | (len(data) - 16)
    assert vector == 4
    assert struct.unpack_from(">HI", data, 38) == (0x7000 | (len(data) - 38), 2)
    priority, _, sequence, options, universe = struct.unpack_from(">BHBBH", data, 108)
    assert struct.unpack_from(">HBBHHHB", data, 115) == (0x7000 | (len(data) - 115), 2, 0xA1, 0, 1, 513, 0)
    assert data[44:108].rstrip(b"\0").decode() == "ChoreoGraphics Live"
    return universe, sequence, priority, bool(options & 0x40), list(data[126:])


def test_sacn_packet_matches_the_standard(receiver):
    sender = SacnSender(Universe("sacn", 258, "127.0.0.1", receiver.getsockname()[1]))
    first = np.arange(512, dtype=np.uint16).astype(np.uint8)
    for row in (first, first[::-1]):
        sender.send(row)
    sender.close()
    assert read_sacn(receiver.recv(2000)) == (258, 0, 100, False, first.tolist())
    assert read_sacn(receiver.recv(2000)) == (258, 1, 100, False, first[::-1].tolist())
    assert [read_sacn(receiver.recv(2000))[3] for _ in range(3)] == [True] * 3


def test_artnet_packet_matches_the_standard(receiver):
    sender = ArtnetSender(Universe("artnet", 258, "127.0.0.1", receiver.getsockname()[1]))
    row = np.arange(512, dtype=np.uint16).astype(np.uint8)
    sender.send(row)
    data = receiver.recv(2000)
    sender.close()
    assert data[:8] == b"Art-Net\0"
    assert struct.unpack_from("<H", data, 8) == (0x5000,)
    assert struct.unpack_from(">H", data, 10)[0] == 14
    assert (data[14], data[15]) == (2, 1), "the low byte is sub-net and universe, the high one the net"
    assert struct.unpack_from(">H", data, 16) == (512,)
    assert list(data[18:]) == row.tolist()


@pytest.mark.long
def test_process_sends_rows_until_show_ends(receiver):
    universe = ("sacn", 1, "127.0.0.1", receiver.getsockname()[1])
    plan = {
        "universes": [universe],
        "channels": [(1, "tempo", 1, 1.0, False), (2, "feet", 1, 1e3, False)],
        "half": (6, 4),
    }
    helper = HelperProcess("live.bridges.lamps.dmx_output", SystemClock(), plan, lambda: None)
    helper.start()
    try:
        helper.send(("timeline", (90.0, 0.0, 0.0, 4, 0.0)))
        helper.send(("news", [("foot", (1, "left", 0.0, 0.0, 1.0, 0)), ("step", (1, "kick", "all"))]))
        rows = [read_sacn(receiver.recv(2000)) for _ in range(5)]
        assert [row[1] for row in rows] == list(range(5))
        assert rows[-1][4][0] == 90
        assert rows[-1][4][1] > 250
        assert wait_for(lambda: helper.frame() or helper.status().get("rows", 0) > 5, 10.0)
    finally:
        helper.stop()
    assert wait_for(lambda: read_sacn(receiver.recv(2000))[3], 10.0), "the stream says that it ends"


class FailingSender:
    def send(self, row):
        raise OSError("no network")

    def close(self):
        pass


def test_failing_network_is_counted_without_affecting_others():
    sent = []

    class Fine(FailingSender):
        def send(self, row):
            sent.append(row.copy())

    clock = ManualClock(1.0)
    out = DmxOutput(DmxMapping([Channel(1, "beat")], (6.0, 4.0)), [FailingSender(), Fine()])
    out.send_frame(clock.now())
    assert (out.sent, out.failed) == (0, 0), "nothing before there is a beat"
    out.handle(("timeline", (120.0, 0.0, 0.0, 4, 0.0)), clock.now())
    for _ in range(3):
        out.send_frame(clock.now())
    assert (out.sent, out.failed, len(sent)) == (3, 3, 3)
