"""Status: the figures of a running show, one JSON object a second in the form of the contracts.

Pressure: how hard it is for the machine to keep up, as one number for whoever can draw less.
"""

import json
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.base.fault_isolation import Bulkhead, name_of
from live.clock.follower.timeline_follower import TimelineFollower
from live.show.journal.journal_writer import LineWriter
from live.show.selection.choices import why_in_words
from live.show.show import Show

KEPT = 4096
"""Frame times kept for the percentiles: about the last minute."""


class FrameTimes:
    """The last frame times in milliseconds, in a preallocated ring."""

    def __init__(self) -> None:
        self._ring = np.zeros(KEPT)
        self._count = 0

    def add(self, seconds: float) -> None:
        """Note one frame that took `seconds`."""
        self._ring[self._count % KEPT] = seconds * 1e3
        self._count += 1

    def percentiles(self, *shares: float) -> list[float]:
        """Percentiles [ms] of the frames kept; zeros before the first."""
        if not self._count:
            return [0.0] * len(shares)
        return [round(float(v), 3) for v in np.percentile(self._ring[: min(self._count, KEPT)], shares)]


class Status:
    """Counts what happens and says it once a second."""

    def __init__(
        self,
        show: Show,
        *,
        rejected: Callable[[], Counter[str]],
        memory: Callable[[], float],
        level: Callable[[], float | None] = lambda: None,
        refusal: Callable[[], str] = lambda: "",
    ) -> None:
        """`rejected`: counts by reason from the inputs; `memory`: resident memory [MB].

        For the overlay: `level`, RMS of what an input device hears (None: there is none), and `refusal`, the last
        refusal in words.
        """
        self._level = level
        self._refusal = refusal
        self._show = show
        self._rejected = rejected
        self._memory = memory
        self._overlay: tuple[str, ...] = ()
        self._overlay_until = 0.0
        self.frame_times = FrameTimes()
        """From one frame to the next."""
        self.work_times = FrameTimes()
        """From a frame's beginning until it is done, by the clock: with what it waited for."""
        self.processor_times = FrameTimes()
        """Time of the processor that the main thread used in a frame: nothing for what it waited."""
        self.frames = 0
        self.late_frames = 0
        self.ticks = 0
        self.skipped_ticks = 0
        self.events_accepted = 0
        self.dropped_events = 0
        self.outranked = 0
        """Values that gave way to an operator's or a musician's."""
        self.impossible = 0
        """What sources said that is no number."""
        self.more: dict[str, Callable[[], Any]] = {}
        """What other parts have to say, by its key in the snapshot."""
        self.tool = ""
        """What the pointer places, for the overlay; empty until the operator chose."""
        self._calls = Bulkhead()
        self.notes: list[Callable[[], str]] = []
        """What is wrong now, for the overlay: a line of words from each, or nothing."""
        self.faults = 0
        """Frames in which drawing failed and the show went on."""

    def _refused(self) -> Counter[str]:
        """What was refused, by reason."""
        rejected, show = Counter(self._rejected()), self._show
        if self.dropped_events:
            rejected["inbox full"] += self.dropped_events
        if self.outranked:
            rejected["outranked"] += self.outranked
        if show.refusals.count:
            rejected["not in this show"] += show.refusals.count
        if impossible := show.follower.rejected + self.impossible:
            rejected["impossible beat"] += impossible
        return rejected

    def refused(self) -> int:
        """How much was refused in all."""
        return self._refused().total()

    def snapshot(self, time: float) -> dict[str, Any]:
        """All figures at `time` [s]; counters are totals since the start. Measures and beats count from 1."""
        show = self._show
        moment = show.moment(time)
        danced = show.span.fraction(moment.beat) * show.timeline.beats_per_measure
        p50, p99, p999 = self.frame_times.percentiles(50, 99, 99.9)
        work50, work99 = self.work_times.percentiles(50, 99)
        cpu50, cpu99 = self.processor_times.percentiles(50, 99)
        return {
            "time": round(time, 3),
            "measure": show.span.number + 1,
            "beat": min(int(danced) + 1, show.timeline.beats_per_measure),
            "bpm": round(show.follower.tempo, 2),
            "source": show.follower.source,
            "clock_state": show.follower.state,
            "confidence": round(moment.confidence, 3),
            **clock_figures(show.follower),
            "frames": self.frames,
            "late_frames": self.late_frames,
            "ticks": self.ticks,
            "skipped_ticks": self.skipped_ticks,
            "frame_ms": {"p50": p50, "p99": p99, "p999": p999},
            "work_ms": {"p50": work50, "p99": work99},
            "cpu_ms": {"p50": cpu50, "p99": cpu99},
            "dancers": int(show.motion.present.sum()),
            "events_accepted": self.events_accepted,
            "events_rejected": dict(self._refused()),
            "phones": show.audience.phones,
            "rss_mb": round(self._memory(), 1),
            "faults": self.faults,
            "behind": show.scheduler.behind(),
            "carried": show.scheduler.carrying.figures(),
            "interrupts": show.interrupts.figures(),
            **({} if show.dancers.answering is None else {"hands": show.dancers.answering.holding.figures()}),
            "why": show.why(),
            **show.prompter.facts(),
            "agenda": show.prompter.agenda.figures(),
            **show.desk.facts(show.danced),
            **{key: self._calls.call(f"the figures of {key}", tell) for key, tell in self.more.items()},
        }

    def overlay(self, time: float) -> tuple[str, ...]:
        """The operator's lines on the picture, made anew four times a second; those of cues count every beat."""
        if time >= self._overlay_until:
            self._overlay_until = time + 0.25
            self._overlay = self._overlay_lines(time)
        return (*self._show.desk.words(self._show.danced), *self._overlay)

    def _overlay_lines(self, time: float) -> tuple[str, ...]:
        s = self.snapshot(time)
        beats = self._show.timeline.beats_per_measure
        frame, cpu = s["frame_ms"], s["cpu_ms"]["p50"]
        level, refusal = self._level(), self._refusal() or self._show.refusals.words
        heard = "" if level is None else f"   input {20.0 * math.log10(max(level, 1e-5)):.0f} dB"
        lines = (
            f"{s['bpm']:.1f} bpm   measure {s['measure']}   beat {s['beat']} of {beats}",
            f"clock: {clock_in_words(s)}{heard}",
            f"frame {frame['p50']:.1f} ms   p99 {frame['p99']:.1f}   p99.9 {frame['p999']:.1f}   cpu {cpu:.1f}   "
            f"late {s['late_frames']}   skipped {s['skipped_ticks']}",
            f"dancers {s['dancers']}   events {s['events_accepted']}   refused {sum(s['events_rejected'].values())}   "
            f"phones {s['phones']}   memory {s['rss_mb']:.0f} MB",
        )
        more = self._show.prompter.words()
        more = (*more, f"pointer: {self.tool}") if self.tool else more
        record = [f"{name}: {told['record']}" for name, told in s["behind"].items() if told["record"]]
        more = (*more, *record[:1], *(why_in_words(s["why"]) if s["why"] else ()))
        more = (*more, *(note for tell in self.notes if (note := self._calls.call(name_of(tell), tell))))
        return (*lines, *more, f"last refused: {refusal}") if refusal else (*lines, *more)


def clock_figures(follower: TimelineFollower) -> dict[str, Any]:
    """What there is to say of the clock beside tempo, beat and state."""
    jump = follower.last_jump
    return {
        "metre": follower.timeline.beats_per_measure,
        "clock_choice": follower.choice,
        "clock_sources": follower.states,
        "clock_jumps": follower.jumps,
        "clock_last_jump": None if jump is None else {"time": round(jump.time, 3), "cause": jump.cause},
        "count_in": follower.counting_in,
        "source_measure": follower.source_measure + 1 if follower.source_measure >= 0 else None,
    }


def clock_in_words(figures: dict[str, Any]) -> str:
    """The overlay's line on the clock: who is followed, how sure that is, and what waits or was chosen."""
    words = [str(figures["source"])]
    if figures["source"] != "internal":
        words += [str(figures["clock_state"]), f"sure to {figures['confidence']:.0%}"]
    if figures["clock_choice"] not in ("auto", figures["source"]):
        words.append(f"waits for {figures['clock_choice']}")
    others = [name for name, state in figures["clock_sources"].items() if state == "locked"]
    others = [name for name in others if name not in (figures["source"], "internal", "tap")]
    if others:
        words.append(f"also {' and '.join(others)}")
    if figures["count_in"]:
        words.append(f"counting in: {figures['count_in']}")
    return ", ".join(words)


class StatusFile:
    """Writes a status line once a second, by a thread of its own; a full disk is counted and forgotten."""

    def __init__(self, path: Path, status: Status, *, more: bool = False) -> None:
        """Raises OSError if the file cannot be made; `more`: lines are added to those that are there."""
        self._writer = LineWriter(path, name="status", more=more)
        self._status = status
        self._next = 1.0

    @property
    def dropped(self) -> int:
        """Lines that could not be written."""
        return self._writer.dropped

    def frame(self, time: float) -> None:
        """To be called each frame: notes the figures when a second has passed."""
        if time < self._next:
            return
        self._next = float(int(time) + 1)
        self._writer.line(json.dumps(self._status.snapshot(time)))

    def close(self, time: float) -> None:
        """Note the last figures, if they are not just noted, and close the file."""
        if time > self._next - 0.9:
            self._writer.line(json.dumps(self._status.snapshot(time)))
        self._writer.close()


HALFLIFE: Final = 2.0
"""After so many seconds a late frame counts half."""
FULL: Final = 0.1
"""This share of late frames is all the pressure there is: a dance that stutters."""


class Pressure:
    """0 where every frame is in time, 1 where a tenth of them or more is late, or the machine has far too much to do.

    Thread: the show's.
    """

    def __init__(self) -> None:
        self._share = 0.0
        self._late = 0
        self._overload = 0.0

    @property
    def value(self) -> float:
        """0 to 1."""
        return max(min(self._share / FULL, 1.0), self._overload)

    def frame(self, late: int, seconds: float, overload: float = 0.0) -> None:
        """After each frame: `late` frames since the start, and how long this one took from the last one [s].

        `overload`: 0 to 1, what whoever watches over the show feels of a machine that has too much to do.
        """
        self._overload = overload
        kept = 0.5 ** (max(seconds, 0.0) / HALFLIFE)
        now = 1.0 if late > self._late else 0.0
        self._late = late
        self._share = kept * self._share + (1.0 - kept) * now
