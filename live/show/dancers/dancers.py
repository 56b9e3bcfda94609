"""The poses of the dancers at any moment of the measure, with all layers from clip blending to partner response."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.motion_parameters import ARM_CLEARANCE, FOOT_LOCK, HEAD
from live.base.row_ranges import run_rows
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import starting_placement
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.pose.arm_clearance import ArmEasing, apply_arm_clearance
from live.motion.pose.foot_lock import LEG_JOINTS, CutFootLift, FootLock
from live.motion.pose.foot_lock_kernels import CONTACT_X, CONTACT_Z, HIP_DROP, SHIFT_X, SHIFT_Z
from live.motion.pose.gather_kernels import set_clearance, set_steps, shift_feet
from live.motion.pose.hand_hold import HandHolds, HeldArms
from live.motion.pose.inertialization import Inertialization
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME
from live.motion.pose.mood_pose import MoodPose
from live.motion.pose.pose_pipeline import NOT_BENT, NOT_LATE, RANGE, PosePipeline, PoseSkeleton
from live.motion.skeleton import JOINT_COUNT, SOLE_BELOW_ANKLE
from live.motion.texture.live_bank import TextureBank
from live.show.capture.performer import CapturedPerformer
from live.show.dancers.current_measure import CurrentMeasures
from live.show.dancers.live_texture import LiveTexture
from live.show.dancers.measure_state import UNDECIDED
from live.show.dancers.variation import Variation
from live.show.partner.leader_input import Tracks

if TYPE_CHECKING:
    from live.show.partner.partner_response import PartnerResponse


Rows = npt.NDArray[np.int64]

LANDED = 0.03
"""While a cut settles, a foot is locked only once it is this near to the floor [m] and near to its place in the clip:
locked farther away, it would soon be released and slide."""


class Dancers(CurrentMeasures):
    """Motion state of A dancers: measures, foot lock, hand holds, inertialization, texture, capture and partners."""

    def __init__(self, graph: MotionGraph, variation: Variation, dancer_count: int) -> None:
        super().__init__(graph, variation, dancer_count)
        self.lock = FootLock(dancer_count)
        self.hands = HandHolds(dancer_count)
        self._locked_at = 0.0
        self._aside = PosePipeline(1)
        self._legs = PosePipeline(dancer_count, PoseSkeleton.legs_only()[0])
        for name in ("sample", "placement", "share"):  # the legs share the whole body's requests
            setattr(self._legs, name, getattr(self._pipeline, name))
        self.inertia = Inertialization(dancer_count, JOINT_COUNT)
        for pipeline in (self._pipeline, self._legs):
            pipeline.difference, pipeline.age = self.inertia.difference, self.inertia.age
        self.landing = CutFootLift(dancer_count)
        self._legs.difference_rows = LEG_JOINTS
        self.texture = LiveTexture(TextureBank.empty(), variation, dancer_count, seed=0, beats=1)
        """Texture of the upper bodies (P024)."""
        self.captured: dict[str, CapturedPerformer] = {}
        """Performers captured live, by name: some dancers show their poses."""
        self.beats = 1
        """Beats of a danced measure."""
        self.partner_response: PartnerResponse | None = None
        """Live partner response, None if the patch has none (H024)."""
        self._settled = np.full(dancer_count, MAX_FADE_TIME, np.float32)
        self._bare_legs = np.zeros_like(self._legs.position), np.zeros_like(self._legs.rotation)
        self.push_velocity: Float64 = np.zeros((dancer_count, 2))
        """Velocity at which each dancer was pushed in the last tick [m/s], (A, 2). Frames go on with it."""
        self._mood = MoodPose(dancer_count)
        self.drawn_hips: Float32 = np.zeros((dancer_count, 2), np.float32)
        """Hips of each dancer at the last tick, as drawn [m], shape (A, 2)."""

    def start(self, node: Int32, position: Float64, heading: Float64) -> None:
        """Put each dancer at the beginning of `node` (A,), with hips at `position` (A, 2) [m] and `heading` (A,)."""
        danced = self.present
        danced.node[:] = node
        danced.placement[:] = starting_placement(self.graph, node, position, heading)
        danced.clear_correction()
        danced.decided = True
        self.past.undecide()
        self.coming.undecide()
        self.drawn_hips[:] = position

    def place(self, rows: npt.NDArray[np.intp], position: Float64, heading: Float64) -> None:
        """Put the invisible dancers `rows` (n,) at `position` (n, 2) [m] and `heading` (n,), where their present
        measure begins."""
        danced = self.present
        danced.placement[rows] = starting_placement(self.graph, danced.node[rows], position, heading)
        danced.clear_correction(rows)
        self.past.node[rows] = UNDECIDED
        self.lock.state[rows] = 0.0
        self.inertia.clear(rows)
        self.drawn_hips[rows] = position

    def release_planned_feet(self, rows: Int32) -> None:
        """Let the feet of the dancers `rows` (n,) go on from their planned places when a cut removes their corrections:
        the lock has the plans' offsets from then on. Free feet return to the clips; standing ones stay, and without a
        speed, which would throw them if they were released at once."""
        offset, state = self._foot_offset[rows, :, :2], self.lock.state
        state[rows, :, SHIFT_X : SHIFT_Z + 1] += offset
        state[rows, :, CONTACT_X : CONTACT_Z + 1] -= offset

    def captured_dancers(self) -> Rows:
        """Dancers who mostly show captured poses, (n,)."""
        worn = [each.rows[each.fade > 0.5] for each in self.captured.values()]
        return np.concatenate(worn) if worn else np.zeros(0, np.int64)

    @property
    def leg_rotation(self) -> Float32:
        """World rotations of hips and legs at the last tick, without capture and partner response, (A, 9, 4)."""
        return self._legs.rotation

    def tick(self, fraction: float, time: float, dt: float) -> None:
        """Advance foot lock and texturing to the tick at `time` [s], `dt` [s] after the last one."""
        self.inertia.update_age(time)
        self.variation.follow_moods(dt)
        contact, landing = self.contact(fraction), self.landing_feet()
        contact[self.variation[FOOT_LOCK] == 0.0] = False  # these feet are never held
        if self.partner_response is not None:
            contact &= ~self.partner_response.path.answering[:, None]
        position, rotation = self._legs.run(self.graph.library.leg_store)
        self.texture.tick(self._phase, position, rotation, dt)
        if self.inertia.any_fading:
            contact &= self._landed(position) | ~self.inertia.fading[:, None]
        self.drawn_hips[:] = position[:, 0, ::2]

        def part(begin: int, end: int) -> None:
            rows = slice(begin, end)
            shift_feet(position[rows], self._foot_offset[rows])
            self.lock.tick(position[rows], contact[rows], dt, landing[rows], rows)

        run_rows(part, len(position), least=4 * RANGE)
        self._locked_at = time

    def pose(
        self,
        fraction: float,
        time: float,
        out: tuple[Float32, Float32] | None = None,
        *,
        visible: Bool | None = None,
        detail: Float64 | None = None,
        easing: ArmEasing | None = None,
    ) -> tuple[Float32, Float32]:
        """Return world positions (A, J, 3) and rotations (A, J, 4) at `fraction` of the measure.

        `time` [s] is at most a tick after the last one. Fills and returns `out` if given, else the dancers' own arrays.
        Arms keep off dancers who are `visible` (A,), all without it, less where `detail` (A,) is below 1, and softly
        with the `easing` of the frames before.
        """
        self._request_samples(fraction)
        self.inertia.update_age(time)
        pipeline, variation = self._pipeline, self.variation
        if self.push_velocity.any():
            pipeline.placement[:, :, :2] += self.push_velocity * max(time - self._locked_at, 0.0)
        pipeline.head[:] = variation[HEAD]
        pipeline.bend, pipeline.late = NOT_BENT, NOT_LATE
        moods = variation.mood.any()
        if moods:
            self._mood.set(variation.mood, time, self.graph.library.moods)
            pipeline.amplitude *= self._mood.size
            pipeline.bend, pipeline.late = self._mood.bend, self._late_arms()
            np.maximum(pipeline.head, self._mood.gaze, out=pipeline.head)
        pipeline.lock = variation.any(FOOT_LOCK) or self.lock.max_shift > 1e-3  # released feet still have to swing back
        if pipeline.lock:
            age = max(time - self._locked_at, 0.0)
            self._write_feet(age)
            if self.inertia.any_fading:
                self.landing.apply(pipeline.feet, self.inertia.age)
            if moods:
                pipeline.feet[:, :, HIP_DROP] += self._mood.drop[:, None]
        position, rotation = pipeline.run(self.graph.library.store, out)
        self.texture.apply(self._phase, position, rotation)
        for captured in self.captured.values():
            captured.apply_poses(position, rotation, time, (self.variation.measure + fraction) * self.beats)
        if self.partner_response is not None:
            self.partner_response.blend_poses(self._phase, position, rotation)
            self.partner_response.lock_feet(position, rotation, max(time - self._locked_at, 0.0))
        self.hands.apply(position, rotation, max(time - self._locked_at, 0.0))
        if self.partner_response is not None:
            self.partner_response.join_hands(position, rotation, max(time - self._locked_at, 0.0))
        held = self.held_arms(time)
        apply_arm_clearance(
            position, rotation, variation[ARM_CLEARANCE], held=held, visible=visible, detail=detail, easing=easing,
            time=time,
        )  # fmt: skip
        return position, rotation

    def _write_feet(self, age: float) -> None:
        """Write the targets of all feet for the pose kernels, `age` [s] after the last tick."""
        pipeline, lock, height = self._pipeline, self.lock, self.graph.library.clip_height

        def part(begin: int, end: int) -> None:
            feet, rows = pipeline.feet[begin:end], slice(begin, end)
            lock.write_feet(feet, age, rows)
            set_clearance(pipeline.feet, pipeline.sample, pipeline.share, height, begin, end)
            set_steps(feet, self._foot_offset[rows], lock.state[rows], age)

        run_rows(part, len(lock.state), least=4 * RANGE)

    def _late_arms(self, rows: Int32 | None = None) -> Float32:
        """Return how late the hands of dancers in a free mood are in each of the four clips [samples], (4, A) or of
        `rows` (4, n); NOT_LATE if nobody is. The samples must have been requested."""
        late, sample = self._mood.late, self._pipeline.sample
        if not late.any():
            return NOT_LATE
        if rows is not None:
            late, sample = late[rows], sample[:, rows]
        return self.graph.library.samples_behind(sample, late / self.graph.library.beats_per_measure).astype(np.float32)

    def held_arms(self, time: float) -> HeldArms | None:
        """Return the arms in a hold at `time` [s], at most a tick after the last one; None if there are none."""
        answers = self.partner_response
        if not self.hands.active and answers is None:
            return None
        held, age = HeldArms(len(self.drawn_hips)), max(time - self._locked_at, 0.0)
        if self.hands.active:
            held.add_holds(*self.hands.closed_holds(age))
        if answers is not None:
            answers.add_held_arms(held, age)
        return held

    def tick_partner_response(self, there: Bool, tracks: Tracks, fraction: float, time: float, dt: float) -> Float64:
        """Advance the partner response by a tick, after `tick`; see `PartnerResponse.tick`.

        Returns the displacement of each dancer [m], (A, 2).
        """
        assert self.partner_response is not None  # callers check
        phase = self.phases(fraction)
        faces = np.ascontiguousarray(self._legs.rotation[:, 0])
        self.partner_response.streamed[:] = False
        for captured in self.captured.values():
            self.partner_response.streamed[captured.rows[captured.fade > 0.0]] = True
        self.partner_response.tick(
            phase, self.drawn_hips, faces, there, tracks, lambda rows: self.drawn_poses(rows, fraction, time), dt
        )
        return self.partner_response.path.displacement

    def drawn_poses(self, rows: Int32, fraction: float, time: float) -> tuple[Float32, Float32]:
        """Return world positions (n, J, 3) and rotations (n, J, 4) of the dancers `rows` (n,) as drawn, but without
        head turns and foot lock."""
        position, rotation = self.raw_poses(rows, fraction, time)
        phase = self.phases(fraction)
        self.texture.apply(phase, position, rotation, rows)
        for captured in self.captured.values():
            if np.isin(rows, captured.rows).any():
                whole = (
                    np.empty((len(phase), *position.shape[1:]), np.float32),
                    np.empty((len(phase), *rotation.shape[1:]), np.float32),
                )
                whole[0][rows], whole[1][rows] = position, rotation
                captured.apply_poses(*whole, time, (self.variation.measure + fraction) * self.beats)
                position[:], rotation[:] = whole[0][rows], whole[1][rows]
        if self.partner_response is not None:
            self.partner_response.blend_poses(phase, position, rotation, rows)
        return position, rotation

    def _landed(self, position: Float32) -> Bool:
        """Return which feet of legs at `position` (A, 9, 3) [m] have reached their places in the clips, (A, 2)."""
        low = np.minimum(position[:, 3::4, 1] - SOLE_BELOW_ANKLE, position[:, 4::4, 1] - TOES_OVER_SOLE) < LANDED
        settling = np.flatnonzero(self.inertia.fading).tolist()
        self._legs.age = self._settled
        there, _ = self._legs.run(self.graph.library.leg_store, self._bare_legs, only=settling)
        self._legs.age = self.inertia.age
        away = position[:, 3::4] - there[:, 3::4]
        return np.asarray(low & self.landing.may_lock(np.hypot(away[..., 0], away[..., 2])))

    def raw_poses(self, rows: Int32, fraction: float, time: float) -> tuple[Float32, Float32]:
        """Return world positions (n, J, 3) and rotations (n, J, 4) of the dancers `rows` (n,), as `pose`, but before
        head turns, foot lock and later layers. These poses must stay continuous in a cut."""
        self._request_samples(fraction, rows.astype(np.int64))
        whole = self._pipeline
        if len(self._aside.age) != len(rows):  # kept: often the same count again
            self._aside = PosePipeline(len(rows))
        aside, joints = self._aside, len(whole.skeleton.parents)
        aside.sample[:], aside.placement[:] = whole.sample[:, rows], whole.placement[:, rows]
        aside.share[:], aside.mean[:] = whole.share[:, rows], whole.mean[:, rows]
        aside.amplitude[:], aside.late = whole.amplitude[rows], NOT_LATE
        if self.variation.mood.any():
            self._mood.set(self.variation.mood, time, self.graph.library.moods)
            aside.amplitude *= self._mood.size[rows]
            aside.late = self._late_arms(rows)
        aside.difference = self.inertia.difference[rows]
        aside.age[:] = np.clip(time - self.inertia.cut_time[rows], 0.0, MAX_FADE_TIME)
        out = np.empty((len(rows), joints, 3), np.float32), np.empty((len(rows), joints, 4), np.float32)
        return aside.run(self.graph.library.store, out)
