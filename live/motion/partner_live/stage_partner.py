"""Live partner on the stage: reads one leader in frames of danced beats and provides the follower's poses.

The follower's standing feet are locked like those of all other dancers (T050, K014).
"""

import copy
from collections.abc import Sequence
from typing import Final

import numpy as np

from live.base.arrays import Bool, Complex128, Float32, Float64, Int32
from live.motion import quaternion
from live.motion.partner.path_leader import MIN_SPEED
from live.motion.partner.point_clouds import hip_projections
from live.motion.partner.units import Units, cut_units
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.online_player import LivePartner
from live.motion.partner_live.stage_partner_kernels import local_to_world, world_to_local
from live.motion.pose.foot_lock import LEG_JOINTS, FootLock
from live.motion.pose.foot_lock_kernels import HELD, SHIFT_X, SHIFT_Z
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline
from live.motion.skeleton import JOINT_COUNT, SKELETON

RATE: Final = 30.0
"""Approximate frame rate at which a leader is read [Hz]; a whole number of frames per beat."""
PATH_RATE: Final = 15.0
"""The same for an agent's path, which changes more slowly."""
MIN_MOVEMENT: Final = 1e-4
"""A leader whose points all move less than this per frame [m] is still."""
REPORT_SHARE: Final = 0.5
"""A unit is reported when this share of it has passed."""
FACING_SMOOTHING: Final = 0.2
"""Share of the error by which a path's facing approaches its direction per frame."""
RECORDING_RATE: Final = 60.0
"""Approximate sample rate of recordings in beats [Hz]."""
STEP_DISTANCE: Final = 0.3
"""A standing foot so far from its place in the recording [m] steps there if the other one stands ..."""
ARRIVAL_DISTANCE: Final = 0.05
"""... until it is as near as this."""
_PARENTS: Final = np.array(SKELETON.parents, np.int32)


def frames_per_beat(tempo: float, rate: float = RATE) -> int:
    """Return the number of frames per beat in a show of that `tempo` [bpm], for about `rate` [Hz]."""
    return max(4, round(rate * 60.0 / tempo))


ALL_STYLES: Final = ""
"""Style of a follower who dances as any of the examples."""


def style_key(style: str) -> str:
    """Return a style as it is compared: without spaces around, capitals do not matter."""
    return style.strip().casefold()


class PartnerExamples:
    """Immutable examples in beats with an unused reader for each style, shared by all leaders."""

    def __init__(
        self,
        units: Units,
        *,
        unit_beats: int,
        per_beat: int,
        tempo: float,
        stretch: float,
        styles: Sequence[str] = (),
    ) -> None:
        """`units` in beats (`retime_to_beats`, at `tempo` [bpm]), read `per_beat` times per beat. `styles`: that of
        each example, empty for one of every style (H025). Raises ValueError for a style with fewer than two units."""
        self.units, self.unit_beats, self.per_beat = units, unit_beats, per_beat
        self.period = 60.0 / tempo
        self.stretch = stretch
        self.styles: tuple[str, ...] = tuple(style_key(one) for one in styles) or ("",) * len(units.examples)
        """Style of each example."""
        rate = self.per_beat / self.period
        self.filters = {ALL_STYLES: FollowerFilter(units, rate=rate)}
        """What is learnt from the examples of each style and from those without one, and from all of them."""
        for name in sorted({*self.styles} - {ALL_STYLES}):
            own = cut_units([one for one, its in zip(units.examples, self.styles, strict=True) if its in ("", name)])
            if own.count < 2:
                raise ValueError(
                    f"style {name!r}: {own.count} unit; there is nothing to choose from with fewer than two"
                )
            alike = len(own.examples) == len(units.examples)
            self.filters[name] = self.filters[ALL_STYLES] if alike else FollowerFilter(own, rate=rate)

    @property
    def filter(self) -> FollowerFilter:
        """The unused reader that has learnt from all examples."""
        return self.filters[ALL_STYLES]

    def fits(self, other: "PartnerExamples") -> bool:
        """Whether a follower of `other` can go on with these examples: both are read in the same frames."""
        points = self.filter.point_count, other.filter.point_count
        return (self.per_beat, self.period, self.unit_beats) == (other.per_beat, other.period, other.unit_beats) and (
            points[0] == points[1]
        )

    def new_filter(self, style: str) -> FollowerFilter:
        """Return a new filter of a style, without input; KeyError for a style that no example has."""
        like = self.filters[style]
        return copy.deepcopy(like, {id(value): value for value in (like.units, like.model)})

    def new_partner(self, style: str = ALL_STYLES) -> LivePartner:
        """Return a new partner of a style, without input; KeyError for a style that no example has."""
        return LivePartner(self.new_filter(style), stretch=self.stretch)


class LeaderReader:
    """Reads one leader; `root` and `answer_rotation` are the follower's poses now, half a frame later and a frame
    later."""

    def __init__(self, lore: PartnerExamples, shift: float = 0.0, style: str = ALL_STYLES) -> None:
        """The frames are offset by `shift` (0 to 1) of a frame, so that leaders are not all read at once."""
        self.examples, self._shift, self.style = lore, shift, style
        self.partner = lore.new_partner(style)
        self.frame_index: int | None = None
        """Number of the latest frame, counted in the leader's danced beats; None before the first."""
        self.still_frames = 0.0
        """Frames since the leader last moved or was visible."""
        self.root: Float32 = np.zeros((3, 3), np.float32)
        self.contact: Bool = np.zeros(2, np.bool_)
        """Which of the follower's feet are in contact."""
        self.answer_rotation: Float32 = np.zeros((3, JOINT_COUNT, 4), np.float32)
        self.answer_rotation[..., 0] = 1.0
        self.has_answer = self.held = False
        """Whether there has been an answer, and whether the last one is held instead of the current one."""
        self.decided_label = ""
        """Label of a unit that was decided at the latest frame; else empty."""
        self._reported = (-1, -1)
        self._facing = complex(1.0)
        self._points: Complex128 = np.zeros(lore.filter.point_count, np.complex128)
        self._heights: Float64 = np.zeros(lore.filter.point_count)

    @property
    def answering(self) -> bool:
        """Whether there is a current answer."""
        return self.partner.has_pose and not self.held

    def continue_with(self, lore: PartnerExamples, style: str) -> None:
        """Answer from other examples, or in another style, from now on, without a jump.

        Raises KeyError for a style that no example has, ValueError for examples that do not fit (`fits`).
        """
        if lore is self.examples and lore.filters[style] is lore.filters[self.style]:
            self.style = style
            return
        told, begin = (self.partner.unit, self.partner.begin) == self._reported, self.partner.begin
        self.partner.continue_with(lore.new_filter(style))
        goes_on = told and begin == self.partner.begin
        self.examples, self.style = lore, style
        self._reported = (self.partner.unit, begin) if goes_on else (-1, -1)

    def hold(self, frames: float) -> None:
        """Forget the input; hold the last answer, `frames` after its frame, until `release`."""
        begin, t = (1, 2.0 * frames - 1.0) if frames >= 0.5 else (0, 2.0 * frames)
        self.root[:] = (1.0 - t) * self.root[begin] + t * self.root[begin + 1]
        self.answer_rotation[:] = quaternion.slerp(
            self.answer_rotation[begin], self.answer_rotation[begin + 1], np.full(JOINT_COUNT, t)
        )
        self.partner, self.frame_index, self.still_frames, self._reported = (
            self.examples.new_partner(self.style),
            None,
            0.0,
            (-1, -1),
        )
        self.held = self.has_answer

    def release(self) -> None:
        """Stop holding: the held answer is no longer shown."""
        self.held = False

    def frames_due(self, danced: float) -> int:
        """Return the number of frames due since the latest one, after `danced` beats."""
        return 1 if self.frame_index is None else int(np.floor(self._frame_position(danced))) - self.frame_index

    def _frame_position(self, danced: float) -> float:
        return danced * self.examples.per_beat + self._shift + 1e-9

    def frames_since(self, danced: float) -> float:
        """Return the (fractional) frames since the latest one; 0 if there was none."""
        return 0.0 if self.frame_index is None else self._frame_position(danced) - self.frame_index

    def process_frame(self, floor: Complex128, height: Float64, danced: float, window: float) -> None:
        """Process the leader's points (P,) [m] after `danced` beats; units begin within `window` [s] of their lines.

        The hips must be seen; hands and feet that are not, are not a number.
        """
        lore = self.examples
        line = int(np.floor(self._frame_position(danced)))
        passed = 1 if self.frame_index is None else line - self.frame_index
        self.frame_index, self.decided_label = line, ""
        whole = bool(np.isfinite(floor[:2]).all() and np.isfinite(height[:2]).all())
        seen = np.isfinite(floor) & np.isfinite(height) & np.isfinite(self._points) & np.isfinite(self._heights)
        moved = max(
            float(np.abs(floor - self._points)[seen].max(initial=0.0)),
            float(np.abs(height - self._heights)[seen].max(initial=0.0)),
        )
        self.still_frames = 0.0 if whole and moved > MIN_MOVEMENT else self.still_frames + passed
        if not whole:
            return
        self._points, self._heights = floor, height
        self.partner.window = window
        for n in range(passed):
            place = (line - passed + 1 + n - self._shift) / lore.per_beat / lore.unit_beats
            self.partner.process_frame(floor, height, place % 1.0)
        if self.answering:
            self._update_poses(goes_on=passed == 1 and self.has_answer and not self.partner.decisions)
            self._report()

    def path_cloud(self, place: Float32, velocity: Float32, row: int) -> tuple[Complex128, Float64]:
        """Return the filter's input for an agent's path: shadows of hips that face the direction of motion (H019).

        While the agent stands the facing is kept.
        """
        way = complex(float(velocity[row, 1]), float(velocity[row, 0]))
        speed = abs(way)
        if speed > MIN_SPEED:
            self._facing += (1.0 if self.frame_index is None else FACING_SMOOTHING) * (way / speed - self._facing)
        size = abs(self._facing)
        facing = self._facing / size if size > 1e-9 else complex(1.0)
        middle = np.array([complex(float(place[row, 1]), float(place[row, 0]))])
        cloud = hip_projections(middle, np.array([1j * facing]), RATE)
        return cloud.floor[0], cloud.height[0]

    def _update_poses(self, *, goes_on: bool) -> None:
        """Update the poses; if the same unit `goes_on`, the first pose is the previous last one."""
        frame = self.examples.period / self.examples.per_beat
        first = 1 if goes_on else 0
        if goes_on:
            self.root[0], self.answer_rotation[0] = self.root[2], self.answer_rotation[2]
        poses = [self.partner.pose(share * frame) for share in (0.0, 0.5, 1.0)[first:]]
        self.contact[:] = poses[0].contact
        self.root[first:] = [pose.root for pose in poses]
        local_to_world(np.stack([pose.rotation for pose in poses]), _PARENTS, self.answer_rotation[first:])
        self.has_answer = True

    def _report(self) -> None:
        """Report a unit once, when so much of it has passed that it is final."""
        partner = self.partner
        if (partner.unit, partner.begin) == self._reported:
            return
        frames = max(self.examples.unit_beats * self.examples.per_beat, 1)
        unit, begin = self._reported
        if (partner.filter.frame_index - partner.begin) / frames >= REPORT_SHARE:
            self._reported = partner.unit, partner.begin
            if unit != partner.unit or partner.begin - begin > REPORT_SHARE * frames:  # else it is only placed anew
                self.decided_label = self.examples.units.label(partner.unit)


class FollowerFootLock:
    """Foot lock for the followers among A dancers."""

    def __init__(self, count: int) -> None:
        self.lock = FootLock(count)
        self._leg_position: Float32 = np.zeros((count, len(LEG_JOINTS), 3), np.float32)
        self._contact: Bool = np.zeros((count, 2), np.bool_)
        self.stepping: Bool = np.zeros((count, 2), np.bool_)
        """Feet that stand in the recording but step, because they are too far from their place there, (A, 2)."""
        self._pipeline = PosePipeline(0)

    def tick(self, rows: Int32, position: Float32, contact: Bool, dt: float) -> None:
        """Advance by `dt` [s]: unlocked poses `position` (n, J, 3) and `contact` (n, 2) of the dancers `rows` (n,).

        All other dancers' feet are released. A foot that is too far from its place steps there, one at a time.
        """
        self._contact[:] = False
        self._contact[rows] = contact
        self._leg_position[rows] = position[:, LEG_JOINTS]
        wanted = self._contact.copy()
        self._contact &= ~self.stepping
        self.lock.tick(self._leg_position, self._contact, dt)
        far = np.hypot(self.lock.state[:, :, SHIFT_X], self.lock.state[:, :, SHIFT_Z])
        held = self.lock.state[:, :, HELD] > 0.0
        lost = wanted & ~held & (far > ARRIVAL_DISTANCE)
        nearest = held[:, ::-1] & (far > STEP_DISTANCE) & (far >= far[:, ::-1])
        self.stepping = lost | (wanted & nearest)

    def apply(self, rows: Int32, position: Float32, rotation: Float32, age: float) -> None:
        """Lock the feet of the dancers `rows` (n,) in poses (A, J, 3) and (A, J, 4), world, `age` [s] after a tick."""
        if not len(rows) or not self.lock.max_shift:
            return
        if len(self._pipeline.age) != len(rows):
            self._pipeline = PosePipeline(len(rows))
            self._pipeline.sample[0] = np.arange(len(rows))
            self._pipeline.lock = True
        pipeline, parents = self._pipeline, self._pipeline.skeleton.parents
        one = FootLock(0)
        one.state = np.ascontiguousarray(self.lock.state[rows])
        one.write_feet(pipeline.feet, age)
        own = np.empty((len(rows), *rotation.shape[1:]), np.float32)
        world_to_local(np.ascontiguousarray(rotation[rows]), parents, own)
        held = pipeline.run(ClipStore.of(position[rows, 0], own))
        position[rows], rotation[rows] = held
