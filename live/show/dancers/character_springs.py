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

from live.base.arrays import Bool, Float32, Int32
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
CHOICE_TICKS: Final = 16
"""Ticks between two choices of the dancers whose bones swing."""
NEARNESS_KEPT: Final = 0.8
"""Who swings counts as nearer by this factor, so that the choice does not alternate."""
FADE_TICKS: Final = 32
"""Ticks until the bones of a dancer are at rest, or swing."""
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
        if bones <= MAX_BONES:
            return ()
        dancers = int((self.rig_of >= 0).sum())
        return (
            f"the characters of {dancers} dancers have {bones} bones that swing; {MAX_BONES} do at a time: those of "
            "the dancers nearest to the camera",
        )


class CharacterSprings:
    """The springs of all dancers of one show. Thread: the show's."""

    def __init__(self, cast: SpringCast, dancers: "Dancers", motion: "GroupMotion", desk: "LightDesk") -> None:
        self.cast = cast
        self._dancers, self._motion, self._desk = dancers, motion, desk
        self._begin()

    def _begin(self) -> None:
        """Put all springs to rest, in arrays of the rigs' sizes."""
        shape = len(self.cast.rig_of), self.bone_count
        self._time, self._ticks = 0.0, 0
        self._chosen: Bool = self.cast.rig_of >= 0
        self._running: Bool = np.zeros(shape[0], np.bool_)
        self._level: Float32 = self._chosen.astype(np.float32)
        """Share of its motion that each dancer's springs show, 0: at rest; shape (A,)."""
        self._hips: Float32 = np.zeros((shape[0], 2), np.float32)
        self._now, self._before = np.zeros((*shape, 3), np.float32), np.zeros((*shape, 3), np.float32)
        self._turn, self._turn_before = self.rest(), self.rest()

    def check_sizes(self) -> None:
        """Begin at rest if a snapshot's arrays are of other files than those that were read."""
        shape = len(self.cast.rig_of), self.bone_count
        if any(array.shape != (*shape, 3) for array in (self._now, self._before)) or any(
            array.shape != (*shape, 4) for array in (self._turn, self._turn_before)
        ):
            self._begin()

    @property
    def bone_count(self) -> int:
        """Most bones of a rig."""
        return max((rig.count for rig in self.cast.rigs), default=0)

    @property
    def resting(self) -> int:
        """Number of dancers whose springs rest because there are too many."""
        return int(((self.cast.rig_of >= 0) & ~self._chosen).sum())

    def tick(self, now: "Now", fraction: float) -> None:
        """Advance all springs to the tick `now`, in which dancers are at `fraction` of the measure."""
        if not self.cast.rigs:
            return
        skipped, self._time = now.time - self._time > 1.5 * TICK, now.time
        if self._ticks % CHOICE_TICKS == 0:
            self._choose()
        self._ticks += 1
        self._level += np.clip(self._chosen - self._level, -1.0 / FADE_TICKS, 1.0 / FADE_TICKS).astype(np.float32)
        hips = self._dancers.drawn_hips
        jumped = np.abs(hips - self._hips).max(axis=1) > JUMP
        self._hips[:] = hips
        swinging = self._motion.present & (self._level > 0.0)
        rows = np.flatnonzero(swinging).astype(np.int32)
        if len(rows):
            starting = ~self._running | jumped | skipped
            position, rotation = self._dancers.drawn_poses(rows, fraction, now.time)
            for number, rig in enumerate(self.cast.rigs):
                mine = np.flatnonzero(self.cast.rig_of[rows] == number)
                if len(mine):
                    self._swing(rig, rows[mine], position[mine], rotation[mine], starting)
        self._running = swinging

    def _swing(self, rig: SpringRig, rows: Int32, position: Float32, rotation: Float32, starting: Bool) -> None:
        count, start = rig.count, starting[rows]
        tips, tips_before = self._now[rows, :count], self._before[rows, :count]
        turn = np.empty((len(rows), count, 4), np.float32)
        swing(
            position, rotation, _REST, rig.parent, rig.joint, rig.centre, rig.head, rig.tail, rig.setting, rig.hits,
            rig.collider_joint, rig.collider, start.astype(np.uint8), TICK, tips, tips_before, turn,
        )  # fmt: skip
        self._now[rows, :count], self._before[rows, :count] = tips, tips_before
        self._turn_before[rows, :count] = np.where(start[:, None, None], turn, self._turn[rows, :count])
        self._turn[rows, :count] = turn

    def _choose(self) -> None:
        """Choose the dancers whose bones swing: the nearest to the camera, those behind it last."""
        worn = self.cast.rig_of >= 0
        sizes = np.array([rig.count for rig in self.cast.rigs], np.int64)[self.cast.rig_of] * (
            worn & self._motion.present
        )
        if sizes.sum() <= MAX_BONES:
            self._chosen[:] = worn
            return
        picture = self._desk.parameters.picture
        away = self._dancers.drawn_hips.astype(np.float64) - picture[EYE][::2]
        ahead = (picture[TARGET] - picture[EYE])[::2]
        distance = np.hypot(away[:, 0], away[:, 1]) * np.where(self._chosen, NEARNESS_KEPT, 1.0)
        order = np.argsort(distance + np.where(away @ ahead < 0.0, _BEHIND, 0.0), kind="stable")
        self._chosen[:] = False
        self._chosen[order] = (np.cumsum(sizes[order]) <= MAX_BONES) & worn[order]

    def show(self, view: StageView, after: float) -> None:
        """Write the springs `after` [s] the last tick into a view: between the last two ticks, so one tick late, but
        relative to joints that are not."""
        if self.cast.rigs:
            mix_springs(self._turn_before, self._turn, self._level, min(max(after / TICK, 0.0), 1.0), view.spring)

    def rest(self) -> Float32:
        """Return all rotations at rest, for a view."""
        return _identity((len(self.cast.rig_of), self.bone_count))


def _identity(shape: tuple[int, int]) -> Float32:
    turn = np.zeros((*shape, 4), np.float32)
    turn[..., 0] = 1.0
    return turn
