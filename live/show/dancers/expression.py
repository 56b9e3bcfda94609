"""Faces and hands of the dancers: gaze, blink, breath, effort and hand shapes, driven by the dance.

What changes with time is decided at ticks and is part of the show's state. A frame adds what follows from the drawn
poses: where the eyes stand in the head, fingers that straighten with the arm, lie flat on the floor, or hold a
partner's hand.
"""

import math
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int32
from live.base.body.expression import FACE_SIZE
from live.base.body.hand_shapes import NO_SHAPE, RELAXED, SHAPE_NAMES, SHAPES, SOFTNESS, shape_index
from live.base.errors import PersonError
from live.base.motion_parameters import FACE_EFFORT, FOOT_POINT, HAND_SHAPE, HEAD, PUBLIC_GAZE, SMILE
from live.base.row_ranges import run_rows
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.event import ControlEvent
from live.motion.editing.body_mass import joint_inertias
from live.motion.expression.dance_kernels import ENERGY, HEAD_JOINT, HEAD_YAW, LEAD_S, TURN, measure_dance
from live.motion.expression.drawing_kernels import draw_expressions
from live.motion.expression.face_kernels import (
    BLINK_AGE,
    BREATH_PHASE,
    BREATH_RATE,
    CHOICE_COLUMNS,
    FIXATION,
    KIND,
    LAST_KIND,
    LAST_OTHER,
    LEAD,
    LEAST_BREATHS,
    LONG_AGO,
    NEXT_BLINK,
    NUMBER_COLUMNS,
    OTHER,
    SACCADE_AGE,
    advance_blinks,
    advance_breath,
    advance_feelings,
)
from live.motion.expression.foot_kernels import point_feet
from live.motion.expression.gaze_kernels import DANCER, LOOK_SECONDS, RIGHT_HAND, choose_targets, find_seekers
from live.motion.expression.hand_kernels import HAND_COLUMNS, SOFT, VALUE, advance_hands
from live.motion.pose.hand_hold import NOBODY
from live.motion.pose.pose_pipeline import RANGE
from live.motion.skeleton import SKELETON
from live.show.dancers.rng import Purpose, generator_for
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion

PHRASE_MEASURES: Final = 4
"""A phrase has so many measures: at its end dancers may blink."""
SHOWN_TICKS: Final = 4
"""The poses of dancers who do not dance their own steps are measured once in so many ticks (an even number)."""
_INERTIA: Final = joint_inertias().astype(np.float32)
_POINTS: Final = np.array([SKELETON.index(name) for name in ("hips", "leftHand", "rightHand", "leftFoot", "rightFoot")])
_POINT_MASS: Final = np.array([0.6, 0.06, 0.06, 0.14, 0.14])
"""Shares of the mass that move with these joints: kinetic energy of bodies whose clips are unknown."""
NO_ROWS: Final = np.zeros(0, np.int64)
NOBODY_HELD: Final = np.zeros((0, 2), np.float32)
EVERYWHERE: Final = (np.zeros(3), 1e9)
"""Eye and distance for which nobody is too far away."""


class Expression:
    """Faces and hands of A dancers. Thread: the show's."""

    EVENTS = (events.SetHands, events.Clear)

    def __init__(self, dancers: "Dancers", motion: "GroupMotion", *, seed: int) -> None:
        count = len(motion.casting.group)
        self._dancers, self._motion, self._seed = dancers, motion, seed & 0x7FFFFFFF
        self._everybody: Int32 = np.arange(count, dtype=np.int32)
        self._soloists: Int32 = np.flatnonzero(motion.casting.soloists).astype(np.int32)
        self._measure, self._ticks = -1, 0
        self.number: Float32 = np.zeros((count, NUMBER_COLUMNS), np.float32)
        """State of the faces, columns as in `face_kernels`, (A, NUMBER_COLUMNS)."""
        self.choice: Int32 = np.zeros((count, CHOICE_COLUMNS), np.int32)
        """What each dancer looks at, columns as there, (A, CHOICE_COLUMNS)."""
        self._slow: Float32 = np.zeros((count, FACE_SIZE), np.float32)
        self.hands: Float32 = np.zeros((2, count, 2, HAND_COLUMNS), np.float32)
        """State of the hands, as in `hand_kernels`, (2, A, 2, HAND_COLUMNS)."""
        self.asked: Int32 = np.full(count, NO_SHAPE, np.int32)
        """Hand shape that a person asked for, NO_SHAPE for none, (A,)."""
        self._until: Float64 = np.zeros(count)  # danced beat at which it ends
        self._measured: Float32 = np.zeros((count, 3), np.float32)
        self._shown_at: Float64 = np.full(count, -1e6)  # time at which shown poses were measured [s]
        self._shown: Float32 = np.zeros((count, len(_POINTS), 3), np.float32)
        chance = generator_for(seed, Purpose.EXPRESSION, 0)
        self.number[:, NEXT_BLINK], self.number[:, FIXATION] = chance.uniform(0.0, (4.0, 1.5), (count, 2)).T
        self.number[:, BREATH_PHASE] = chance.uniform(0.0, 1.0, count)
        self.number[:, BREATH_RATE] = LEAST_BREATHS
        self.number[:, SACCADE_AGE] = self.number[:, BLINK_AGE] = LONG_AGO
        self.choice[:, OTHER] = self.choice[:, LAST_OTHER] = NOBODY
        self.hands[VALUE, :, :, :SOFT], self.hands[VALUE, :, :, SOFT] = SHAPES[RELAXED], SOFTNESS[RELAXED]

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `EVENTS`; PersonError for an unknown shape, or if nobody is selected."""
        if not isinstance(event, events.SetHands):
            self.asked[:] = NO_SHAPE
            return
        shape = shape_index(event.shape)
        if shape is None:
            raise PersonError(f"no hand shape is called {event.shape!r}", f"there are: auto, {', '.join(SHAPE_NAMES)}")
        who = self._motion.casting.select(event.group, self._motion.state.position)
        if not who.any():
            raise PersonError(f"{event.group!r}: nobody is there now")
        self.asked[who] = shape
        self._until[who] = now.danced_beats + event.measures * now.measure_beats

    # -- ticks ---------------------------------------------------------------------------------------------------

    def tick(self, now: Now, fraction: float, *, music: float) -> None:
        """Advance by a tick to `fraction` of the measure; `music`: its energy, 0 to 1. Called after the dancers'."""
        dancers, motion, variation = self._dancers, self._motion, self._dancers.variation
        phrase_ends = now.span.number != self._measure and now.span.number % PHRASE_MEASURES == 0
        if now.span.number != self._measure:
            self._measure = now.span.number
            self._soloists = np.flatnonzero(motion.casting.soloists).astype(np.int32)
        beat, tempo = now.danced_beats, now.timeline.tempo
        if self.asked.max(initial=NO_SHAPE) > NO_SHAPE:
            self.asked[self._until <= beat] = NO_SHAPE
        shown = self._shown_rows()
        kept = self._measured[shown] if len(shown) else None
        self._measure_clips(now.timeline.beats_per_measure * 60.0 / tempo)
        self._ticks = (self._ticks + 1) % SHOWN_TICKS
        if kept is not None:
            self._measured[shown] = kept
            if self._ticks == 0:
                self._measure_shown(shown, fraction, now.time)
        cues, partner, half = dancers.graph.library.node_hands, self._partners(), motion.stage_area.half
        position, there, soloists = dancers.drawn_hips, motion.on_stage, self._soloists

        number, choice, measured = self.number, self.choice, self._measured
        lead_before, smile, gaze = number[:, LEAD].copy(), variation[SMILE], variation[PUBLIC_GAZE]
        measure_beats, seed = float(now.measure_beats), self._seed

        def part(begin: int, end: int) -> None:
            advance_feelings(number, measured, variation.mood, smile, music, TICK, begin, end)
            advance_breath(
                self._slow, number, variation[FACE_EFFORT], beat, measure_beats, tempo, seed, TICK, begin, end
            )
            rows, views = np.empty(end - begin, np.int32), np.empty(end - begin, np.float32)
            found = find_seekers(rows, views, number, choice, measured, position, there, gaze, TICK, begin, end)
            if found:
                choose_targets(
                    rows, views, found, number, choice, measured, position, motion.state.velocity, there, partner,
                    soloists, variation.mood, gaze, float(half[0]), float(half[1]), LOOK_SECONDS, seed,
                )  # fmt: skip
            advance_blinks(number, choice, lead_before, phrase_ends, seed, TICK, begin, end)
            advance_hands(
                self.hands, SHAPES, SOFTNESS, self.asked, cues, dancers.past.node, dancers.present.node,
                dancers.coming.node, dancers.decided, dancers.requested_phase, variation[HAND_SHAPE], self.number,
                self._seed, TICK, begin, end,
            )  # fmt: skip

        run_rows(part, len(self.number), least=4 * RANGE)

    def _measure_clips(self, measure_s: float) -> None:
        """Measure heads and energy of the dancers in their clips; a measure lasts `measure_s` now."""
        dancers, library = self._dancers, self._dancers.graph.library

        def part(begin: int, end: int) -> None:
            measure_dance(
                self._measured, library.store.root, library.store.rotation, *dancers.requested_samples,
                dancers.requested_phase, dancers.past.node, dancers.present.node, dancers.coming.node, dancers.decided,
                library.node_first, library.node_last, library.node_lead, measure_s, dancers.variation[HEAD], _INERTIA,
                self._ticks % 2, begin, end,
            )  # fmt: skip

        run_rows(part, len(self.number), least=4 * RANGE)

    def _shown_rows(self) -> npt.NDArray[np.int64]:
        """Return the dancers who show captured poses or a partner's response instead of their own steps, (n,)."""
        dancers = self._dancers
        rows = dancers.captured_dancers() if dancers.captured else NO_ROWS
        if dancers.partner_response is not None:
            rows = np.union1d(rows, np.flatnonzero(dancers.partner_response.path.weight > 0.5))
        return rows

    def _measure_shown(self, rows: npt.NDArray[np.int64], fraction: float, time: float) -> None:
        """Measure heads and energy of dancers `rows` (n,) who do not dance their own steps, from their poses."""
        position, rotation = self._dancers.drawn_poses(rows.astype(np.int32), fraction, time)
        points, turned = position[:, _POINTS], rotation[:, HEAD_JOINT].astype(np.float64)
        sound = np.isfinite(points).all(axis=(1, 2)) & np.isfinite(turned).all(axis=1)  # a lost pose changes nothing
        rows, points = rows[sound], points[sound]
        w, x, y, z = turned[sound].T
        yaw = np.arctan2(2.0 * (x * z + w * y), 1.0 - 2.0 * (x * x + y * y))
        passed = time - self._shown_at[rows]
        known = (passed > 0.0) & (passed < 0.3)
        span = np.where(known, passed, 1.0)
        turned = np.remainder(yaw - self._measured[rows, HEAD_YAW] + math.pi, 2.0 * math.pi) - math.pi
        speed = np.linalg.norm(points - self._shown[rows], axis=-1) / span[:, None]
        self._measured[rows, HEAD_YAW] = yaw
        self._measured[rows, TURN] = np.where(known, np.clip(turned * LEAD_S / span, -1.5, 1.5), 0.0)
        self._measured[rows, ENERGY] = np.where(known, np.minimum(0.5 * speed**2 @ _POINT_MASS, 50.0), 0.0)
        self._shown[rows], self._shown_at[rows] = points, time

    def _partners(self) -> Int32:
        """Return whom each dancer dances with, NOBODY for nobody, (A,)."""
        partner, answers = self._motion.partners.partner, self._dancers.partner_response
        if answers is None:
            return partner
        partner = partner.copy()
        for pair in answers.pairs:
            if pair.leader != pair.follower and answers.path.weight[pair.follower] > 0.0:
                partner[pair.follower], partner[pair.leader] = pair.leader, pair.follower
        return partner

    # -- frames --------------------------------------------------------------------------------------------------

    def show(self, view: StageView, time: float, now: Now, seen: tuple[Float64, float] = EVERYWHERE) -> None:
        """Fill faces and hands of a view whose poses are filled, for `time` [s], and point the feet of these poses.

        `seen`: the eye (3,) and the distance [m] beyond which faces are too small to be seen.
        """
        dancers, age = self._dancers, min(max(time - now.time, 0.0), 2.0 * TICK)
        arms = dancers.held_arms(time)
        held = NOBODY_HELD if arms is None else arms.share
        eye, far = seen
        there, point = view.present, self._foot_point()

        def part(begin: int, end: int) -> None:
            point_feet(view.joint_position, view.joint_rotation, there, point, begin, end)
            draw_expressions(
                view.face, view.hand, view.joint_position, view.joint_rotation, there, self.number, self.choice,
                self._slow, self.hands, SHAPES, held, eye, far, self._seed, age, time, begin, end,
            )  # fmt: skip

        run_rows(part, len(self.number), least=4 * RANGE)

    def _foot_point(self) -> Float64:
        """Return how far feet are pointed, (A,): those of captured performers are as they are."""
        point = self._dancers.variation[FOOT_POINT]
        if self._dancers.captured:
            point = point.copy()
            for captured in self._dancers.captured.values():
                point[captured.rows] *= 1.0 - captured.fade
        return point

    def hashed(self) -> tuple[npt.NDArray[np.generic], ...]:
        """Return the arrays that belong to the state hash."""
        return self.number, self.choice, self.hands, self.asked

    def is_consistent(self) -> bool:
        """Whether targets, dancers and shapes are within the tables that kernels look them up in."""
        kinds, others = self.choice[:, (KIND, LAST_KIND)], self.choice[:, (OTHER, LAST_OTHER)]
        known = ((kinds >= 0) & (kinds <= RIGHT_HAND) & (others >= NOBODY) & (others < len(self.number))).all()
        shapes = ((self.asked >= NO_SHAPE) & (self.asked < len(SHAPES))).all()
        return bool(known and shapes and (others[kinds == DANCER] >= 0).all())
