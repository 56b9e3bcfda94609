"""State follower: replays the journal lines of another show and reaches the same state."""

import base64
import contextlib
import json
import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from live.base.compression import decompress_text
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events.event_json import event_from_json
from live.control.events.events import (
    ControlEvent,
    ExamplesChanged,
    PatchChanged,
    SetLatency,
    StepsAdded,
    StepsChanged,
    TicksSkipped,
)
from live.show.journal.replay import ReplayError, load_from_header
from live.show.journal.skipped_events import SKIPPED_KEY, can_be_skipped
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch_checks.patch_check import PATCH_CHECKS
from live.show.selection.graph_update import library_hash
from live.show.show import Show, apply_safely
from live.show.state.snapshot import SnapshotError, restore
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.recovery_log import RecoveryLog
from live.supervisor.supervisor_link import describe_error

MAX_ARRIVALS: Final = 256
"""Ticks whose arrival is remembered: some seconds, in which clocks do not drift apart."""
Line = dict[str, Any]
FileChange = StepsAdded | StepsChanged | ExamplesChanged


class TickFailed(Exception):
    """A tick ended in an error: the show's state is no longer valid."""

    def __init__(self, tick: int, stage: int, error: Exception) -> None:
        super().__init__(f"tick {tick}: {describe_error(error)}")
        self.tick, self.stage, self.why = tick, stage, describe_error(error)


class StateFollower:
    """Replays the lines of a show (`RecoveryLog.since` and later ones).

    `advance` leaves the lines after the last measure line to `Recovery.run` (`recovery.py`), so that an event that
    kills one engine does not kill the spare as well. A state that differs from the original's is counted, and the next
    snapshot corrects it. Thread: one.
    """

    def __init__(
        self, loaded: LoadedShow, *, heartbeat: Heartbeat | None = None, keeps_lines: bool = True
    ) -> None:  # fmt: skip
        """`heartbeat`: of this process; shows beats and the running tick and stage during long runs. `keeps_lines`:
        whether the lines since the last snapshot are kept, for a repair; otherwise another follower takes its place."""
        self._first = self._loaded = loaded
        self._heartbeat, self._log, self._keeps_lines = heartbeat, RecoveryLog(), keeps_lines
        self._pending: deque[Line] = deque()
        self._since_snapshot: deque[Line] = deque()  # lines since the last snapshot, for a repair
        self._coming: tuple[Line, ...] = ()  # lines of `run`, which are not pending
        self._measures = 0
        self.header: Line = {}
        self.show: Show | None = None
        self.tick = 0
        """The last tick run."""
        self.granted = 0
        """The last tick that the sender is known to have run."""
        self.compared = self.differences = self.repaired = self.refused = 0
        """Measures compared; those that differed; corrections by a snapshot; events that failed."""
        self.problem = ""
        """Why the last snapshot could not be used; empty if it could."""
        self.latencies: dict[str, float] = {}
        """Latencies that were changed by hand [s]."""
        self._arrivals: deque[float] = deque(maxlen=MAX_ARRIVALS)
        self._last_measure: tuple[int, str] = (0, "")
        self._diverged = self._stuck = self._was_ahead = False

    @property
    def ready(self) -> bool:
        """Whether this show is verified: a state was compared, and the last comparison found no difference."""
        return self.show is not None and self.compared > 0 and not (self._diverged or self._stuck or self._pending)

    @property
    def differs(self) -> bool:
        """Whether the state differs from the sender's, or cannot be computed, until the next snapshot."""
        return self._diverged or self._stuck

    @property
    def origin(self) -> float:
        """Origin of the clock, for a process on the same machine [s of perf_counter]."""
        return float(self.header["origin"])

    @property
    def music_start(self) -> float | None:
        """When the music began [s of the show]; None if none plays or the show listens."""
        begun = self.header.get("begun")
        return float(begun) if isinstance(begun, int | float) else None

    def local_origin(self, lead: float) -> float:
        """Return the origin of the clock for another machine, from the recent tick that arrived with the least delay.

        `lead` [s]: how far ahead of the clock ticks are run.
        """
        return min(self._arrivals) + lead if self._arrivals else time.perf_counter()

    def facts(self) -> dict[str, int]:
        """Return figures on how well it follows."""
        return {"compared": self.compared, "different": self.differences, "repaired": self.repaired}

    def add_line(self, line: str, *, arrived: float | None = None) -> None:
        """Add a line without running it. `arrived` [s of perf_counter]: when it came from another machine."""
        value = json.loads(line)
        if self._keeps_lines:
            self._log.add_line(line)
        if "journal" in value:
            self.header = value
            return
        self.granted = max(self.granted, value["tick"])
        if len(value) == 1:
            if arrived is not None:
                self._arrivals.append(arrived - value["tick"] * TICK)
            if self._pending and len(self._pending[-1]) == 1:
                self._pending[-1] = value
                return
        if SKIPPED_KEY in value:
            self._remove_events(value[SKIPPED_KEY])
        self._measures += "measure" in value
        self._pending.append(value)
        if self._stuck and "snapshot" in value:
            self._restart_from_snapshot(stuck=False)

    def _remove_events(self, count: int) -> None:
        """Remove the last `count` events, which are in quarantine. If one has been applied already, the state counts as
        different until the next snapshot."""
        for value in [value for value in reversed(self._pending) if is_event(value)][:count]:
            self._pending.remove(value)
            count -= 1
        self._diverged = self._diverged or count > 0

    @property
    def loaded(self) -> LoadedShow:
        """Current patch and steps."""
        if self.show is None:
            return self._loaded
        answers = None if self._loaded.answers is None else self.show.hot_swap.answers
        return replace(self._loaded, patch=self.show.patch, graph=self.show.graph, answers=answers)

    @property
    def pending(self) -> list[Line]:
        """Lines received but not run yet, in order."""
        return list(self._pending)

    def advance(self, *, lines: int = 64) -> bool:
        """Run at most `lines` lines, not beyond the last measure line; return whether more can be run."""
        try:
            for _ in range(lines):
                if not self._measures or self._stuck:
                    return False
                self._run(self._pending.popleft())
        except TickFailed:  # it ran on the original, but not here: `Recovery.run` finds out why
            self._restart_from_snapshot(stuck=True)
            return False
        return self._measures > 0

    def _restart_from_snapshot(self, *, stuck: bool) -> None:
        """Return to the last snapshot, with all lines since then pending."""
        self.reset_to(None, 0)
        self._pending = deque(self.lines_from_snapshot())
        self._measures = sum("measure" in value for value in self._pending)
        self._stuck = stuck

    def run(self, lines: Iterable[Line], until: int) -> None:
        """Run these lines instead of the pending ones, and every tick up to `until`; TickFailed if one fails.

        No line is pending afterwards.
        """
        self._coming = tuple(lines)
        self._pending.clear()
        self._measures = 0
        for value in self._coming:
            self._measures += "measure" in value
            self._run(value)
        self._run_to(self._ensure_started(), until)
        self._coming = ()

    def reset_to(self, show: Show | None, tick: int) -> None:
        """Continue from `show` as it was after `tick`; None: nothing of it has been run."""
        self._set_show(show)
        self.tick = tick
        self._diverged = self._was_ahead = False
        self._since_snapshot.clear()
        if show is None:
            self._loaded = self._first

    def lines_from_snapshot(self) -> list[Line]:
        """Return all lines needed to run the show again from its last snapshot."""
        again = StateFollower(self._first)
        for line in self._log.replay_lines():
            again.add_line(line)
        return again.pending

    @property
    def last_measure(self) -> tuple[int, str]:
        """Tick of the last measure line, and the hash of the state there."""
        return self._last_measure

    def run_pending(self) -> None:
        """Run all pending lines in lockstep with the sender; if one fails, wait for a snapshot."""
        while self._pending and not self._stuck:
            try:
                self._run(self._pending.popleft())
            except TickFailed:
                self._restart_from_snapshot(stuck=True)

    def run_until(
        self, tick: int, deadline: float = math.inf, *, ahead: bool = False,
        now: Callable[[], float] = time.perf_counter,
    ) -> bool:  # fmt: skip
        """Run ticks and the lines among them up to `tick`; return whether all of that is done.

        The sender is not overtaken, unless `ahead`: then this state may differ from its, which shows with its next
        lines (`differs`). `deadline` [s of `now`]: none is begun after it.
        """
        goal = tick if ahead else min(tick, self.granted)
        try:
            while not self._stuck:
                value = self._pending[0] if self._pending else None
                due = value is not None and ("snapshot" in value or value["tick"] <= self.tick)
                until = goal if value is None else min(goal, value["tick"])
                if not due and self.tick >= until:
                    return True
                if now() >= deadline:
                    return False
                if due:
                    self._run(self._pending.popleft())
                else:
                    self._run_to(self._ensure_started(), self.tick + 1)
        except TickFailed:  # it ran on the original, but not here
            self._stuck = True
        return False

    def build(self) -> None:
        """Make the show as the snapshot says that comes first, or as it began, without running a tick; ReplayError if
        it cannot be made here."""
        if self._pending and "snapshot" in self._pending[0]:
            self._run(self._pending.popleft())
        self._ensure_started()

    def _run(self, value: Line) -> None:
        self._measures -= "measure" in value
        if "snapshot" in value:
            self._apply_snapshot(value)
            return
        show = self._ensure_started()
        self._run_to(show, value["tick"])
        if len(value) > 1 and self._keeps_lines:
            self._since_snapshot.append(value)
        if "event" in value:
            if value["tick"] < self.tick:  # it came after this show had gone ahead; a hash of measures misses a light
                self._diverged = self._was_ahead = True
            self._apply_json(show, value["event"])
        elif "measure" in value:
            self.compared += 1
            differs = self._last_measure != (value["tick"], value["hash"])
            self.differences += differs
            self._diverged = differs or self._was_ahead

    def _run_to(self, show: Show, until: int) -> None:
        while self.tick < until:
            self.tick += 1
            if self._heartbeat is not None:
                self._heartbeat.begin_tick(self.tick)
            try:
                if show.tick(self.tick * TICK):
                    self._last_measure = (self.tick, show.state_hash())
            except Exception as error:
                raise TickFailed(self.tick, show.breakers.running, error) from error

    def _apply_json(self, show: Show, value: Line) -> None:
        """Apply an event; one that is unknown to this version is counted, as in a replay."""
        try:
            event = event_from_json(value)
        except (ValueError, TypeError):
            self.refused += 1
            return
        self._apply(show, event)

    def _apply(self, show: Show, event: ControlEvent) -> None:
        self.refused += apply_safely(show, event) is None
        if isinstance(event, TicksSkipped):
            self.tick += event.count
        elif isinstance(event, SetLatency):
            self.latencies[event.what] = event.seconds

    def _apply_snapshot(self, value: Line) -> None:
        """Start from a snapshot or correct the state with it. If the state is right, only older lines are dropped."""
        tick = value["tick"]
        self._since_snapshot = deque(kept for kept in self._since_snapshot if is_after(kept, tick))
        if self.show is not None and not self._diverged:
            return
        try:
            self._load_initial(self._later_changes())
            self._set_show(restore(self._loaded, base64.b64decode(value["snapshot"])))
        except (SnapshotError, ReplayError, ValueError) as error:
            self.problem = str(error)
            return
        assert self.show is not None
        self.repaired += self._diverged
        stood, self.tick, self._diverged, self._was_ahead = self.tick, tick, False, False
        for kept in self._since_snapshot:
            self._run_to(self.show, kept["tick"])
            if "event" in kept:
                self._apply_json(self.show, kept["event"])
        self._run_to(self.show, stood)

    def _ensure_started(self) -> Show:
        if self.show is None:
            self._load_initial(self._later_changes())
            try:
                show = self._loaded.start(seed=self.header["seed"], tempo=self.header["tempo"])
            except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
                raise ReplayError(f"its first line does not say how it began: {describe_error(error)}") from None
            self._set_show(show)
        assert self.show is not None
        return self.show

    def _set_show(self, show: Show | None) -> None:
        self.show = show
        if show is not None and self._heartbeat is not None:
            show.breakers.publish(self._heartbeat.stage)

    def show_mismatch(self) -> str | None:
        """Return how the received show differs from the one loaded here; None if it is the same, or before the header.

        A patch that was edited during the show may be loaded as it is now.
        """
        if self.show is not None or not self.header:
            return None
        try:
            patches = [Patch.model_validate(self.header["patch"], context=PATCH_CHECKS), *self._patches()]
        except (KeyError, ValueError):
            return None  # reported when the show is started
        mine, *all_told = (patch.model_dump(mode="json") for patch in (self._loaded.patch, *patches))
        if mine in all_told:
            return None
        last = all_told[-1]
        keys = [key for key in mine if mine[key] != last.get(key)]
        there, here = Path(str(self.header.get("patch_path"))).name, self._loaded.path.name
        return f"{there} ({patches[-1].name}), here it is {here} ({mine['name']}); different: {', '.join(keys[:8])}"

    def _patches(self) -> Iterator[Patch]:
        """Yield the later versions of the patch."""
        for value in self._pending:
            event = value.get("event")
            if isinstance(event, dict) and event.get("type") == PatchChanged.__name__:
                changed = event_from_json(event)
                assert isinstance(changed, PatchChanged)
                yield Patch.model_validate_json(decompress_text(changed.patch), context=PATCH_CHECKS)

    def _later_changes(self) -> list[FileChange]:
        """Return the later changes of steps and examples, which must not be loaded from the start."""
        events = (value["event"] for value in (*self._coming, *self._pending) if "event" in value)
        kinds = (StepsAdded.__name__, StepsChanged.__name__, ExamplesChanged.__name__)
        found = []
        for told in events:
            with contextlib.suppress(ValueError, TypeError):  # it is counted when it is run
                event = event_from_json(told) if isinstance(told, dict) and told.get("type") in kinds else None
                if isinstance(event, FileChange):
                    found.append(event)
        return found

    def _load_initial(self, later: list[FileChange]) -> None:
        """Load the patch, steps and examples with which the show began."""
        header, loaded = self.header, self._loaded
        if not isinstance(header.get("patch"), dict) or not isinstance(header.get("steps_hash"), str):
            raise ReplayError("its first line does not hold a whole show")
        same = header["steps_hash"] == library_hash(loaded.graph.library)
        answers = None if loaded.answers is None else loaded.answers.digest()
        same = same and header.get("partner") == answers
        if same and not later and header["patch"] == loaded.patch.to_json_values():
            return
        added = (event.clips.split("\n") for event in later if isinstance(event, StepsAdded))
        changed = (event for event in later if isinstance(event, StepsChanged))
        examples = [event for event in later if isinstance(event, ExamplesChanged)]
        self._loaded = load_from_header(header | {"patch_path": str(loaded.path)}, added, changed, examples)


def check_show(following: StateFollower) -> None:
    """Raise PersonError if this machine plays another show than the one that is received."""
    if (other := following.show_mismatch()) is not None:
        raise PersonError(f"the leader plays another show: {other}", "start all machines with the same patch")


def cannot_run(error: ReplayError) -> PersonError:
    """Return what the person has to know if the received show cannot be run here."""
    return PersonError(f"the leader's show cannot run here: {error}", "use the same steps on all machines")


def is_event(value: Line) -> bool:
    """Return whether a line holds an event that can be left out."""
    return "event" in value and can_be_skipped(value["event"])


def is_after(value: Line, tick: int) -> bool:
    """Return whether a line comes after the state of a snapshot that was taken after `tick` was run."""
    return bool(value["tick"] > tick or (value["tick"] == tick and "event" in value))
