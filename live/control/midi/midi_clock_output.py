"""MIDI clock output: 24 pulses per beat, start, stop, continue and song position.

Its thread sleeps until shortly before each pulse and then busy-waits. The show sets the Timeline by one assignment and
never waits. Pulses are placed at absolute times, so errors do not accumulate.
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
"""Seconds before a pulse at which sleep ends and busy-waiting starts ..."""

NEAR_POLITE: Final = 0.0001
"""... and without real-time priority, where a longer busy-wait would use up the time slice before the pulse."""

NAP: Final = 0.010
"""Longest sleep [s], so that a new Timeline takes effect."""

GOODBYE: Final = 0.05
"""Seconds that the last message gets before the port is closed."""

TAKES: Final = 0.005
"""The port is checked only if so many seconds are left before the next pulse."""

SWITCH_INTERVAL: Final = 0.0005
"""Thread switch interval [s]; Python's default of 5 ms would be audible jitter."""


class MidiClockOut(PortThread):
    """Sends the pulses of a PulseSchedule. Call `follow` from the show's thread, the rest from the creating thread."""

    def __init__(self, name: str, clock: Clock, *, open_by_name: Open = open_output) -> None:
        """Open nothing yet; a missing port is opened as soon as it appears."""
        super().__init__(name, "midi clock out", open_by_name)
        self.failed = 0
        """Number of pulses that could not be scheduled ..."""
        self.failure = ""
        """... and the last reason."""
        self.sent = 0
        """Number of pulses sent."""
        self.late: deque[float] = deque(maxlen=2048)
        """Lateness of the most recent pulses [s]."""
        self._clock = clock
        self._schedule = PulseSchedule()
        self._timeline: Timeline | None = None
        self._looked = -midi_ports.RETRY
        self._near = NEAR
        self._switch_interval = sys.getswitchinterval()

    def follow(self, timeline: Timeline) -> None:
        """Send pulses by this Timeline from now on."""
        self._timeline = timeline

    def start(self) -> None:
        """Start to send."""
        self._switch_interval = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_INTERVAL, self._switch_interval))
        super().start()

    def stop(self) -> None:
        """Send a stop message and end the thread."""
        began = self._thread is not None
        super().stop()
        if began:
            sys.setswitchinterval(self._switch_interval)

    def facts(self) -> dict[str, Any]:
        """Return figures for the status line."""
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
                except Exception as error:  # skip a pulse that cannot be scheduled
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
        """Sleep a little, or send the pulse that is due."""
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
        except Exception as error:  # the port is gone
            self._lose(words_of(error))
            return False
        return True

    def _look(self, now: float) -> None:
        """Open or check the port, at most every `RETRY` seconds."""
        if now - self._looked >= midi_ports.RETRY:
            self._looked = now
            self._care()

    def _care(self) -> None:
        """As the base class, but a lost port is opened again only at the next call."""
        try:
            if self._port is None:
                self._open()
            elif not self._port.there:
                self._lose("the port is gone")
        except Exception as error:
            self._lose(words_of(error))

    def _begin(self, port: Port) -> None:
        self._schedule.relocate()
