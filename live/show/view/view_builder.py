"""View builder: fills the drawing snapshot of a show, and hashes its visible state."""

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.base.picture_parameters import EYE, FIELD_OF_VIEW, PLAN, TARGET
from live.base.stage_snapshot import StageView, Title
from live.clock.ticks import TICK
from live.control.events.events import FreezePicture
from live.motion.pose.arm_clearance import ArmEasing
from live.motion.skeleton import JOINT_COUNT
from live.show.dancers.expression import EVERYWHERE
from live.show.group.division import Division
from live.show.journal.state_hash import hash_of
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.clock.follower.timeline_follower import TimelineFollower
    from live.show.audience.audience import Audience
    from live.show.dancers.character_springs import CharacterSprings
    from live.show.dancers.dancers import Dancers
    from live.show.dancers.expression import Expression
    from live.show.dancers.garments import Garments
    from live.show.desk.light_desk import LightDesk
    from live.show.group.group_motion import GroupMotion
    from live.show.stages.light_stage import LightStage
    from live.show.view.appearance import Appearances


MAX_EXTRAPOLATION: Final = 2.0 * TICK
"""Maximum extrapolation beyond a measure line [s]; a frame is at most one tick after the last tick."""
BODY_HEIGHT: Final = 1.7
"""Height of a dancer [m] when detail is chosen."""
FULL_DETAIL, NO_DETAIL = 0.06, 0.045
"""Heights of a dancer, as shares of the picture's, from which on arms keep off others fully, and below which they do
not: there an arm in another's body is three pixels of 1080."""
FACE_DETAIL = 0.08
"""Dancers whose height is a smaller share of the picture's have no expression: there a head has 11 pixels of 1080."""
WIDEST = 4.0
"""No picture is wider than so many times its height; ..."""
BESIDE = 3.0
"""... whoever is so far [m] beyond its edges, or behind the camera, is not seen."""
LIVE_FIELDS: Final = ("brightness", "detailed", "flash_limit_lifted", "overlay", "guide", "guide_count")
"""Fields of a view that still change while the picture is frozen."""


class ViewBuilder:
    """Builder of drawing snapshots from the dancers and agents of one show; read-only."""

    EVENTS = (FreezePicture,)

    def __init__(
        self,
        dancers: "Dancers",
        motion: "GroupMotion",
        division: Division,
        desk: "LightDesk",
        audience: "Audience",
        light: "LightStage",
        follower: "TimelineFollower",
        appearances: "Appearances",
        expression: "Expression",
        garments: "Garments",
        springs: "CharacterSprings",
    ) -> None:
        self._expression = expression
        self._dancers, self._motion, self._division, self._desk = dancers, motion, division, desk
        self._audience, self._light, self._follower = audience, light, follower
        self._appearances, self._garments, self._springs = appearances, garments, springs
        self._frozen_view: StageView | None = None
        self._easing = ArmEasing()

    def view(self) -> StageView:
        """Return an empty drawing snapshot of the right size, to be filled each frame."""
        view = StageView.allocate(len(self._division.part), JOINT_COUNT)
        view.picture = self._desk.parameters.picture.copy()
        self._springs.prepare(view)
        return view

    @property
    def _brightness(self) -> float:
        return self._light.brightness * self._desk.master.level

    def fill(self, view: StageView, time: float, now: Now) -> None:
        """Fill the snapshot for `time` [s], at most a tick after `now`; poses are at the exact beat.

        While the picture is frozen only its light changes; a new view gets the stored picture (`handle`).
        """
        view.brightness, view.flash_limit_lifted = self._brightness, self._desk.master.flashes
        if self._desk.master.frozen and view.filled:
            return
        if self._desk.master.frozen and self._frozen_view is not None:
            _copy_view(self._frozen_view, view)
            return
        self._fill(view, time, now)

    def _fill(self, view: StageView, time: float, now: Now) -> None:
        view.filled, timeline, span = True, now.timeline, now.span
        beat = timeline.beat_at(time)
        fraction = span.fraction(beat)
        # a frame beyond the measure line extrapolates, because only the next tick crosses the line; the limit matters
        # after a stall, when several lines are overdue and no pose exists that far ahead
        on = min(max(beat - span.end, 0.0), MAX_EXTRAPOLATION * timeline.tempo / 60.0) / timeline.beats_per_measure
        if view.picture is not None:
            view.picture[:] = self._desk.parameters.picture
            after = min(max(time - now.time, 0.0), 2.0 * TICK)
            self._desk.spots.place(view, after)
            self._desk.camera_rig.place(view.picture, after, after * timeline.tempo / 60.0)
            self._desk.director.place(view.picture, after)
            self._desk.score_light.show(view, after)
        hips = self._dancers.drawn_hips
        self._dancers.pose(
            fraction + on,
            time,
            out=(view.joint_position, view.joint_rotation),
            visible=self._motion.present,
            detail=None if view.detailed or view.picture is None else motion_detail(view.picture, hips),
            easing=self._easing,
        )
        self._springs.show(view, time - now.time)
        self._motion.show(view)
        seen = EVERYWHERE if view.detailed or view.picture is None else face_distance(view.picture)
        self._expression.show(view, time, now, seen)
        view.group[:] = self._division.part
        view.appearance[:] = self._appearances.rows()
        self._garments.show(view, min(max(time - now.time, 0.0), MAX_EXTRAPOLATION))
        view.time, view.beat, view.tempo = time, beat, self._follower.tempo
        view.measure, view.beats_per_measure = span.number, timeline.beats_per_measure
        view.phase = fraction * timeline.beats_per_measure
        self._audience.show(view)
        view.titles = self.titles_at(beat)
        view.background_age[:] = self._desk.background_age
        view.energy = self._desk.energy
        after = min(max(time - now.time, 0.0), 2.0 * TICK)
        view.gobo_turns = self._desk.gobo_turns(after * timeline.tempo / 60.0 / timeline.beats_per_measure)
        counted = self._desk.cues.count_in(span.danced_beats(beat, self._desk.beats))
        view.count_in = 0.0 if counted is None else max(counted[0], 0.0)

    def titles_at(self, beat: float) -> tuple[Title, ...]:
        """Return the titles and words that are seen at a beat."""
        return (*self._audience.words.seen_at(beat), *self._desk.titles.seen_at(beat))

    def handle(self, event: FreezePicture, now: Now) -> None:
        """Store the picture when it is frozen, for views of a restored show; drop it when it is released.

        The desk has handled the event before.
        """
        if not self._desk.master.frozen:
            self._frozen_view = None
        elif self._frozen_view is None:
            still = self.view()
            still.guide = np.zeros((0, 10), np.float32)  # the largest array, and never frozen
            self._fill(still, now.time, now)
            self._frozen_view = still

    def state_hash(self, now: Now) -> str:
        """Return a short hash over every bit of the agents' and dancers' states and poses at the last tick."""
        dancers, danced, motion = self._dancers, self._dancers.present, self._motion
        beat = now.beat
        return hash_of(
            motion.state.flat, motion.entrances.state, motion.casting.group, danced.node, danced.placement,
            danced.correction, danced.aim_origin, danced.foot_aim, danced.take, danced.warp, dancers.lock.state,
            dancers.variation.drift.phase,
            *dancers.pose(now.span.fraction(beat), now.time, visible=motion.present),
            motion.stage_area.half, motion.stage_area.border,
            np.array([beat, now.timeline.tempo, self._brightness]),
            *self._expression.hashed(),
            *self._desk.hashed(),
            *(part for captured in dancers.captured.values() for part in captured.hashed()),
            *self._garments.hashed(),
        )  # fmt: skip


def face_distance(picture: Float64) -> tuple[Float64, float]:
    """Return the eye (3,) of a picture with these parameters, and the distance from it [m] beyond which faces and
    fingers are too small to be seen; a plan has no distance."""
    if picture[PLAN] > 0.0:
        return EVERYWHERE
    half = math.tan(math.radians(0.5 * float(picture[FIELD_OF_VIEW])))
    return picture[EYE], BODY_HEIGHT / (2.0 * half * FACE_DETAIL)


def motion_detail(picture: Float64, hips: Float32) -> Float64 | None:
    """Return how much detail of motion dancers at `hips` (A, 2) [m] need in a picture with these parameters, 0 to 1.

    None: all of it for everybody, also in a plan, whose camera has no distance. Lens shift up to a picture's size fits
    into the margins.
    """
    if picture[PLAN] > 0.0:
        return None
    eye, half = picture[EYE], math.tan(math.radians(0.5 * float(picture[FIELD_OF_VIEW])))
    way = picture[TARGET] - eye
    way /= max(float(np.linalg.norm(way)), 1e-6)
    to_x, to_z, to_y = hips[:, 0] - eye[0], hips[:, 1] - eye[2], 0.5 * BODY_HEIGHT - eye[1]
    depth = to_x * way[0] + to_y * way[1] + to_z * way[2]
    square = to_x**2 + to_z**2 + to_y**2
    seen = np.sqrt(np.maximum(square - depth**2, 0.0)) < WIDEST * half * np.maximum(depth, 0.0) + BESIDE
    seen &= depth > -BESIDE
    if seen.all() and float(square.max(initial=0.0)) <= (BODY_HEIGHT / (2.0 * half * FULL_DETAIL)) ** 2:
        return None
    height = BODY_HEIGHT / (2.0 * half * np.sqrt(square))
    return np.asarray(seen * np.clip((height - NO_DETAIL) / (FULL_DETAIL - NO_DETAIL), 0.0, 1.0), np.float64)


def _copy_view(still: StageView, view: StageView) -> None:
    """Copy a stored picture into `view`."""
    for field in fields(StageView):
        if field.name in LIVE_FIELDS:
            continue
        kept, there = getattr(still, field.name), getattr(view, field.name)
        if isinstance(kept, np.ndarray) and there is not None:
            if kept.shape == there.shape:
                there[...] = kept
            else:  # another number of garments
                setattr(view, field.name, kept.copy())
        else:
            setattr(view, field.name, kept)
