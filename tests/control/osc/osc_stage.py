"""An OSC input with a socket to send from, and messages built by python-osc."""

import socket
import threading
import time

from pythonosc.osc_message_builder import OscMessageBuilder

from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from live.control.osc.osc_server import OscInput

DEADLINE_S = 20.0


def wait_until(condition):
    """Waits for a condition that another thread sets; fails after a deadline."""
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
        self.inbox, self.clock = EventQueue(), ManualClock(7.25)
        lane = self.inbox.add_queue(options.pop("capacity", 4096))
        self.osc = OscInput("127.0.0.1", 0, lane, self.clock, **options)
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
        """Sends the packets, and waits until each was handled (or dropped by the system)."""
        for packet in packets:
            self.sender.sendto(packet, ("127.0.0.1", self.osc.port))
            self.sent += 1
        wait_until(lambda: self.osc.received + self.osc.lost >= self.sent and not self.osc._prefilter.has_pending)

    def events(self):
        return self.inbox.drain()


STAMP = {"time": 7.25, "source": "osc"}
TAP = message("/dance/clock/tap").dgram
PING = message("/dance/ping").dgram
