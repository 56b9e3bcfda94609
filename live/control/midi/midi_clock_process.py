"""MIDI clock output in a separate process, so that the show's interpreter never delays a pulse.

The show writes its Timelines to a non-blocking pipe; both processes read the same monotonic clock. Status figures come
back as one JSON line per second. The process ends with its standard input.
"""

import contextlib
import gc
import json
import os
import signal
import struct
import subprocess
import sys
import threading
import time
from functools import partial
from typing import Any, Final

from live.base.fault_isolation import keep_running, run_once
from live.clock.time_source import Clock, SystemClock
from live.clock.timeline import Timeline
from live.control.midi.midi_clock_output import MidiClockOutput

TIMELINE: Final = struct.Struct("=ddddd")
"""tempo, beat_origin, time_origin, beats_per_measure, measure_origin."""

STATUS_INTERVAL: Final = 1.0
RESTART_AFTER: Final = 2.0


class MidiClockProcess:
    """The show's end. Call `set_timeline` from the show's thread, `start` and `stop` from the creating thread."""

    def __init__(self, name: str, clock: Clock) -> None:
        """Start nothing yet; a missing port is opened as soon as it appears."""
        self.name = name
        self._clock = clock
        self._process: subprocess.Popen[bytes] | None = None
        self._last_sent: Timeline | None = None
        self._started_at = 0.0
        self._facts: dict[str, Any] = {"port": name, "problem": "", "pulses": 0, "late_p99_ms": None}

    @property
    def problem(self) -> str:
        """Why nothing is sent; empty if all is well."""
        return str(self._facts["problem"])

    def status(self) -> dict[str, Any]:
        """Return figures for the status line, up to a second old."""
        return self._facts

    def start(self) -> None:
        """Start the process."""
        origin = time.perf_counter() - self._clock.now()
        command = [sys.executable, "-m", "live.control.midi.midi_clock_process", self.name, repr(origin)]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C ends the show, which then ends this process
        )
        assert self._process.stdin is not None
        os.set_blocking(self._process.stdin.fileno(), False)
        self._last_sent = None
        self._started_at = self._clock.now()
        reading = partial(run_once, "the reader of the MIDI clock's figures", partial(self._read, self._process))
        threading.Thread(target=reading, name="midi clock out", daemon=True).start()

    def set_timeline(self, timeline: Timeline) -> None:
        """Send pulses by this Timeline from now on; a process that has ended is restarted."""
        process = self._process
        if process is None or timeline is self._last_sent:
            return
        if process.poll() is not None:
            self._facts = {**self._facts, "problem": self.problem or "the sender ended unexpectedly"}
            if self._clock.now() - self._started_at > RESTART_AFTER:
                self._started_at = self._clock.now()
                self._restart(process)
            return
        assert process.stdin is not None
        values = (timeline.tempo, timeline.beat_origin, timeline.time_origin, timeline.beats_per_measure)
        with contextlib.suppress(OSError):  # pipe full or process just ended: the next Timeline replaces this one
            os.write(process.stdin.fileno(), TIMELINE.pack(*values, timeline.measure_origin))
            self._last_sent = timeline

    def _restart(self, ended: "subprocess.Popen[bytes]") -> None:
        """Restart a process that has ended; if the system has no resources for it, `set_timeline` tries again later."""
        self._close(ended)
        try:
            self.start()
        except OSError as error:
            self._facts = {**self._facts, "problem": f"the sender cannot be started: {error.strerror or error}"}

    def stop(self) -> None:
        """Stop the clock and the process."""
        process, self._process = self._process, None
        if process is not None:
            self._close(process)

    def _close(self, process: "subprocess.Popen[bytes]") -> None:
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.close()
        try:
            process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _read(self, process: "subprocess.Popen[bytes]") -> None:
        assert process.stdout is not None
        with process.stdout as lines:
            for line in lines:
                with contextlib.suppress(ValueError):
                    self._facts = json.loads(line)


def main(name: str, origin: float) -> None:
    """Run the process: send until the standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.disable()  # there are no reference cycles here, and a collection would delay pulses
    sends = MidiClockOutput(name, SystemClock(origin))
    sends.start()
    ended = threading.Event()

    def tell() -> None:
        keep_running("the MIDI clock's figures", say, ended.wait)

    def say() -> None:
        while not ended.wait(STATUS_INTERVAL):
            with contextlib.suppress(OSError):  # the show is gone
                print(json.dumps(sends.status()), flush=True)

    threading.Thread(target=tell, daemon=True).start()
    try:
        while len(block := sys.stdin.buffer.read(TIMELINE.size)) == TIMELINE.size:
            tempo, beat, begin, beats_per_measure, measure = TIMELINE.unpack(block)
            with contextlib.suppress(ValueError):
                sends.set_timeline(Timeline(tempo, beat, begin, int(beats_per_measure), measure))
    finally:
        ended.set()
        sends.stop()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
