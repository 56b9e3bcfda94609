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
from live.control.midi.midi_ports import Open, PortThread, error_text, open_output
from live.control.midi.midi_streams import Port
from live.control.realtime_priority import request_realtime

SPIN_TIME: Final = 0.0015
"""Seconds before a pulse at which sleep ends and busy-waiting starts ..."""

SPIN_TIME_SHARED: Final = 0.0001
"""... and without real-time priority, where a longer busy-wait would use up the time slice before the pulse."""

MAX_SLEEP: Final = 0.010
"""Longest sleep [s], so that a new Timeline takes effect."""

CLOSE_DELAY: Final = 0.05
"""Seconds that the last message gets before the port is closed."""

MIN_FREE_TIME: Final = 0.005
"""The port is checked only if so many seconds are left before the next pulse."""

SWITCH_INTERVAL: Final = 0.0005
"""Thread switch interval [s]; Python's default of 5 ms would be audible jitter."""


class MidiClockOutput(PortThread):
    """Sends the pulses of a PulseSchedule. Call `set_timeline` from the show's thread, the rest from the creating
    thread."""

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
        self._checked_at = -midi_ports.RETRY_INTERVAL
        self._spin_time = SPIN_TIME
        self._switch_interval = sys.getswitchinterval()

    def set_timeline(self, timeline: Timeline) -> None:
        """Send pulses by this Timeline from now on."""
        self._timeline = timeline

    def start(self) -> None:
        """Start to send."""
        self._switch_interval = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_INTERVAL, self._switch_interval))
        super().start()

    def stop(self) -> None:
        """Send a stop message and end the thread."""
        began = self._worker.started
        super().stop()
        if began:
            sys.setswitchinterval(self._switch_interval)

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        late = sorted(self.late)
        return super().status() | {
            "pulses": self.sent,
            "failed": self.failed,
            "failure": self.failure,
            "late_p99_ms": round(1e3 * late[int(0.99 * (len(late) - 1))], 3) if late else None,
        }

    def _run(self) -> None:
        self._spin_time = SPIN_TIME if request_realtime() else SPIN_TIME_SHARED
        try:
            while not self._stop.is_set():
                try:
                    self._step()
                except Exception as error:  # skip a pulse that cannot be scheduled
                    self.failed += 1
                    self.failure = f"{type(error).__name__}: {error}"
                    self._schedule = PulseSchedule()
                    self._stop.wait(MAX_SLEEP)
        finally:
            if self._port is not None:
                self._send((bytes((STOP,)),))
                time.sleep(CLOSE_DELAY)
            self._close()

    def _step(self) -> None:
        """Sleep a little, or send the pulse that is due."""
        now, timeline = self._clock.now(), self._timeline
        if self._port is None or timeline is None:
            self._check_port(now)
            self._stop.wait(MAX_SLEEP)
            return
        due = self._schedule.next_pulse(timeline, now)
        left = due.time - now
        if left > MIN_FREE_TIME and now - self._checked_at >= midi_ports.RETRY_INTERVAL:
            self._check_port(now)
            return
        if left > self._spin_time:
            time.sleep(min(left - self._spin_time, MAX_SLEEP))
            return
        while (now := self._clock.now()) < due.time:
            time.sleep(0.0)
        if self._send(due.messages):
            self.late.append(now - due.time)
            self.sent += 1
        self._schedule.mark_sent(timeline)

    def _send(self, messages: tuple[bytes, ...]) -> bool:
        port = self._port
        if port is None:
            return False
        try:
            for message in messages:
                port.send(message)
        except Exception as error:  # the port is gone
            self._disconnect(error_text(error))
            return False
        return True

    def _check_port(self, now: float) -> None:
        """Open or check the port, at most every `RETRY` seconds."""
        if now - self._checked_at >= midi_ports.RETRY_INTERVAL:
            self._checked_at = now
            self._maintain()

    def _maintain(self) -> None:
        """As the base class, but a lost port is opened again only at the next call."""
        try:
            if self._port is None:
                self._open()
            elif not self._port.exists:
                self._disconnect("the port is gone")
        except Exception as error:
            self._disconnect(error_text(error))

    def _on_open(self, port: Port) -> None:
        self._schedule.relocate()
