"""Tests of OSC output: beats, steps, feet and positions as decoded by python-osc and liblo."""

import shutil
import socket
import subprocess

import numpy as np
import pytest
from pythonosc.osc_packet import OscPacket

from live.clock.time_source import ManualClock, SystemClock
from live.clock.timeline import Timeline
from live.control.helper_process import HelperProcess
from live.control.message_codec import encode_packet
from live.control.osc.osc_codec import MAX_DATAGRAM_BYTES, bundles, encode
from live.control.osc.osc_output import MESSAGES, PREFIX, OscOutput, Targets
from tests.control.waiting import wait_for

TAGS = {PREFIX + name: tags for name, tags, _, _ in MESSAGES}


class OutputRecorder:
    """An OscOutput whose datagrams are decoded by python-osc."""

    def __init__(self, tempo=120.0, *, size=4):
        self.clock, self.datagrams = ManualClock(0.0), []
        self.out = OscOutput(self.datagrams.append, self.clock)
        self.follow(Timeline(tempo, beats_per_measure=size), number=0, end=float(size))

    def follow(self, timeline, *, number, end):
        self.out.handle(("measure", (number, end)))
        row = (timeline.tempo, timeline.beat_origin, timeline.time_origin, timeline.beats_per_measure,
               timeline.measure_origin)  # fmt: skip
        self.out.handle(("timeline", row))

    def at(self, time):
        self.clock.set(time)
        self.out.send_due()
        return self.messages()

    def messages(self):
        found = [(m.message.address, *m.message.params) for d in self.datagrams for m in OscPacket(d).messages]
        self.datagrams.clear()
        return found


def test_beats_and_measures_are_sent_when_due():
    heard = OutputRecorder(size=3)
    assert heard.at(0.4) == [(PREFIX + "tempo", 120.0)]
    assert heard.out.seconds_to_next() == pytest.approx(0.1)
    assert heard.at(0.5) == [(PREFIX + "beat", 2, 1, 120.0)]
    assert heard.at(0.9) == []
    assert heard.at(1.001) == [(PREFIX + "beat", 3, 1, 120.0)]
    assert heard.at(1.5) == [(PREFIX + "measure", 2), (PREFIX + "beat", 1, 2, 120.0)]
    heard.out.handle(("measure", (1, 6.0)))
    assert heard.at(2.0) == [(PREFIX + "beat", 2, 2, 120.0)]
    assert heard.at(3.6) == [(PREFIX + "beat", 2, 3, 120.0)]  # it was away: the beats that are over are not told
    assert list(heard.out.late) == pytest.approx([0.0, 0.001, 0.0, 0.0, 0.1])


def test_tempo_change_is_sent_and_moves_beats():
    heard = OutputRecorder()
    heard.at(0.0)
    heard.follow(Timeline(60.0, 1.0, 0.5), number=0, end=4.0)
    assert heard.at(0.5) == [(PREFIX + "tempo", 60.0), (PREFIX + "beat", 2, 1, 60.0)]
    assert heard.at(1.4) == []
    assert heard.at(1.5) == [(PREFIX + "beat", 3, 1, 60.0)]
    for step in range(100):  # it swings in: that is not told in every tick, and a hair not at all
        heard.follow(Timeline(60.0 + step / 100, 3.0, 1.5), number=0, end=4.0)
        heard.clock.set(1.5 + step / 100)
        heard.out.send_due()
    told = [message for message in heard.messages() if message[0] == PREFIX + "tempo"]
    assert 8 <= len(told) <= 10


def test_hundred_dancers_fit_datagrams_with_documented_types():
    heard = OutputRecorder()
    heard.at(0.0)
    rows = np.array([(d + 1, d / 10, -d / 10, 0.5) for d in range(100)], np.float32)
    heard.out.handle(("positions", rows.tobytes()))
    heard.out.handle(("news", [("step", (1, "glide", "ember")), ("foot", (2, "left", 0.5, 1.5, 0.25, 2))]))
    assert all(len(datagram) <= MAX_DATAGRAM_BYTES for datagram in heard.datagrams)
    assert len(heard.datagrams) < 12
    for datagram in heard.datagrams:
        for packed in OscPacket(datagram).messages:
            raw = packed.message.dgram
            tags = raw[raw.index(b",") + 1 :].split(b"\0")[0].decode()
            assert tags == TAGS[packed.message.address]
    found = heard.messages()
    assert [message[1] for message in found if message[0] == PREFIX + "position"] == list(range(1, 101))
    assert found[-2:] == [(PREFIX + "step", 1, "glide", "ember"), (PREFIX + "foot", 2, "left", 0.5, 1.5, 0.25, 2)]


def test_bundles_contain_every_message_once_in_order():
    messages = [encode("/a", (number,)) for number in range(300)]
    read = [m.message.params[0] for d in bundles(messages) for m in OscPacket(d).messages]
    assert read == list(range(300))
    assert list(bundles(messages[:1])) == messages[:1]


def test_unreachable_target_does_not_affect_other_targets():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as there:
        there.bind(("127.0.0.1", 0))
        there.settimeout(5.0)
        targets = Targets([("127.0.0.1", 9), there.getsockname()])
        for number in range(5):
            targets.send(bytes([number]))
            assert there.recv(10) == bytes([number])
        targets.close()
    with pytest.raises(socket.gaierror):
        Targets([("no such host.invalid", 1)])


@pytest.mark.liblo
@pytest.mark.skipif(shutil.which("oscdump") is None, reason="liblo's oscdump is not installed (Debian: liblo-tools)")
def test_killed_output_process_is_restarted():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    dump = subprocess.Popen([shutil.which("oscdump"), "-L", str(port)], stdout=subprocess.PIPE, text=True)
    clock, told = SystemClock(), []
    row = ("timeline", (300.0, 0.0, 0.0, 4, 0.0))
    helper = HelperProcess(
        "live.control.osc.osc_output", clock, {"targets": (("127.0.0.1", port),)}, lambda: told.append(row)
    )
    try:
        helper.start()
        helper.send(row)
        line = next(line for line in dump.stdout if "/dance/out/beat iif" in line)
        assert line.split()[-1].startswith("300")
        helper._process.kill()
        helper._started_at -= 10.0  # long ago
        assert wait_for(lambda: helper.frame() or (helper.restarts == 1 and len(told) == 2), 10.0)
        assert wait_for(lambda: helper._starting is None or helper.frame() or helper._starting is None, 10.0)
        helper.send(row)
        for _ in range(3):
            assert "/dance/out/" in next(iter(dump.stdout))
        helper._process.send_signal(19)  # it stands still: nobody waits for it
        while helper.send(("news", [("step", (1, "x" * 1000, "y"))])):
            pass
        assert helper.dropped == 1
        assert len(encode_packet(helper.status())) < 1000
        helper._process.send_signal(18)
    finally:
        helper.stop()
        dump.terminate()
        dump.wait()
        dump.stdout.close()
