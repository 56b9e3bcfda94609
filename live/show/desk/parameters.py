"""Parameter values of a show and their fades.

Fades count beats that pass while the show is not held. This row is the master copy for the picture. For the variation
of dancers `Variation` is the master copy, and fades write to it.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base import picture_parameters
from live.base.arrays import Float64
from live.control.events.event import ControlEvent
from live.control.events.parameters import SetParameter
from live.show.dancers.variation import Variation
from live.show.desk.parameter_table import ParameterTable, Slot

MIN_LIGHT_FADE_BEATS: Final = 0.125
"""Fade time of light that is set at once [beats]: quick, but no flash; cameras cut."""
PATCH_FADE_BEATS: Final = 4.0
"""Fade time of picture values from an edited patch [beats]."""
VARIATION_UPDATE_TICKS: Final = 4
"""Ticks between updates of `Variation` during a fade."""


class Parameters:
    """The values of one show. Thread: the show's."""

    def __init__(self, table: ParameterTable, start: Float64, variation: Variation) -> None:
        """`start`: the picture's row from the patch, shape (picture.SIZE,)."""
        self.table = table
        self._variation = variation
        self.value: Float64 = np.zeros(table.size)
        """All present values, shape (P,)."""
        self.value[: picture_parameters.ROW_SIZE] = start
        self._read_variation()
        self.start: Float64 = self.value.copy()
        """Values of the patch, shape (P,)."""
        self._from, self._goal = self.value.copy(), self.value.copy()
        self._start_beat, self._length = np.zeros(table.size), np.ones(table.size)
        self._fading = np.zeros(table.size, np.bool_)
        self._running = self._ticks = 0
        self.beat = 0.0
        """Beats that have passed while the show was not held."""
        self.held = False
        """Whether fades stand still."""
        self.touched = False
        """Whether anything was ever set here or faded."""

    @property
    def picture(self) -> Float64:
        """The picture's present row, shape (picture.SIZE,): a view."""
        return self.value[: picture_parameters.ROW_SIZE]

    @property
    def fading(self) -> int:
        """Number of values that are fading."""
        return self._running

    # -- changes -----------------------------------------------------------------------------------------------

    def set(self, slot: Slot, numbers: Iterable[float], *, beats: float) -> None:
        """Fade one parameter to new numbers within `beats`; PersonError if it cannot have this value."""
        numbers = tuple(numbers)
        self._variation.check(slot.parameter, numbers[0])
        if slot.first >= picture_parameters.ROW_SIZE and beats <= 0.0:  # `Variation` has the master copy
            self._fading[slot.first] = False
            self._running = int(np.count_nonzero(self._fading))
            self._variation.set(slot.parameter, slot.group, numbers[0])
            return
        self.fade(dict(zip(slot.numbers, numbers, strict=True)), beats=beats)

    def fade(self, goals: Mapping[int, float], *, beats: float) -> None:
        """Fade numbers of the row, by place, to new values within `beats`."""
        self._read_variation()
        self.touched = True
        at_once: list[int] = []
        for place, goal in goals.items():
            light = (
                place < picture_parameters.ROW_SIZE
                and not picture_parameters.CAMERA.start <= place < picture_parameters.CAMERA.stop
            )
            length = 0.0 if place in self.table.switches else max(beats, MIN_LIGHT_FADE_BEATS) if light else beats
            self._fading[place] = fades = length > 1e-9
            if not fades:
                self.value[place] = goal
                at_once.append(place)
                continue
            self._from[place], self._goal[place] = self.value[place], goal
            self._start_beat[place], self._length[place] = self.beat, length
        self._running = int(np.count_nonzero(self._fading))
        told = [place for place in at_once if place >= picture_parameters.ROW_SIZE]
        if told:
            self._write_variation(np.array(told, np.intp))

    def reset(self, *, beats: float) -> None:
        """Fade all values to those of the patch."""
        self.fade(dict(enumerate(self.start.tolist())), beats=beats)

    def apply_patch(self, fresh: "Parameters") -> None:
        """Fade picture values that changed in an edited patch within `NEW` beats; the others stay as set.

        `Variation` adopts its own changes.
        """
        changed = np.flatnonzero(
            fresh.start[: picture_parameters.ROW_SIZE] != self.start[: picture_parameters.ROW_SIZE]
        )
        self.start = fresh.start
        if len(changed):
            self.fade({int(place): float(self.start[place]) for place in changed}, beats=PATCH_FADE_BEATS)

    def snapshot(self) -> Float64:
        """Return all present values, shape (P,): a copy; the state does not change."""
        row = self.value.copy()
        row[picture_parameters.ROW_SIZE :] = self._variation.values.ravel()
        return row

    def goals(self) -> Float64:
        """Return the value or fade target of all numbers, shape (P,): a copy."""
        self._read_variation()
        return np.where(self._fading, self._goal, self.value)

    def goals_at(self, places: Iterable[int]) -> dict[int, float]:
        """Return the value or fade target of these numbers of the picture, by place."""
        return {at: float(self._goal[at] if self._fading[at] else self.value[at]) for at in places}

    def edited_values(self, event: ControlEvent) -> Float64 | dict[int, float]:
        """Return values or fade targets by place in the row, see `EditablePart`. Values of the picture are
        frequent: only their own numbers are compared."""
        if type(event) is SetParameter:
            places = self.table.places(event.address, event.group)
            if places and max(places) < picture_parameters.ROW_SIZE:
                return self.goals_at(places)
        return self.goals()

    def restore_values(self, values: Mapping[int, float]) -> None:
        """See `EditablePart`."""
        self.fade(values, beats=0.0)

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, beats: float) -> None:
        """Advance by `beats`."""
        if self.held:
            return
        self.beat += beats
        self._ticks += 1
        if self._running:
            self._move(update_variation=self._ticks % VARIATION_UPDATE_TICKS == 0)

    def _move(self, *, update_variation: bool) -> None:
        """Update all fading values."""
        rows = self._fading.nonzero()[0]
        share = np.clip((self.beat - self._start_beat[rows]) / self._length[rows], 0.0, 1.0)
        eased = share * share * (3.0 - 2.0 * share)
        done = share >= 1.0
        goal = self._goal[rows]
        self.value[rows] = np.where(done, goal, self._from[rows] + (goal - self._from[rows]) * eased)
        eye = (rows == picture_parameters.EYE.start).nonzero()[0]
        if len(eye) and not done[eye[0]]:
            self._orbit(float(eased[eye[0]]))
        self._fading[rows[done]] = False
        self._running -= int(np.count_nonzero(done))
        if len(rows) and rows[-1] >= picture_parameters.ROW_SIZE and (update_variation or done.any()):
            self._write_variation(rows[rows >= picture_parameters.ROW_SIZE])

    def _orbit(self, share: float) -> None:
        """Move the camera around its target, not through it: distance, bearing and height change evenly."""
        eye, target = picture_parameters.EYE, picture_parameters.TARGET
        towards = self._goal if self._fading[target.start] else self.value
        begin = self._from if self._fading[target.start] else self.value
        a, b = self._from[eye] - begin[target], self._goal[eye] - towards[target]
        far_a, far_b = math.hypot(a[0], a[2]), math.hypot(b[0], b[2])
        bearing_a = math.atan2(a[0], a[2]) if far_a > 1e-6 else math.atan2(b[0], b[2])
        turn = math.remainder(math.atan2(b[0], b[2]) - bearing_a, math.tau) if far_b > 1e-6 else 0.0
        far, bearing = far_a + (far_b - far_a) * share, bearing_a + turn * share
        height = a[1] + (b[1] - a[1]) * share
        self.value[eye] = self.value[target] + (far * math.sin(bearing), height, far * math.cos(bearing))

    def turn_camera(self, angle: float) -> None:
        """Turn the camera, and its running fade, around its target by `angle` [rad]."""
        eye, target = picture_parameters.EYE, picture_parameters.TARGET
        for row in (self.value, self._from, self._goal) if self._fading[eye.start] else (self.value,):
            around = row if self._fading[target.start] else self.value
            row[eye] = turn_eye(row[eye], around[target], angle)

    # -- variation of dancers ----------------------------------------------------------------------------------

    def _read_variation(self) -> None:
        """Copy the groups' variation into the row, because an edited patch sets it too."""
        self.value[picture_parameters.ROW_SIZE :] = self._variation.values.ravel()

    def _write_variation(self, rows: npt.NDArray[np.intp]) -> None:
        """Write the variation to `Variation`; only numbers in `rows` change."""
        new = self.value[rows]
        self._read_variation()
        self.value[rows] = new
        self._variation.set_values(self.value[picture_parameters.ROW_SIZE :].reshape(self._variation.values.shape))


def turn_eye(eye: Float64, target: Float64, angle: float) -> Float64:
    """Return an eye position turned around its target by `angle` [rad], from +z towards +x."""
    cos, sin = math.cos(angle), math.sin(angle)
    x, z = float(eye[0] - target[0]), float(eye[2] - target[2])
    return np.array([target[0] + cos * x + sin * z, eye[1], target[2] + cos * z - sin * x])
