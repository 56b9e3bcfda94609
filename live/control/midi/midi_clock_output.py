"""MidiClockOut: the show's beat as MIDI clock on a port: 24 pulses a beat, start, stop, continue, song position.

A thread of its own sleeps until shortly before each pulse and then watches the clock. The Timeline is handed over by
one assignment, so the show never waits; pulses are placed by absolute times, so nothing adds up.
"""

import sys
import time
from collections import deque
from typing import Any, Final

from live.clock.midi.midi_clock import STOP
from live.clock.midi.pulse_schedule import PulseSchedule
from live.clock.time_source import Clock
from live.clock.timeline import Timeline
from live.control.midi import midi_ports
from live.control.midi.midi_ports import Open, PortThread, open_output, words_of
from live.control.midi.midi_streams import Port
from live.control.realtime_priority import hurry

NEAR: Final = 0.0015
"""Seconds before a pulse at which sleeping ends ..."""

NEAR_POLITE: Final = 0.0001
"""... and where others come first: whoever watches the clock there has used his share up when it counts."""

NAP: Final = 0.010
"""Longest sleep [s]: a Timeline handed over meanwhile counts."""

GOODBYE: Final = 0.05
"""Seconds that the last message gets to leave before the port is closed."""

TAKES: Final = 0.005
"""Looking whether the port is still there is done only where so many seconds are free."""

SWITCH_INTERVAL: Final = 0.0005
"""Seconds after which Python lets this thread in while another one works; 5 ms, its own, would be heard."""


class MidiClockOut(PortThread):
    """Sends what a PulseSchedule says. Thread: `follow` from the show, the rest from the one that made it."""

    def __init__(self, name: str, clock: Clock, *, open_by_name: Open = open_output) -> None:
        """Nothing is opened yet; a port that is not there is waited for."""
        super().__init__(name, "midi clock out", open_by_name)
        self.failed = 0
        """Pulses that could not be placed ..."""
        self.failure = ""
        """... and why, in words."""
        self.sent = 0
        """Pulses sent."""
        self.late: deque[float] = deque(maxlen=2048)
        """How late the last pulses were sent [s]."""
        self._clock = clock
        self._schedule = PulseSchedule()
        self._timeline: Timeline | None = None
        self._looked = -midi_ports.RETRY
        self._near = NEAR
        self._switch_interval = sys.getswitchinterval()

    def follow(self, timeline: Timeline) -> None:
        """From now on pulses fall as this Timeline says."""
        self._timeline = timeline

    def start(self) -> None:
        """Begin to send."""
        self._switch_interval = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_INTERVAL, self._switch_interval))
        super().start()

    def stop(self) -> None:
        """Send a stop and end."""
        began = self._thread is not None
        super().stop()
        if began:
            sys.setswitchinterval(self._switch_interval)

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        late = sorted(self.late)
        return super().facts() | {
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
            self._look(now)
            self._stop.wait(NAP)
            return
        due = self._schedule.due(timeline, now)
        left = due.time - now
        if left > TAKES and now - self._looked >= midi_ports.RETRY:
            self._look(now)
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
            self._lose(words_of(error))
            return False
        return True

    def _look(self, now: float) -> None:
        """See that the port is open, if it is time to."""
        if now - self._looked >= midi_ports.RETRY:
            self._looked = now
            self._care()

    def _care(self) -> None:
        """As always, but a port that has gone is tried again the next time."""
        try:
            if self._port is None:
                self._open()
            elif not self._port.there:
                self._lose("the port is gone")
        except Exception as error:
            self._lose(words_of(error))

    def _begin(self, port: Port) -> None:
        self._schedule.relocate()
