"""Audio process: listens to a device or plays music for an engine.

It ends with the supervisor, or with the engine if the supervisor has died. As a separate process it detects beats
without delay while the engine's Python is busy, and music plays on when an engine ends.
"""

import contextlib
import json
import signal
import socket
import sys
from collections import deque
from pathlib import Path
from typing import Any, Final

from live.app.session_audio import analyses
from live.base.event_queue import Inbox
from live.clock.follower.manual_control import Seed
from live.clock.time_source import SystemClock
from live.control.audio.audio_input import AudioInput
from live.control.audio.channel_mixer import Channels
from live.control.audio.music_file import read_music
from live.control.audio.music_player import MusicPlayer
from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import ControlEvent
from live.supervisor.adoption.audio_adoption import SoundLifeline
from live.supervisor.cpu_priority import AUDIO_NICE, come_forward
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import Lifeline

ROUND: Final = 0.2
LARGEST: Final = 1 << 16


class Outbox(Inbox[ControlEvent]):
    """Sends each event to the engine at once, as one packet. Thread: any."""

    def __init__(self, sock: socket.socket) -> None:
        super().__init__(1)
        self._socket = sock

    def put(self, item: ControlEvent) -> None:
        """Send one event; it is lost if the socket is full."""
        self.tell(event=event_to_json(item))

    def tell(self, **values: Any) -> None:
        """Send other values."""
        with contextlib.suppress(OSError):
            self._socket.send(json.dumps(values).encode())


class Sounding:
    """Audio source that follows the engine's orders."""

    def __init__(self, outbox: Outbox) -> None:
        self._outbox = outbox
        self._seeds: deque[Seed] = deque(maxlen=64)
        self._source: AudioInput | MusicPlayer | None = None

    def obey(self, told: dict[str, Any]) -> None:
        """Carry out one order."""
        if "start" in told and self._source is None:
            self._start(told["start"])
        if "stop" in told:
            self.stop()
            self._source = None
        if "seed" in told:
            self._seeds.append(Seed(**told["seed"]))
        if "latency" in told:
            into, out = told["latency"]
            if isinstance(self._source, AudioInput):
                self._source.latency = into
            elif self._source is not None:
                self._source.latency = out
        if "event" in told and isinstance(self._source, AudioInput):
            self._source.act(event_from_json(told["event"]))

    def tell(self) -> None:
        """Report the source's state."""
        if self._source is not None:
            self._outbox.tell(facts=self._source.facts(), level=getattr(self._source, "level", None))

    def stop(self) -> None:
        """Stop and free the device."""
        if self._source is not None:
            self._source.stop()

    def _start(self, plan: dict[str, Any]) -> None:
        clock = SystemClock(plan["origin"])
        analysis = analyses(plan["tracker"], self._seeds)
        into, out = plan["latency"]
        begun = plan["begun"]
        try:
            if plan["music"] is None:
                source: AudioInput | MusicPlayer = AudioInput(
                    plan["device"], self._outbox, clock, channels=Channels.of(plan["channels"]), latency=into,
                    analysis=analysis,
                )  # fmt: skip
                source.start()
            else:
                source = MusicPlayer(
                    read_music(Path(plan["music"])), self._outbox, clock, loop=True, output=plan["output"] or True,
                    latency=out, one_at=plan["one_at"] if begun is None else None, analysis=analysis,
                )  # fmt: skip
                begun = clock.now() if begun is None else begun
                source.start(begun=begun)
        except Exception as error:  # of the sound system: the engine reports it
            self._outbox.tell(refused=str(error))
            return
        self._source = source
        self._outbox.tell(started=clock.now() if begun is None else begun)


def main() -> None:
    """Carry out the engine's orders until supervisor and engine have ended."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    sock = socket.socket(fileno=int(sys.argv[1]))
    sock.setblocking(False)
    there = SoundLifeline(sock, Lifeline.inherited(int(sys.argv[2]), int(sys.argv[3])), round_s=ROUND, largest=LARGEST)
    come_forward(AUDIO_NICE)
    outbox = Outbox(sock)
    outbox.tell(hello=True)
    sounding = Sounding(outbox)
    try:
        while not there.deserted:
            for order in there.orders():
                there.lifeline.beat(0, Phase.STARTING)  # loading takes seconds on a busy machine
                sounding.obey(json.loads(order))
            sounding.tell()
            there.lifeline.beat(0, Phase.RUNNING)
    finally:
        sounding.stop()


if __name__ == "__main__":
    main()
