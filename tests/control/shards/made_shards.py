"""Several gateways and the reducer in one process, without sockets, on a clock that a test moves."""

from types import SimpleNamespace

from live.clock.ticks import TICK
from live.control.audience.participant_state import Voices
from live.control.audience.phone_protocol import FULL_SCALE, TOUCH_DTYPE
from live.control.audience.phone_registry import Device
from live.control.audience.session_state import Rules, SessionState
from live.control.message_codec import decode_packet
from live.control.shards.reduction import Reduction
from live.control.shards.shard import ShardUplink

PLAN = {
    "secret": b"s" * 32, "first": 1, "link": "http://stage.local", "most": 400, "per_address": 400, "visible": 8,
    "network": "own wifi", "proxies": [], "by_card": False, "code_s": 30.0, "grace_s": 120.0, "joins_per_code": None,
    "bans": [],
}  # fmt: skip


class FakeTransport:
    """A phone's connection."""

    def __init__(self, on_abort=lambda: None):
        self.aborted, self._on_abort = False, on_abort

    def abort(self):
        if not self.aborted:
            self.aborted = True
            self._on_abort()


class FakeLink:
    """A gateway's end of its connection; packets wait until `Hall.deliver`."""

    def __init__(self):
        self.sent, self.closed = [], False
        self.on_packet, self.on_end = lambda packet: None, lambda: None

    def publish(self, packet, *, fleeting=False):
        self.sent.append(packet)
        return not self.closed

    def close(self):
        self.closed = True


class Hall:
    """A show with K gateways."""

    def __init__(self, shards, rules=None, **plan):
        self.time, self.rules, self.tick = 1000.0, rules or Rules(), TICK
        self.shards = []
        self.reduction = Reduction({**PLAN, **plan})
        self.reduction.update_rules(self.rules, self.time)
        self.shards = [self.join(f"shard {k}") for k in range(shards)]
        self.step(3)

    def join(self, name, capacity=8000):
        """Let a gateway in, with a session of its own."""
        uplink, link = ShardUplink(name, capacity), FakeLink()
        uplink.attach(link)
        one = SimpleNamespace(uplink=uplink, link=link, back=[], killed=False, name=name)
        one.known = self.reduction.enter(decode_packet(link.sent.pop()), "here", one.back.append, link.close, self.time)
        for packet in one.back[:1]:
            uplink.receive(packet)
        del one.back[:1]
        one.session = SessionState(uplink.plan)
        one.session.now = lambda: self.time
        uplink.use(one.session)
        uplink.start(lambda packet: self._told(one, packet), lambda: None)
        self.deliver(one)
        return one

    def _told(self, one, packet):
        one.session.heard_show_at = self.time
        if isinstance(packet, Rules):
            one.session.update_rules(packet)

    def deliver(self, one):
        """Carry what waits in both directions."""
        while one.link.sent or one.back:
            if one.link.sent:
                self.reduction.handle(one.known, one.link.sent.pop(0), self.time)
            if one.back:
                one.uplink.receive(one.back.pop(0))

    def tell(self, rules):
        self.rules = rules
        self.reduction.update_rules(rules, self.time)

    def kill(self, one):
        """A process ends without a word."""
        one.killed = True
        self.reduction.leave(one.known)

    def step(self, ticks=1):
        """Let ticks pass; returns the last report of all gateways."""
        for _ in range(ticks):
            self.time += self.tick
            for one in self.shards:
                if not one.killed:
                    one.session.tally = one.uplink.publish(one.session.report(self.time), self.time)
                    self.deliver(one)
            report = self.reduction.report(self.time)
            for one in self.shards:
                if not one.killed:
                    self.deliver(one)
        return report

    def enter(self, one, number, group, region=0, origin=None, fresh=True):
        """A phone connects to a gateway."""
        device = Device(number, 0, group if origin is None else origin)
        transport = FakeTransport()
        phone = one.session.enter(device, region, group, 1, None, transport, fresh=fresh)
        transport._on_abort = lambda: one.session.disconnect(phone)
        return phone


def touch(one, phone, mode, x, z):
    """A phone's finger is at (x, z), each as a share of the stage."""
    data = bytes((1, mode)) + b"".join(round(v * FULL_SCALE).to_bytes(2, "little") for v in (x, z))
    assert len(data) == TOUCH_DTYPE.itemsize
    assert one.session.handle_message(phone, data, one.session.now()) == b""


def single(voices: Voices, now):
    """The force that one gateway with all voices would have."""
    return voices.sketch(now).force()
