"""Captured: one performer who is captured live: her last poses, who wears them, and how much of them is seen.

Directed: what patch and people say of a captured performer: who she is, where, how, and what she does to others.
"""

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
    """What is said of one performer. Thread: the show's."""

    def __init__(self, section: MocapSection) -> None:
        self.section = section
        self.shown, self.mirrored = section.shown, section.mirrored
        self.obstacle, self.attract, self.attracts = section.obstacle, section.attract, section.attracts
        self.dancer = section.dancer
        """Words for the dancer who is her; None: anybody who is free."""
        self.canon, self.canon_beats = section.canon, section.canon_beats
        self.lay(*section.at, section.turn_deg, section.scale)

    def lay(self, x: float, z: float, turn: float, scale: float) -> None:
        """The middle of her floor lies at x, z [m], it is turned so far [degrees], and her ways are so long."""
        self.turn, self.scale = turn, scale
        self.origin = x, z, math.radians(turn)

    @property
    def later(self) -> float:
        """How much later she is shown than she was received [s]."""
        return self.section.delay_ms / 1000.0

    @property
    def said(self) -> dict[str, tuple[Plain, ...]]:
        """What is said of her now, as in `/dance/mocap/NAME/...`: the values that each control takes."""
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
"""A pose of which no newer one comes is held for so long [s]; then her dancer goes on by herself."""
FOLLOWS: Final = 0.3
"""So much of the way to where a tracker is said to be is gone in a tick."""
LEAVES: Final = -1.0
"""The delay of a dancer who was her and is her no more."""
_OFFSETS: Final = np.array(SKELETON.offsets, np.float32)
_PARENTS: Final = np.array(SKELETON.parents, np.int32)


class Captured(Directed):
    """One performer. Her own dancer is the first of `rows`; after her those who repeat her. Thread: the show's."""

    def __init__(self, section: MocapSection, half: Float64) -> None:
        """`half` (2,): half width and half depth of the stage [m], the array that the show keeps up to date."""
        super().__init__(section)
        self.edges = Edges(half)
        """What keeps those who repeat her on the stage."""
        self.rows: Int64 = np.zeros(0, np.int64)
        """Dancers who wear her poses, (n,)."""
        self.delay: Float64 = np.zeros(0)
        """How many beats later than she, (n,); her own dancer has 0."""
        self.share: Float64 = np.zeros(0)
        """How far each has come into her poses, 0 to 1 evenly in time, (n,)."""
        self.moved: Float64 = np.zeros((0, 2))
        """How far from her each dances [m], (n, 2)."""
        self.turned: Float64 = np.zeros(0)
        """How far each was turned from her own heading at the last tick [rad], whole turns counted, (n,)."""
        self.poses = HeardPoses()
        """Her last poses, where her tracker has corrected them."""
        self.draws = 0.0
        """1 while an attractor follows her, -1 while a repulsor does."""
        self.follower = -1
        """The dancer who goes where her tracker is; -1: nobody."""
        self._spot = self._target = (0.0, 0.0)
        self._tracked = -math.inf
        self.anchor = Anchor()
        """What her tracker corrects of where her suit has her."""
        self._suit, self._anchored = (0.0, 0.0), False

    @property
    def is_danced(self) -> bool:
        """Whether a dancer is her, wholly or partly."""
        return bool(self.share[self.delay == 0.0].any())

    def recast(self, dancer: str) -> None:
        """She is another dancer from now on; whom she was goes back to her own dance."""
        self.dancer, self.follower = dancer, -1
        self.delay[self.delay == 0.0] = LEAVES

    def add(self, rows: dict[int, float], shown: Float32, time: float, beat: float) -> None:
        """These dancers wear her poses too, so many beats later; at first nothing of them is seen. Who repeats her
        does that from where she is, `shown` (A, 2) [m]."""
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
        """Only these of `rows` go on wearing her poses, (n,)."""
        if not kept.all():
            self.rows, self.delay = self.rows[kept], self.delay[kept]
            self.share, self.moved, self.turned = self.share[kept], self.moved[kept], self.turned[kept]
            self.edges.keep(kept)

    def take(self, other: "Captured") -> None:
        """Go on with the poses and dancers of `other`, who is the same performer."""
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
        """Where she is on the stage [m], whether a dancer is her or not; there must be a pose or a tracker."""
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
        """When she was heard of last [s], by a pose or a tracker."""
        return max(self.poses.last, self._tracked)

    def track(self, place: tuple[float, float], time: float) -> None:
        """Her tracker is at `place` of her floor [m]."""
        if time - self._tracked > HOLD:
            self._spot = place  # she is there anew
        self._target, self._tracked = place, max(time, self._tracked)
        if time - self.poses.last <= GAP:
            self.anchor.compare(place, self._suit)

    def settle(self, time: float) -> None:
        """A tick: where she is follows her tracker softly."""
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
        """For the status: of the tracker that corrects her suit, when it was heard of last and how much it corrects."""
        if self.section.tracker is None:
            return {}
        ago = time - self._tracked
        heard = {"tracker": self.section.tracker, "tracker_last_s_ago": round(ago, 2) if math.isfinite(ago) else None}
        return {**heard, "corrected_m": [round(each, 3) for each in self.anchor.offset]}

    def is_tracked(self, time: float) -> bool:
        """Whether her tracker, and no pose of hers, says at `time` [s] where she is."""
        return time - self._tracked <= HOLD < time - self.poses.last

    def hear(self, pose: str, time: float, beat: float) -> None:
        """Her pose at `time` [s] and the danced `beat`, packed; of several within a tick the newest stays. ValueError
        for none."""
        root, turned = unpack_pose(pose)
        if time > self.poses.last:  # else an old one that comes late
            self._suit = float(root[0]), float(root[2])
            root[::2] += self.anchor.offset
            self.poses.hear(root, turned, time, beat)

    def mirror(self, mirrored: bool, time: float) -> None:
        """She is seen as in a mirror from `time` [s] on, or as she is: she goes over softly from what was seen."""
        if mirrored != self.mirrored and self.poses.count:
            self.poses.turn_over(time - self.later)
        self.mirrored = mirrored

    def is_live(self, asked: Float64, time: float, tempo: float) -> npt.NDArray[np.bool_]:
        """For whom of `rows` there is a pose at `time` [s], when this is `asked` (n, ASKED), (n,)."""
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
        """A tick: who is `live` (n,) comes into her poses by `rate`, the others out of them; `asked` is told."""
        self.share = np.clip(self.share + np.where(live, rate, -rate), 0.0, 1.0)
        asked[:, SHARE] = self.share * self.share * (3.0 - 2.0 * self.share)

    def find(
        self, asked: Float64, live: npt.NDArray[np.bool_], shown: Float32, legs: Float32
    ) -> tuple[Float64, Float64]:
        """Where her dancers are seen now, and how far those who are wholly her went from their own dance, (n, 2) each
        [m]: see `find_places`."""
        there, way = np.empty((2, len(self.rows), 2))
        find_places(
            there, way, self.turned, self.rows, live, asked, *self.poses.kept,
            self.scale, self.mirrored, shown, legs,
        )  # fmt: skip
        return there, way

    def _places(self, asked: Float64) -> Float64:
        """Where the hips of what is `asked` (n, ASKED) are on the stage, (n, 2) [m]; nowhere without a pose."""
        place = np.zeros((len(asked), 4))
        if self.poses.count:
            where_captured(place, asked, *self.poses.kept, self.scale, self.mirrored)
        return np.asarray(place[:, :3:2])

    def stay(self, time: float, beat: float) -> Float64:
        """A tick: whoever repeats her stays on the stage. What is asked of the remembered poses then, (n, ASKED)."""
        asked, repeats = self._asked(time, beat), self.delay > 0.0
        if repeats.any():
            there, floor = self._places(asked), (*self.origin, self.scale)
            way = self.edges.settle(there, time, floor, repeats, mirrored=self.mirrored)
            self.moved += way
            asked[:, PLACE_X : PLACE_X + 2] += way
        return asked

    def asked(self, time: float, beat: float) -> Float64:
        """What is asked of the remembered poses for all of `rows`, at most a tick after `stay`, (n, ASKED)."""
        asked, repeats = self._asked(time, beat), self.delay > 0.0
        if repeats.any():
            way = self.edges.bent(self._places(asked), time)
            asked[repeats, PLACE_X : PLACE_X + 2] += way[repeats]
        return asked

    def _asked(self, time: float, beat: float) -> Float64:
        x, z, yaw = self.origin
        when, caught = time - self.later, self.poses.caught(time - self.later)
        columns = self.delay.tolist(), self.share.tolist(), self.moved.tolist(), self.turned.tolist()
        # the rows are few: what numpy would do with columns takes longer
        rows = [
            (*((TIME, when, caught) if delay <= 0.0 else (BEAT, beat - delay, 1.0)),
             share * share * (3.0 - 2.0 * share), moved[0] + x, moved[1] + z, yaw, turned)
            for delay, share, moved, turned in zip(*columns, strict=True)
        ]  # fmt: skip
        return np.array(rows).reshape(-1, ASKED)

    def dress(self, position: Float32, rotation: Float32, time: float, beat: float) -> None:
        """Let her dancers wear her poses at `time` [s], the danced `beat`: world positions (A, J, 3) and rotations
        (A, J, 4) are changed, and nothing else."""
        if self.poses.count and self.share.any():
            asked = self.asked(time, beat)
            worn = asked[:, SHARE] > 0.0
            wear(
                position, rotation, self.rows[worn], asked[worn], *self.poses.kept,
                self.scale, self.mirrored, _OFFSETS, _PARENTS, OTHER,
            )  # fmt: skip

    def hashed(self) -> tuple[npt.NDArray[np.generic], ...]:
        """What belongs to the state of the show beyond what is seen."""
        told = np.array([self.poses.count, *self._spot])
        return self.rows, self.share, self.moved, self.turned, told, self.poses.stamp, *self._corrected()

    def _corrected(self) -> tuple[npt.NDArray[np.generic], ...]:
        """What belongs to the state of who has a tracker beside her suit."""
        return (np.array([*self._suit, *self.anchor.numbers]),) if self.section.tracker is not None else ()
