"""Following: a show that runs after another one's lines, and stands where that one stood."""

import json
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Final

from live.clock.ticks import TICK
from live.control.events import ControlEvent, SetLatency, StepsAdded, StepsChanged, TicksSkipped, event_from_json
from live.show.core import Show
from live.show.load import LoadedShow, library_hash
from live.show.replay_start import loaded_of

ARRIVALS: Final = 256
"""Lines whose delay is remembered: some seconds, in which clocks do not drift apart."""
UNSAFE: Final = 128
"""Ticks before an end in a crash whose events are left out when nothing else has helped: one may be the cause."""


class Following:
    """Takes the lines of a show (`Log.since`, and those that follow) and runs the same show.

    `advance` leaves what came after the last measure line for `finish`: an event that ends one engine shall not end
    the one that waits as well. Thread: one.
    """

    def __init__(self, loaded: LoadedShow, *, alive: Callable[[int], None] = lambda tick: None) -> None:
        """`alive` is told the tick from time to time while much is run."""
        self._loaded = loaded
        self._alive = alive
        self._waiting: deque[dict[str, Any]] = deque()
        self._measures = 0
        self.header: dict[str, Any] = {}
        self.show: Show | None = None
        self.tick = 0
        """Where the show stands."""
        self.compared = 0
        self.differences = 0
        """Measures whose state was another one than told, of those compared."""
        self.repaired = 0
        """How often a snapshot made them the same again."""
        self._arrivals: deque[float] = deque(maxlen=ARRIVALS)
        self.refused = 0
        """Events that could not be applied."""
        self.latencies: dict[str, float] = {}
        """Delays that were changed by hand."""
        self._hash: tuple[int, str] = (0, "")
        self._astray = False

    @property
    def origin(self) -> float:
        """The clock's, for a process on the same machine [s of perf_counter]."""
        return float(self.header["origin"])

    @property
    def begun(self) -> float | None:
        """When the music began [s of the show]; None if none plays, or the show listens."""
        return self.header.get("begun")

    def origin_here(self, lead: float) -> float:
        """The clock's for another machine: of all ticks heard of lately that one counts that came soonest.

        `lead` [s]: how far ahead of the clock ticks are run.
        """
        return min(self._arrivals) + lead if self._arrivals else time.perf_counter()

    def facts(self) -> dict[str, int]:
        """How well it follows."""
        return {"compared": self.compared, "different": self.differences, "repaired": self.repaired}

    def take(self, line: str, *, arrived: float | None = None) -> None:
        """Take a line; nothing is run yet. `arrived` [s of perf_counter]: when it came from another machine."""
        value = json.loads(line)
        if arrived is not None and len(value) == 1:
            self._arrivals.append(arrived - value["tick"] * TICK)
        if "journal" in value:
            self.header = value
            return
        if len(value) == 1 and self._waiting and len(self._waiting[-1]) == 1:
            self._waiting[-1] = value
            return
        self._measures += "measure" in value
        self._waiting.append(value)

    def advance(self, *, lines: int = 64) -> bool:
        """Run on by so many lines at most, not beyond the last measure line; whether there is more to run."""
        for _ in range(lines):
            if not self._measures:
                return False
            self._run(self._waiting.popleft())
        return self._measures > 0

    def finish(self, *, careful: bool = False) -> Show:
        """Run to the end of what was told. `careful`: without the last events, should one of them be poison."""
        last = max((value["tick"] for value in self._waiting), default=self.tick)
        while self._waiting:
            value = self._waiting.popleft()
            if careful and "event" in value and value["tick"] > last - UNSAFE:
                self.refused += 1
                continue
            self._run(value)
        return self._begun()

    def follow(self) -> None:
        """Run all that was told, in lockstep with who tells it."""
        while self._waiting:
            self._run(self._waiting.popleft())

    def _begun(self) -> Show:
        if self.show is None:
            self.show = _start(self._loaded, self.header, list(self._waiting))
        return self.show

    def _run(self, value: dict[str, Any]) -> None:
        self._measures -= "measure" in value
        until = value["tick"]
        if self.show is None and "snapshot" in value:
            self._restore(value)
            return
        show = self._begun()
        while self.tick < until:
            self.tick += 1
            if show.tick(self.tick * TICK):
                self._hash = (self.tick, show.state_hash())
            if self.tick % 64 == 0:
                self._alive(self.tick)
        if "snapshot" in value:
            self._restore(value)
        elif "event" in value:
            self._apply(show, event_from_json(value["event"]))
        elif "measure" in value:
            self.compared += 1
            self._astray = self._hash != (self.tick, value["hash"])
            self.differences += self._astray

    def _restore(self, value: dict[str, Any]) -> None:
        """Stand where a snapshot stands, if this show does not stand there anyway."""

    def _apply(self, show: Show, event: ControlEvent) -> None:
        try:
            show.apply(event)
        except Exception:  # whatever it was that the other one could do: the show goes on
            self.refused += 1
        if isinstance(event, TicksSkipped):
            self.tick += event.count
        elif isinstance(event, SetLatency):
            self.latencies[event.what] = event.seconds


def _start(loaded: LoadedShow, header: dict[str, Any], waiting: list[dict[str, Any]]) -> Show:
    """The show of that header at its first moment: of what is loaded if it is the same, else as a replay loads it."""
    events = [value["event"] for value in waiting if "event" in value]
    later = any(isinstance(event, dict) and event.get("type") == StepsAdded.__name__ for event in events)
    same = header["steps_hash"] == library_hash(loaded.graph.library)
    if same and not later and header["patch"] == loaded.patch.written():
        return loaded.start(seed=header["seed"], tempo=header["tempo"])
    kinds = (StepsAdded.__name__, StepsChanged.__name__)
    known = [event_from_json(event) for event in events if isinstance(event, dict) and event.get("type") in kinds]
    keys = (event.clips.split("\n") for event in known if isinstance(event, StepsAdded))
    changed = (event for event in known if isinstance(event, StepsChanged))
    return loaded_of(header, keys, changed).start(seed=header["seed"], tempo=header["tempo"])
