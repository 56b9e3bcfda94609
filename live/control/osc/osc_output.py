"""OSC output of the running show: beat, measure, tempo, steps, footfalls and positions.

Beats are sent when they are due by the show's Timeline, independently of frames. Run as a module, this is a separate
process (`HelperProcess`), so that sending costs the frame loop nothing.
"""

import gc
import math
import select
import socket
import sys
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from live.clock.time_source import Clock, SystemClock
from live.clock.timeline import Timeline
from live.control.helper_process import HelperChannel
from live.control.osc.osc_codec import bundles, encode

PREFIX: Final = "/dance/out/"
MESSAGES: Final = (
    ("beat", "iif", "beat measure tempo", "On each beat: beat and measure numbers from 1, tempo in bpm."),
    ("measure", "i", "measure", "On each measure line, before its beat: the number of the new measure."),
    ("tempo", "f", "tempo", "The tempo in bpm, whenever it changes."),
    ("step", "iss", "dancer step group", "A dancer begins another step."),
    (
        "foot", "isfffi", "dancer foot x z strength part",
        "A foot comes down: `left` or `right`, position [m], strength (0 to 1); part 0 ball, 1 heel, 2 whole sole.",
    ),
    (
        "unit", "sss", "partner label name",
        "A partner's response to its leader is chosen: the unit, such as `turn/2`, and the name of its recording or "
        "step, such as `turn`.",
    ),
    (
        "position", "ifff", "dancer x z heading",
        "At a fixed rate: each dancer's hip position [m] and heading [rad; 0 is towards the audience, positive "
        "towards +x].",
    ),
)  # fmt: skip
"""Address, type tags, names of the values, and when the message is sent."""

STATUS_INTERVAL: Final = 1.0
TEMPO_INTERVAL: Final = 0.1
TEMPO_TOLERANCE: Final = 5e-4
"""Relative change of tempo below which nothing is sent."""
MAX_LATENESS_BEATS: Final = 0.5
"""Lateness in beats beyond which a beat is not sent."""

Send = Callable[[bytes], None]


class OscOutput:
    """Encoder and timer of the OSC output. Use from one thread."""

    def __init__(self, send: Send, clock: Clock) -> None:
        self._send, self._clock = send, clock
        self._timeline: Timeline | None = None
        self._measure = (0, 0.0)
        self._beat = -math.inf
        self._tempo, self._tempo_at = 0.0, -math.inf
        self.beats = 0
        """Number of beats sent."""
        self.late: deque[float] = deque(maxlen=512)
        """Lateness of the most recent beats [s]."""

    def handle(self, packet: tuple[str, Any]) -> None:
        """Handle a packet from the show: `timeline`, `measure` (number from 0, beat of its end), `news` or
        `positions` (array of rows dancer, x, z, heading)."""
        what, value = packet
        if what == "timeline":
            self._set_timeline(Timeline(*value))
        elif what == "measure":
            self._measure = value
        elif what == "news":
            self._send_messages([encode(PREFIX + name, values) for name, values in value])
        elif what == "positions":
            rows = np.frombuffer(value, np.float32).reshape(-1, 4).tolist()
            self._send_messages([encode(f"{PREFIX}position", (int(row[0]), *row[1:])) for row in rows])

    def seconds_to_next(self) -> float:
        """Return the seconds until the next beat or the next status report."""
        if self._timeline is None:
            return STATUS_INTERVAL
        due = self._timeline.time_at(self._beat + 1.0)
        return min(max(due - self._clock.now(), 0.0), STATUS_INTERVAL)

    def send_due(self) -> None:
        """Send the beat that is due; if several are, only the last."""
        timeline = self._timeline
        if timeline is None:
            return
        now = self._clock.now()
        self._send_tempo(timeline.tempo, now)
        last = math.floor(timeline.beat_at(now) + 1e-9)
        if last <= self._beat:
            return
        self._beat = last
        late = now - timeline.time_at(last)
        if late * timeline.tempo / 60.0 > MAX_LATENESS_BEATS:
            return
        measure, beat = self._place(last, timeline.beats_per_measure)
        line = [encode(f"{PREFIX}measure", (measure,))] if beat == 1 else []
        self._send_messages([*line, encode(f"{PREFIX}beat", (beat, measure, float(timeline.tempo)))])
        self.beats += 1
        self.late.append(late)

    def _set_timeline(self, timeline: Timeline) -> None:
        first = self._timeline is None
        self._timeline = timeline
        if first:
            self._beat = math.floor(timeline.beat_at(self._clock.now()) + 1e-9)

    def _place(self, beat: float, size: int) -> tuple[int, int]:
        """Return measure and beat in it, both from 1, of a Timeline beat in the current measure or later."""
        number, end = self._measure
        over = round(beat - end)
        if over >= 0:
            return number + 2 + over // size, over % size + 1
        return number + 1, max(size + over, 0) + 1

    def _send_tempo(self, tempo: float, now: float) -> None:
        if abs(tempo - self._tempo) > TEMPO_TOLERANCE * tempo and now - self._tempo_at >= TEMPO_INTERVAL:
            self._tempo, self._tempo_at = tempo, now
            self._send_messages([encode(f"{PREFIX}tempo", (float(tempo),))])

    def _send_messages(self, messages: Sequence[bytes]) -> None:
        for datagram in bundles(messages):
            self._send(datagram)


class Targets:
    """The destinations of the output. Use from one thread."""

    def __init__(self, targets: Sequence[tuple[str, int]]) -> None:
        """Raise OSError for an unknown host."""
        self._all = []
        for host, port in targets:
            family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
            sock = socket.socket(family, kind, protocol)
            sock.setblocking(False)
            self._all.append((sock, address))
        self.sent = self.failed = 0

    def close(self) -> None:
        """Close the sockets."""
        for sock, _ in self._all:
            sock.close()

    def send(self, datagram: bytes) -> None:
        """Send to every target; a failure is counted and does not affect the others."""
        for sock, address in self._all:
            try:
                sock.sendto(datagram, address)
                self.sent += 1
            except OSError:
                self.failed += 1


def main() -> None:
    """Send until the show closes the channel."""
    told = HelperChannel(sys.argv[1])
    gc.disable()
    targets = Targets(told.plan["targets"])
    clock = SystemClock(told.plan["origin"])
    out = OscOutput(targets.send, clock)
    say_at = clock.now() + STATUS_INTERVAL
    while not told.closed:
        select.select([told.socket], [], [], out.seconds_to_next())
        out.send_due()
        for packet in told.packets():
            out.handle(packet)
        if clock.now() >= say_at:
            say_at = clock.now() + STATUS_INTERVAL
            gc.collect(0)
            late = sorted(out.late)
            p99 = round(1e3 * late[int(0.99 * (len(late) - 1))], 3) if late else None
            told.send_facts(
                {"datagrams": targets.sent, "failed": targets.failed, "beats": out.beats, "late_p99_ms": p99}
            )


if __name__ == "__main__":
    main()
