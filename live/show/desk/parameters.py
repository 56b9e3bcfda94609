"""Parameter values of a show and their fades.

Fades count beats that pass while the show is not held. This row is the master copy for the picture. For the variation
of dancers `Variation` is the master copy, and fades write to it.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base import picture_parameters
from live.base.arrays import Bool, Float64
from live.base.errors import PersonError
from live.control.events.event import ControlEvent
from live.control.events.parameters import SetParameter
from live.show.dancers.variation import Variation
from live.show.desk.parameter_table import ROWS, ParameterTable, Slot
from live.show.group.division import FREE, dancer_words

if TYPE_CHECKING:
    from live.show.group.group_motion import GroupMotion

MIN_LIGHT_FADE_BEATS: Final = 0.125
"""Fade time of light that is set at once [beats]: quick, but no flash; cameras cut."""
PATCH_FADE_BEATS: Final = 4.0
"""Fade time of picture values from an edited patch [beats]."""
FOLLOW_SCORE: Final = picture_parameters.BY_ADDRESS["/dance/light/score"].first
"""Setting it gives all light back to the layer that follows the score."""
VARIATION_UPDATE_TICKS: Final = 4
"""Ticks between updates of `Variation` during a fade."""


class Parameters:
    """The values of one show. Thread: the show's."""

    def __init__(
        self, table: ParameterTable, start: Float64, variation: Variation, motion: "GroupMotion", *, beats: int
    ) -> None:
        """`start`: the picture's row from the patch, shape (picture.SIZE,); `beats` per measure."""
        self.table, self._measure_beats = table, beats
        self._variation, self._motion, self._division = variation, motion, variation.division
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
        self.claimed: Bool = np.zeros(table.size, np.bool_)
        """Whether each value was set by a hand, a cue, a scene or a look, so that no layer changes it, shape (P,)."""

    @property
    def picture(self) -> Float64:
        """The picture's present row, shape (picture.SIZE,): a view."""
        return self.value[: picture_parameters.ROW_SIZE]

    @property
    def fading(self) -> int:
        """Number of values that are fading."""
        return self._running

    # -- changes -----------------------------------------------------------------------------------------------

    def check_words(self, words: str) -> None:
        """Raise PersonError for a selection with unknown words."""
        self._motion.casting.select(words, self._motion.state.position)

    def slots(self, address: str, words: str = "*") -> list[Slot]:
        """Return the parameters at an address that the dancers selected by `words` have, after dividing groups where
        necessary; the one of the stage if it is no parameter of groups.

        PersonError for an unknown selection, if nobody is selected, and if there would be too many parts.
        """
        slots = self.table.find(address)
        if not slots[0].parameter.per_group:
            return slots
        casting = self._motion.casting
        groups = casting.groups_of(words)
        if groups is None:
            who = casting.select(words, self._motion.state.position)
            if not who.any():
                raise PersonError(f"{words!r}: nobody is there now", f"groups are {', '.join(casting.names)}")
            parts = self._divide(who)
        else:
            parts = self._division.parts_of(groups)
        return [self.table.slot(address, part) for part in parts]

    def _divide(self, who: Bool) -> list[int]:
        """Return the parts that are exactly the dancers `who` (A,); PersonError if there would be too many."""
        parts = self._division.divide(who, self._copy_part, self._is_like)
        self._variation.update_groups()
        return parts

    def _copy_part(self, old: int, new: int) -> None:
        """Give a new part the values and fades of the one that it is taken from."""
        self._variation.values[new] = self._variation.values[old]
        self._read_variation()
        there, here = self.table.part_places(old), self.table.part_places(new)
        rows = (
            self.value,
            self.start,
            self._from,
            self._goal,
            self._start_beat,
            self._length,
            self._fading,
            self.claimed,
        )
        for row in rows:
            row[here] = row[there]
        self._running = int(np.count_nonzero(self._fading))

    def _is_like(self, part: int, other: int) -> bool:
        """Whether two parts have the same values, and none of them fades."""
        self._read_variation()
        here, there = self.table.part_places(part), self.table.part_places(other)
        still = not self._fading[here].any() and not self._fading[there].any()
        return still and np.array_equal(self.value[here], self.value[there])

    def parts(self) -> Iterator[tuple[int, int, str]]:
        """Yield the parts of groups that have dancers: row, group, and the dancers as a selection."""
        division = self._division
        for part in range(division.group_count, picture_parameters.PART_COUNT if division.is_divided else 0):
            dancers = np.flatnonzero(division.part == part) + 1
            if len(dancers) and division.group_of[part] != FREE:
                yield part, int(division.group_of[part]), dancer_words(dancers.tolist())

    def with_parts(self, goals: Mapping[int, float]) -> dict[int, float]:
        """Return numbers of groups and the stage, by place, with the same numbers of the groups' parts."""
        found, division = dict(goals), self._division
        for part in range(division.group_count, picture_parameters.PART_COUNT if division.is_divided else 0):
            if division.group_of[part] == FREE:
                continue
            there, here = self.table.part_places(int(division.group_of[part])), self.table.part_places(part)
            found |= {
                int(place): goals[like]
                for like, place in zip(there.tolist(), here.tolist(), strict=True)
                if like in goals
            }
        return found

    def set(self, slot: Slot, numbers: Iterable[float], *, beats: float) -> None:
        """Fade one parameter to new numbers within `beats`; PersonError if it cannot have this value."""
        numbers = tuple(numbers)
        self._variation.check(slot.parameter, numbers[0])
        if slot.first >= picture_parameters.ROW_SIZE and beats <= 0.0:  # `Variation` has the master copy
            self._fading[slot.first] = False
            self._running = int(np.count_nonzero(self._fading))
            self._variation.set(slot.parameter, slot.part, numbers[0])
            return
        self.fade(dict(zip(slot.numbers, numbers, strict=True)), beats=beats)

    def release(self) -> None:
        """Let layers change all values again."""
        self.claimed[:] = False

    def begin_with(self, slot: Slot, numbers: Iterable[float]) -> None:
        """Let a picture parameter of a part have these numbers now and whenever the patch's own values return."""
        for place, number in zip(slot.numbers, numbers, strict=True):
            self.value[place] = self.start[place] = number
            self._fading[place] = False

    def fade(self, goals: Mapping[int, float], *, beats: float) -> None:
        """Fade numbers of the row, by place, to new values within `beats`; they are claimed."""
        self._read_variation()
        self.touched = True
        goals = self._directed(goals)
        self.claimed[list(goals)] = True
        if list(goals) == [FOLLOW_SCORE]:
            self.release()
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

    def _directed(self, goals: Mapping[int, float]) -> Mapping[int, float]:
        """Return goals after the rule of the camera director: who sets the camera takes it over, and a director who is
        switched on together with a camera finds its own way."""
        directed, director = picture_parameters.DIRECTED, picture_parameters.DIRECTOR
        if not any(place in directed for place in goals):
            return goals
        if goals.get(director, 0.0) >= 0.5:
            return {place: goal for place, goal in goals.items() if place not in directed}
        return {**goals, director: 0.0}

    def direct_camera(self, numbers: Float64) -> None:
        """Set the camera as its director has it: the numbers of `picture_parameters.DIRECTED`, shape (D,). Their fades
        end."""
        led = slice(picture_parameters.DIRECTED.start, picture_parameters.DIRECTED.stop)
        self.value[led] = numbers
        if self._running and self._fading[led].any():
            self._fading[led] = False
            self._running = int(np.count_nonzero(self._fading))

    def reset(self, *, beats: float) -> None:
        """Fade all values to those of the patch."""
        self.fade(dict(enumerate(self.start.tolist())), beats=beats)
        self.release()

    def apply_patch(self, fresh: "Parameters") -> None:
        """Fade picture values that changed in an edited patch within `NEW` beats; the others stay as set.

        `Variation` adopts its own changes.
        """
        whole = self.table.part_of < self._division.group_count
        changed = np.flatnonzero(whole & (fresh.start != self.start))
        changed = changed[changed < picture_parameters.ROW_SIZE]
        self.start = fresh.start.copy()
        for place, number in self.with_parts(dict(enumerate(fresh.start.tolist()))).items():
            self.start[place] = number
        if len(changed):
            goals = {int(place): float(self.start[place]) for place in changed}
            claimed = self.claimed.copy()
            self.fade(self.with_parts(goals), beats=PATCH_FADE_BEATS)
            self.claimed = claimed

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
        """Return the value or fade target of these numbers, by place."""
        self._read_variation()
        return {at: float(self._goal[at] if self._fading[at] else self.value[at]) for at in places}

    def edited_values(self, event: ControlEvent) -> Float64 | dict[int, float]:
        """Return values or fade targets by key, see `EditablePart`. Single parameters are frequent: only their own
        numbers are compared.

        A key is the place in the row. Dancers of parts have a key for each of their numbers, because their part may
        have been divided, or have ended, when it is restored.
        """
        divided = self._division.is_divided
        if type(event) is SetParameter and event.address in ROWS:
            places = [place for slot in self.table.find(event.address) for place in slot.numbers]
            if places[0] in picture_parameters.DIRECTED:
                places.append(picture_parameters.DIRECTOR)
            if divided or max(places) < picture_parameters.ROW_SIZE:
                return self.goals_at(places) | self._own_goals(self._indices(event.address))
        goals = self.goals()
        if not divided:
            return goals
        whole = np.flatnonzero(self.table.part_of < self._division.group_count)
        base = dict(zip(whole.tolist(), goals[whole].tolist(), strict=True))
        return base | self._own_goals(range(len(self.table.part_places(0))))

    def _indices(self, address: str) -> list[int]:
        """Return the indices of a parameter's numbers among those of a part."""
        places = self.table.part_places(0).tolist()
        slot = self.table.slot(address, 0)
        return [places.index(place) for place in slot.numbers] if slot.part >= 0 else []

    def _own_goals(self, indices: Sequence[int]) -> dict[int, float]:
        """Return these numbers of the dancers of parts, by key."""
        if not self._division.is_divided or not indices:
            return {}
        goals, part = self.goals(), self._division.part
        count = len(self.table.part_places(0))
        found: dict[int, float] = {}
        for dancer in np.flatnonzero(part >= self._division.group_count).tolist():
            numbers = goals[self.table.part_places(int(part[dancer]))]
            found |= {self.table.size + dancer * count + index: float(numbers[index]) for index in indices}
        return found

    def restore_values(self, values: Mapping[int, float | None]) -> None:
        """See `EditablePart`. A number that a dancer did not have before becomes that of the group."""
        goals: dict[int, float] = {}
        wanted: dict[tuple[int, float | None], list[int]] = {}
        count, now, division = len(self.table.part_places(0)), self.goals(), self._division
        for key, value in values.items():
            if key < self.table.size:
                if value is not None and self.table.part_of[key] < division.group_count:
                    goals[key] = value
                continue
            dancer, index = divmod(key - self.table.size, count)
            wanted.setdefault((index, value), []).append(dancer)
        found: list[tuple[Bool, int, float | None]] = []
        for (index, value), dancers in wanted.items():
            who = np.zeros(len(division.part), np.bool_)
            who[dancers] = True
            found.append((who, index, value))
            self._divide(who)
        goals = self.with_parts(goals)  # also for dancers who have left their group's row since
        for who, index, value in found:
            for part in np.unique(division.part[who]).tolist():
                group = int(division.group_of[part])
                there = int(self.table.part_places(group)[index])
                goals[int(self.table.part_places(part)[index])] = (
                    goals.get(there, float(now[there])) if value is None else value
                )
        self.fade(goals, beats=0.0)

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, beats: float) -> None:
        """Advance by `beats`."""
        if self.held:
            return
        self._turn_camera(beats)
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
        if len(eye):
            self._orbit(float(share[eye[0]]), float(eased[eye[0]]))
        self._fading[rows[done]] = False
        self._running -= int(np.count_nonzero(done))
        if len(rows) and rows[-1] >= picture_parameters.ROW_SIZE and (update_variation or done.any()):
            self._write_variation(rows[rows >= picture_parameters.ROW_SIZE])

    def _orbit(self, share: float, eased: float) -> None:
        """Move the camera around its target, not through it: distance, bearing and height change evenly.

        Orbits go on meanwhile: the present one becomes the new one. If the new view does not turn, the camera ends at
        its place.
        """
        eye, target = picture_parameters.EYE, picture_parameters.TARGET
        towards = self._goal if self._fading[target.start] else self.value
        begin = self._from if self._fading[target.start] else self.value
        turned, ahead = self._turns(share)
        a, b = self._from[eye] - begin[target], self._goal[eye] - towards[target]
        far_a, far_b = math.hypot(a[0], a[2]), math.hypot(b[0], b[2])
        bearing_a = math.atan2(a[0], a[2]) if far_a > 1e-6 else math.atan2(b[0], b[2])
        bearing_b = math.atan2(b[0], b[2]) - ahead
        turn = math.remainder(bearing_b - bearing_a, math.tau) if far_b > 1e-6 else 0.0
        if share >= 1.0:
            if turned:
                self.value[eye] = turn_eye(self._goal[eye], towards[target], turned - ahead)
            return
        far, bearing = far_a + (far_b - far_a) * eased, bearing_a + turn * eased + turned
        height = a[1] + (b[1] - a[1]) * eased
        self.value[eye] = self.value[target] + (far * math.sin(bearing), height, far * math.cos(bearing))

    def _turns_itself(self) -> bool:
        """Whether the camera's place and its orbit are in one fade, which turns the camera then."""
        eye, orbit = picture_parameters.EYE.start, picture_parameters.ORBIT
        return bool(
            self._fading[eye]
            and self._fading[orbit]
            and self._start_beat[eye] == self._start_beat[orbit]
            and self._length[eye] == self._length[orbit]
        )

    def _turns(self, share: float) -> tuple[float, float]:
        """Return how far orbits have turned the camera in this fade, and how far they will have at its end [rad].

        The second is 0 if the new view turns: it is there at any angle.
        """
        if not self._turns_itself():
            return 0.0, 0.0
        orbit = picture_parameters.ORBIT
        whole = math.tau * float(self._length[orbit]) / self._measure_beats
        before, after = float(self._from[orbit]) * whole, float(self._goal[orbit]) * whole
        eased = share**3 - 0.5 * share**4  # the integral of the easing
        return before * share + (after - before) * eased, 0.0 if after else 0.5 * before

    def _turn_camera(self, beats: float) -> None:
        """Turn the camera, and its running fade, around its target, as far as its orbit goes in so many beats."""
        eye, target = picture_parameters.EYE, picture_parameters.TARGET
        rate = float(self.value[picture_parameters.ORBIT])
        if not rate or self._turns_itself():
            return
        angle = math.tau * rate * beats / self._measure_beats
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
