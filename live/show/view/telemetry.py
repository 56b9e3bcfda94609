"""Telemetry of a running show: outgoing notices (Timeline, measures, steps, footfalls, positions) and the current
value of every control, by address."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import StageView
from live.clock.timeline import Timeline
from live.control.events.events import NotesHeard
from live.control.registry.control import ArgumentValue
from live.control.registry.registry import STATUS, Rows
from live.show.capture.capture_manager import SETTINGS
from live.show.dancers.footfalls import FootfallDetector
from live.show.desk.parameter_table import ROWS, Slot
from live.show.partner.partner_pairs import PartnerSettings
from live.show.show import Show
from live.show.view.status import Status

NOTICES_PER_FRAME: Final = 64
"""Maximum number of step and foot notices sent per frame; the rest follows in the next frames."""
BEAT_TOLERANCE: Final = 1e-6
"""Tolerance for two Timelines to count as equal [beats]."""
MAX_ROWS: Final = 1000
_SIDES: Final = ("left", "right")

Notice = tuple[str, Any]


class Telemetry:
    """Collects notices about one show after each frame; read-only. Thread: the show's."""

    def __init__(self, show: Show, *, positions: float = 10.0, feet: bool = True) -> None:
        """`positions`: how often positions are sent [1/s]; 0: never."""
        self._show, self._positions = show, positions
        self._feet = FootfallDetector(show) if feet else None
        self._timeline: Timeline | None = None
        self._measure = (-1, 0.0)
        self._step: npt.NDArray[np.int32] = np.full(len(show.group), -1, np.int32)
        self._names: tuple[str, ...] = ()
        self._waiting: list[tuple[str, tuple[Any, ...]]] = []
        self._time = -1.0
        self._due = 0.0
        self._units = 0
        self.dropped = 0
        """Step and foot notices dropped because there were too many."""

    def reset(self) -> None:
        """Send Timeline and measure again, for a new receiver."""
        self._timeline = None
        self._measure = (-1, 0.0)

    def frame(self, view: StageView) -> list[Notice]:
        """Return the notices after the frame for which `view` was filled."""
        show = self._show
        told: list[Notice] = []
        measure = (show.span.number, show.span.end)
        if measure != self._measure:
            self._measure = measure
            told.append(("measure", measure))
        timeline = show.timeline
        if self._timeline is None or not _same_timeline(timeline, self._timeline, show.time):
            self._timeline = timeline
            told.append(("timeline", (timeline.tempo, timeline.beat_origin, timeline.time_origin,
                                      timeline.beats_per_measure, timeline.measure_origin)))  # fmt: skip
        self._add_steps(view)
        self._add_units()
        if self._feet is not None and view.filled and view.time > self._time:
            for fall in self._feet.detect(view):
                values = (fall.dancer + 1, _SIDES[fall.foot], *fall.place, fall.strength, fall.part)
                self._waiting.append(("foot", values))
        self._time = view.time
        if self._waiting:
            told.append(("news", self._waiting[:NOTICES_PER_FRAME]))
            rest = self._waiting[NOTICES_PER_FRAME:]
            self.dropped += max(len(rest) - MAX_ROWS, 0)
            self._waiting = rest[:MAX_ROWS]
        if self._positions and view.time >= self._due:
            self._due = view.time + 1.0 / self._positions
            told.append(("positions", position_rows(view)))
        return told

    def _add_units(self) -> None:
        """Add notices of the units that responding partners dance."""
        answering = self._show.dancers.partner_response
        if answering is None or answering.leaders.unit_count == self._units:
            return
        for number, partner, label in answering.leaders.recent_units:
            if number > self._units:
                self._waiting.append(("unit", (partner, label, label.rpartition("/")[0])))
        self._units = answering.leaders.unit_count

    def _add_steps(self, view: StageView) -> None:
        """Add notices of dancers that begin another step."""
        library = self._show.graph.library
        step = library.node_step[self._show.dancers.node]
        if library.steps != self._names:
            self._names = library.steps
        begun = np.flatnonzero((step != self._step) & view.present)
        if not len(begun):
            return
        self._step[begun] = step[begun]
        for dancer in begun.tolist():
            values = (dancer + 1, self._names[step[dancer]], self._show.patch.group[self._show.group[dancer]].name)
            self._waiting.append(("step", values))


def _same_timeline(one: Timeline, other: Timeline, time: float) -> bool:
    """Whether two Timelines are equal from `time` [s] on, for a listener to the beats."""
    same_lines = one.beats_per_measure == other.beats_per_measure and one.measure_origin == other.measure_origin
    return same_lines and one.tempo == other.tempo and abs(one.beat_at(time) - other.beat_at(time)) < BEAT_TOLERANCE


def position_rows(view: StageView) -> bytes:
    """Return rows (number from 1, x, z [m], heading [rad]) of the dancers on the stage, as float32 bytes."""
    there = np.flatnonzero(view.present)[:MAX_ROWS]
    w, x, y, z = view.joint_rotation[there, 0].T
    hips = view.joint_position[there, 0]
    heading = np.arctan2(2.0 * (x * z + w * y), 1.0 - 2.0 * (x * x + y * y))
    return np.column_stack((there + 1, hips[:, 0], hips[:, 2], heading)).astype(np.float32).tobytes()


SIGNIFICANT_DIGITS: Final = 6
"""Significant digits of a value. More are of no use to a person, and would make every value a change."""
PERCENTILE_INTERVAL: Final = 16
"""The frame percentile is recomputed once in this many calls."""


class CurrentValues:
    """Current values of one show, by address; read-only. Thread: the show's."""

    def __init__(self, show: Show, status: Status) -> None:
        self._show, self._status = show, status
        self.extra_values: dict[str, Callable[[], ArgumentValue | None]] = {}
        """Values of other parts, by address; None: no value now."""
        table = show.desk.parameters.table
        self._found: list[tuple[str, list[Slot]]] = [(address, table.find(address)) for address in ROWS]
        self._row: npt.NDArray[np.float64] = np.zeros(0)
        self._names: tuple[str, ...] = ()
        self._rows: dict[str, Rows] = {}
        self._call_count = 0
        self._frame_ms = 0.0

    def changes(self) -> dict[str, Rows]:
        """Return the values that have changed since the last call; all at the first call."""
        found = self._parameters()
        for address, values in self._show_values().items():
            found[address] = (("", values),)
        found |= self._partners() | self._mocap() | self._answers()
        new = {address: rows for address, rows in found.items() if self._rows.get(address) != rows}
        self._rows.update(new)
        return new

    def _parameters(self) -> dict[str, Rows]:
        """Return the parameters with a changed value."""
        parameters = self._show.desk.parameters
        row, names = parameters.snapshot(), parameters.table.group_names
        if len(row) == len(self._row) and names == self._names:
            moved = set(np.flatnonzero(row != self._row).tolist())
            if not moved:
                return {}
        else:
            moved = set(range(len(row)))
        self._row, self._names = row, names
        found: dict[str, Rows] = {}
        for address, those in self._found:
            if any(place in moved for one in those for place in one.numbers):
                found[address] = self._parameter_rows(those)
        return found

    def _parameter_rows(self, those: list[Slot]) -> Rows:
        """Return one value if all groups have the same, else one per group."""
        known = those[0].parameter
        as_said: Callable[[float], ArgumentValue] = bool if known.kind == "switch" else _round
        if known.kind == "names":
            as_said = known.names_of_number
        values = [tuple(as_said(self._row[place]) for place in one.numbers) for one in those]
        if all(value == values[0] for value in values):
            return (("", values[0]),)
        return tuple((self._names[one.part], value) for one, value in zip(those, values, strict=True))

    def _partners(self) -> dict[str, Rows]:
        """Return the settings of partner responses; defaults if there are none."""
        answering = self._show.dancers.partner_response
        asked = [] if answering is None else answering.settings
        keys: dict[str, Callable[[PartnerSettings], ArgumentValue]] = {
            "on": lambda one: one.on, "amount": lambda one: _round(one.amount),
            "stretch": lambda one: _round(one.window), "hands": lambda one: _round(one.hands),
            "style": lambda one: one.style,
        }  # fmt: skip
        nobody: dict[str, ArgumentValue] = {"on": False, "amount": 0.0, "stretch": 0.0, "hands": 0.0, "style": ""}
        return {
            f"/dance/partner/{key}": tuple((one.name, (tell(one),)) for one in asked) or (("", (nobody[key],)),)
            for key, tell in keys.items()
        }

    def _answers(self) -> dict[str, Rows]:
        """Return the settings of the answers to performers' steps; defaults if there are none."""
        said = self._show.seen_steps.settings()
        nobody: tuple[ArgumentValue, ...] = (False, "same", "*")
        return {
            f"/dance/answer/{key}": tuple((name, (now[place],)) for name, now in said.items())
            or (("", (nobody[place],)),)
            for place, key in enumerate(("on", "how", "group"))
        }

    def _mocap(self) -> dict[str, Rows]:
        """Return the settings of captured performers; empty if there are none."""
        said = {name: captured.current_settings for name, captured in self._show.mocap.performers.items()}
        return {
            f"/dance/mocap/{what}": tuple((name, tuple(map(_rounded, now[what]))) for name, now in said.items())
            for what in (SETTINGS if said else ())
        }

    def _show_values(self) -> dict[str, tuple[ArgumentValue, ...]]:
        """Return the values of the whole show."""
        show, status = self._show, self._status
        follower, desk, prompter = show.follower, show.desk, show.score_runner
        width, depth = (2.0 * show.motion.stage_area.half).tolist()
        beats = show.timeline.beats_per_measure
        count_in = desk.cues.count_in(show.danced_beats)
        playhead = prompter.playhead
        place = playhead.place(playhead.measure)
        if self._call_count % PERCENTILE_INTERVAL == 0:
            (self._frame_ms,) = status.frame_times.percentiles(99)
        self._call_count += 1
        standby = desk.cues.standby_name
        singles: dict[str, Any] = {
            "/dance/clock/tempo": _round(follower.tempo),
            "/dance/clock/hold": follower.held,
            "/dance/clock/metre": float(beats),
            "/dance/clock/source": follower.choice,
            "/dance/blackout": show.blackout,
            "/dance/hold": desk.held,
            "/dance/hold/score": playhead.held,
            "/dance/audience/open": show.audience.open,
            "/dance/audience/gain": _round(show.audience.gain),
            "/dance/audience/mute": show.audience.muted,
            "/dance/audience/shake": show.audience.shaking,
            "/dance/audience/tally": show.audience.tally,
            "/dance/output/fade": _round(desk.master.level),
            "/dance/output/freeze": desk.master.frozen,
            "/dance/output/flashes": desk.master.flashes,
            STATUS + "measure": show.span.number + 1,
            STATUS + "beat": min(int(show.span.fraction(show.timeline.beat_at(show.time)) * beats) + 1, beats),
            STATUS + "bpm": round(follower.tempo, 2),
            STATUS + "source": follower.source,
            STATUS + "clock": str(follower.state),
            STATUS + "clock_asks": follower.runner_up[0] if follower.asks else 0.0,
            STATUS + "dancers": int(np.count_nonzero(show.motion.present)),
            STATUS + "phones": show.audience.phones,
            STATUS + "section": playhead.section_name(place),
            STATUS + "cue": standby,
            STATUS + "seen_step": show.seen_steps.words(),
            STATUS + "count_in": 0.0 if count_in is None else round(min(max(count_in[0], 0.0), 1e6), 1),
            **_notes(prompter.mood.notes),
            STATUS + "fading": desk.parameters.fading,
            STATUS + "frame_ms": self._frame_ms,
            STATUS + "late_frames": status.late_frames,
            STATUS + "accepted": status.events_accepted,
            STATUS + "refused": status.refused_count(),
        }
        told: dict[str, tuple[ArgumentValue, ...]] = {address: (value,) for address, value in singles.items()}
        told["/dance/stage"] = (_round(width), _round(depth))
        for address, tell in self.extra_values.items():
            value = tell()
            if value is not None:
                told[address] = (value,)
        return told


def _notes(played: NotesHeard | None) -> dict[str, Any]:
    """Return the figures of the notes played over MIDI."""
    return {
        STATUS + "note_energy": 0.0 if played is None else round(played.energy, 3),
        STATUS + "note_density": 0.0 if played is None else round(played.density, 3),
        STATUS + "notes": 0 if played is None else played.chord,
        STATUS + "pitch": 0.5 if played is None else round(played.pitch, 3),
    }


def _rounded(value: ArgumentValue) -> ArgumentValue:
    return _round(value) if type(value) is float else value


def _round(value: float) -> float:
    return float(f"{value:.{SIGNIFICANT_DIGITS}g}")
