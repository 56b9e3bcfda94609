"""Audio process: listens to a device or plays music for an engine.

It ends with the supervisor, or with the engine if the supervisor has died. As a separate process it detects beats
without delay while the engine's Python is busy, and music plays on when an engine ends.
"""

import contextlib
import json
import socket
import sys
from collections import deque
from pathlib import Path
from typing import Any, Final

from live.base.event_queue import EventQueue
from live.base.system.process_control import ignore_interrupts
from live.clock.bar_pointer.state_space import BarPointerModel
from live.clock.follower.manual_control import TrackerHint
from live.clock.map_clock import MapClock
from live.clock.measure_map import MeasureLine, MeasureMap
from live.clock.time_source import SystemClock
from live.control.audio.analysis import make_analysis_factory
from live.control.audio.audio_input import AudioInput
from live.control.audio.channel_mixer import Channels
from live.control.audio.music_file import Music, read_music
from live.control.audio.music_player import MusicPlayer
from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import ControlEvent
from live.supervisor.adoption.audio_adoption import AudioLink
from live.supervisor.cpu_priority import AUDIO_NICE, raise_priority
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import SupervisorLink

POLL_INTERVAL: Final = 0.2
MAX_PACKET_BYTES: Final = 1 << 16


class EventSender(EventQueue[ControlEvent]):
    """Sends each event to the engine at once, as one packet. Thread: any."""

    def __init__(self, sock: socket.socket) -> None:
        super().__init__(1)
        self._socket = sock

    def put(self, item: ControlEvent) -> None:
        """Send one event; it is lost if the socket is full."""
        self.send(event=event_to_json(item))

    def send(self, **values: Any) -> None:
        """Send other values."""
        with contextlib.suppress(OSError):
            self._socket.send(json.dumps(values).encode())


class AudioWorker:
    """Audio source that follows the engine's orders."""

    def __init__(self, sender: EventSender) -> None:
        self._sender = sender
        self._seeds: deque[TrackerHint] = deque(maxlen=64)
        self._source: AudioInput | MusicPlayer | None = None
        self._rows: list[list[Any]] = []
        self._measures: MapClock | None = None  # of the music, once it plays
        self._prepared: dict[str, Music] = {}  # by the file's path

    def handle_order(self, order: dict[str, Any]) -> None:
        """Carry out one order."""
        if "prepare" in order and self._source is None:
            self._prepare(order["prepare"])
        if "start" in order and self._source is None:
            self._start(order["start"])
        if "stop" in order:
            self.stop()
            self._source = None
        if "seed" in order:
            self._seeds.append(TrackerHint(**order["seed"]))
        if "measures" in order:
            self._take_rows(order)
        if "latency" in order:
            into, out = order["latency"]
            if isinstance(self._source, AudioInput):
                self._source.latency = into
            elif self._source is not None:
                self._source.latency = out
        if "event" in order and isinstance(self._source, AudioInput):
            self._source.handle(event_from_json(order["event"]))

    def send_status(self) -> None:
        """Report the source's state."""
        if self._source is not None:
            self._sender.send(facts=self._source.status(), level=getattr(self._source, "level", None))

    def stop(self) -> None:
        """Stop and free the device."""
        if self._source is not None:
            self._source.stop()

    def _take_rows(self, order: dict[str, Any]) -> None:
        """Take some measure lines; with the last of them the music is followed by them."""
        del self._rows[order["from"] :]
        self._rows += order["measures"]
        if len(self._rows) == order["of"] and self._measures is not None:
            self._measures.replace(MeasureMap([MeasureLine(*row) for row in self._rows]) if self._rows else None)

    def _prepare(self, path: str) -> None:
        """Decode music while the engine still builds the show."""
        with contextlib.suppress(Exception):  # the start says what is wrong
            self._prepared = {path: read_music(Path(path))}

    def _start(self, plan: dict[str, Any]) -> None:
        clock = SystemClock(plan["origin"])
        into, out = plan["latency"]
        begun = plan["begun"]
        try:
            path, prepared = plan["music"], self._prepared
            self._prepared = {}
            music = None if path is None else prepared[path] if path in prepared else read_music(Path(path))
            self._measures = None if music is None else MapClock(None, music.duration)
            model = BarPointerModel.expecting(plan["metres"], plan["likely_bpm"])
            analysis = make_analysis_factory(plan["tracker"], self._seeds, self._measures, model)
            if music is None:
                source: AudioInput | MusicPlayer = AudioInput(
                    plan["device"], self._sender, clock, channels=Channels.parse(plan["channels"]), latency=into,
                    analysis=analysis,
                )  # fmt: skip
                source.start()
            else:
                source = MusicPlayer(
                    music, self._sender, clock, output=plan["output"] or True,
                    latency=out, one_at=plan["one_at"] if begun is None else None, analysis=analysis,
                )  # fmt: skip
                begun = clock.now() if begun is None else begun
                source.start(begun=begun)
        except Exception as error:  # of the sound system: the engine reports it
            self._sender.send(refused=str(error))
            return
        self._source = source
        self._sender.send(started=clock.now() if begun is None else begun)


def main() -> None:
    """Carry out the engine's orders until supervisor and engine have ended."""
    ignore_interrupts()
    sock = socket.socket(fileno=int(sys.argv[1]))
    sock.setblocking(False)
    there = AudioLink(
        sock,
        SupervisorLink.of_arguments(*sys.argv[2:4]),
        round_s=POLL_INTERVAL,
        largest=MAX_PACKET_BYTES,
    )
    raise_priority(AUDIO_NICE)
    outbox = EventSender(sock)
    outbox.send(hello=True)
    sounding = AudioWorker(outbox)
    try:
        while not there.orphaned:
            for order in there.receive_commands():
                there.link.beat(0, Phase.STARTING)  # loading takes seconds on a busy machine
                sounding.handle_order(json.loads(order))
            sounding.send_status()
            there.link.beat(0, Phase.RUNNING)
    finally:
        sounding.stop()


if __name__ == "__main__":
    main()
