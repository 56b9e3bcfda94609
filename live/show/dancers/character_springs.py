"""Springs of the dancers' characters: hair, skirts and tails of files, advanced at ticks.

They hang from the poses of the tick. If there are more bones than `MAX_BONES`, the dancers nearest to the camera have
theirs; those of the others come to rest. Whoever appears, jumps or comes back after skipped ticks begins at rest.

Nothing in the show depends on them, so they are no part of its hash: a replay without the files of the characters is
still a replay of the show.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Bool, Float32, Int32, Int64
from live.base.picture_parameters import EYE, TARGET
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.motion.cloth.spring_kernels import mix_springs, swing
from live.motion.cloth.spring_rig import SpringRig
from live.motion.skeleton import SKELETON

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.desk.light_desk import LightDesk
    from live.show.group.group_motion import GroupMotion
    from live.show.stages.now import Now

MAX_BONES: Final = 4096
"""Maximum number of bones that swing at a time: 100 dancers of 40."""
MAX_DANCERS: Final = 200
"""Maximum number of dancers whose bones swing at a time."""
CHOICE_TICKS: Final = 16
"""Ticks between two choices of the dancers whose bones swing."""
NEARNESS_KEPT: Final = 0.8
"""Who swings counts as nearer by this factor, so that the choice does not alternate."""
FADE_TICKS: Final = 32
"""Ticks until the bones of a dancer who is not chosen any more are at rest."""
JUMP: Final = 0.5
"""A dancer whose hips move farther in a tick [m] begins at rest."""
_BEHIND: Final = 1e3
_REST: Final = np.ascontiguousarray(SKELETON.rest_positions(), np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class SpringCast:
    """Who wears which springs."""

    rigs: tuple[SpringRig, ...]
    rig_of: Int32
    """Each dancer's, -1: none; shape (A,)."""

    @staticmethod
    def of(rig_of_body: Mapping[str, SpringRig], bodies: Sequence[str], dancer_count: int) -> "SpringCast":
        """Return the springs that dancers wear; `bodies`: names from the first dancer on, `rig_of_body`: springs of
        characters."""
        worn = [name for name, rig in rig_of_body.items() if rig.count and name in bodies]
        rig_of = np.full(dancer_count, -1, np.int32)
        for dancer, name in enumerate(bodies[:dancer_count]):
            if name in worn:
                rig_of[dancer] = worn.index(name)
        return SpringCast(tuple(rig_of_body[name] for name in worn), rig_of)

    def notes(self) -> tuple[str, ...]:
        """Return a note if not all bones can swing at a time."""
        sizes = [rig.count for rig in self.rigs]
        bones = sum(sizes[rig] for rig in self.rig_of.tolist() if rig >= 0)
        dancers = int((self.rig_of >= 0).sum())
        if bones <= MAX_BONES and dancers <= MAX_DANCERS:
            return ()
        return (
            f"the characters of {dancers} dancers have {bones} bones that swing; {MAX_BONES} of at most {MAX_DANCERS} "
            "dancers do at a time: of those nearest to the camera",
        )


class CharacterSprings:
    """The springs of all dancers of one show, in slots: whoever swings has one. Thread: the show's."""

    def __init__(self, cast: SpringCast, dancers: "Dancers", motion: "GroupMotion", desk: "LightDesk") -> None:
        self.cast = cast
        self._dancers, self._motion, self._desk = dancers, motion, desk
        self._begin()

    def _begin(self) -> None:
        """Free all slots, in arrays of the rigs' sizes."""
        slots, bones = self.slot_count, self.bone_count
        self._time, self._ticks = 0.0, 0
        self._chosen: Bool = np.zeros(len(self.cast.rig_of), np.bool_)
        self._dancer: Int32 = np.full(slots, -1, np.int32)
        """Dancer of each slot, -1: it is free."""
        self._level: Float32 = np.zeros(slots, np.float32)
        """Share of its motion that each slot shows, 0: at rest."""
        self._running: Bool = np.zeros(slots, np.bool_)
        self._hips: Float32 = np.zeros((slots, 2), np.float32)
        self._now, self._before = np.zeros((slots, bones, 3), np.float32), np.zeros((slots, bones, 3), np.float32)
        self._turn, self._turn_before = self._at_rest(), self._at_rest()

    def check_sizes(self) -> None:
        """Begin at rest if a snapshot's arrays are of other files than those that were read."""
        slots, bones = self.slot_count, self.bone_count
        wanted = (
            (slots,), (slots,), (slots,), (slots, 2), (slots, bones, 3), (slots, bones, 3), (slots, bones, 4),
            (slots, bones, 4),
        )  # fmt: skip
        state = (
            self._dancer, self._level, self._running, self._hips, self._now, self._before, self._turn,
            self._turn_before,
        )  # fmt: skip
        dancers = self._dancer[self._dancer >= 0]
        worn = (self.cast.rig_of[dancers] >= 0).all() if (dancers < len(self.cast.rig_of)).all() else False
        if not worn or any(array.shape != shape for array, shape in zip(state, wanted, strict=True)):
            self._begin()

    @property
    def bone_count(self) -> int:
        """Most bones of a rig."""
        return max((rig.count for rig in self.cast.rigs), default=0)

    @property
    def slot_count(self) -> int:
        """Number of dancers that can swing at a time, with those who come to rest."""
        return min(int((self.cast.rig_of >= 0).sum()), 2 * MAX_DANCERS)

    @property
    def resting(self) -> int:
        """Number of dancers on the stage whose springs rest because there are too many."""
        return int(((self.cast.rig_of >= 0) & self._motion.present & ~self._chosen).sum())

    def tick(self, now: "Now", fraction: float) -> None:
        """Advance all springs to the tick `now`, in which dancers are at `fraction` of the measure."""
        if not self.cast.rigs:
            return
        skipped, self._time = now.time - self._time > 1.5 * TICK, now.time
        if self._ticks % CHOICE_TICKS == 0:
            self._choose()
        self._ticks += 1
        self._assign()
        slots = np.flatnonzero(self._dancer >= 0)
        slots = slots[self._motion.present[self._dancer[slots]]]
        rows, hips = self._dancer[slots], self._dancers.drawn_hips
        starting = ~self._running[slots] | (np.abs(hips[rows] - self._hips[slots]).max(axis=1, initial=0.0) > JUMP)
        self._running[:] = False
        self._running[slots], self._hips[slots] = True, hips[rows]
        if not len(rows):
            return
        position, rotation = self._dancers.drawn_poses(rows, fraction, now.time)
        for number, rig in enumerate(self.cast.rigs):
            mine = np.flatnonzero(self.cast.rig_of[rows] == number)
            if len(mine):
                self._swing(rig, slots[mine], position[mine], rotation[mine], starting[mine] | skipped)

    def _assign(self) -> None:
        """Free the slots of those who have come to rest, and give free ones to those who are chosen."""
        worn = self._dancer >= 0
        chosen = worn & self._chosen[self._dancer]
        self._level[worn] = np.where(chosen[worn], 1.0, np.maximum(self._level[worn] - 1.0 / FADE_TICKS, 0.0))
        self._dancer[self._level <= 0.0] = -1
        without = self._chosen.copy()
        without[self._dancer[self._dancer >= 0]] = False
        free, new = np.flatnonzero(self._dancer < 0), np.flatnonzero(without)
        count = min(len(free), len(new))
        self._dancer[free[:count]], self._level[free[:count]] = new[:count], 1.0
        self._running[free] = False

    def _swing(self, rig: SpringRig, slots: Int64, position: Float32, rotation: Float32, start: Bool) -> None:
        count = rig.count
        tips, tips_before = self._now[slots, :count], self._before[slots, :count]
        turn = np.empty((len(slots), count, 4), np.float32)
        swing(
            position, rotation, _REST, rig.parent, rig.joint, rig.centre, rig.head, rig.tail, rig.setting, rig.hits,
            rig.collider_joint, rig.collider, start.astype(np.uint8), TICK, tips, tips_before, turn,
        )  # fmt: skip
        self._now[slots, :count], self._before[slots, :count] = tips, tips_before
        self._turn_before[slots, :count] = np.where(start[:, None, None], turn, self._turn[slots, :count])
        self._turn[slots, :count] = turn

    def _choose(self) -> None:
        """Choose the dancers whose bones swing: the nearest to the camera, those behind it last."""
        there = (self.cast.rig_of >= 0) & self._motion.present
        sizes = np.array([rig.count for rig in self.cast.rigs], np.int64)[self.cast.rig_of] * there
        if sizes.sum() <= MAX_BONES and there.sum() <= MAX_DANCERS:
            self._chosen[:] = there
            return
        picture = self._desk.parameters.picture
        away = self._dancers.drawn_hips.astype(np.float64) - picture[EYE][::2]
        ahead = (picture[TARGET] - picture[EYE])[::2]
        distance = np.hypot(away[:, 0], away[:, 1]) * np.where(self._chosen, NEARNESS_KEPT, 1.0)
        order = np.argsort(distance + np.where(away @ ahead < 0.0, _BEHIND, 0.0), kind="stable")
        order = order[there[order]][:MAX_DANCERS]
        self._chosen[:] = False
        self._chosen[order[np.cumsum(sizes[order]) <= MAX_BONES]] = True

    def show(self, view: StageView, after: float) -> None:
        """Write the springs `after` [s] the last tick into a view: between the last two ticks, so one tick late, but
        relative to joints that are not."""
        if self.cast.rigs:
            share = min(max(after / TICK, 0.0), 1.0)
            mix_springs(self._turn_before, self._turn, self._level, share, view.spring)
            view.spring_slot[:] = -1
            worn = np.flatnonzero(self._dancer >= 0)
            view.spring_slot[self._dancer[worn]] = worn

    def prepare(self, view: StageView) -> None:
        """Give a new view the arrays that `show` fills."""
        view.spring = self._at_rest()

    def _at_rest(self) -> Float32:
        turn = np.zeros((self.slot_count, self.bone_count, 4), np.float32)
        turn[..., 0] = 1.0
        return turn
