"""A seen person's landmarks, picture by picture, as poses of the engine's skeleton."""

from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.motion import quaternion
from live.motion.capture.camera_view import CameraView, assumed_view
from live.motion.capture.captured_body import FloorEstimator
from live.motion.capture.joint_rotations import SEEN_BY, JointRotations
from live.motion.capture.landmark_kernels import ANKLE, ELBOW, HEEL, HIP, KNEE, SHOULDER, TOE, WRIST
from live.motion.capture.landmarks import LANDMARK_NAMES, Landmarks
from live.motion.capture.limb_depth import LimbDepth
from live.motion.capture.one_euro import MAX_LEAD, PlaceFilter, RotationFilter
from live.motion.capture.stage_points import StagePoints, ViewedPerson
from live.motion.capture.standing_feet import SOLE_HEIGHTS, SOLES, StandingFeet, lowest_sole
from live.motion.skeleton import JOINT_COUNT, SKELETON

MIN_PRESENCE: Final = 0.5
"""Below this confidence of the model there is no person."""
HOLD: Final = 0.25
"""How long [s] the pose is held when the person is not seen; then they are lost."""
RETURN: Final = 0.25
"""How long [s] it takes to blend from a held pose to a person who is seen again."""
FORGET: Final = 1.5
"""A person who was not seen for this long [s] begins anew, without a blend."""
_FEW: Final = 0.05
"""Visibility under which a landmark tells nothing."""
_MANY: Final = 0.2
"""So much more visibility lets the filter follow in full."""
_UNSEEN_HOLD: Final = 0.4
"""How long [s] joints that are not seen keep their rotation before they relax."""
_RELAX_HALFLIFE: Final = 0.4
"""Half-life [s] with which they relax."""
_MAX_TURN: Final = np.radians(75.0)
"""Farthest turn of the pelvis from one picture to the next; a spinning dancer turns 40 degrees in 1/30 s."""
_TURN_SPEED: Final = 20.0
"""How much farther for each second [rad/s] where pictures are missing."""
_REFUSED: Final = 0.2
"""How long [s] sudden swaps and flips are refused; what lasts longer is true."""
_SWAP_GAIN, _SWAP_MISS = 0.5, 0.12
"""Left and right are exchanged back if that makes the distance from the last picture less than this share of it, where
it is over so many metres a landmark."""
_OTHER: Final = np.array(
    [
        LANDMARK_NAMES.index(
            name.replace("left", "right") if "left" in name else name.replace("right", "left")
            if "right" in name else name.replace("Left", "Right") if "Left" in name else name.replace("Right", "Left")
        )
        for name in LANDMARK_NAMES
    ]
)  # fmt: skip
"""For each landmark that of the other side."""
_LEGS: Final = np.array([row + side for row in (KNEE, ANKLE, HEEL, TOE) for side in (0, 1)])
_BODY: Final = np.array([*(row + side for row in (HIP, SHOULDER, ELBOW, WRIST) for side in (0, 1)), *_LEGS])
_ALL: Final = np.arange(len(_OTHER))
_SWAPPED_LEGS: Final = np.where(np.isin(_ALL, _LEGS), _OTHER, _ALL)
_FLOOR_NOISE: Final = 0.05
"""Heights of the lower foot under this [m] are noise: the foot stands."""
_ROTATION_FILTER: Final = (1.5, 1.2, 4.0)
"""Cut-off at rest [Hz], gain [Hz per rad/s] and cut-off of the speed [Hz] of the joints' One Euro filter."""
_PLACE_FILTER, _RISE_FILTER = (1.0, 1.5, 3.0), (3.0, 6.0, 4.0)
"""The same, with gains in Hz per m/s, of the hips' place and of the height of the lower foot."""
_LEG_LINE: Final = np.array((0.0, float(SKELETON.offsets[SKELETON.index("leftUpperLeg"), 1]), 0.0))
"""From the hips to the middle of the hip joints in the pelvis's axes [m]."""


def _relaxed() -> Float64:
    """Return local rotations (J, 4) of a body that stands with hanging arms."""
    pose = np.zeros((JOINT_COUNT, 4))
    pose[:, 0] = 1.0
    for side, sign in (("left", -1.0), ("right", 1.0)):
        pose[SKELETON.index(side + "UpperArm")] = quaternion.from_axis_angle(
            np.array((0.0, 0.0, sign)), np.asarray(np.radians(75.0))
        )
    return pose


_RELAXED: Final = _relaxed()

Pose = tuple[Float64, Float64]
"""Hips (3,) [m] on the stage and local rotations (J, 4) (w, x, y, z)."""


class LandmarkBody:
    """One seen person. To be used from one thread; same landmarks in, same poses out, bit by bit.

    Rotations go through One Euro filters and are predicted by the delay that the caller measured. Feet on the floor are
    planted.
    """

    def __init__(self) -> None:
        self._persons: dict[int, ViewedPerson] = {}
        self._assumed: CameraView | None = None
        self._start()

    def _start(self) -> None:
        self._rotation = RotationFilter(*_ROTATION_FILTER)
        self._place = PlaceFilter(*_PLACE_FILTER)
        self._rise = PlaceFilter(*_RISE_FILTER)
        self._feet = StandingFeet()
        self._joints = JointRotations()
        self._limbs = LimbDepth()
        self._floor = FloorEstimator()
        self._unseen = np.zeros(JOINT_COUNT)
        self._points: Float64 | None = None
        self._odd = 0.0
        self._time = -np.inf
        self._shown: Pose | None = None
        self._before: Pose | None = None
        self._caught = RETURN
        self.lost = True
        """Whether nobody was seen for over `HOLD`."""

    @property
    def contact(self) -> Bool:
        """Whether the left and the right foot stand on the floor (2,)."""
        return self._feet.contact.copy()

    @property
    def seen(self) -> Float64:
        """How long each joint has not been seen (J,) [s]; 0: it is seen now."""
        return self._unseen.copy()

    def update(self, landmarks: Landmarks, view: CameraView | None = None, lead: float = 0.0) -> Pose | None:
        """Return the pose `lead` [s] after the picture from one camera's landmarks; None if the person is lost.

        Without a `view` the camera is assumed to be level in the audience. Raises ValueError for malformed landmarks.
        """
        points = self.points(landmarks, view)
        return self.hold(landmarks.time) if points is None else self.update_points(points, lead)

    def points(self, landmarks: Landmarks, view: CameraView | None = None, camera: int = 0) -> StagePoints | None:
        """Return the landmarks that `camera` sees in stage axes, for `fuse_views`; None where there is no person."""
        if landmarks.presence < MIN_PRESENCE:
            return None
        if view is None:
            if self._assumed is None or self._assumed.aspect != landmarks.aspect:
                self._assumed = assumed_view(landmarks.aspect)
            view = self._assumed
        return self._persons.setdefault(camera, ViewedPerson()).points(landmarks, view)

    def hold(self, time: float) -> Pose | None:
        """Return the held pose at `time` [s], when the person is not seen; None if they are lost."""
        self.lost = self._shown is None or time - self._time > HOLD
        return None if self.lost else self._shown

    def update_points(self, points: StagePoints, lead: float = 0.0) -> Pose | None:
        """Return the pose `lead` [s] after the picture, from landmarks in stage axes."""
        gap = points.time - self._time
        if gap <= 0.0:
            return self.hold(points.time)
        if gap > FORGET:
            self._start()
        elif gap > HOLD:
            shown = self._shown
            feet, floor = self._feet, self._floor
            self._start()
            self._before, self._caught, self._feet, self._floor = shown, 0.0, feet, floor
        dt = 0.0 if self._points is None else gap
        self._time, self.lost = points.time, False
        position, weight = self._sorted(points.position, points.weight, dt)
        seen = position
        position = self._limbs.fit(seen, points.eye, points.depth, points.size)
        world = self._joints.find(position)
        if dt > 0.0 and self._flipped(world, dt):
            if self._odd <= _REFUSED:
                return self._shown
            self._before, self._caught, self._odd, dt = self._shown, 0.0, 0.0, 0.0
        self._points = seen
        self._filter(world, weight, dt)
        self._place_hips(points, position, world, dt)
        ahead = min(max(lead, 0.0), MAX_LEAD)
        rotation = self._rotation.predicted(ahead)
        x, z = self._place.value + ahead * self._place.speed
        rise = max(float(self._rise.value[0] + ahead * self._rise.speed[0]) - _FLOOR_NOISE, 0.0)
        hips = np.array((x, rise - lowest_sole(rotation), z))
        self._feet.plant(hips, rotation, dt)
        return self._blended(hips, rotation, dt)

    def _sorted(self, position: Float64, weight: Float64, dt: float) -> tuple[Float64, Float64]:
        """Return landmarks and weights with legs or the whole body's sides exchanged, if they were swapped."""
        if self._points is None or self._odd > _REFUSED:
            return position, weight
        last, now = self._points - _hips(self._points), position - _hips(position)
        for part, other in ((_BODY, _OTHER), (_LEGS, _SWAPPED_LEGS)):
            kept = np.sqrt(np.sum((now[part] - last[part]) ** 2, axis=1)).mean()
            swapped = np.sqrt(np.sum((now[other[part]] - last[part]) ** 2, axis=1)).mean()
            if kept > _SWAP_MISS and swapped < _SWAP_GAIN * kept:
                self._odd += dt
                return position[other], weight[other]
        return position, weight

    def _flipped(self, world: Float64, dt: float) -> bool:
        """Return whether the pelvis turned impossibly far since the last picture, and so the picture is refused."""
        turn = 2.0 * np.arccos(min(abs(float(world[0] @ self._rotation.value[0])), 1.0))
        if turn > _MAX_TURN + _TURN_SPEED * max(dt - 1.0 / 30.0, 0.0):
            self._odd += dt
            return True
        self._odd = max(self._odd - 0.5 * dt, 0.0)
        return False

    def _filter(self, world: Float64, weight: Float64, dt: float) -> None:
        """Filter the rotations; joints that are not seen hold, then relax."""
        trust = np.clip((weight[SEEN_BY].min(axis=1) - _FEW) / _MANY, 0.0, 1.0)
        self._unseen = np.where(trust > 0.0, 0.0, self._unseen + dt)
        rotation = self._rotation.update(world, dt, trust)
        relaxing = self._unseen > _UNSEEN_HOLD
        if relaxing[1:].any():
            relaxing[0] = False
            rotation[relaxing] = _mix(rotation[relaxing], _RELAXED[relaxing], 1.0 - 0.5 ** (dt / _RELAX_HALFLIFE))
            self._rotation.speed[relaxing] = 0.0

    def _place_hips(self, points: StagePoints, position: Float64, world: Float64, dt: float) -> None:
        """Filter the place of the hips, their height over the floor, and find the contacts of the feet."""
        hips = _hips(position) - quaternion.rotate(world[0], _LEG_LINE)
        self._place.update(hips[::2], dt)
        soles = position[SOLES]
        low = float((soles[:, 1] - SOLE_HEIGHTS).min())
        if not points.on_floor:
            floor = self._floor.update(low, points.time)
            soles[:, 1] -= floor
            low -= floor
        self._rise.update(np.array((max(low, 0.0),)), dt)
        self._feet.observe(soles, points.depth, points.time)

    def _blended(self, hips: Float64, rotation: Float64, dt: float) -> Pose:
        """Return the pose, blended with that before a gap."""
        if self._before is not None:
            self._caught += dt
            share = min(self._caught / RETURN, 1.0)
            if share < 1.0:
                hips = self._before[0] + share * (hips - self._before[0])
                rotation = _mix(self._before[1], rotation, share)
            else:
                self._before = None
        self._shown = (hips, rotation)
        return self._shown


def _hips(points: Float64) -> Float64:
    """Return the middle of the hips (3,) of landmarks (L, 3)."""
    return np.asarray(0.5 * (points[HIP] + points[HIP + 1]))


def _mix(a: Float64, b: Float64, share: float) -> Float64:
    """Interpolate unit quaternions (..., 4) along the shorter arc (the chord, normalized)."""
    near = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, -b, b)
    return np.asarray(quaternion.unit(a + share * (near - a)), np.float64)
