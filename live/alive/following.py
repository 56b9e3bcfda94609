"""Following: a show that runs after another one's lines, and stands where that one stood."""

import base64
import json
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

from live.base.packed import unpacked
from live.clock.ticks import TICK
from live.control.event_json import event_from_json
from live.control.events import ControlEvent, PatchChanged, SetLatency, StepsAdded, StepsChanged, TicksSkipped
from live.show.acting import act
from live.show.core import Show
from live.show.left_out import can_be_left_out
from live.show.library_hash import library_hash
from live.show.load import LoadedShow
from live.show.patch import Patch
from live.show.replay_start import ReplayError, loaded_of
from live.show.snapshot import SnapshotError, restore

ARRIVALS: Final = 256
"""Lines whose delay is remembered: some seconds, in which clocks do not drift apart."""
UNSAFE: Final = 128
"""Ticks before a crash whose events are left out when nothing else has helped: one may be the cause."""

Line = dict[str, Any]


class Following:
    """Takes the lines of a show (`Log.since`, and those that follow) and runs the same show.

    `advance` leaves what came after the last measure line for `finish`: an event that ends one engine shall not end
    the one that waits as well. A state that differs from the other show's is counted, and the next snapshot puts it
    right. Thread: one.
    """

    def __init__(self, loaded: LoadedShow, *, alive: Callable[[int], None] = lambda tick: None) -> None:
        """`alive` is told the tick from time to time while much is run."""
        self._loaded, self._alive = loaded, alive
        self._waiting: deque[Line] = deque()
        self._since: deque[Line] = deque()  # what came since the last snapshot, should this one have to be repaired
        self._measures = 0
        self.header: Line = {}
        self.show: Show | None = None
        self.tick = 0
        """Where the show stands."""
        self.compared = self.differences = self.repaired = self.refused = 0
        """Measures compared; those whose state differed; how often a snapshot put that right; events that failed."""
        self.left_out = 0
        """Events, the last that were told, that `finish` left out."""
        self.problem = ""
        """Why the last snapshot could not be used."""
        self.latencies: dict[str, float] = {}
        """Delays that were changed by hand."""
        self._arrivals: deque[float] = deque(maxlen=ARRIVALS)
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
        if "journal" in value:
            self.header = value
            return
        if len(value) == 1:
            if arrived is not None:
                self._arrivals.append(arrived - value["tick"] * TICK)
            if self._waiting and len(self._waiting[-1]) == 1:
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
        """Run to the end of what was told. `careful`: without the last events, should one of them be poison.

        Ticks that were skipped stay so: that is no cause, and all later ones are counted from there.
        """
        last = max((value["tick"] for value in self._waiting), default=self.tick)
        while self._waiting:
            value = self._waiting.popleft()
            if careful and "event" in value and value["tick"] > last - UNSAFE and can_be_left_out(value["event"]):
                self.left_out += 1
                continue
            self._run(value)
        return self._begun()

    def follow(self) -> None:
        """Run all that was told, in lockstep with who tells it."""
        while self._waiting:
            self._run(self._waiting.popleft())

    def _run(self, value: Line) -> None:
        self._measures -= "measure" in value
        if "snapshot" in value:
            self._take_snapshot(value)
            return
        show = self._begun()
        self._run_to(show, value["tick"])
        if len(value) > 1:
            self._since.append(value)
        if "event" in value:
            self._apply(show, event_from_json(value["event"]))
        elif "measure" in value:
            self.compared += 1
            self._astray = self._hash != (self.tick, value["hash"])
            self.differences += self._astray

    def _run_to(self, show: Show, until: int) -> None:
        while self.tick < until:
            self.tick += 1
            if show.tick(self.tick * TICK):
                self._hash = (self.tick, show.state_hash())
            if self.tick % 64 == 0:
                self._alive(self.tick)

    def _apply(self, show: Show, event: ControlEvent) -> None:
        self.refused += act(show, event) is None
        if isinstance(event, TicksSkipped):
            self.tick += event.count
        elif isinstance(event, SetLatency):
            self.latencies[event.what] = event.seconds

    def _take_snapshot(self, value: Line) -> None:
        """Begin with it, or be put right by it; who stands well needs it only to forget what was before."""
        tick = value["tick"]
        self._since = deque(kept for kept in self._since if belongs_after(kept, tick))
        if self.show is not None and not self._astray:
            return
        try:
            self._began_with(self._needed())
            self.show = restore(self._loaded, base64.b64decode(value["snapshot"]))
        except (SnapshotError, ReplayError, ValueError) as error:
            self.problem = str(error)
            return
        self.repaired += self._astray
        stood, self.tick, self._astray = self.tick, tick, False
        for kept in self._since:
            self._run_to(self.show, kept["tick"])
            if "event" in kept:
                self._apply(self.show, event_from_json(kept["event"]))
        self._run_to(self.show, stood)

    def _begun(self) -> Show:
        if self.show is None:
            self._began_with(self._needed())
            self.show = self._loaded.start(seed=self.header["seed"], tempo=self.header["tempo"])
        return self.show

    def other_show(self) -> str | None:
        """In what the show that is told of differs from the one that is loaded here; None if it is the same, or before
        anything is told. A patch that was edited while it was played may be loaded as it is now."""
        if self.show is not None or not self.header:
            return None
        try:
            patches = [Patch.model_validate(self.header["patch"]), *self._patches()]
        except (KeyError, ValueError):
            return None  # whoever begins it says what is wrong with it
        mine, *all_told = (patch.model_dump(mode="json") for patch in (self._loaded.patch, *patches))
        if mine in all_told:
            return None
        last = all_told[-1]
        keys = [key for key in mine if mine[key] != last.get(key)]
        there, here = Path(str(self.header.get("patch_path"))).name, self._loaded.path.name
        return f"{there} ({patches[-1].name}), here it is {here} ({mine['name']}); different: {', '.join(keys[:8])}"

    def _patches(self) -> Iterator[Patch]:
        """What the patch became later."""
        for value in self._waiting:
            event = value.get("event")
            if isinstance(event, dict) and event.get("type") == PatchChanged.__name__:
                changed = event_from_json(event)
                assert isinstance(changed, PatchChanged)
                yield Patch.model_validate_json(unpacked(changed.patch))

    def _needed(self) -> list[StepsAdded | StepsChanged]:
        """What becomes of the steps later, and must not be so from the beginning."""
        events = (value["event"] for value in self._waiting if "event" in value)
        kinds = (StepsAdded.__name__, StepsChanged.__name__)
        known = (event_from_json(event) for event in events if isinstance(event, dict) and event["type"] in kinds)
        return [event for event in known if isinstance(event, StepsAdded | StepsChanged)]

    def _began_with(self, later: list[StepsAdded | StepsChanged]) -> None:
        """See that what is loaded is what the show began with."""
        header, loaded = self.header, self._loaded
        same = header["steps_hash"] == library_hash(loaded.graph.library)
        if same and not later and header["patch"] == loaded.patch.written():
            return
        added = (event.clips.split("\n") for event in later if isinstance(event, StepsAdded))
        changed = (event for event in later if isinstance(event, StepsChanged))
        self._loaded = loaded_of(header | {"patch_path": str(loaded.path)}, added, changed)


def belongs_after(value: Line, tick: int) -> bool:
    """Whether a line tells of something after the state that a snapshot holds, taken after `tick` was run."""
    return bool(value["tick"] > tick or (value["tick"] == tick and "event" in value))
