"""Sender for the simulated players and band: OSC over UDP and MIDI clock, in real time."""

import heapq
import socket
from collections.abc import Callable, Iterator
from typing import Any, Final

from pythonosc.osc_message_builder import BuildError, OscMessageBuilder

from live.rehearse.simulated_band import SimulatedBand
from live.rehearse.simulated_players import Call

PULSES_PER_BEAT: Final = 24
"""MIDI clock pulses per beat."""
CLOCK, START, STOP = b"\xf8", b"\xfa", b"\xfc"
TimedPacket = tuple[float, bytes]


def packet_of(call: Call) -> bytes | None:
    """Return the OSC packet of a call; None if OSC has no type for one of its values."""
    message = OscMessageBuilder(address=call.address)
    try:
        for value in call.values:
            if value is None:
                message.add_arg(None, OscMessageBuilder.ARG_TYPE_NIL)
            else:
                message.add_arg(value)  # type: ignore[arg-type]
        return bytes(message.build().dgram)
    except (BuildError, ValueError, OverflowError, UnicodeError):
        return None


def clock_pulses(band: SimulatedBand) -> Iterator[TimedPacket]:
    """Yield the MIDI clock of a band: 24 pulses a beat, start at the first beat, stop and start around rests."""
    last = None
    for played in band.beats():
        if last is None or played.rest_before > 0.0:
            if last is not None:
                yield last, STOP
            yield played.time, START
        for number in range(PULSES_PER_BEAT):
            yield played.time + number * played.period / PULSES_PER_BEAT, CLOCK
        last = played.time + played.period


def osc_packets(calls: Iterator[Call]) -> Iterator[TimedPacket]:
    """Yield the OSC packets of calls with their send times."""
    for call in calls:
        packet = packet_of(call)
        if packet is not None:
            yield call.time, packet


class UdpSender:
    """Sends packets to one address over UDP, and counts failures."""

    def __init__(self, host: str, port: int) -> None:
        """Raises OSError if the host has no address."""
        family, _, _, _, there = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        self._address: Any = there
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self.sent, self.failed = 0, 0

    def send(self, packet: bytes) -> None:
        """Send one packet; never waits, never raises."""
        try:
            self._socket.sendto(packet, self._address)
            self.sent += 1
        except OSError:
            self.failed += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def send_all(
    streams: list[tuple[Iterator[TimedPacket], Callable[[bytes], None]]],
    *,
    now: Callable[[], float],
    wait: Callable[[float], bool],
    until: float,
) -> None:
    """Send all streams at their times until `until` [s]. `wait` sleeps for some seconds; it returns True to stop.

    A stream is a pair: packets (time, bytes) in order of time, and the function that sends one.
    """
    coming: list[tuple[float, int, bytes]] = []
    for number, (stream, _) in enumerate(streams):
        first = next(stream, None)
        if first is not None:
            heapq.heappush(coming, (first[0], number, first[1]))
    while coming and coming[0][0] < until:
        time, number, what = coming[0]
        left = time - now()
        if left > 0.0:
            if wait(min(left, 0.2)):
                return
            continue
        stream, send = streams[number]
        send(what)
        following = next(stream, None)
        if following is None:
            heapq.heappop(coming)
        else:
            heapq.heapreplace(coming, (following[0], number, following[1]))
    while now() < until:
        if wait(min(until - now(), 0.2)):
            return
