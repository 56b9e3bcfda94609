"""MidiClockOut: the show's beat as MIDI clock on a port: 24 pulses a beat, start, stop, continue, song position.

A thread of its own sleeps until shortly before each pulse and then watches the clock. The Timeline is handed over by
one assignment, so the show never waits; pulses are placed by absolute times, so nothing adds up.
"""

import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Final

from live.clock.midi_clock import STOP
from live.clock.pulse_schedule import PulseSchedule
from live.clock.source import Clock
from live.clock.timeline import Timeline
from live.control.midi_ports import open_output
from live.control.midi_streams import Port
from live.control.urgency import hurry

NEAR: Final = 0.0015
"""Seconds before a pulse at which sleeping ends ..."""

NEAR_POLITE: Final = 0.0001
"""... and where others come first: whoever watches the clock there has used his share up when it counts."""

NAP: Final = 0.010
"""Longest sleep [s]: a Timeline handed over meanwhile counts."""

RETRY: Final = 2.0
GOODBYE: Final = 0.05
"""Seconds that the last message gets to leave before the port is closed."""

TAKES: Final = 0.005
"""Looking whether the port is still there is done only where so many seconds are free."""

SWITCH_INTERVAL: Final = 0.0005
"""Seconds after which Python lets this thread in while another one works; 5 ms, its own, would be heard."""


class MidiClockOut:
    """Sends what a PulseSchedule says. Thread: `follow` from the show, the rest from the one that made it."""

    def __init__(self, name: str, clock: Clock, *, open_by_name: Callable[[str], Port] = open_output) -> None:
        """Nothing is opened yet; a port that is not there is waited for."""
        self.name = name
        self.connected = ""
        self.problem = ""
        self.failed = 0
        """Pulses that could not be placed ..."""
        self.failure = ""
        """... and why, in words."""
        self.sent = 0
        """Pulses sent."""
        self.late: deque[float] = deque(maxlen=2048)
        """How late the last pulses were sent [s]."""
        self._clock = clock
        self._open_by_name = open_by_name
        self._schedule = PulseSchedule()
        self._timeline: Timeline | None = None
        self._port: Port | None = None
        self._looked = -RETRY
        self._near = NEAR
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._switch_interval = sys.getswitchinterval()

    def follow(self, timeline: Timeline) -> None:
        """From now on pulses fall as this Timeline says."""
        self._timeline = timeline

    def start(self) -> None:
        """Begin to send."""
        self._switch_interval = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_INTERVAL, self._switch_interval))
        self._stop.clear()
        self._thread = threading.Thread(target=self._run, name=f"midi clock out {self.name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Send a stop and end."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None
            sys.setswitchinterval(self._switch_interval)

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        late = sorted(self.late)
        return {
            "port": self.connected or self.name,
            "problem": self.problem,
            "pulses": self.sent,
            "failed": self.failed,
            "failure": self.failure,
            "late_p99_ms": round(1e3 * late[int(0.99 * (len(late) - 1))], 3) if late else None,
        }

    def _run(self) -> None:
        self._near = NEAR if hurry() else NEAR_POLITE
        try:
            while not self._stop.is_set():
                try:
                    self._step()
                except Exception as error:  # a pulse that cannot be placed is left out, the next ones come
                    self.failed += 1
                    self.failure = f"{type(error).__name__}: {error}"
                    self._schedule = PulseSchedule()
                    self._stop.wait(NAP)
        finally:
            if self._port is not None:
                self._send((bytes((STOP,)),))
                time.sleep(GOODBYE)
            self._close()

    def _step(self) -> None:
        """Sleep on, or send what is due."""
        now, timeline = self._clock.now(), self._timeline
        if self._port is None or timeline is None:
            self._care(now)
            self._stop.wait(NAP)
            return
        due = self._schedule.due(timeline, now)
        left = due.time - now
        if left > TAKES and now - self._looked >= RETRY:
            self._care(now)
            return
        if left > self._near:
            time.sleep(min(left - self._near, NAP))
            return
        while (now := self._clock.now()) < due.time:
            time.sleep(0.0)
        if self._send(due.messages):
            self.late.append(now - due.time)
            self.sent += 1
        self._schedule.sent(timeline)

    def _send(self, messages: tuple[bytes, ...]) -> bool:
        port = self._port
        if port is None:
            return False
        try:
            for message in messages:
                port.send(message)
        except Exception as error:  # the port has gone
            self.problem = " ".join(str(error).split())
            self._close()
            return False
        return True

    def _care(self, now: float) -> None:
        """See that the port is open; whatever goes wrong, there is another time."""
        if now - self._looked < RETRY:
            return
        self._looked = now
        try:
            if self._port is not None and not self._port.there:
                self.problem = "the port is gone"
                self._close()
            elif self._port is None:
                self._port = self._open_by_name(self.name)
                self.connected, self.problem = self._port.name, ""
                self._schedule.relocate()
        except Exception as error:
            self.problem = " ".join(str(error).split())
            self._close()

    def _close(self) -> None:
        port, self._port, self.connected = self._port, None, ""
        if port is not None:
            port.close()
