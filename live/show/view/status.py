"""Status figures of a running show, written as one JSON object per second, and its measure of overload."""

import json
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.base.fault_isolation import Bulkhead, callback_name
from live.clock.follower.timeline_follower import TimelineFollower
from live.show.journal.line_writer import LineWriter
from live.show.score.division_tree import part_facts
from live.show.selection.choices import explanation_lines, tempo_line
from live.show.show import Show

FRAME_TIMES_KEPT = 4096
"""Number of frame times kept for the percentiles: about the last minute."""


class FrameTimes:
    """Ring buffer of the last frame times [ms]."""

    def __init__(self) -> None:
        self._ring = np.zeros(FRAME_TIMES_KEPT)
        self._count = 0

    def add(self, seconds: float) -> None:
        """Record one frame that took `seconds`."""
        self._ring[self._count % FRAME_TIMES_KEPT] = seconds * 1e3
        self._count += 1

    def percentiles(self, *shares: float) -> list[float]:
        """Return percentiles of the kept frame times [ms]; zeros before the first frame."""
        if not self._count:
            return [0.0] * len(shares)
        return [round(float(v), 3) for v in np.percentile(self._ring[: min(self._count, FRAME_TIMES_KEPT)], shares)]


class Status:
    """Counters and figures of one show, for the status line and the overlay."""

    def __init__(
        self,
        show: Show,
        *,
        rejected: Callable[[], Counter[str]],
        memory: Callable[[], float],
        level: Callable[[], float | None] = lambda: None,
        refusal: Callable[[], str] = lambda: "",
    ) -> None:
        """`rejected`: rejected inputs by reason; `memory`: resident memory [MB].

        For the overlay: `level`, the RMS of the audio input (None: no input), and `refusal`, the last refusal in
        words.
        """
        self._level = level
        self._refusal = refusal
        self._show = show
        self._rejected = rejected
        self._memory = memory
        self._overlay: tuple[str, ...] = ()
        self._overlay_until = 0.0
        self.frame_times = FrameTimes()
        """Intervals between frames."""
        self.work_times = FrameTimes()
        """Wall time of each frame from begin to end, including waiting."""
        self.processor_times = FrameTimes()
        """CPU time of the main thread in each frame."""
        self.frames = 0
        self.late_frames = 0
        self.ticks = 0
        self.skipped_ticks = 0
        self.events_accepted = 0
        self.dropped_events = 0
        self.outranked = 0
        """Values displaced by a source of higher rank (an operator or a musician)."""
        self.invalid = 0
        """Measurements with NaN or infinity."""
        self.extra_figures: dict[str, Callable[[], Any]] = {}
        """Figures of other parts, by key in the snapshot."""
        self.tool = ""
        """The pointer's tool, for the overlay; empty until the operator chooses one."""
        self._calls = Bulkhead()
        self.notices: list[Callable[[], str]] = []
        """Current problems, for the overlay: each returns a line, or an empty string."""
        self.faults = 0
        """Frames in which drawing failed and the show continued."""

    def _refused_by_reason(self) -> Counter[str]:
        """Return the refused events by reason."""
        rejected, show = Counter(self._rejected()), self._show
        if self.dropped_events:
            rejected["inbox full"] += self.dropped_events
        if self.outranked:
            rejected["outranked"] += self.outranked
        if show.refusals.count:
            rejected["not in this show"] += show.refusals.count
        if impossible := show.follower.rejected + self.invalid:
            rejected["impossible beat"] += impossible
        return rejected

    def refused_count(self) -> int:
        """Return the number of all refused events."""
        return self._refused_by_reason().total()

    def snapshot(self, time: float) -> dict[str, Any]:
        """Return all figures at `time` [s]; counters are totals since the start. Measures and beats count from 1."""
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
            "events_rejected": dict(self._refused_by_reason()),
            "phones": show.audience.phones,
            "words": show.audience.words.facts(),
            "rss_mb": round(self._memory(), 1),
            "faults": self.faults,
            "behind": show.scheduler.reachability_report(),
            "off_tempo": show.scheduler.tempo_report(show.follower.tempo),
            "carried": show.scheduler.root_correction.statistics(),
            "interrupts": show.interrupts.statistics(),
            **(
                {}
                if show.dancers.partner_response is None
                else {
                    "hands": show.dancers.partner_response.hand_holds.statistics(),
                    "partners": show.dancers.partner_response.facts(),
                }
            ),
            "why": show.explain_choice(),
            "division": part_facts(show),
            **show.score_runner.facts(),
            "seen_steps": show.seen_steps.facts(),
            "agenda": show.score_runner.beat_scheduler.counters(),
            "launcher": show.launcher.facts(),
            "gestures": show.gestures.facts(),
            **show.desk.facts(show.danced_beats),
            **{key: self._calls.call(f"the figures of {key}", tell) for key, tell in self.extra_figures.items()},
        }

    def overlay(self, time: float) -> tuple[str, ...]:
        """Return the operator's overlay lines, updated four times a second; those of cues at every beat."""
        if time >= self._overlay_until:
            self._overlay_until = time + 0.25
            self._overlay = self._overlay_lines(time)
        return (*self._show.desk.status_lines(self._show.danced_beats), *self._overlay)

    def _overlay_lines(self, time: float) -> tuple[str, ...]:
        s = self.snapshot(time)
        beats = self._show.timeline.beats_per_measure
        frame, cpu = s["frame_ms"], s["cpu_ms"]["p50"]
        level, refusal = self._level(), self._refusal() or self._show.refusals.last_reason
        heard = "" if level is None else f"   input {20.0 * math.log10(max(level, 1e-5)):.0f} dB"
        lines = (
            f"{s['bpm']:.1f} bpm   measure {s['measure']}   beat {s['beat']} of {beats}",
            f"clock: {clock_in_words(s)}{heard}",
            f"frame {frame['p50']:.1f} ms   p99 {frame['p99']:.1f}   p99.9 {frame['p999']:.1f}   cpu {cpu:.1f}   "
            f"late {s['late_frames']}   skipped {s['skipped_ticks']}",
            f"dancers {s['dancers']}   events {s['events_accepted']}   refused {sum(s['events_rejected'].values())}   "
            f"phones {s['phones']}   memory {s['rss_mb']:.0f} MB",
        )
        more = self._show.score_runner.status_lines()
        more = (*more, f"pointer: {self.tool}") if self.tool else more
        waiting = s["words"]["waiting"]
        more = (*more, f"words wait: {', '.join(waiting)[:120]}") if waiting else more
        record = [f"{name}: {told['record']}" for name, told in s["behind"].items() if told["record"]]
        more = (*more, *tempo_line(s["off_tempo"]), *record[:1], *(explanation_lines(s["why"]) if s["why"] else ()))
        more = (*more, *(note for tell in self.notices if (note := self._calls.call(callback_name(tell), tell))))
        return (*lines, *more, f"last refused: {refusal}") if refusal else (*lines, *more)


SHOWN_SHARE: Final = 0.3
"""Another measure line is shown from this probability on."""


def clock_figures(follower: TimelineFollower) -> dict[str, Any]:
    """Return the figures of the clock other than tempo, beat and state."""
    jump = follower.last_jump
    return {
        "metre": follower.timeline.beats_per_measure,
        "clock_choice": follower.choice,
        "clock_sources": follower.states,
        "clock_jumps": follower.jumps,
        "clock_last_jump": None if jump is None else {"time": round(jump.time, 3), "cause": jump.cause},
        "count_in": follower.counting_in,
        "runner_up": {"beats_later": follower.runner_up[0], "share": round(follower.runner_up[1], 2)},
        "clock_asks": follower.asks,
        "source_measure": follower.source_measure + 1 if follower.source_measure >= 0 else None,
    }


def clock_in_words(figures: dict[str, Any]) -> str:
    """Return the overlay's line on the clock: source, state and confidence, and what it waits for."""
    words = [str(figures["source"])]
    if figures["source"] != "internal":
        words += [str(figures["clock_state"]), f"confidence {figures['confidence']:.0%}"]
    if figures["clock_choice"] not in ("auto", figures["source"]):
        words.append(f"waits for {figures['clock_choice']}")
    others = [name for name, state in figures["clock_sources"].items() if state == "locked"]
    others = [name for name in others if name not in (figures["source"], "internal", "tap")]
    if others:
        words.append(f"also {' and '.join(others)}")
    other = figures["runner_up"]
    if figures["clock_asks"]:
        words.append(f"IS THE ONE {other['beats_later']:g} BEATS LATER ({other['share']:.0%})? - takes it")
    elif other["share"] >= SHOWN_SHARE:
        words.append(f"or the one {other['beats_later']:g} beats later ({other['share']:.0%})")
    if figures["count_in"]:
        words.append(f"counting in: {figures['count_in']}")
    return ", ".join(words)


class StatusFile:
    """Writes a status line once a second in a thread of its own; lines lost to a full disk are counted."""

    def __init__(self, path: Path, status: Status, *, append: bool = False) -> None:
        """Raises OSError if the file cannot be made; `append`: append to an existing file."""
        self._writer = LineWriter(path, name="status", append=append)
        self._status = status
        self._next = 1.0

    @property
    def dropped(self) -> int:
        """Lines that could not be written."""
        return self._writer.dropped

    def frame(self, time: float) -> None:
        """Write the figures if a second has passed. Call it each frame."""
        if time < self._next:
            return
        self._next = float(int(time) + 1)
        self._writer.line(json.dumps(self._status.snapshot(time)))

    def close(self, time: float) -> None:
        """Write the last figures, unless they were just written, and close the file."""
        if time > self._next - 0.9:
            self._writer.line(json.dumps(self._status.snapshot(time)))
        self._writer.close()


HALFLIFE: Final = 2.0
"""Half-life of a late frame's weight [s]."""
FULL_PRESSURE_SHARE: Final = 0.1
"""Share of late frames that counts as full pressure: visible stutter."""


class Pressure:
    """Overload of the machine: 0 if every frame is in time, 1 if a tenth or more are late or the supervisor reports it.

    Thread: the show's.
    """

    def __init__(self) -> None:
        self._share = 0.0
        self._late = 0
        self._overload = 0.0

    @property
    def value(self) -> float:
        """0 to 1."""
        return max(min(self._share / FULL_PRESSURE_SHARE, 1.0), self._overload)

    def frame(self, late: int, seconds: float, overload: float = 0.0) -> None:
        """Update after each frame. `late`: late frames since the start; `seconds`: time since the last frame.

        `overload`: the supervisor's estimate, 0 to 1.
        """
        self._overload = overload
        kept = 0.5 ** (max(seconds, 0.0) / HALFLIFE)
        now = 1.0 if late > self._late else 0.0
        self._late = late
        self._share = kept * self._share + (1.0 - kept) * now
