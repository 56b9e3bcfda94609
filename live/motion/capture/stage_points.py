"""A seen person's landmarks in stage axes: from one camera's picture, and fused from several cameras."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.capture.camera_view import CameraView
from live.motion.capture.landmark_kernels import ANKLE, HEEL, HIP, TOE
from live.motion.capture.landmarks import LANDMARK_COUNT, Landmarks
from live.motion.capture.standing_feet import SOLE_HEIGHTS, SOLES

_PLACED: Final = np.array([*range(11, 17), *range(23, 33)])
"""Landmarks that tell how far away the person is: shoulders, elbows, wrists and everything from the hips down."""
ACROSS, ALONG = 0.025, 0.12
"""Standard deviations [m], at 3 m, of a landmark across a camera's ray and along it: pictures tell little of depth."""
REACH: Final = 0.7
"""Persons whom two cameras see within this distance on the floor [m] are one."""
_SIZE_SPREAD: Final = 0.05
"""Standard deviation of the logarithm of a person's size over the model's at first, and at most."""
_SIZE_DRIFT: Final = 0.0002
"""Variance per second by which the model's size of one person changes with the pose."""
_FOOT_SPREAD: Final = 0.03
"""Standard deviation [m] of the height at which a standing foot is seen."""
_SLOW: Final = 0.4
"""A foot that moves across the ray by this speed [m/s] tells the floor with twice the standard deviation."""
_SPEED_SPAN: Final = 0.07
"""The time [s] over which the speed is measured."""
_ON_FLOOR: Final = 0.08
"""A foot whose depth would have to change by this share to stand on the floor is in the air rather than misjudged."""
_FOOT: Final = np.array((ANKLE, HEEL, TOE))
_SIZE_RANGE: Final = float(np.log(1.7))
"""Largest logarithm of a person's size over the model's average person."""


@dataclass(frozen=True, slots=True, eq=False)
class StagePoints:
    """One person's landmarks in stage axes (L landmarks, 33)."""

    time: float
    """Capture time in show time [s]."""
    position: Float64
    """(L, 3) [m]."""
    weight: Float64
    """How far each landmark is to be trusted, (L,), 0 to 1."""
    eye: Float64
    """Place of the camera (3,) [m]."""
    on_floor: bool
    """Whether heights are over the stage's floor (a calibrated camera), or over an unknown level."""

    size: float
    """The person's size over the model's average person."""
    depth: Float64
    """Direction (3,) in which positions are least sure: the ray of the only camera; zero after fusing."""

    @property
    def place(self) -> Float64:
        """The middle of the hips on the floor (2,) (x, z) [m]."""
        return np.asarray(0.5 * (self.position[HIP, ::2] + self.position[HIP + 1, ::2]))


class ViewedPerson:
    """One person in one camera: keeps their size, so that their distance from the camera is steady.

    The model scales everybody to its average person. Where the camera is calibrated, the ray of the lower foot meets
    the floor at the true distance; this gives the size, which is kept while both feet are in the air.
    """

    def __init__(self) -> None:
        self._size, self._variance = 0.0, _SIZE_SPREAD**2
        self._time = -np.inf
        self._soles: list[tuple[float, Float64]] = []
        self._floor_depth = np.ones(LANDMARK_COUNT)

    @property
    def size(self) -> float:
        """The person's size over the model's average person."""
        return float(np.exp(self._size))

    def points(self, landmarks: Landmarks, view: CameraView) -> StagePoints:
        """Return the landmarks in stage axes; raises ValueError for landmarks that are malformed."""
        _check(landmarks)
        gone = min(max(landmarks.time - self._time, 0.0), 1.0)
        self._time = landmarks.time
        weight = np.clip(landmarks.visibility.astype(np.float64), 0.0, 1.0) * min(max(landmarks.presence, 0.0), 1.0)
        rays = view.rays(landmarks.picture)
        seen = landmarks.body.astype(np.float64) @ _towards(rays[[HIP, HIP + 1]].mean(axis=0)).T
        away = _translation(seen, rays, np.maximum(weight, 1e-3))
        scale = self.size
        if view.calibrated:
            scale = self._follow_floor(landmarks, view, seen, rays, away, gone)
        # places in the picture are surer than the model's metres: keep their rays, take only the depth
        depth = scale * np.maximum(seen[:, 2] + away[2], 0.1)
        if view.calibrated:
            depth = depth * self._floor_depth
        camera = rays * depth[:, None]
        position = view.to_stage(camera)
        ray = _unit(0.5 * (position[HIP] + position[HIP + 1]) - view.position)
        return StagePoints(landmarks.time, position, weight, view.position, view.calibrated, scale, ray)

    def _follow_floor(
        self, landmarks: Landmarks, view: CameraView, seen: Float64, rays: Float64, away: Float64, gone: float
    ) -> float:
        """Return the size, from the floor under the foot that needs the smallest: a Kalman filter of one number."""
        depth = np.maximum(seen[SOLES, 2] + away[2], 0.1)
        soles = rays[SOLES, :2] * (self.size * depth)[:, None]
        while len(self._soles) > 1 and landmarks.time - self._soles[1][0] >= _SPEED_SPAN - 0.01:
            self._soles.pop(0)
        moved = np.zeros(4)
        if self._soles:
            begin, there = self._soles[0]
            moved = np.hypot(*(soles - there).T) / max(landmarks.time - begin, 1e-3)
        self._soles.append((landmarks.time, soles))
        self._variance += _SIZE_DRIFT * gone
        down = (rays[SOLES] @ view.rotation)[:, 1]
        sizes = (SOLE_HEIGHTS - view.position[1]) / np.where(down < -0.02, down * depth, np.nan)
        self._floor_depth = np.ones(LANDMARK_COUNT)
        sure = (landmarks.visibility[SOLES] > 0.3) & (sizes > 0.0)
        if not sure.any():
            return self.size
        found = np.log(np.where(sure, sizes, 1e3))
        lowest = int(np.argmin(found + 0.1 * np.minimum(moved, 2.0)))
        spread = _FOOT_SPREAD / max(float(view.position[1]), 0.3) * (1.0 + (moved[lowest] / _SLOW) ** 2)
        missed, noise = float(found[lowest]) - self._size, spread * spread
        if missed * missed > self._variance + noise:
            # higher than it should be: the foot is in the air; lower: the points are wrong
            noise *= 10.0 if missed > 0.0 else 3.0
        gain = self._variance / (self._variance + noise)
        self._variance = min((1.0 - gain) * self._variance, _SIZE_SPREAD**2)
        self._size += gain * float(np.clip(missed, -0.3, 0.3))
        self._size = float(np.clip(self._size, -_SIZE_RANGE, _SIZE_RANGE))
        # a foot that stands is where its ray meets the floor, whatever depth the model guesses
        off = found - self._size
        for side in (0, 1):
            own = off[2 * side : 2 * side + 2]
            shift = float(own.min())
            slow = 1.0 / (1.0 + (moved[2 * side : 2 * side + 2].min() / _SLOW) ** 4)
            share = slow * float(np.exp(-((shift / _ON_FLOOR) ** 2)))
            self._floor_depth[_FOOT + side] = np.exp(share * shift)
        return self.size


def fuse_views(seen: Sequence[StagePoints]) -> StagePoints:
    """Return one person's landmarks from several calibrated cameras.

    The positions are the mean by precision: each camera tells much across its rays and little along them, so that two
    cameras at an angle measure what each alone must guess. The time is the latest. Raises ValueError for no view.
    """
    if not seen:
        raise ValueError("there is no view to fuse")
    if len(seen) == 1:
        return seen[0]
    precisions = [_precision(each.position - each.eye, each.weight) for each in seen]
    pulled = np.sum([p @ each.position[..., None] for p, each in zip(precisions, seen, strict=True)], axis=0)
    position = np.linalg.solve(np.sum(precisions, axis=0), pulled)[..., 0]
    weight = 1.0 - np.prod([1.0 - each.weight for each in seen], axis=0)
    return StagePoints(
        max(each.time for each in seen),
        position,
        weight,
        seen[0].eye,
        all(each.on_floor for each in seen),
        float(np.mean([each.size for each in seen])),
        np.zeros(3),
    )


def same_persons(views: Sequence[Sequence[StagePoints]]) -> list[list[tuple[int, int]]]:
    """Return who is who in several calibrated cameras: for each person the pairs (camera, number in its list).

    A person whom two cameras see is close to the same place on the floor: the nearest pairs are joined first, and
    nobody gets two persons of one camera. Persons are in the order in which the first camera that sees them has them.
    """
    groups = [[(camera, number)] for camera, persons in enumerate(views) for number in range(len(persons))]
    places = [views[camera][number].place for ((camera, number),) in groups]
    apart = sorted(
        (float(np.linalg.norm(places[a] - places[b])), a, b)
        for a in range(len(groups))
        for b in range(a + 1, len(groups))
        if groups[a][0][0] != groups[b][0][0]
    )
    owner = list(range(len(groups)))
    for distance, a, b in apart:
        one, two = groups[owner[a]], groups[owner[b]]
        if distance > REACH or one is two or {camera for camera, _ in one} & {camera for camera, _ in two}:
            continue
        kept, gone = min(owner[a], owner[b]), max(owner[a], owner[b])
        groups[kept] = sorted(one + two)
        groups[gone] = []
        owner = [kept if each == gone else each for each in owner]
    return [group for group in groups if group]


def _check(landmarks: Landmarks) -> None:
    """Raise ValueError if the landmarks are malformed."""
    shapes = landmarks.picture.shape, landmarks.body.shape, landmarks.visibility.shape
    if shapes != ((LANDMARK_COUNT, 2), (LANDMARK_COUNT, 3), (LANDMARK_COUNT,)):
        raise ValueError(f"landmarks have the shapes {shapes}, {LANDMARK_COUNT} of each expected")
    values = (landmarks.picture, landmarks.body, landmarks.visibility)
    if (
        not all(np.isfinite(each).all() for each in values)
        or not np.isfinite((landmarks.time, landmarks.presence)).all()
    ):
        raise ValueError("landmarks contain a value that is not a finite number")
    if np.abs(landmarks.body).max() > 10.0 or np.abs(landmarks.picture).max() > 10.0:
        raise ValueError("landmarks are over 10 m from the hips, or far out of the picture")


def _towards(ray: Float64) -> Float64:
    """Return the shortest rotation (3, 3) from the camera's axis to a ray.

    The model sees a person cut out of the picture: its axes are those of a camera that looks straight at them.
    """
    x, y, z = ray / np.sqrt(ray @ ray)
    k = 1.0 / (1.0 + z)
    return np.array(((1.0 - k * x * x, -k * x * y, x), (-k * x * y, 1.0 - k * y * y, y), (-x, -y, z)))


def _translation(seen: Float64, rays: Float64, weight: Float64) -> Float64:
    """Return the translation (3,) [m] that brings the points `seen` (L, 3) nearest to their rays (least squares)."""
    points, ray, w = seen[_PLACED], rays[_PLACED], weight[_PLACED] ** 2
    a, b = ray[:, 0], ray[:, 1]
    right, low = a * points[:, 2] - points[:, 0], b * points[:, 2] - points[:, 1]
    whole, wa, wb = w.sum(), w @ a, w @ b
    matrix = np.array(((whole, 0.0, -wa), (0.0, whole, -wb), (-wa, -wb, w @ (a * a + b * b))))
    pulled = np.array((w @ right, w @ low, -(w @ (a * right + b * low))))
    matrix[np.arange(3), np.arange(3)] += 1e-9
    found: Float64 = np.linalg.solve(matrix, pulled)
    found[2] = min(max(found[2], 0.4), 60.0)
    return found


def _unit(vector: Float64) -> Float64:
    return np.asarray(vector / max(float(np.sqrt(vector @ vector)), 1e-9))


def _precision(away: Float64, weight: Float64) -> Float64:
    """Return the inverse covariances (L, 3, 3) of points `away` (L, 3) [m] from a camera."""
    distance = np.sqrt(np.sum(away * away, axis=1))
    ray = away / distance[:, None]
    nearness = (3.0 / np.maximum(distance, 1.0)) ** 2 * np.maximum(weight, 0.02) ** 2
    across, along = nearness / ACROSS**2, nearness / ALONG**2
    outer = ray[:, :, None] * ray[:, None, :]
    return np.asarray(across[:, None, None] * np.eye(3) + (along - across)[:, None, None] * outer)
