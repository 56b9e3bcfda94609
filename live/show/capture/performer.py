"""One live captured performer: settings, latest poses, and the dancers that wear them with their fade."""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.control.registry.control import Plain
from live.motion.capture.capture_blend_kernels import find_places, wear
from live.motion.capture.capture_kernels import ASKED, BEAT, KEY, PLACE_X, SHARE, TIME, WANTED, where_captured
from live.motion.packed_pose import unpack_pose
from live.motion.skeleton import SKELETON
from live.show.capture.pose_buffer import GAP, OTHER, Anchor, HeardPoses
from live.show.capture.stage_presence import Edges
from live.show.patch.section_io import MocapSection


class Directed:
    """Settings of one performer from patch and controls. Thread: the show's."""

    def __init__(self, section: MocapSection) -> None:
        self.section = section
        self.shown, self.mirrored = section.shown, section.mirrored
        self.obstacle, self.attract, self.attracts = section.obstacle, section.attract, section.attracts
        self.dancer = section.dancer
        """Words for the performer's own dancer; None: any free dancer."""
        self.canon, self.canon_beats = section.canon, section.canon_beats
        self.lay(*section.at, section.turn_deg, section.scale)

    def lay(self, x: float, z: float, turn: float, scale: float) -> None:
        """Place the origin of the performer's floor at x, z [m], turned by `turn` [degrees], with paths scaled by
        `scale`."""
        self.turn, self.scale = turn, scale
        self.origin = x, z, math.radians(turn)

    @property
    def later(self) -> float:
        """Display delay after reception [s]."""
        return self.section.delay_ms / 1000.0

    @property
    def said(self) -> dict[str, tuple[Plain, ...]]:
        """Present settings as in `/dance/mocap/NAME/...`: the values of each control."""
        x, z, _ = self.origin
        return {
            "dancer": ("*" if self.dancer is None else self.dancer,),
            "shown": (self.shown,),
            "mirrored": (self.mirrored,),
            "place": (float(x), float(z), float(self.turn), float(self.scale)),
            "canon": (self.canon, float(self.canon_beats)),
            "obstacle": (self.obstacle,),
            "attract": (float(self.attract), self.attracts),
        }


Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

HOLD: Final = 0.25
"""Time [s] for which the last pose is held; then the dancer's own steps fade in."""
FOLLOWS: Final = 0.3
"""Smoothing of tracker positions: share of the distance covered per tick."""
LEAVES: Final = -1.0
"""Delay value of a dancer who was the performer's own and is released."""
_OFFSETS: Final = np.array(SKELETON.offsets, np.float32)
_PARENTS: Final = np.array(SKELETON.parents, np.int32)


class Captured(Directed):
    """One performer. The own dancer is the first of `rows`; those in canon follow. Thread: the show's."""

    def __init__(self, section: MocapSection, half: Float64) -> None:
        """`half` (2,): half width and half depth of the stage [m]; the show updates this array in place."""
        super().__init__(section)
        self.edges = Edges(half)
        """Stage bounds for dancers in canon."""
        self.rows: Int64 = np.zeros(0, np.int64)
        """Dancers who wear the poses, (n,)."""
        self.delay: Float64 = np.zeros(0)
        """Canon delay in beats, (n,); the own dancer has 0."""
        self.share: Float64 = np.zeros(0)
        """Fade level of each dancer, 0 to 1, linear in time, (n,)."""
        self.moved: Float64 = np.zeros((0, 2))
        """Offset of each dancer from the performer's position [m], (n, 2)."""
        self.turned: Float64 = np.zeros(0)
        """Angle from each dancer's own heading at the last tick [rad], unwrapped, (n,)."""
        self.poses = HeardPoses()
        """Latest poses, corrected by the tracker."""
        self.draws = 0.0
        """1 while an attractor follows the performer, -1 while a repulsor does."""
        self.follower = -1
        """Dancer who follows the tracker; -1: none."""
        self._spot = self._target = (0.0, 0.0)
        self._tracked = -math.inf
        self.anchor = Anchor()
        """Correction of the suit's position by the tracker."""
        self._suit, self._anchored = (0.0, 0.0), False

    @property
    def is_danced(self) -> bool:
        """Whether an own dancer wears the poses, fully or partly."""
        return bool(self.share[self.delay == 0.0].any())

    def recast(self, dancer: str) -> None:
        """Assign another own dancer; the previous one returns to its own steps."""
        self.dancer, self.follower = dancer, -1
        self.delay[self.delay == 0.0] = LEAVES

    def add(self, rows: dict[int, float], shown: Float32, time: float, beat: float) -> None:
        """Let these dancers wear the poses with a delay in beats, at fade level 0.

        Dancers in canon start from their positions `shown` (A, 2) [m].
        """
        new = np.array(list(rows), np.int64)
        self.rows = np.concatenate([self.rows, new])
        self.delay = np.concatenate([self.delay, np.array(list(rows.values()))])
        self.share = np.concatenate([self.share, np.zeros(len(new))])
        self.moved = np.concatenate([self.moved, np.zeros((len(new), 2))])
        self.turned = np.concatenate([self.turned, np.zeros(len(new))])
        self.edges.add(shown[new].astype(np.float64))
        place = self._places(self._asked(time, beat))
        fresh = (np.arange(len(self.rows)) >= len(self.rows) - len(new)) & (self.delay > 0.0)
        self.moved[fresh] = shown[self.rows[fresh]] - place[fresh]

    def keep(self, kept: npt.NDArray[np.bool_]) -> None:
        """Keep only these of `rows`, (n,)."""
        if not kept.all():
            self.rows, self.delay = self.rows[kept], self.delay[kept]
            self.share, self.moved, self.turned = self.share[kept], self.moved[kept], self.turned[kept]
            self.edges.keep(kept)

    def take(self, other: "Captured") -> None:
        """Take over the poses and dancers of `other`, which is the same performer."""
        for name in (
            "rows",
            "delay",
            "share",
            "moved",
            "turned",
            "poses",
            "draws",
            "anchor",
            "edges",
            "_suit",
            "_anchored",
        ):
            setattr(self, name, getattr(other, name))

    def stands(self, time: float) -> tuple[float, float]:
        """Return the position on the stage [m], with or without an own dancer; there must be a pose or a tracker."""
        x, z, yaw = self.origin
        if self.is_tracked(time):
            (a, b), c, s = self._spot, math.cos(yaw), math.sin(yaw)
            a, b = (-self.scale if self.mirrored else self.scale) * a, self.scale * b
            return x + c * a + s * b, z + c * b - s * a
        when = time - self.later
        ((x, z),) = self._places(np.array([[TIME, when, self.poses.caught(when), 1.0, x, z, yaw, 0.0]])).tolist()
        return x, z

    @property
    def last(self) -> float:
        """Time of the last pose or tracker position [s]."""
        return max(self.poses.last, self._tracked)

    def track(self, place: tuple[float, float], time: float) -> None:
        """Handle the tracker position `place` on the performer's floor [m]."""
        if time - self._tracked > HOLD:
            self._spot = place  # new arrival: no smoothing from the old position
        self._target, self._tracked = place, max(time, self._tracked)
        if time - self.poses.last <= GAP:
            self.anchor.compare(place, self._suit)

    def settle(self, time: float) -> None:
        """Advance one tick: smooth the tracker position and update the anchor."""
        (x, z), (to_x, to_z) = self._spot, self._target
        self._spot = x + FOLLOWS * (to_x - x), z + FOLLOWS * (to_z - z)
        worn, silent = bool(self.share.any()), time - self.poses.last > HOLD
        self._anchored = self._anchored and (worn or not silent)
        if self.section.tracker is None:
            if any(self.anchor.numbers):
                self.anchor.let_go()
                self.anchor.follow()
        elif not silent and time - self._tracked <= HOLD:
            if worn or self._anchored:
                self.anchor.follow()
            else:
                self.anchor.compare(self._target, self._suit)
                self.poses.shift(self.anchor.leap())
            self._anchored = True

    def tracker_facts(self, time: float) -> dict[str, Any]:
        """Return for the status: tracker name, seconds since its last data, and its correction."""
        if self.section.tracker is None:
            return {}
        ago = time - self._tracked
        heard = {"tracker": self.section.tracker, "tracker_last_s_ago": round(ago, 2) if math.isfinite(ago) else None}
        return {**heard, "corrected_m": [round(each, 3) for each in self.anchor.offset]}

    def is_tracked(self, time: float) -> bool:
        """Whether the position at `time` [s] comes from the tracker, because there is no recent pose."""
        return time - self._tracked <= HOLD < time - self.poses.last

    def hear(self, pose: str, time: float, beat: float) -> None:
        """Store the packed pose at `time` [s] and the danced `beat`; within one tick the newest counts. Raises
        ValueError for an invalid pose."""
        root, turned = unpack_pose(pose)
        if time > self.poses.last:  # otherwise an old one that arrived late
            self._suit = float(root[0]), float(root[2])
            root[::2] += self.anchor.offset
            self.poses.hear(root, turned, time, beat)

    def mirror(self, mirrored: bool, time: float) -> None:
        """Switch mirroring from `time` [s] on, with a smooth transition from the visible pose."""
        if mirrored != self.mirrored and self.poses.count:
            self.poses.turn_over(time - self.later)
        self.mirrored = mirrored

    def is_live(self, asked: Float64, time: float, tempo: float) -> npt.NDArray[np.bool_]:
        """Return for which of `rows` there is a pose at `time` [s], given the sample requests `asked` (n, ASKED),
        (n,)."""
        if not self.poses.count:
            return np.zeros(len(self.rows), np.bool_)
        here = time - self.poses.last <= HOLD
        if len(self.rows) == 1 and self.delay[0] <= 0.0:
            return np.array([here])
        own, wanted = asked[:, KEY] == TIME, asked[:, WANTED]
        oldest, newest = self.poses.beats
        live = (wanted <= newest + HOLD * tempo / 60.0) & (wanted >= oldest)
        live[own] = here
        return np.asarray(live)

    def go(self, live: npt.NDArray[np.bool_], rate: float, asked: Float64) -> None:
        """Advance one tick: fade dancers that are `live` (n,) in by `rate`, others out; write the weights to
        `asked`."""
        self.share = np.clip(self.share + np.where(live, rate, -rate), 0.0, 1.0)
        asked[:, SHARE] = self.share * self.share * (3.0 - 2.0 * self.share)

    def find(
        self, asked: Float64, live: npt.NDArray[np.bool_], shown: Float32, legs: Float32
    ) -> tuple[Float64, Float64]:
        """Return the visible positions of the dancers, and the displacement of fully driven ones from their own
        steps, (n, 2) each [m]: see `find_places`."""
        there, way = np.empty((2, len(self.rows), 2))
        find_places(
            there, way, self.turned, self.rows, live, asked, *self.poses.kept,
            self.scale, self.mirrored, shown, legs,
        )  # fmt: skip
        return there, way

    def _places(self, asked: Float64) -> Float64:
        """Return the hip positions for the sample requests `asked` (n, ASKED), (n, 2) [m]; zeros without a pose."""
        place = np.zeros((len(asked), 4))
        if self.poses.count:
            where_captured(place, asked, *self.poses.kept, self.scale, self.mirrored)
        return np.asarray(place[:, :3:2])

    def stay(self, time: float, beat: float) -> Float64:
        """Advance one tick: keep dancers in canon on the stage, and return the sample requests, (n, ASKED)."""
        asked, repeats = self._asked(time, beat), self.delay > 0.0
        if repeats.any():
            there, floor = self._places(asked), (*self.origin, self.scale)
            way = self.edges.settle(there, time, floor, repeats, mirrored=self.mirrored)
            self.moved += way
            asked[:, PLACE_X : PLACE_X + 2] += way
        return asked

    def asked(self, time: float, beat: float) -> Float64:
        """Return the sample requests for all of `rows`, at most a tick after `stay`, (n, ASKED)."""
        asked, repeats = self._asked(time, beat), self.delay > 0.0
        if repeats.any():
            way = self.edges.bent(self._places(asked), time)
            asked[repeats, PLACE_X : PLACE_X + 2] += way[repeats]
        return asked

    def _asked(self, time: float, beat: float) -> Float64:
        x, z, yaw = self.origin
        when, caught = time - self.later, self.poses.caught(time - self.later)
        columns = self.delay.tolist(), self.share.tolist(), self.moved.tolist(), self.turned.tolist()
        # few rows: a Python loop is faster than numpy columns
        rows = [
            (*((TIME, when, caught) if delay <= 0.0 else (BEAT, beat - delay, 1.0)),
             share * share * (3.0 - 2.0 * share), moved[0] + x, moved[1] + z, yaw, turned)
            for delay, share, moved, turned in zip(*columns, strict=True)
        ]  # fmt: skip
        return np.array(rows).reshape(-1, ASKED)

    def dress(self, position: Float32, rotation: Float32, time: float, beat: float) -> None:
        """Write the poses at `time` [s], the danced `beat`, into the rows of these dancers: world positions (A, J,
        3) and rotations (A, J, 4)."""
        if self.poses.count and self.share.any():
            asked = self.asked(time, beat)
            worn = asked[:, SHARE] > 0.0
            wear(
                position, rotation, self.rows[worn], asked[worn], *self.poses.kept,
                self.scale, self.mirrored, _OFFSETS, _PARENTS, OTHER,
            )  # fmt: skip

    def hashed(self) -> tuple[npt.NDArray[np.generic], ...]:
        """Return the arrays that belong to the state hash beyond the visible state."""
        told = np.array([self.poses.count, *self._spot])
        return self.rows, self.share, self.moved, self.turned, told, self.poses.stamp, *self._corrected()

    def _corrected(self) -> tuple[npt.NDArray[np.generic], ...]:
        """Return the state of the tracker correction; empty without a tracker."""
        return (np.array([*self._suit, *self.anchor.numbers]),) if self.section.tracker is not None else ()
