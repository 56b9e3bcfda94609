"""One live captured performer: settings, latest poses, and the dancers that wear them with their fade."""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int64
from live.control.registry.control import ArgumentValue
from live.motion.capture.capture_blend_kernels import blend_captured, find_positions
from live.motion.capture.capture_kernels import (
    BEAT,
    BLEND,
    ORIGIN_X,
    REQUEST_COLUMNS,
    STAMP,
    STAMP_COLUMN,
    TIME,
    captured_hips,
)
from live.motion.capture.packed_pose import unpack_pose
from live.motion.skeleton import SKELETON
from live.show.capture.pose_buffer import GAP_S, MIRROR_JOINT, DriftCorrection, PoseBuffer
from live.show.capture.stage_presence import CanonBounds
from live.show.patch.section_io import MocapSection


class PerformerSettings:
    """Settings of one performer from patch and controls. Thread: the show's."""

    def __init__(self, section: MocapSection) -> None:
        self.section = section
        self.shown, self.mirrored = section.shown, section.mirrored
        self.obstacle, self.attract, self.attracts = section.obstacle, section.attract, section.attracts
        self.dancer = section.dancer
        """Words for the performer's own dancer; None: any free dancer."""
        self.canon, self.canon_beats = section.canon, section.canon_beats
        self.place_floor(*section.at, section.turn_deg, section.scale)

    def place_floor(self, x: float, z: float, turn: float, scale: float) -> None:
        """Place the origin of the performer's floor at x, z [m], turned by `turn` [degrees], with paths scaled by
        `scale`."""
        self.turn, self.scale = turn, scale
        self.origin = x, z, math.radians(turn)

    @property
    def display_delay(self) -> float:
        """Display delay after reception [s]."""
        return self.section.delay_ms / 1000.0

    @property
    def current_settings(self) -> dict[str, tuple[ArgumentValue, ...]]:
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


HOLD_S: Final = 0.25
"""Time [s] for which the last pose is held; then the dancer's own steps fade in."""
TRACKER_SMOOTHING: Final = 0.3
"""Smoothing of tracker positions: share of the distance covered per tick."""
RELEASED: Final = -1.0
"""Delay value of a dancer who was the performer's own and is released."""
_OFFSETS: Final = np.array(SKELETON.offsets, np.float32)
_PARENTS: Final = np.array(SKELETON.parents, np.int32)


class CapturedPerformer(PerformerSettings):
    """One performer. The own dancer is the first of `rows`; those in canon follow. Thread: the show's."""

    def __init__(self, section: MocapSection, half: Float64) -> None:
        """`half` (2,): half width and half depth of the stage [m]; the show updates this array in place."""
        super().__init__(section)
        self.bounds = CanonBounds(half)
        """Stage bounds for dancers in canon."""
        self.rows: Int64 = np.zeros(0, np.int64)
        """Dancers who wear the poses, (n,)."""
        self.delay: Float64 = np.zeros(0)
        """Canon delay in beats, (n,); the own dancer has 0."""
        self.fade: Float64 = np.zeros(0)
        """Fade level of each dancer, 0 to 1, linear in time, (n,)."""
        self.offset: Float64 = np.zeros((0, 2))
        """Offset of each dancer from the performer's position [m], (n, 2)."""
        self.turn_angle: Float64 = np.zeros(0)
        """Angle from each dancer's own heading at the last tick [rad], unwrapped, (n,)."""
        self.poses = PoseBuffer()
        """Latest poses, corrected by the tracker."""
        self.attraction_sign = 0.0
        """1 while an attractor follows the performer, -1 while a repulsor does."""
        self.follower = -1
        """Dancer who follows the tracker; -1: none."""
        self._tracker_position = self._tracker_target = (0.0, 0.0)
        self._tracker_time = -math.inf
        self.drift_correction = DriftCorrection()
        """Correction of the suit's position by the tracker."""
        self._suit_position, self._anchored = (0.0, 0.0), False

    @property
    def is_danced(self) -> bool:
        """Whether an own dancer wears the poses, fully or partly."""
        return bool(self.fade[self.delay == 0.0].any())

    def assign_dancer(self, dancer: str) -> None:
        """Assign another own dancer; the previous one returns to its own steps."""
        self.dancer, self.follower = dancer, -1
        self.delay[self.delay == 0.0] = RELEASED

    def add(self, rows: dict[int, float], drawn_hips: Float32, time: float, beat: float) -> None:
        """Let these dancers wear the poses with a delay in beats, at fade level 0.

        Dancers in canon start from their positions `drawn_hips` (A, 2) [m].
        """
        new = np.array(list(rows), np.int64)
        self.rows = np.concatenate([self.rows, new])
        self.delay = np.concatenate([self.delay, np.array(list(rows.values()))])
        self.fade = np.concatenate([self.fade, np.zeros(len(new))])
        self.offset = np.concatenate([self.offset, np.zeros((len(new), 2))])
        self.turn_angle = np.concatenate([self.turn_angle, np.zeros(len(new))])
        self.bounds.add(drawn_hips[new].astype(np.float64))
        place = self._positions(self._sample_requests(time, beat))
        fresh = (np.arange(len(self.rows)) >= len(self.rows) - len(new)) & (self.delay > 0.0)
        self.offset[fresh] = drawn_hips[self.rows[fresh]] - place[fresh]

    def keep(self, kept: npt.NDArray[np.bool_]) -> None:
        """Keep only these of `rows`, (n,)."""
        if not kept.all():
            self.rows, self.delay = self.rows[kept], self.delay[kept]
            self.fade, self.offset, self.turn_angle = self.fade[kept], self.offset[kept], self.turn_angle[kept]
            self.bounds.keep(kept)

    def take_over(self, other: "CapturedPerformer") -> None:
        """Take over the poses and dancers of `other`, which is the same performer."""
        for name in (
            "rows",
            "delay",
            "fade",
            "offset",
            "turn_angle",
            "poses",
            "attraction_sign",
            "drift_correction",
            "bounds",
            "_suit_position",
            "_anchored",
        ):
            setattr(self, name, getattr(other, name))

    def position(self, time: float) -> tuple[float, float]:
        """Return the position on the stage [m], with or without an own dancer; there must be a pose or a tracker."""
        x, z, yaw = self.origin
        if self.is_tracked(time):
            (a, b), c, s = self._tracker_position, math.cos(yaw), math.sin(yaw)
            a, b = (-self.scale if self.mirrored else self.scale) * a, self.scale * b
            return x + c * a + s * b, z + c * b - s * a
        when = time - self.display_delay
        ((x, z),) = self._positions(np.array([[TIME, when, self.poses.gap_blend(when), 1.0, x, z, yaw, 0.0]])).tolist()
        return x, z

    @property
    def last_time(self) -> float:
        """Time of the last pose or tracker position [s]."""
        return max(self.poses.last, self._tracker_time)

    def track(self, place: tuple[float, float], time: float) -> None:
        """Handle the tracker position `place` on the performer's floor [m]."""
        if time - self._tracker_time > HOLD_S:
            self._tracker_position = place  # new arrival: no smoothing from the old position
        self._tracker_target, self._tracker_time = place, max(time, self._tracker_time)
        if time - self.poses.last <= GAP_S:
            self.drift_correction.set_difference(place, self._suit_position)

    def update_tracker(self, time: float) -> None:
        """Advance one tick: smooth the tracker position and update the anchor."""
        (x, z), (to_x, to_z) = self._tracker_position, self._tracker_target
        self._tracker_position = x + TRACKER_SMOOTHING * (to_x - x), z + TRACKER_SMOOTHING * (to_z - z)
        worn, silent = bool(self.fade.any()), time - self.poses.last > HOLD_S
        self._anchored = self._anchored and (worn or not silent)
        if self.section.tracker is None:
            if any(self.drift_correction.state):
                self.drift_correction.release()
                self.drift_correction.tick()
        elif not silent and time - self._tracker_time <= HOLD_S:
            if worn or self._anchored:
                self.drift_correction.tick()
            else:
                self.drift_correction.set_difference(self._tracker_target, self._suit_position)
                self.poses.shift(self.drift_correction.snap())
            self._anchored = True

    def tracker_facts(self, time: float) -> dict[str, Any]:
        """Return for the status: tracker name, seconds since its last data, and its correction."""
        if self.section.tracker is None:
            return {}
        ago = time - self._tracker_time
        heard = {"tracker": self.section.tracker, "tracker_last_s_ago": round(ago, 2) if math.isfinite(ago) else None}
        return {**heard, "corrected_m": [round(each, 3) for each in self.drift_correction.offset]}

    def is_tracked(self, time: float) -> bool:
        """Whether the position at `time` [s] comes from the tracker, because there is no recent pose."""
        return time - self._tracker_time <= HOLD_S < time - self.poses.last

    def add_pose(self, pose: str, time: float, beat: float) -> None:
        """Store the packed pose at `time` [s] and the danced `beat`; within one tick the newest counts. Raises
        ValueError for an invalid pose."""
        root, turned = unpack_pose(pose)
        if time > self.poses.last:  # otherwise an old one that arrived late
            self._suit_position = float(root[0]), float(root[2])
            root[::2] += self.drift_correction.offset
            self.poses.add(root, turned, time, beat)

    def set_mirrored(self, mirrored: bool, time: float) -> None:
        """Switch mirroring from `time` [s] on, with a smooth transition from the visible pose."""
        if mirrored != self.mirrored and self.poses.count:
            self.poses.begin_mirror_blend(time - self.display_delay)
        self.mirrored = mirrored

    def is_live(self, requests: Float64, time: float, tempo: float) -> npt.NDArray[np.bool_]:
        """Return for which of `rows` there is a pose at `time` [s], given the sample requests `requests` (n,
        REQUEST_COLUMNS), (n,)."""
        if not self.poses.count:
            return np.zeros(len(self.rows), np.bool_)
        here = time - self.poses.last <= HOLD_S
        if len(self.rows) == 1 and self.delay[0] <= 0.0:
            return np.array([here])
        own, wanted = requests[:, STAMP_COLUMN] == TIME, requests[:, STAMP]
        oldest, newest = self.poses.beats
        live = (wanted <= newest + HOLD_S * tempo / 60.0) & (wanted >= oldest)
        live[own] = here
        return np.asarray(live)

    def update_fade(self, live: npt.NDArray[np.bool_], rate: float, requests: Float64) -> None:
        """Advance one tick: fade dancers that are `live` (n,) in by `rate`, others out; write the weights to
        `requests`."""
        self.fade = np.clip(self.fade + np.where(live, rate, -rate), 0.0, 1.0)
        requests[:, BLEND] = self.fade * self.fade * (3.0 - 2.0 * self.fade)

    def find_positions(
        self, requests: Float64, live: npt.NDArray[np.bool_], drawn_hips: Float32, legs: Float32
    ) -> tuple[Float64, Float64]:
        """Return the visible positions of the dancers, and the displacement of fully driven ones from their own
        steps, (n, 2) each [m]: see `find_positions`."""
        there, way = np.empty((2, len(self.rows), 2))
        find_positions(
            there, way, self.turn_angle, self.rows, live, requests, *self.poses.arrays,
            self.scale, self.mirrored, drawn_hips, legs,
        )  # fmt: skip
        return there, way

    def _positions(self, requests: Float64) -> Float64:
        """Return the hip positions for the sample requests `requests` (n, REQUEST_COLUMNS), (n, 2) [m]; zeros without a
        pose."""
        place = np.zeros((len(requests), 4))
        if self.poses.count:
            captured_hips(place, requests, *self.poses.arrays, self.scale, self.mirrored)
        return np.asarray(place[:, :3:2])

    def keep_on_stage(self, time: float, beat: float) -> Float64:
        """Advance one tick: keep dancers in canon on the stage, and return the sample requests, (n,
        REQUEST_COLUMNS)."""
        asked, repeats = self._sample_requests(time, beat), self.delay > 0.0
        if repeats.any():
            there, floor = self._positions(asked), (*self.origin, self.scale)
            way = self.bounds.update(there, time, floor, repeats, mirrored=self.mirrored)
            self.offset += way
            asked[:, ORIGIN_X : ORIGIN_X + 2] += way
        return asked

    def sample_requests(self, time: float, beat: float) -> Float64:
        """Return the sample requests for all of `rows`, at most a tick after `keep_on_stage`, (n, REQUEST_COLUMNS)."""
        asked, repeats = self._sample_requests(time, beat), self.delay > 0.0
        if repeats.any():
            way = self.bounds.correction(self._positions(asked), time)
            asked[repeats, ORIGIN_X : ORIGIN_X + 2] += way[repeats]
        return asked

    def _sample_requests(self, time: float, beat: float) -> Float64:
        x, z, yaw = self.origin
        when, caught = time - self.display_delay, self.poses.gap_blend(time - self.display_delay)
        columns = self.delay.tolist(), self.fade.tolist(), self.offset.tolist(), self.turn_angle.tolist()
        # few rows: a Python loop is faster than numpy columns
        rows = [
            (*((TIME, when, caught) if delay <= 0.0 else (BEAT, beat - delay, 1.0)),
             share * share * (3.0 - 2.0 * share), moved[0] + x, moved[1] + z, yaw, turned)
            for delay, share, moved, turned in zip(*columns, strict=True)
        ]  # fmt: skip
        return np.array(rows).reshape(-1, REQUEST_COLUMNS)

    def apply_poses(self, position: Float32, rotation: Float32, time: float, beat: float) -> None:
        """Write the poses at `time` [s], the danced `beat`, into the rows of these dancers: world positions (A, J,
        3) and rotations (A, J, 4)."""
        if self.poses.count and self.fade.any():
            asked = self.sample_requests(time, beat)
            worn = asked[:, BLEND] > 0.0
            blend_captured(
                position, rotation, self.rows[worn], asked[worn], *self.poses.arrays,
                self.scale, self.mirrored, _OFFSETS, _PARENTS, MIRROR_JOINT,
            )  # fmt: skip

    def hashed(self) -> tuple[npt.NDArray[np.generic], ...]:
        """Return the arrays that belong to the state hash beyond the visible state."""
        told = np.array([self.poses.count, *self._tracker_position])
        return self.rows, self.fade, self.offset, self.turn_angle, told, self.poses.stamp, *self._correction_state()

    def _correction_state(self) -> tuple[npt.NDArray[np.generic], ...]:
        """Return the state of the tracker correction; empty without a tracker."""
        return (
            (np.array([*self._suit_position, *self.drift_correction.state]),)
            if self.section.tracker is not None
            else ()
        )
