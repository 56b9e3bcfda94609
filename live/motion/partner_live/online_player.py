"""Follower poses for every frame of a live leader, without delay and without jumps (H024).

The filter says where the follower is expected, and which recorded moments the couple is near. The follower dances on in
the present recording until another moment fits better: at the limits of units a little better, within them clearly.
Differences of pose and velocity fade out. Recordings are placed on the floor by a rigid motion M that follows the
expected position; it moves slowly while a foot is in contact.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.partner_live.floor_transform import FloorTransform
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.follower_moments import HOLDS

SWITCH_MARGIN: Final = 0.15
"""Another moment must cost less by this [m²] ..."""
BOUNDARY_MARGIN: Final = 0.05
"""... and by this near the limits of units."""
BOUNDARY_SHARE: Final = 0.15
"""Share of a unit that is near its limit."""
SLACK: Final = 1e-9
"""Tolerance for rounding."""
MIN_SECONDS: Final = 0.4
"""A recording is danced for at least this long [s]."""
RUN_OUT_MOMENTS: Final = 5
"""Moments that are followed by fewer than this are chosen only ..."""
EARLY_END: Final = 1e3
"""... if there is no other: their cost is higher by this [m²]."""
OFF_BEAT_COST: Final = 0.5
"""Cost of a moment that is off the leader's beats, if these are trusted [m²/s]."""
FADE_TIME: Final = 0.35
"""Fade time of the difference between two recordings [s]."""
TAKE_HOLD: Final = 0.3
"""A hold begins when it is more probable than this ..."""
RELEASE_HOLD: Final = 0.18
"""... and ends when it is less probable."""
SHOULDER_WIDTH: Final = 0.16
SHOULDER_HEIGHT: Final = 1.38
"""Distance of a shoulder from the middle of the hips, and its height [m]."""
ARM_REACH: Final = 0.55
"""Length of a nearly straight arm to the other one's wrist [m]."""
SURE_HOLD: Final = 0.9
"""Probability of a hold for which the follower comes near enough, ..."""
MAX_REACH_STEP: Final = 0.2
"""For a hand that is farther than this out of reach [m] the follower does not come nearer."""
NOBODY: Final = -1


@dataclass(frozen=True, slots=True, eq=False)
class LivePose:
    """One pose of the follower."""

    root: Float64
    """(3,) [m]"""
    rotation: Float64
    """Local rotations (J, 4)."""
    contact: Bool
    """(2,)"""


@dataclass(frozen=True, slots=True, eq=False)
class LeftMotion:
    """What is danced when a recording is left."""

    pose: tuple[Float64, Float64]
    """Root and rotations of the recording, placed on the floor ..."""
    speed: Float64
    """... and their rates."""
    offset: tuple[Float64, Float64]
    """What is left of the last blend, and its rate."""
    root: tuple[complex, complex]
    """The follower's hips on the floor and their facing."""


def same_motion(one: Clip, other: Clip) -> bool:
    """Whether two clips hold the same motion, bit by bit."""
    return one is other or all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in ("root_position", "rotation", "contact")
    )


def off_beat(phase: npt.NDArray[np.float64] | float) -> npt.NDArray[np.float64]:
    """Return shares of a unit off its nearest begin, -0.5 to 0.5."""
    return np.asarray((phase + 0.5) % 1.0 - 0.5)


class LivePartner:
    """Follower of one leader. State is plain values; output depends only on the input frames."""

    def __init__(self, reader: FollowerFilter, *, window: float = 0.04, stretch: float = 0.15) -> None:
        """Units begin within `window` [s] of the leader's beats and are stretched by at most `stretch` [s], as far as
        the beats are trusted."""
        self.filter = reader
        self.window, self._stretch = window, stretch
        self.unit = -1
        """Current unit, -1 before the first."""
        self.begin = 0
        """Frame at which it began."""
        self.decisions: list[tuple[int, int, float]] = []
        """Changes of the recording in the latest frame: (unit, begin, share of the unit that had passed)."""
        self.hands: tuple[int, int] = (NOBODY, NOBODY)
        """The leader's hands that the follower's left and right hand hold; NOBODY for none."""
        self._example = -1
        self._step = reader.units.rate / reader.rate
        self._source = 0.0
        self._floor_transform = FloorTransform()
        joints = reader.units.examples[0].follower.rotation.shape[1]
        self._offset, self._speed = np.zeros((1 + joints, 3)), np.zeros((1 + joints, 3))
        self._age = FADE_TIME

    def process_frame(self, floor: npt.NDArray[np.complex128], height: Float64, phase: float | None = None) -> None:
        """Process the leader's next frame, see `FollowerFilter.process_frame`."""
        self.filter.process_frame(floor, height, phase)
        dt = 1.0 / self.filter.rate
        self.decisions.clear()
        if self.has_pose:
            self._source += self._step
            self._age += dt
            self._update_unit()
            self._keep_beat(phase)
        chooses = self.filter.frames_since_moment == min(1, self.filter.model.stride - 1) or not self.has_pose
        moment = self._next_moment(phase) if chooses else None
        if moment is not None:
            self._switch(moment)
        elif self.has_pose:
            self._follow_expected(dt)
        self._update_hands()

    @property
    def has_pose(self) -> bool:
        """Whether there is a pose yet."""
        return self._example >= 0

    def continue_with(self, reader: FollowerFilter) -> None:
        """Follow the same leader with an unused filter of another model (another style, other examples).

        The recording that is danced goes on if the new model has it; else the follower blends into the moment that fits
        best. Raises ValueError as `FollowerFilter.take_over` does.
        """
        reader.take_over(self.filter)
        if not self.has_pose:
            self.filter = reader
            return
        clip, samples = self.filter.units.examples[self._example].follower, self.filter.units.rate
        for n, one in enumerate(reader.units.examples):
            if reader.units.rate == samples and same_motion(one.follower, clip):
                self.filter, self._example, self.unit = reader, n, -1
                self._update_unit()
                return
        self._floor_transform.rewind()
        left = self._leave()
        self.filter = reader
        self._set_moment(self._cheapest(reader.moment_costs(-1)))
        self._blend_from(left)
        self._floor_transform.drift(self._recorded_root[0], 1.0 / reader.rate)

    def _update_unit(self) -> None:
        """Count on in the units of the recording."""
        units = self.filter.units
        own = self.filter.model.units_of[self._example]
        n = int(np.searchsorted(units.start[own[0] : own[1]], self._source + SLACK, side="right"))
        unit = int(own[0]) + max(n - 1, 0)
        if unit != self.unit:
            self.unit = unit
            self.begin = self.filter.frame_index - round((self._source - float(units.start[unit])) / self._step)

    def _keep_beat(self, phase: float | None) -> None:
        """Dance faster or slower, so that the unit keeps to the leader's beats as far as these are trusted."""
        units, unit = self.filter.units, self.unit
        own = units.rate / self.filter.rate
        self._step = own
        if phase is not None:
            share = (self._source - float(units.start[unit])) / float(units.length[unit])
            late = float(off_beat(phase - share))
            limit = self._stretch / float(units.seconds[unit])
            self._step = own * (1.0 + self.filter.beat_trust * min(max(late, -limit), limit))

    def _next_moment(self, phase: float | None) -> int | None:
        """Return the moment to go on from, None for that of the present recording."""
        reader, model = self.filter, self.filter.model
        row = self._row if self.has_pose else -1
        cost = reader.moment_costs(row)
        if phase is not None and reader.beat_trust > 0.0:
            away = np.abs(off_beat(model.moments.phase - phase)) * reader.units.seconds[model.moments.unit]
            cost += OFF_BEAT_COST * reader.beat_trust * np.maximum(away - self.window, 0.0)
        best = self._cheapest(cost)
        if row < 0 or model.remaining[row] < 2:
            return best
        if self._age < MIN_SECONDS or best == row:
            return None
        share = (self._source - float(reader.units.start[self.unit])) / float(reader.units.length[self.unit]) % 1.0
        near = min(share, 1.0 - share) <= BOUNDARY_SHARE
        margin = BOUNDARY_MARGIN if near else SWITCH_MARGIN
        return best if cost[best] + margin < cost[row] else None

    def _cheapest(self, cost: Float64) -> int:
        """Return the moment that costs least, (M,), of those that are followed by enough others."""
        return int(np.argmin(np.where(self.filter.model.remaining >= RUN_OUT_MOMENTS, cost, cost + EARLY_END)))

    @property
    def _row(self) -> int:
        """The moment that is danced now."""
        first, stop = self.filter.model.rows_of[self._example].tolist()
        sample = self.filter.model.moments.sample[first:stop]
        row = int(np.searchsorted(sample, self._source + 0.5 * self._step, side="right")) - 1
        return int(first) + max(row, 0)

    def _switch(self, moment: int) -> None:
        if not self.has_pose:
            self._set_moment(moment)
            self._floor_transform.align(*self._recorded_root, *self.filter.expected_root())
            return
        left = self._leave()
        self._set_moment(moment)
        self._blend_from(left)
        self._floor_transform.drift(self._recorded_root[0], 1.0 / self.filter.rate)

    def _leave(self) -> "LeftMotion":
        """Return the motion that is danced now, to blend from it."""
        self._floor_transform.freeze()
        bent = self._remaining_offset(0.0)
        return LeftMotion(*self._pose_and_rates(self._source), bent, self._current_root(bent[0]))

    def _blend_from(self, left: "LeftMotion") -> None:
        """Begin the recording where the follower stands who leaves another one; the difference fades out."""
        place, speed, bent = left.pose, left.speed, left.offset
        self._floor_transform.align(*self._recorded_root, *left.root)
        new_place, new_speed = self._pose_and_rates(self._source)
        offset = np.empty_like(self._offset)
        offset[0] = place[0] + bent[0][0] - new_place[0]
        old = quaternion.mul(place[1], quaternion.from_rotation_vector(bent[0][1:]))
        offset[1:] = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(new_place[1]), old))
        self._speed = speed + bent[1] - new_speed
        self._offset, self._age = offset, 0.0

    def _set_moment(self, moment: int) -> None:
        moments = self.filter.model.moments
        since = self.filter.frames_since_moment * self.filter.units.rate / self.filter.rate
        self._example, self._source = int(moments.example[moment]), float(moments.sample[moment]) + since
        self.unit = -1
        self._update_unit()
        units = self.filter.units
        share = (self._source - float(units.start[self.unit])) / float(units.length[self.unit])
        self.decisions.append((self.unit, self.begin, share))

    @property
    def _recorded_root(self) -> tuple[complex, complex]:
        """The hips and facing in the current recording."""
        return self.filter.recorded_root(self._example, self._source)

    def _current_root(self, bent: Float64) -> tuple[complex, complex]:
        """Return the follower's hips on the floor and their facing."""
        root, rotation = self._sample_pose(self._source)
        hips = quaternion.mul(rotation[0], quaternion.from_rotation_vector(bent[1]))
        front = quaternion.rotate(hips, np.array((0.0, 0.0, 1.0)))
        facing = complex(front[2], front[0])
        facing = facing / abs(facing) if abs(facing) > 1e-9 else complex(1.0)
        return complex(root[2] + bent[0, 2], root[0] + bent[0, 0]), facing

    def _update_hands(self) -> None:
        """Hold the hands that probably hold now."""
        held = self.filter.expected[HOLDS].reshape(2, 2)
        found = [NOBODY, NOBODY]
        for side in range(2):
            now, likely = self.hands[side], int(np.argmax(held[:, side]))
            keeps = now != NOBODY and held[now, side] >= RELEASE_HOLD
            takes = held[likely, side] > TAKE_HOLD
            if keeps and not (takes and held[likely, side] > held[now, side] + TAKE_HOLD - RELEASE_HOLD):
                found[side] = now
            elif takes:
                found[side] = likely
        if found[0] == found[1] != NOBODY:  # a leader's hand holds one hand
            found[int(held[found[0], 0] >= held[found[0], 1])] = NOBODY
        self.hands = found[0], found[1]

    def _pose_and_rates(self, source: float) -> tuple[tuple[Float64, Float64], Float64]:
        """Return root and rotations of the unit at a sample of its recording, and their rates [1/s]."""
        here, rotation = self._sample_pose(source)
        there, other = self._sample_pose(source + self._step, 1.0)
        turn = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(rotation), other))
        speed = np.concatenate(((there - here)[None], turn)) * self.filter.rate
        return (here, rotation), np.asarray(speed, np.float64)

    def _sample_pose(self, source: float, placed: float = 0.0) -> tuple[Float64, Float64]:
        """Return root and rotations of the unit at sample `source`.

        M is taken at the share `placed` between the last frame and this one.
        """
        clip = self.filter.units.examples[self._example].follower
        source = min(max(source, 0.0), clip.sample_count - 1.0)
        low = min(int(source), clip.sample_count - 2)
        w = source - low
        root = (1.0 - w) * clip.root_position[low].astype(np.float64) + w * clip.root_position[low + 1]
        one = clip.rotation[low].astype(np.float64)
        two = clip.rotation[low + 1].astype(np.float64)
        rotation = np.asarray(quaternion.slerp(one, two, np.full(len(one), w)), np.float64)
        turn, shift = self._floor_transform.interpolate(placed)
        place = turn * complex(root[2], root[0]) + shift
        half = 0.5 * float(np.angle(turn))
        rotation[0] = quaternion.mul(np.array((np.cos(half), 0.0, np.sin(half), 0.0)), rotation[0])
        return np.array((place.imag, root[1], place.real)), rotation

    def _contact(self, part: float) -> Bool:
        """Return the recording's foot contacts `part` of a frame after the latest one, (2,)."""
        clip = self.filter.units.examples[self._example].follower
        return np.asarray(clip.contact[min(max(round(self._source + self._step * part), 0), clip.sample_count - 1)])

    def _remaining_offset(self, ahead: float) -> tuple[Float64, Float64]:
        """Return the remainder of the last switch: offset and its rate, `ahead` [s] after the latest frame (a
        quintic)."""
        t = min((self._age + ahead) / FADE_TIME, 1.0)
        rest = 1.0 - t
        place, moving = rest**3 * (1.0 + 3.0 * t + 6.0 * t * t), FADE_TIME * t * rest**3 * (1.0 + 3.0 * t)
        falls = -30.0 * t * t * rest**2 / FADE_TIME
        slows = rest**2 * (1.0 + 2.0 * t - 15.0 * t * t)
        return place * self._offset + moving * self._speed, falls * self._offset + slows * self._speed

    def _follow_expected(self, dt: float) -> None:
        """Move towards the expected position, and away from the leader if too near."""
        place, facing = self._recorded_root
        here = self._floor_transform.turn * place + self._floor_transform.shift
        expected = self.filter.expected_root()
        free = self.filter.keep_distance(here)
        near = self._reach_hands(*expected)
        wanted = self.filter.keep_distance(near + free - here), expected[1]
        stands = bool(self._contact(0.0).any())
        self._floor_transform.follow(place, facing, wanted, dt, standing=stands, too_near=free != here)

    def _reach_hands(self, place: complex, facing: complex) -> complex:
        """Return `place`, moved until the leader's hands that are held are within an arm's reach."""
        held = self.filter.expected[HOLDS].reshape(2, 2)
        for side, hand in enumerate(self.hands):
            point = None if hand == NOBODY else self.filter.point(2 + hand)
            if point is None:
                continue
            shoulder = place + facing * (1j if side == 0 else -1j) * SHOULDER_WIDTH
            away, fall = point[0] - shoulder, SHOULDER_HEIGHT - point[1]
            reach = max(ARM_REACH**2 - fall**2, 0.0) ** 0.5
            far = abs(away)
            if reach < far < reach + MAX_REACH_STEP:
                sure = min(max((float(held[hand, side]) - TAKE_HOLD) / (SURE_HOLD - TAKE_HOLD), 0.0), 1.0)
                place += away * (sure * (far - reach) / far)
        return place

    def pose(self, ahead: float = 0.0) -> LivePose:
        """Return the pose `ahead` [s] after the latest frame, at most one frame; valid only if `has_pose`."""
        part = ahead * self.filter.rate
        root, rotation = self._sample_pose(self._source + self._step * part, part)
        offset, _ = self._remaining_offset(ahead)
        bent = quaternion.mul(rotation, quaternion.from_rotation_vector(offset[1:]))
        return LivePose(root + offset[0], np.asarray(bent, np.float64), self._contact(part))
