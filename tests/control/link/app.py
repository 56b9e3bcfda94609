"""The show's side of a Link session: LinkSession, queue, follower at 64 ticks a second; commands as in `peer.py`.

A show without dancers: the consumers of the timeline are omitted, its producers are real.
"""

import json
import sys
import threading
import time
from typing import Any

from live.base.event_queue import EventQueue
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.time_source import SystemClock
from live.control.events.events import BeatHeard, ControlEvent, SetTempo, SourceChanged
from live.control.link.link_session import LinkSession
from live.show.sound.clock_commands import apply_clock_event

TICK = 1.0 / 64.0


class App:
    """A show that can be enabled and disabled; its time starts when it is made."""

    def __init__(self, tempo: float, mode: str) -> None:
        self.clock = SystemClock()
        self.inbox: EventQueue[ControlEvent] = EventQueue()
        self.follower = TimelineFollower(tempo=tempo)
        self.mode = mode
        self.start_stop = False
        self.session: LinkSession | None = None
        self.beat: BeatHeard | None = None
        self.states: list[str] = []
        self.jumps = 0
        self.step = 0.0
        """The largest step of the Timeline [beats] that the music's tempo does not explain, tick to tick."""
        self._last: tuple[float, float] | None = None
        self.hand = self.follower.manual_tempo[0]

    def tick(self) -> None:
        now = self.clock.now()
        for event in self.inbox.drain():
            if isinstance(event, BeatHeard):
                self.beat = event
                self.jumps += event.jump
            elif isinstance(event, SourceChanged):
                self.states.append(event.state)
            apply_clock_event(self.follower, event)
        timeline = self.follower.advance(now)
        if self.session is not None:
            if self.follower.manual_tempo[0] != self.hand:
                self.hand = self.follower.manual_tempo[0]
                self.session.set_tempo(self.follower.manual_tempo[1])
            self.session.set_timeline(timeline, self.follower.tempo)
        beat = timeline.beat_at(now)
        if self._last is not None:
            before, there = self._last
            self.step = max(self.step, abs(beat - there - (now - before) * self.follower.tempo / 60.0))
        self._last = (now, beat)

    def command(self, command: dict[str, Any]) -> None:
        match command["do"]:
            case "enable":
                if command["on"] and self.session is None:
                    self.session = LinkSession(
                        self.inbox, self.clock, tempo=self.follower.tempo, mode=self.mode, start_stop=self.start_stop
                    )
                    self.session.start()
                elif not command["on"] and self.session is not None:
                    self.session.stop()
                    self.session = None
            case "share":
                self.start_stop = command["on"]
            case "tempo":
                apply_clock_event(self.follower, SetTempo(time=self.clock.now(), source="test", tempo=command["bpm"]))
            case "load":  # another patch: another show on the same participant
                self.follower = TimelineFollower(tempo=command["bpm"])
                self.hand = self.follower.manual_tempo[0]
                self._last = None
            case "play":
                assert self.session is not None
                self.session.set_playing(command["on"])
            case "resync":
                assert self.session is not None
                self.session.resync()
            case "forget":
                self.states.clear()
                self.jumps, self.step = 0, 0.0

    def answer(self, at: float) -> dict[str, Any]:
        timeline, session, beat = self.follower.timeline, self.session, self.beat
        heard = None if beat is None else (beat.beat + (at - beat.beat_time) / beat.period) % beat.beats_per_measure
        return {
            "peers": 0 if session is None else session.peers,
            "tempo": self.follower.tempo,
            "running": timeline.tempo,
            "phase": timeline.phase_at(at),
            "beat": timeline.beat_at(at),
            "heard": heard,
            "heard_tempo": None if beat is None else 60.0 / beat.period,
            "source": self.follower.source,
            "state": self.follower.state,
            "states": list(self.states),
            "jumps": self.jumps,
            "step": self.step,
            "playing": None if session is None or session.reading is None else session.reading.playing,
            "summary": "off" if session is None else session.summary,
            "faults": 0 if session is None else session.faults,
        }


def main() -> None:
    app = App(120.0, "follow")
    lines: list[str] = []
    ended = threading.Event()

    def read() -> None:
        for line in sys.stdin:
            lines.append(line)
        ended.set()

    threading.Thread(target=read, daemon=True).start()
    print(json.dumps({"ready": True}), flush=True)
    while not ended.wait(TICK):
        app.tick()
        while lines:
            command = json.loads(lines.pop(0))
            if command["do"] == "new":
                app.command({"do": "enable", "on": False})
                app = App(command["bpm"], command.get("mode", "follow"))
            app.command(command)
            app.tick()  # what comes of it is in the answer
            at = command.get("at", time.perf_counter()) - app.clock.origin
            print(json.dumps(app.answer(at)), flush=True)
    if app.session is not None:
        app.session.stop()


if __name__ == "__main__":
    main()
