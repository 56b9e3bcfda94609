"""Engine's side of the audio process.

Messages are whole packets in a socket that the supervisor holds too. When an engine ends, the music plays on, and
events wait in the socket for the next engine.
"""

import contextlib
import json
import os
import select
import socket
import time
from collections import deque
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from live.app.processes.resume_state import ResumeState
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.follower.manual_control import TrackerHint
from live.clock.measure_map import MeasureMap
from live.clock.time_source import SystemClock
from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import ChooseAudio, ControlEvent, RestartAudio, SetLatency, SourceChanged
from live.show.show import Show
from live.show.venue.venue import Latencies

START_TIMEOUT: Final = 30.0
"""Time limit [s] for the process to start to play or listen: it loads the tracker first."""
MAX_PACKET_BYTES: Final = 1 << 16
ROWS_PER_PACKET: Final = 500
"""Measure lines in a packet."""
LOST_TIMEOUT: Final = 1.0
"""Seconds without a message after which the source counts as lost: the process reports five times a second."""


def prepare_music(descriptor: int, path: Path) -> None:
    """Have the audio process decode music that will be played, while the show is still built.

    `descriptor`: of the engine's end of its socket. If the message is lost, the music is decoded when it starts.
    """
    with contextlib.suppress(OSError), socket.socket(fileno=os.dup(descriptor)) as there:
        there.setblocking(False)
        there.send(json.dumps({"prepare": str(path.resolve())}).encode())


class AudioClient:
    """Audio source in a separate process. Thread: the show's; call `frame` before each frame."""

    def __init__(
        self, descriptor: int, plan: dict[str, Any], show: Show, latencies: Latencies, inbox: EventQueue[ControlEvent],
        clock: SystemClock, *, resumed: ResumeState | None,
    ) -> None:  # fmt: skip
        """`plan`: settings of the source; `resumed`: the show that is resumed, if another engine began it."""
        self._socket = socket.socket(fileno=os.dup(descriptor))
        self._socket.setblocking(False)
        self._plan, self._show, self._latencies, self._inbox, self._clock = plan, show, latencies, inbox, clock
        self._running = resumed is not None and not resumed.from_other_machine
        self._wait_for_start = resumed is None
        self.start_time = None if resumed is None else resumed.audio_start
        """Start time of the audio [s of the show]."""
        self._facts: dict[str, Any] = {"state": "starting", "problem": ""}
        self._seeds: deque[dict[str, Any]] = deque(maxlen=64)
        self._rows: list[tuple[Any, ...]] = []
        self._unsent_rows: deque[dict[str, Any]] = deque()  # one packet each
        self._last_message_at = clock.now()
        self._lost = False
        self.level: float | None = None
        """RMS level of the input device; None for music."""
        if self._running:
            show.follower.on_hint = self._send_seed
        else:
            show.seed_tracker(self._send_seed)

    def start(self) -> None:
        """Start to listen or to play; raise PersonError if that fails."""
        if self._running:
            return
        self._send_start()
        if not self._wait_for_start:
            return  # a resumed show does not wait for audio
        deadline = time.monotonic() + START_TIMEOUT
        while not self._has_started():
            if time.monotonic() > deadline:
                raise PersonError(
                    f"the audio did not start within {START_TIMEOUT:g} s", "--alone runs everything in one process"
                )
            self._send_rows()
            select.select([self._socket], [], [], 0.1)
            for told in self._packets():
                if "refused" in told:
                    raise PersonError(f"audio: {told['refused']}", "see `live devices`")
                self._handle_message(told)

    def _has_started(self) -> bool:
        return self._running

    def stop(self) -> None:
        """Close the link; the supervisor ends the process with the show."""
        self._socket.close()

    def frame(self) -> None:
        """Receive messages since the last frame, and check whether the process still reports."""
        self._send_rows()
        for told in self._packets():
            self._handle_message(told)
        now = self._clock.now()
        if now - self._last_message_at > LOST_TIMEOUT and not self._lost:
            self._lost = True
            self._facts = {**self._facts, "state": "lost", "problem": "the audio process has gone"}
            self._inbox.put(SourceChanged(time=now, source="audio", state="lost", detail="its process has gone"))

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        return self._facts

    def handle(self, event: ControlEvent) -> None:
        """Pass on events that concern the audio."""
        if isinstance(event, SetLatency):
            self._send(latency=[self._latencies.input, self._latencies.output])
        if isinstance(event, RestartAudio | ChooseAudio):
            self._send(event=event_to_json(event))
        if isinstance(event, RestartAudio):  # a restart by hand discards manual settings
            self._send_seed(TrackerHint("forget", event.time))
            self._show.seed_tracker(self._send_seed)

    def set_measures(self, measures: MeasureMap | None) -> None:
        """Set the known measures of the music; None if they are not known."""
        rows: list[tuple[Any, ...]] = []
        if measures is not None:
            rows = [(one.time_s, one.measure, one.beats, one.tempo) for one in measures.lines]
        if rows != self._rows:
            self._rows = rows
            self._queue_rows()

    def _queue_rows(self) -> None:
        """Send the measures, in packets that come while the process has room for them."""
        self._unsent_rows.clear()
        starts = range(0, max(len(self._rows), 1), ROWS_PER_PACKET)
        for start in starts:
            some = self._rows[start : start + ROWS_PER_PACKET]
            self._unsent_rows.append({"measures": some, "from": start, "of": len(self._rows)})

    def _send_rows(self) -> None:
        while self._unsent_rows and self._send(**self._unsent_rows[0]):
            self._unsent_rows.popleft()

    def silence(self) -> None:
        """Order the process to stop playing and listening."""
        self._send(stop=True)

    def _handle_message(self, message: dict[str, Any]) -> None:
        self._last_message_at = self._clock.now()
        if "hello" in message:  # a new process; it ignores a second start order
            self._send_start()
        if "event" in message:
            with contextlib.suppress(ValueError):
                self._inbox.put(event_from_json(message["event"]))
        if "started" in message:
            self._running, self.start_time = True, float(message["started"])
        if "facts" in message:
            self._facts, self.level = message["facts"], message["level"]
            if self._lost:
                self._lost = False
                self._inbox.put(SourceChanged(time=self._last_message_at, source="audio", state="found"))

    def _send_start(self) -> None:
        latency = [self._latencies.input, self._latencies.output]
        self._send(start=self._plan | {"origin": self._clock.origin, "latency": latency, "begun": self.start_time})
        for seed in self._seeds:
            self._send(seed=seed)
        self._queue_rows()

    def _send_seed(self, seed: TrackerHint) -> None:
        self._seeds.append(asdict(seed))
        if self._running:
            self._send(seed=asdict(seed))

    def _send(self, **values: Any) -> bool:
        """Send values; return whether there was room for them."""
        with contextlib.suppress(OSError):  # no process now; a new one gets everything again
            self._socket.send(json.dumps(values).encode())
            return True
        return False

    def _packets(self) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = []
        while True:
            try:
                data = self._socket.recv(MAX_PACKET_BYTES)
            except OSError:
                return found
            if not data:
                return found
            found.append(json.loads(data))
