"""MidiClockProcess: MidiClockOut in a process of its own, so that the show's Python never delays a pulse.

The show hands its Timelines over through a pipe that is never waited for; both processes read the same monotonic
clock. Figures come back as a JSON line a second. The process ends when its standard input does.
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
from live.control.midi.midi_clock_output import MidiClockOut

TIMELINE: Final = struct.Struct("=ddddd")
"""tempo, beat_origin, time_origin, beats_per_measure, measure_origin."""

FIGURES_EVERY: Final = 1.0
RESTART_AFTER: Final = 2.0


class MidiClockProcess:
    """The show's side. Thread: `follow` from the show; `start` and `stop` from the one that made it."""

    def __init__(self, name: str, clock: Clock) -> None:
        """Nothing is started yet; a port that is not there is waited for."""
        self.name = name
        self._clock = clock
        self._process: subprocess.Popen[bytes] | None = None
        self._told: Timeline | None = None
        self._started_at = 0.0
        self._facts: dict[str, Any] = {"port": name, "problem": "", "pulses": 0, "late_p99_ms": None}

    @property
    def problem(self) -> str:
        """Why nothing is sent; empty while it is."""
        return str(self._facts["problem"])

    def facts(self) -> dict[str, Any]:
        """For the status line; a second old."""
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
            start_new_session=True,  # Ctrl-C ends the show, and the show this
        )
        assert self._process.stdin is not None  # asked for above
        os.set_blocking(self._process.stdin.fileno(), False)
        self._told = None
        self._started_at = self._clock.now()
        reading = partial(run_once, "the reader of the MIDI clock's figures", partial(self._read, self._process))
        threading.Thread(target=reading, name="midi clock out", daemon=True).start()

    def follow(self, timeline: Timeline) -> None:
        """From now on pulses fall as this Timeline says; a process that has ended is started again."""
        process = self._process
        if process is None or timeline is self._told:
            return
        if process.poll() is not None:
            self._facts = {**self._facts, "problem": self.problem or "the sender ended unexpectedly"}
            if self._clock.now() - self._started_at > RESTART_AFTER:
                self._started_at = self._clock.now()
                self._start_again(process)
            return
        assert process.stdin is not None
        values = (timeline.tempo, timeline.beat_origin, timeline.time_origin, timeline.beats_per_measure)
        with contextlib.suppress(OSError):  # full, or just ended: the next one counts
            os.write(process.stdin.fileno(), TIMELINE.pack(*values, timeline.measure_origin))
            self._told = timeline

    def _start_again(self, ended: "subprocess.Popen[bytes]") -> None:
        """In place of the process that has ended; a system that has no room for one now is asked again later."""
        self._close(ended)
        try:
            self.start()
        except OSError as error:
            self._facts = {**self._facts, "problem": f"the sender cannot be started: {error.strerror or error}"}

    def stop(self) -> None:
        """End the song and the process."""
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
    """The process' side: send until the standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.disable()  # nothing here refers to itself, and a search for what does would be late pulses
    sends = MidiClockOut(name, SystemClock(origin))
    sends.start()
    ended = threading.Event()

    def tell() -> None:
        keep_running("the MIDI clock's figures", say, ended.wait)

    def say() -> None:
        while not ended.wait(FIGURES_EVERY):
            with contextlib.suppress(OSError):  # the show has gone
                print(json.dumps(sends.facts()), flush=True)

    threading.Thread(target=tell, daemon=True).start()
    try:
        while len(block := sys.stdin.buffer.read(TIMELINE.size)) == TIMELINE.size:
            tempo, beat, begin, beats_per_measure, measure = TIMELINE.unpack(block)
            with contextlib.suppress(ValueError):
                sends.follow(Timeline(tempo, beat, begin, int(beats_per_measure), measure))
    finally:
        ended.set()
        sends.stop()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
