import shutil
import socket
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from pythonosc.osc_bundle_builder import OscBundleBuilder
from pythonosc.osc_message import OscMessage
from pythonosc.osc_message_builder import OscMessageBuilder
from pythonosc.udp_client import SimpleUDPClient

from live.base.inbox import Inbox
from live.clock.source import ManualClock
from live.control import events
from live.control.osc import CannotListen, OscInput, PortBusy
from live.control.registry import REGISTRY
from live.control.rejections import Reason

DEADLINE_S = 20.0


def wait_until(condition):
    """Wait for something that another thread does; fails after a deadline, never sleeps longer than needed."""
    limit = time.monotonic() + DEADLINE_S
    pause = threading.Event()
    while not condition():
        assert time.monotonic() < limit, "nothing happened before the deadline"
        pause.wait(0.002)


def message(address, *values):
    builder = OscMessageBuilder(address)
    for value in values:
        builder.add_arg(value)
    return builder.build()


class Stage:
    """An OSC input on a free port with a socket to send from."""

    def __init__(self, **options):
        self.inbox, self.clock = Inbox(options.pop("capacity", 4096)), ManualClock(7.25)
        self.osc = OscInput("127.0.0.1", 0, self.inbox, self.clock, **options)
        self.sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sender.settimeout(DEADLINE_S)
        self.sent = 0

    def __enter__(self):
        self.osc.start()
        return self

    def __exit__(self, *_):
        self.osc.stop()
        self.sender.close()

    def send(self, *packets):
        """Send the packets, and wait until each was dealt with (or given up by the system)."""
        for packet in packets:
            self.sender.sendto(packet, ("127.0.0.1", self.osc.port))
            self.sent += 1
        wait_until(lambda: self.osc.received + self.osc.lost >= self.sent)

    def events(self):
        return self.inbox.drain()


@pytest.fixture
def stage():
    with Stage() as running:
        yield running


STAMP = {"time": 7.25, "source": "osc"}
TAP = message("/dance/clock/tap").dgram
PING = message("/dance/ping").dgram


def test_controls_arrive_stamped_in_order(stage):
    stage.send(message("/dance/attract", 1.5, -2.0).dgram, message("/dance/step", "samba", 8).dgram, TAP)
    assert stage.events() == [
        events.Attract(x=1.5, z=-2.0, **STAMP),
        events.CallStep(name="samba", measures=8.0, **STAMP),
        events.Tap(**STAMP),
    ]
    assert (stage.osc.received, stage.osc.accepted, stage.osc.rejected.total) == (3, 3, 0)


def test_the_clock_stamps_each_arrival(stage):
    stage.send(TAP)
    stage.clock.set(9.5)
    stage.send(TAP)
    assert [event.time for event in stage.events()] == [7.25, 9.5]


def test_python_osc_as_client(stage):
    client = SimpleUDPClient("127.0.0.1", stage.osc.port)
    client.send_message("/dance/blackout", True)
    client.send_message("/dance/clock/tempo", 96)
    wait_until(lambda: stage.osc.received == 2)
    client._sock.close()
    assert stage.events() == [events.Blackout(on=True, **STAMP), events.SetTempo(tempo=96.0, **STAMP)]


def killer_packets():
    future = OscBundleBuilder(time.time() + 3600.0)
    future.add_content(message("/dance/clock/one"))
    negative = b"#bundle\0" + struct.pack(">Q", 1) + struct.pack(">i", -4) + bytes(16)
    return future.build().dgram, negative


def test_the_two_packets_that_stop_other_receivers_do_not_stop_this_one(stage):
    future, negative = killer_packets()
    stage.send(future, negative, *[TAP] * 20)
    assert stage.events() == [events.One(**STAMP)] + [events.Tap(**STAMP)] * 20
    assert stage.osc.rejected.as_dict() == {"bundle element size": 1}
    assert stage.osc.future_timetags == 1


def test_only_time_tags_ahead_of_now_count_as_future(stage):
    for tag in (1, int((time.time() - 5.0 + 2_208_988_800) * 2**32)):
        stage.send(b"#bundle\0" + struct.pack(">Qi", tag, len(TAP)) + TAP)
    assert stage.osc.future_timetags == 0
    assert len(stage.events()) == 2


def test_a_time_tag_of_the_next_ntp_era_lies_ahead(stage):
    after_2036 = 5 << 32  # the seconds begin again at 0 on 7 February 2036
    stage.send(b"#bundle\0" + struct.pack(">Qi", after_2036, len(TAP)) + TAP)
    assert stage.osc.future_timetags == 1
    assert stage.events() == [events.Tap(**STAMP)]


HOSTILE = [
    b"",
    b"\0",
    b"\xff" * 36,
    bytes(range(256)),
    b"x" * 9000,
    b"/" + b"\0" * 60_000,
    b"/dance/attract\0\0,ff\0" + struct.pack(">ff", float("nan"), 0.0),
    b"/dance/attract\0\0,ff\0" + struct.pack(">ff", 0.0, float("inf")),
    message("/dance/attract", 1e30, 0.0).dgram,
    b"/dance/attract\0\0,ff\0" + struct.pack(">f", 1.0) + b"\0\0",
    b"/dance/attract\0\0,ff\0" + struct.pack(">f", 1.0),
    b"/dance/attract\0\0," + b"T" * 60_000 + b"\0\0\0",
    message("/dance/*", 1.0).dgram,
    message("/nowhere").dgram,
    message("/dance/step", "x" * 65).dgram,
    message("/dance/clear", 7.0).dgram,
    message("/dance/blackout", 7).dgram,
]


def test_hostile_datagrams_are_counted_one_by_one_and_the_show_goes_on(stage):
    stage.send(*HOSTILE)
    assert stage.events() == []
    assert stage.osc.received == len(HOSTILE) == stage.osc.rejected.total
    assert stage.osc.rejected.as_dict() == {
        "packet empty or too large": 4,
        "length not a multiple of 4": 2,
        "wildcard in address": 1,
        "string too long or without end": 1,
        "padding not zero": 1,
        "value cut off": 1,
        "not a finite number": 2,
        "unknown address": 1,
        "extra argument": 1,
        "out of range": 2,
        "unusable name": 1,
    }
    assert stage.osc.last_rejection.reason == Reason.OUT_OF_RANGE
    stage.send(TAP)
    assert stage.events() == [events.Tap(**STAMP)]


def test_a_bad_value_in_a_bundle_spoils_that_message_only(stage):
    bundle = OscBundleBuilder(0)
    for content in (message("/dance/spread"), message("/dance/attract", 1e30, 0.0), message("/dance/clear")):
        bundle.add_content(content)
    stage.send(bundle.build().dgram)
    assert stage.events() == [events.Spread(**STAMP), events.Clear(**STAMP)]
    assert (stage.osc.accepted, stage.osc.rejected.as_dict()) == (2, {"out of range": 1})


def test_a_flood_is_counted_to_the_last_datagram(stage):
    good, bad = message("/dance/attract", 1.0, 2.0).dgram, b"\xff" * 40
    for index in range(20_000):
        stage.sender.sendto(bad if index % 4 == 3 else good, ("127.0.0.1", stage.osc.port))
    wait_until(lambda: stage.osc.received + stage.osc.lost >= 20_000)
    osc = stage.osc
    assert osc.received + osc.lost == 20_000
    assert osc.accepted + osc.rejected.total == osc.received
    assert len(stage.events()) + stage.inbox.dropped == osc.accepted
    assert osc.rejected.total <= 5_000
    assert osc.accepted <= 15_000
    stage.sent = 20_000
    stage.send(TAP)
    assert stage.events() == [events.Tap(**STAMP)]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux counts the datagrams that a socket dropped")
def test_what_the_system_dropped_is_still_known_after_the_end():
    class Slow(ManualClock):
        def now(self):
            gate.wait(DEADLINE_S)
            return super().now()

    gate = threading.Event()
    with Stage() as stage:
        stage.osc._clock = Slow()
        stage.osc._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        for _ in range(200):  # the thread stands at the gate, so that the small buffer must overflow
            stage.sender.sendto(TAP, ("127.0.0.1", stage.osc.port))
        gate.set()
        wait_until(lambda: stage.osc.received + stage.osc.lost >= 200)
        lost = stage.osc.lost
    assert stage.osc.lost == lost == 200 - stage.osc.received > 0


def test_events_beyond_the_inbox_push_out_the_oldest_and_are_counted():
    with Stage(capacity=10) as stage:
        stage.send(*[message("/dance/attract", float(x), 0.0).dgram for x in range(25)])
        assert [event.x for event in stage.events()] == list(range(15, 25))
        assert stage.inbox.dropped == 15
        assert stage.osc.accepted == 25


def test_ping_is_answered_to_its_sender_with_no_more_bytes_than_it_sent(stage):
    stage.send(PING)
    answer, sender = stage.sender.recvfrom(2048)
    assert OscMessage(answer).address == "/dance/pong"
    assert len(answer) <= len(PING)
    assert sender[1] == stage.osc.port
    assert stage.events() == []


def test_many_pings_in_one_datagram_get_one_answer(stage):
    bundle = OscBundleBuilder(0)
    for _ in range(60):
        bundle.add_content(message("/dance/ping"))
    stage.send(bundle.build().dgram)
    stage.sender.recvfrom(2048)
    stage.sender.setblocking(False)
    with pytest.raises(BlockingIOError):  # the answer to the whole datagram was sent before it was counted
        stage.sender.recvfrom(2048)
    assert stage.osc.accepted == 60


def test_only_listed_senders_are_heard():
    with Stage(allow=["192.0.2.0/24", "2001:db8::1"]) as closed, Stage(allow=["127.0.0.1/8"]) as open_stage:
        closed.send(TAP, PING)
        open_stage.send(TAP)
        assert closed.events() == []
        assert closed.osc.rejected.as_dict() == {"sender not allowed": 2}
        assert len(open_stage.events()) == 1


def test_an_error_of_our_own_is_counted_and_the_next_datagram_heard():
    class Broken:
        def call(self, address, values, time, source):
            if address == "/break":
                raise ZeroDivisionError
            return REGISTRY.call(address, values, time, source)

    with Stage(registry=Broken()) as stage:
        stage.send(message("/break").dgram, TAP)
        assert stage.events() == [events.Tap(**STAMP)]
        assert stage.osc.rejected.as_dict() == {"internal error": 1}


def test_a_busy_port_says_so_and_names_the_remedy(stage):
    second = OscInput("127.0.0.1", stage.osc.port, Inbox(), ManualClock())
    with pytest.raises(PortBusy) as caught:
        second.start()
    assert f"127.0.0.1:{stage.osc.port}" in str(caught.value)
    assert "--osc HOST:PORT" in str(caught.value)
    second.stop()


@pytest.mark.parametrize(("host", "port"), [("192.0.2.1", 0), ("127.0.0.1", 70_000), ("not a host", 9010)])
def test_an_address_that_is_not_ours_is_a_clear_error(host, port):
    with pytest.raises(CannotListen, match="--osc HOST:PORT"):
        OscInput(host, port, Inbox(), ManualClock()).start()


def test_start_and_stop_leave_no_thread_and_no_open_file():
    def open_files():
        return len(list(Path("/proc/self/fd").iterdir()))

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("counts open files through /proc, which this system does not have")
    stage = Stage()
    with stage:
        stage.send(TAP)
    threads, files = threading.active_count(), open_files()
    for _ in range(20):
        with stage.osc:
            assert stage.osc.port > 0
            assert stage.osc.buffer_bytes > 0
    stage.osc.stop()
    assert (threading.active_count(), open_files()) == (threads, files)
    assert stage.osc.accepted == 1


OSCSEND = shutil.which("oscsend")


def clock_and_sound_controls():
    """What the musician's hand and the sound's operator may say."""
    return {
        "/dance/clock/half": ([], events.ScaleTempo(factor=0.5, **STAMP)),
        "/dance/clock/double": ([], events.ScaleTempo(factor=2.0, **STAMP)),
        "/dance/clock/nudge": (["d", "-0.015"], events.Nudge(seconds=-0.015, **STAMP)),
        "/dance/clock/shift": (["f", "0.5"], events.ShiftBeats(beats=0.5, **STAMP)),
        "/dance/clock/hold": (["F"], events.HoldTempo(on=False, **STAMP)),
        "/dance/clock/metre": (["i", "3"], events.SetMetre(beats=3.0, **STAMP)),
        "/dance/clock/count_in": (["i", "2"], events.CountIn(measures=2.0, **STAMP)),
        "/dance/clock/source": (["s", "midi"], events.ChooseSource(name="midi", **STAMP)),
        "/dance/audio/restart": ([], events.RestartAudio(**STAMP)),
        "/dance/audio/device": (
            ["ss", "stage box", "5,6"],
            events.ChooseAudio(device="stage box", channels="5,6", **STAMP),
        ),
        "/dance/audio/channels": (["s", "3"], events.ChooseAudio(channels="3", **STAMP)),
        "/dance/click": (["i", "0"], events.SetClick(on=False, **STAMP)),
        **{
            f"/dance/latency/{what}": (["f", "12.5"], events.SetLatency(what=what, seconds=0.0125, **STAMP))
            for what in ("input", "output", "display", "projector")
        },
    }


def scene_controls():
    """What light desk and stage manager say."""

    def picture(parameter, *numbers, **others):
        return events.SetPicture(parameter=parameter, **dict(zip("xyz", numbers, strict=False)), **others, **STAMP)

    sent = {
        "/dance/light/level": (["f", "0.5"], picture("/dance/light/level", 0.5)),
        "/dance/light/key": (["ff", "2", "4"], picture("/dance/light/key", 2.0, measures=4.0)),
        "/dance/light/key/direction": (["fff", "0", "-1", "0"], picture("/dance/light/key/direction", 0.0, -1.0, 0.0)),
        "/dance/camera/field_of_view": (["i", "60"], picture("/dance/camera/field_of_view", 60.0)),
        "/dance/group/colour": (
            ["fffsf", "1", "0.5", "0", "tide", "2"],
            picture("/dance/group/colour", 1.0, 0.5, 0.0, group="tide", measures=2.0),
        ),
    }
    for name, value in (("rim", 2.0), ("ambient", 0.5), ("haze", 0.25), ("saturation", 0.0)):
        sent[f"/dance/light/{name}"] = (["d", str(value)], picture(f"/dance/light/{name}", value))
    for name in ("light/key/colour", "light/rim/colour", "light/ambient/colour", "light/background", "light/floor"):
        sent[f"/dance/{name}"] = (["fff", "1", "0.5", "0"], picture(f"/dance/{name}", 1.0, 0.5, 0.0))
    for name in ("eye", "target"):
        sent[f"/dance/camera/{name}"] = (["fff", "1", "2.5", "-3"], picture(f"/dance/camera/{name}", 1.0, 2.5, -3.0))
    return sent | {
        "/dance/camera": (["sf", "side", "2"], events.RecallView(name="side", measures=2.0, **STAMP)),
        "/dance/look": (["s", "dusk"], events.RecallLook(name="dusk", **STAMP)),
        "/dance/scene": (["si", "finale", "0"], events.RecallScene(name="finale", measures=0.0, **STAMP)),
        "/dance/scene/store": (["s", "mine"], events.StoreScene(name="mine", **STAMP)),
        "/dance/go": (["i", "1"], events.Go(**STAMP)),
        "/dance/cue": (["s", "12.5"], events.GiveCue(name="12.5", **STAMP)),
        "/dance/standby": (["s", "finale"], events.StandBy(name="finale", **STAMP)),
        "/dance/back": ([], events.StepBack(**STAMP)),
        "/dance/panic": ([], events.Panic(**STAMP)),
        "/dance/hold": (["T"], events.HoldShow(on=True, **STAMP)),
        "/dance/undo": ([], events.Undo(**STAMP)),
        "/dance/redo": ([], events.Redo(**STAMP)),
    }


def score_controls():
    """What moves the score, and signals."""
    return {
        "/dance/section": (
            ["ssi", "solo", "section", "3"],
            events.JumpTo(section="solo", when="section", measure=3, **STAMP),
        ),
        "/dance/advance": ([], events.Advance(when="section", **STAMP)),
        "/dance/hold/score": (["T"], events.HoldScore(on=True, **STAMP)),
        "/dance/practice": (["ii", "17", "24"], events.Practice(first=17, last=24, **STAMP)),
        "/dance/improvise": (["is", "1", "left"], events.Improvise(on=True, group="left", **STAMP)),
        "/dance/signal": (["sf", "hit", "0.5"], events.Signal(name="hit", value=0.5, **STAMP)),
    }


def group_controls():
    """What is sent to each control of elements and group motion, and the event that comes of it."""

    def element(kind, points="", **others):
        return events.PlaceElement(kind=kind, points=points, **others, **STAMP)

    at, line = ["ff", "1.5", "-2"], ["ffii", "0", "-4", "0", "4"]
    drawn = "-3 0, 0 -2.5, 3 0"
    return {
        "/dance/attract/line": (line, element("attract", "0.0 -4.0, 0.0 4.0")),
        "/dance/attract/drawn": (["s", drawn], element("attract", drawn)),
        "/dance/attract/region": (["fff", "1.5", "-2", "2"], element("attract", "1.5 -2.0", radius=2.0)),
        "/dance/voice": (at, events.Voice(x=1.5, z=-2.0, **STAMP)),
        "/dance/repel/line": (line, element("repel", "0.0 -4.0, 0.0 4.0")),
        "/dance/repel/region": (["fff", "1.5", "-2", "2"], element("repel", "1.5 -2.0", radius=2.0)),
        "/dance/cross": (
            [line[0] + "ffsT", *line[1:], "1", "8", "tide & left"],
            element("cross", "0.0 -4.0, 0.0 4.0", measures=8.0, group="tide & left", next=True),
        ),
        "/dance/flow": (line, element("flow", "0.0 -4.0, 0.0 4.0", flow="uniform")),
        "/dance/flow/radial": (["fff", "1.5", "-2", "-1"], element("flow", "1.5 -2.0", flow="radial", strength=-1.0)),
        "/dance/flow/vortex": (at, element("flow", "1.5 -2.0", flow="vortex")),
        "/dance/flow/drawn": (["s", drawn], element("flow", drawn, flow="drawn")),
        "/dance/path": (["s", drawn], element("path", drawn)),
        "/dance/wander": ([], element("wander")),
        "/dance/flock": (["ff", "2", "8"], element("flock", strength=2.0, measures=8.0)),
        "/dance/follow": (["s", "7"], element("follow", whom="7")),
        "/dance/pursue": (["s", "tide"], element("pursue", whom="tide")),
        "/dance/evade": (["s", "tide"], element("evade", whom="tide")),
        "/dance/formation": (
            ["sfs", "star:6", "2", "ember"],
            events.Evolve(formation="star:6", measures=2.0, group="ember", **STAMP),
        ),
        "/dance/formation/define": (
            ["ss", "flower", "circle poisson"],
            events.DefineFormation(name="flower", formation="circle poisson", **STAMP),
        ),
        "/dance/travel": (["s", drawn], events.Travel(points=drawn, **STAMP)),
        "/dance/pause": (["f", "2"], events.Pause(measures=2.0, **STAMP)),
        "/dance/release": ([], events.Release(**STAMP)),
        "/dance/regroup": (["ss", "1-4", "tide"], events.Regroup(dancers="1-4", group="tide", **STAMP)),
        "/dance/ripple": (
            ["fss", "2", "0 -2", "tide"],
            events.SetRipple(beats=2.0, begins="0 -2", group="tide", **STAMP),
        ),
        "/dance/enter": (["i", "3"], events.Enter(count=3.0, **STAMP)),
        "/dance/leave": (["ss", "7", "left"], events.Leave(dancers="7", gate="left", **STAMP)),
        "/dance/obstacle": (["sff", "box", "1", "2"], events.PlaceObstacle(name="box", x=1.0, z=2.0, **STAMP)),
        "/dance/wall": (["sffff", "w", "0", "1", "2", "3"], events.PlaceWall(name="w", x=0, z=1, x2=2, z2=3, **STAMP)),
        "/dance/obstacle/remove": (["s", "box"], events.RemoveObstacle(name="box", **STAMP)),
        "/dance/stage": (["ff", "8", "5.5"], events.SetStage(width=8.0, depth=5.5, **STAMP)),
        "/dance/performer": (["sff", "Ana", "1", "2"], events.Performer(name="Ana", x=1.0, z=2.0, **STAMP)),
    }


@pytest.mark.liblo
@pytest.mark.skipif(OSCSEND is None, reason="liblo's oscsend is not installed (Debian: liblo-tools)")
def test_liblos_oscsend_sends_every_control(stage):
    sent = {
        "/dance/attract": (["ff", "1.5", "-2"], events.Attract(x=1.5, z=-2.0, **STAMP)),
        "/dance/repel": (
            ["fidh", "1", "2", "0.5", "8"],
            events.Repel(x=1.0, z=2.0, strength=0.5, measures=8.0, **STAMP),
        ),
        "/dance/spread": (["f", "2"], events.Spread(measures=2.0, **STAMP)),
        "/dance/clear": ([], events.Clear(**STAMP)),
        "/dance/now": (["ssf", "jump", "tide", "2"], events.StepNow(name="jump", group="tide", measures=2.0, **STAMP)),
        "/dance/step": (["s", "side step"], events.CallStep(name="side step", **STAMP)),
        "/dance/clock/tap": ([], events.Tap(**STAMP)),
        "/dance/clock/one": (["I"], events.One(**STAMP)),
        "/dance/clock/tempo": (["d", "132.5"], events.SetTempo(tempo=132.5, **STAMP)),
        **clock_and_sound_controls(),
        "/dance/sequence": (
            ["ss", "sway, glide x2, *", "front"],
            events.SetSequence(steps="sway, glide x2, *", group="front", **STAMP),
        ),
        **{
            f"/dance/motion/{name}": (
                [kind, value],
                events.SetMotion(parameter=field, value=number, group="*", **STAMP),
            )
            for name, kind, value, field, number in (
                ("warp", "f", "0.25", "warp_beats", 0.25),
                ("warp_sequence", "i", "1", "warp_sequence", 1.0),
                ("amplitude", "f", "0.5", "amplitude", 0.5),
                ("amplitude_sequence", "F", None, "amplitude_sequence", 0.0),
                ("larger", "f", "0.25", "larger", 0.25),
                ("mix", "f", "0.5", "mix", 0.5),
                ("arms", "f", "1", "arms", 1.0),
                ("obedience", "f", "0.75", "obedience", 0.75),
                ("foot_lock", "i", "0", "lock", 0.0),
                ("turn_on_support", "T", None, "on_support", 1.0),
                ("face_average", "i", "1", "face_average", 1.0),
                ("mirror", "i", "-1", "mirror", -1.0),
            )
        },
        "/dance/motion/head": (
            ["fs", "0.75", "left"],
            events.SetMotion(parameter="head", value=0.75, group="left", **STAMP),
        ),
        "/dance/facing": (
            ["ss", "dancer 3", "left"],
            events.SetFacing(facing="dancer 3", group="left", **STAMP),
        ),
        "/dance/why": (["i", "7"], events.AskWhy(dancer=7, **STAMP)),
        "/dance/blackout": (["T"], events.Blackout(on=True, **STAMP)),
        "/dance/takeover": ([], events.TakeOver(**STAMP)),
        "/dance/ping": ([], None),
        **group_controls(),
        **scene_controls(),
        **score_controls(),
    }
    assert set(sent) == {control.address for control in REGISTRY}
    for count, (address, (arguments, event)) in enumerate(sent.items(), start=1):
        command = [OSCSEND, "127.0.0.1", str(stage.osc.port), address, *filter(None, arguments)]
        subprocess.run(command, check=True, timeout=DEADLINE_S)
        wait_until(lambda count=count: stage.osc.received == count)
        assert stage.events() == ([] if event is None else [event]), stage.osc.last_rejection
    assert stage.osc.rejected.total == 0
