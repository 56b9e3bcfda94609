"""Random variation of the dancers of a group: timing, amplitude and takes, drawn for every measure (T051-T060).

Draws depend only on the seed and the measure number, so a show is the same live, offline and replayed.
"""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int32, Int64
from live.base.errors import PersonError, error_context
from live.base.motion_parameters import (
    AMPLITUDE,
    AMPLITUDE_SEQUENCE,
    ARMS,
    LARGER,
    MIRRORED,
    MIX,
    MOODS,
    MOTION_PARAMETERS,
    TEXTURE,
    TURN_ON_SUPPORT,
    WARP,
    WARP_SEQUENCE,
)
from live.base.parameter import Parameter
from live.base.picture_parameters import PART_COUNT
from live.control.events.event import ControlEvent
from live.graph.takes import NO_TAKE
from live.motion.editing.time_warp import F_MAX, draw_measure_warps
from live.motion.pose.gather_kernels import MAX_SPEED_CHANGE, delay_phases
from live.motion.pose.mood_pose import TIME
from live.show.dancers.measure_state import MeasureState
from live.show.dancers.rng import Purpose, generator_for
from live.show.dancers.timing_offsets import MAX_DRIFT_FREQUENCY, Drift, Ripple, parse_ripple
from live.show.group.division import FREE, Division
from live.show.group.group_values import GroupValues
from live.show.patch.patch import Patch
from live.show.patch.section_base import parameter_number
from live.show.patch.section_motion import GroupSection


def section_values(patch: Patch, group: GroupSection) -> list[float]:
    """Return the motion parameters of a group: a key of its own counts before the one of the whole patch."""
    values, overlaid = [], {"motion": patch.motion_of(group), "mood": patch.mood_of(group)}
    for row in MOTION_PARAMETERS:
        table, _, key = row.patch.partition(".")
        own = None if table in overlaid else getattr(group, key)
        section = overlaid[table] if table in overlaid else getattr(patch, table)
        values.append(parameter_number(row, getattr(section, key) if own is None else own))
    return values


def group_values(patch: Patch) -> Float64:
    """Return the motion parameters of each group of a patch, shape (G, MOTION_SIZE).

    A group that mirrors another dances mirror images only; the other, unless its patch says so, dances none.
    """
    values = np.array([section_values(patch, section) for section in patch.group])
    names = [section.name for section in patch.group]
    for index, section in enumerate(patch.group):
        if section.like is None or not section.mirrored:
            continue
        values[index, MIRRORED.first] = 1.0
        leader = names.index(section.like)
        if values[leader, MIRRORED.first] == 0.0:
            values[leader, MIRRORED.first] = -1.0
    return values


MOOD_TIME: Final = 0.4
"""Time constant with which dancers follow a mood [s]."""
_MOOD_ROWS: Final = slice(MOODS[0].first, MOODS[-1].first + 1)
MAX_DELAY: Final = 0.95
"""Largest delay, as a share of a measure."""
MAX_DELAY_CHANGE: Final = 0.2
"""Largest change of a delay within one measure, as a share of a measure, where no warp changes the speed as well."""
MIN_SPEED: Final = 0.15
"""Lowest clip speed while a delay changes, as a share of the normal speed."""
MAX_DRIFT: Final = 0.12
"""Largest drift ahead or behind, as a share of a measure: less than the beat by which steps are decided."""


def ripples_of(patch: Patch) -> list[Ripple]:
    """Return the ripple of each group of a patch. Raises PersonError for a ripple with an unknown origin."""
    ripples = []
    for index, section in enumerate(patch.group):
        with error_context(f"group {section.name!r}", ("group", index, "ripple")):
            ripples.append(parse_ripple(section.ripple, section.ripple_beats))
    return ripples


class Variation:
    """Variation parameters of all groups, and the draws for every dancer and measure."""

    def __init__(
        self,
        values: Float64,
        group: Int32,
        *,
        seed: int,
        beats_per_measure: int,
        window: float,
        late: tuple[float, ...] = (),
        ripples: tuple[Ripple, ...] = (),
    ) -> None:
        """`values` (G, MOTION_SIZE): the parameters of each group. `group` (A,) is shared with the show, which calls
        `update_groups` when it or the division has changed.

        `late`: delay of each group [beats] (canon, T147), less than a measure; `ripples`: additional delays within
        each group.
        """
        self.values = np.zeros((PART_COUNT, values.shape[1]))
        """Parameters of each part, of which the groups are the first, shape (PART_COUNT, MOTION_SIZE)."""
        self.values[: len(values)] = values
        self.division = Division(group, len(values))
        """The parts of the groups, with values of their own."""
        self._group = group
        self._group_delays = np.array(late or [0.0] * len(values)) / beats_per_measure
        self._seed = seed
        self._beats = beats_per_measure
        self._window = window
        count = len(group)
        self.drift = Drift(count, seed)
        """Time warp of each dancer over the whole sequence (T056)."""
        self.measure = 0
        self.has_recordings = False
        """Whether there are recordings for the texture of upper bodies."""
        self.ripples = GroupValues(list(ripples or [Ripple()] * len(values)))
        """Ripples of groups and of selected dancers."""
        self._patch_values, self._patch_ripples = values.copy(), tuple(self.ripples.groups)  # as in the patch
        self.delays: Float64 = self._group_delays[group]
        """Intended delay of each dancer at the end of the present measure (canon and ripple), as a share of a measure,
        shape (A,)."""
        self._late_before = self.delays.copy()
        self._timing_source = self._previous_timing_source = np.arange(count, dtype=np.int32)
        self._paired: npt.NDArray[np.intp] = np.zeros(0, np.intp)
        self._even: Float64 = np.zeros(count)
        self._everybody: Int64 = np.arange(count)
        self.update_groups()
        self.mood: Float64 = self._of_dancers[_MOOD_ROWS].copy()
        """The moods as danced now, which follow those that are asked for, shape (6, A)."""

    @classmethod
    def of(cls, patch: Patch, group: Int32, *, seed: int, window: float) -> "Variation":
        """Create the variation of a patch; `group` (A,) as in the constructor."""
        beats = patch.clock.beats_per_measure
        return cls(
            group_values(patch),
            group,
            seed=seed,
            beats_per_measure=beats,
            window=window,
            late=tuple(float(section.beats_later % beats) for section in patch.group),
            ripples=tuple(ripples_of(patch)),
        )

    def update_groups(self) -> None:
        """Update the values of each dancer from the parts' parameters and members."""
        self.division.follow_groups()
        self._of_dancers: Float64 = np.ascontiguousarray(self.values[self.division.part].T)
        warp_sequence = self[WARP_SEQUENCE]
        self._drifts = bool(warp_sequence.any())
        # largest drift of each dancer [share of a measure], (A,)
        self._farthest: Float64 = np.minimum(self[WARP] / self._beats, MAX_DRIFT) * (warp_sequence != 0.0)

    def __getitem__(self, parameter: Parameter) -> Float64:
        """Return a parameter's value for each dancer, shape (A,); read only."""
        row: Float64 = self._of_dancers[parameter.first]
        return row

    def any(self, parameter: Parameter) -> bool:
        """Whether any dancer's value is not 0."""
        return bool(self._of_dancers[parameter.first].any())

    @property
    def sides(self) -> Int32:
        """Side that each dancer wants: -1 as made, 1 mirrored, 0 either, shape (A,)."""
        return np.sign(self[MIRRORED]).astype(np.int32)

    def edited_values(self, event: ControlEvent) -> dict[int, Any]:
        """Return the ripples by group and of dancers, see `EditablePart`."""
        return self.ripples.by_key()

    def restore_values(self, values: Mapping[int, Any]) -> None:
        """See `EditablePart`."""
        self.ripples.restore(values, len(self._group))

    def set_ripple(self, groups: list[int] | None, who: npt.NDArray[np.bool_], ripple: Ripple) -> None:
        """Set the ripple of whole groups, or (None) one of the dancers `who` (A,)."""
        if groups is None:
            self.ripples.set_dancers(who, ripple)
        for group in groups or ():
            self.ripples.set_group(group, ripple, self._group)

    def apply_patch(self, fresh: "Variation") -> None:
        """Apply the fields that differ between the old and the new patch. Values set live stay otherwise.

        `fresh` is the variation of a show with the new patch that has not run.
        """
        edited = fresh._patch_values != self._patch_values
        for part, group in enumerate(self.division.group_of.tolist()):
            if group != FREE:
                self.values[part, edited[group]] = fresh._patch_values[group, edited[group]]
        for index, (ripple, new_ripple) in enumerate(zip(self._patch_ripples, fresh._patch_ripples, strict=True)):
            if ripple != new_ripple:
                self.ripples.set_group(index, new_ripple, self._group)
        self._patch_values, self._patch_ripples, self._group_delays = (
            fresh._patch_values,
            fresh._patch_ripples,
            fresh._group_delays,
        )
        self._window = fresh._window
        self.update_groups()

    def check(self, parameter: Parameter, number: float) -> None:
        """Raise PersonError if a parameter cannot have this value in this show."""
        if parameter is TEXTURE and number > 0.0 and not self.has_recordings:
            raise PersonError("there are no recordings for the texture", "name them under [texture] in the patch")

    def set(self, parameter: Parameter, part: int, number: float) -> None:
        """Set a parameter of one group or part, by its index, for all later draws."""
        self.values[part, parameter.first] = number
        self.update_groups()

    def set_values(self, values: Float64) -> None:
        """Set the parameters of all parts, shape (PART_COUNT, MOTION_SIZE), for all later draws."""
        self.values[:] = values
        self.update_groups()

    def draw(self, measure: int, measure_state: MeasureState) -> None:
        """Write the variation of measure `measure` (from 0) into `measure_state`, whose nodes are chosen already."""
        count = len(self._group)
        chance = generator_for(self._seed, Purpose.MEASURE, measure)
        # everything is drawn for all dancers, so that no control changes the random numbers of another
        warps = draw_measure_warps(chance, count, window=self._window, a_max=0.0)
        amplitude, take, mix, arms = chance.uniform(0.0, 1.0, (4, count))
        most = self[WARP] / self._beats * (self[WARP_SEQUENCE] == 0.0)
        frequency = np.minimum(warps.frequency, F_MAX)
        steep = MAX_SPEED_CHANGE / (2.0 * np.pi * frequency)
        measure_state.warp[0] = np.minimum(most * chance.uniform(0.0, 1.0, count), steep)
        measure_state.warp[1:] = frequency, warps.start, warps.sign
        measure_state.warp[:] = measure_state.warp[:, self._timing_source]
        measure_state.on_support[:] = self[TURN_ON_SUPPORT]
        measure_state.take[:] = measure_state.graph.takes.draw(measure_state.node, take)
        takes = measure_state.take != NO_TAKE
        measure_state.take_share[0] = takes * self[MIX] * mix
        measure_state.take_share[0, self._paired] = 0.0
        measure_state.take_share[1] = np.maximum(measure_state.take_share[0], takes * (arms < self[ARMS]))
        measure_state.amplitude[:] = 1.0 + self[AMPLITUDE] * np.floor(3.0 * amplitude - 1.0)
        slow = self[AMPLITUDE_SEQUENCE] != 0.0
        if slow.any():
            measure_state.amplitude[0, slow] = self._slow_amplitude(measure)[slow]
            measure_state.amplitude[1, slow] = self._slow_amplitude(measure + 1)[slow]
        measure_state.amplitude *= 1.0 + self[LARGER]

    def _slow_amplitude(self, measure: int) -> Float64:
        """Amplitude at the line before `measure`, (A,): each value is used for two lines (T059).

        The monotone cubic (PCHIP) is flat between equal values, so it eases between different ones.
        """
        chance = generator_for(self._seed, Purpose.AMPLITUDE, measure // 2)
        return np.asarray(1.0 + self[AMPLITUDE] * (chance.integers(0, 3, len(self._group)) - 1.0))

    def begin_measure(self, measure: int) -> None:
        """Begin the measure `measure` (from 0)."""
        self.measure = measure
        self.drift.begin_measure(measure)

    def sequence_warp(self, fraction: float, rows: Int64 | None = None) -> Float64:
        """Drift of all dancers, (A,), or of `rows` (n,), at `fraction` of the measure [share of a measure], positive
        ahead."""
        rows = self._everybody if rows is None else rows
        ahead = np.empty(len(rows))
        self.drift.at(ahead, rows, fraction, self._farthest, self._previous_timing_source, self._timing_source)
        return ahead

    def follow_moods(self, dt: float) -> None:
        """Let the dancers' moods follow those that are asked for, a tick of `dt` [s]: nobody's pose jumps."""
        wanted = self._of_dancers[_MOOD_ROWS]
        if not np.array_equal(self.mood, wanted):
            self.mood += (wanted - self.mood) * (1.0 - np.exp(-dt / MOOD_TIME))
            near = np.abs(self.mood - wanted) < 1e-4
            self.mood[near] = wanted[near]

    # -- intended delays: canon and ripple ------------------------------------------------------------------------

    def phases(self, out: Float64, fraction: float, warp: Float64, rows: Int64 | None = None) -> tuple[float, float]:
        """Write the phases in a measure warped by `warp` (4, A) at `fraction` of the present one into `out` (A,).

        Drift and intended delays are included. With `rows` (n,), only for these dancers, into `out` (n,). Returns the
        lowest and the highest phase.
        """
        ahead, before, late = self._even, self._late_before, self.delays
        if rows is not None:
            warp, ahead, before, late = np.ascontiguousarray(warp[:, rows]), ahead[rows], before[rows], late[rows]
        if self._drifts:
            ahead = self.sequence_warp(fraction, rows)
        sudden = self.mood[TIME]
        turns = 2.0 * np.pi * self._beats if sudden.any() else 0.0
        sudden = sudden if rows is None else sudden[rows]
        return delay_phases(out, fraction, warp, self._window, ahead, before, late, sudden, turns)

    def update_delays(
        self,
        timing_source: Int32,
        place: npt.NDArray[np.floating],
        there: npt.NDArray[np.bool_],
        measure_state: MeasureState,
    ) -> None:
        """Set the delays at the end of the measure that begins, from the positions `place` (A, 2) [m].

        `timing_source` (A,) is the dancer whose timing each dancer uses (partners), `there` (A,) whether they are on
        the stage. Delays change no faster than the measure `measure_state`, with its warp, allows.
        """
        if timing_source is not self._timing_source:
            self._paired = np.flatnonzero(np.bincount(timing_source, minlength=len(timing_source))[timing_source] > 1)
        self._previous_timing_source, self._timing_source = self._timing_source, timing_source
        self._late_before[:] = self.delays
        if not (self._group_delays.any() or self.delays.any() or self.ripples.any(Ripple())):
            return
        late = self._group_delays[self._group] * self._beats
        for members, ripple in self.ripples.parts(self._group):
            rows = members[there[members]] if ripple.beats else ()
            if len(rows):
                late[rows] += ripple.delays(np.asarray(place, np.float64)[rows])
        late = np.minimum(late / self._beats, MAX_DELAY)[timing_source]
        steep = 2.0 * np.pi * measure_state.warp[0] * measure_state.warp[1]
        steep = steep + 2.0 * np.pi * MAX_DRIFT_FREQUENCY * self._farthest
        most = np.clip(
            (1.0 - MIN_SPEED - steep) / 1.5, 0.0, MAX_DELAY_CHANGE
        )  # an ease is 1.5 times as steep as a line
        self.delays += np.clip(late - self.delays, -most, most)
