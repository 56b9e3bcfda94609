"""How well poses from a camera fit the truth: joints, feet, tempo, place on the floor, identity, gestures and steps.

F frames at the times of the truth, J joints (22). Frames without a pose hold NaN: they do not count as errors of joints
or places, which say for how many frames there was a pose, but as missing feet and identities.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from bench._camera_films import FilmTruth
from live.base.arrays import Bool, Float64, Int64
from live.motion.beats.tempo_estimation import estimate_tempo
from live.motion.clip import Clip
from live.motion.foot_contact import TOES_OVER_SOLE, find_contacts
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import JOINT_COUNT, SKELETON, SOLE_BELOW_ANKLE

_SIDES: Final = ("left", "right")


def _joints(*names: str) -> Int64:
    return np.array([SKELETON.index(side + name) for name in names for side in _SIDES])


_HANDS, _FEET, _BALLS = _joints("Hand"), _joints("Foot"), _joints("Toes")
_HEAD: Final = SKELETON.index("head")
SEEN_JOINTS: Final = np.sort(
    np.append(_joints("UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toes"), _HEAD)
)
"""The joints that landmarks of a pose model cover; trunk, neck and collar bones have to be inferred from them."""
STANDING_HIPS: Final = float(SKELETON.rest_positions()[0, 1])
"""Height of the hips of somebody who stands [m]."""


@dataclass(frozen=True, slots=True)
class Score:
    """Hits, false alarms and misses."""

    hits: int = 0
    false: int = 0
    missed: int = 0

    def __add__(self, other: "Score") -> "Score":
        return Score(self.hits + other.hits, self.false + other.false, self.missed + other.missed)

    @property
    def precision(self) -> float:
        """Share of what was found that is true; 1 if nothing was found."""
        return self.hits / (self.hits + self.false) if self.hits + self.false else 1.0

    @property
    def recall(self) -> float:
        """Share of what is true that was found; 1 if there is nothing."""
        return self.hits / (self.hits + self.missed) if self.hits + self.missed else 1.0

    @property
    def f1(self) -> float:
        """Harmonic mean of both; 1 if there is nothing and nothing was found."""
        total = 2 * self.hits + self.false + self.missed
        return 2 * self.hits / total if total else 1.0


# -- joints ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class JointError:
    """Distances of joints from the truth when the hips are laid on each other (MPJPE, root-aligned)."""

    mean: float
    """Over all 22 joints except the hips, which fit by definition [m]."""
    seen: float
    """Over `SEEN_JOINTS` [m]."""
    scaled: float
    """As `mean`, after the found body has got the true one's size [m]."""
    scaled_seen: float
    """As `seen`, after that [m]."""
    size: float
    """Size of the found body over the true one's."""
    each: Float64
    """Mean of every joint, unscaled [m], (J,)."""
    found: float
    """Share of frames with a pose."""


def joint_error(found: Float64, truth: Float64) -> JointError:
    """Return the error of found joints (F, J, 3) [m], in the truth's axes, against true ones (F, J, 3) [m].

    Only places count, not facing or floor. Sizes are compared by the sum of all bones. Without any pose all errors are
    NaN. Source of the measure: Ionescu et al. 2014, "Human3.6M", protocol 1.
    """
    _check_shapes(found, truth)
    there = _there(found)
    if not there.any():
        nothing = np.full(JOINT_COUNT, np.nan)
        return JointError(np.nan, np.nan, np.nan, np.nan, np.nan, nothing, 0.0)
    own, true = (points[there] - points[there, :1] for points in (found, truth))
    size = _bone_sum(own) / _bone_sum(true)
    each = np.linalg.norm(own - true, axis=-1).mean(axis=0)
    scaled = np.linalg.norm(own / size - true, axis=-1).mean(axis=0)
    return JointError(
        mean=float(each[1:].mean()), seen=float(each[SEEN_JOINTS].mean()), scaled=float(scaled[1:].mean()),
        scaled_seen=float(scaled[SEEN_JOINTS].mean()), size=size, each=each, found=float(there.mean()),
    )  # fmt: skip


def pose_joints(hips: Float64, rotation: Float64, scale: float = 1.0) -> Float64:
    """Return the joints (F, J, 3) [m] of poses: hips (F, 3) [m] in the world, local rotations (F, J, 4); NaN where
    either is NaN. `scale`: size of the body over the skeleton's."""
    there = np.isfinite(hips).all(axis=1) & np.isfinite(rotation).all(axis=(1, 2))
    joints = np.full((len(hips), JOINT_COUNT, 3), np.nan)
    if there.any():
        joints[there] = scale * forward_kinematics(hips[there] / scale, rotation[there])[0]
    return joints


def _bone_sum(joints: Float64) -> float:
    parents = SKELETON.parents[1:]
    return float(np.linalg.norm(joints[:, 1:] - joints[:, parents], axis=-1).sum(axis=1).mean())


def _there(points: Float64) -> Bool:
    return np.asarray(np.isfinite(points).all(axis=tuple(range(1, points.ndim))))


def _check_shapes(found: Float64, truth: Float64) -> None:
    if found.shape != truth.shape:
        raise ValueError(f"found {found.shape} and truth {truth.shape} differ in shape")


# -- feet and tempo --------------------------------------------------------------------------------------------------


def foot_contacts(joints: Float64, rate: float, scale: float = 1.0) -> Bool:
    """Return the contact of the left and right foot (F, 2) of joints (F, J, 3) [m] over the floor at y = 0, as the
    engine finds it; none in frames without a pose. `scale`: size of the body over the skeleton's."""
    there = _there(joints)
    contact = np.zeros((len(joints), 2), np.bool_)
    for first, last in _runs(there):
        part = joints[first : last + 1] / scale
        contact[first : last + 1] = find_contacts(part[:, _FEET], part[:, _BALLS], rate)
    return contact


def contact_score(found: Bool, truth: Bool) -> Score:
    """Return how well contacts (F, 2) of feet fit the true ones, frame by frame and foot by foot."""
    if found.shape != truth.shape:
        raise ValueError(f"contacts {found.shape} and truth {truth.shape} differ in shape")
    return Score(int((found & truth).sum()), int((found & ~truth).sum()), int((~found & truth).sum()))


@dataclass(frozen=True, slots=True)
class TempoError:
    """Tempi of found and true motion by the same estimate from feet and bounce."""

    found_bpm: float
    true_bpm: float

    @property
    def error(self) -> float:
        """Relative error of the found tempo."""
        return abs(self.found_bpm / self.true_bpm - 1.0)

    @property
    def octave_error(self) -> float:
        """The same for half, the same or twice the tempo, whichever is nearest."""
        return min(abs(ratio * self.found_bpm / self.true_bpm - 1.0) for ratio in (0.5, 1.0, 2.0))


def tempo_error(found: Clip, truth: Clip) -> TempoError | None:
    """Return the tempi of a found and the true motion of the same time; None if the truth has none.

    A found motion without a tempo has that of 0 bpm, which is wholly wrong.
    """
    true = estimate_tempo(truth)
    if true is None:
        return None
    own = estimate_tempo(found)
    return TempoError(0.0 if own is None else own.reference.bpm, true.reference.bpm)


def motion_clip(name: str, hips: Float64, rotation: Float64, rate: float, scale: float = 1.0) -> Clip:
    """Return poses, hips (F, 3) [m] and local rotations (F, J, 4), as a clip of the skeleton's size.

    Frames without a pose hold the one before them, the first ones the first pose. ValueError if there is no pose.
    """
    there = np.isfinite(hips).all(axis=1) & np.isfinite(rotation).all(axis=(1, 2))
    if not there.any():
        raise ValueError(f"{name}: no pose")
    held = np.maximum.accumulate(np.where(there, np.arange(len(hips)), int(np.argmax(there))))
    root, local = hips[held] / scale, rotation[held]
    joints = forward_kinematics(root, local)[0]
    contact = find_contacts(joints[:, _FEET], joints[:, _BALLS], rate)
    return Clip(name, root.astype(np.float32), local.astype(np.float32), rate, contact)


def true_clip(truth: FilmTruth, dancer: int) -> Clip:
    """Return the true motion of a dancer at the film's rate."""
    return motion_clip(truth.name, truth.hips[:, dancer], truth.rotation[:, dancer], truth.fps, truth.scale)


# -- place and identity ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class RootError:
    """Distances of the hips from the truth on the floor [m]."""

    mean: float
    p95: float
    height: float
    """Mean distance of their heights [m]."""
    found: float
    """Share of frames with a pose."""


def root_error(found: Float64, truth: Float64) -> RootError:
    """Return the error of hips (F, 3) [m] against true ones (F, 3) [m], both in the stage's axes."""
    _check_shapes(found, truth)
    there = _there(found)
    if not there.any():
        return RootError(np.nan, np.nan, np.nan, 0.0)
    off = found[there] - truth[there]
    away = np.hypot(off[:, 0], off[:, 2])
    mean, p95 = float(away.mean()), float(np.percentile(away, 95.0))
    return RootError(mean, p95, float(np.abs(off[:, 1]).mean()), float(there.mean()))


NEAREST: Final = 0.6
"""A found person farther from every dancer than this [m] is none of them."""


def identities(people: Sequence[Sequence[tuple[int, float, float]]], hips: Float64) -> Int64:
    """Return which found person each dancer is in each frame, (F, D): their identity, or -1 for nobody.

    `people`: for each frame identity (0 or more) and place on the floor (x, z) [m] of everyone found; `hips` (F, D, 3)
    [m]: the truth. One dancer gets one person: those assignments of the smallest sum of distances.
    """
    from scipy.optimize import linear_sum_assignment

    if len(people) != len(hips):
        raise ValueError(f"{len(people)} frames of people, {len(hips)} of the truth")
    found = np.full(hips.shape[:2], -1, np.int64)
    for frame, seen in enumerate(people):
        if not seen:
            continue
        places = np.array([(x, z) for _, x, z in seen])
        far = np.linalg.norm(hips[frame][:, None, ::2] - places, axis=-1)
        for dancer, person in zip(*linear_sum_assignment(np.minimum(far, 10.0 * NEAREST)), strict=True):
            if far[dancer, person] <= NEAREST:
                found[frame, dancer] = seen[person][0]
    return found


@dataclass(frozen=True, slots=True)
class Crossing:
    """Two dancers before or behind one another, from frame `first` to `last`."""

    dancers: tuple[int, int]
    first: int
    last: int


BODY_WIDTH: Final = 0.45
"""Dancers nearer than this beside each other, as the camera sees them at the nearer one's distance, overlap [m]."""
APART_S: Final = 0.5
"""Overlaps nearer in time than this are one [s]; and so long dancers must be apart before and after a crossing."""


def find_crossings(truth: FilmTruth) -> list[Crossing]:
    """Return all crossings of a film, by the hips in the picture, in the order of their first frames.

    Whether the dancers change sides or turn back does not matter. Those at the film's very beginning or end are left
    out.
    """
    across = truth.pixels()[:, :, 0, 0]
    depth = truth.hips @ truth.camera[2, :3] + truth.camera[2, 3]
    axis = truth.camera[2, :3]
    focal = float(np.linalg.norm(truth.camera[0, :3] - (truth.camera[0, :3] @ axis) * axis))
    least = round(APART_S * truth.fps)
    found = []
    for one, other in combinations(range(truth.hips.shape[1]), 2):
        nearer = np.minimum(depth[:, one], depth[:, other])
        overlap = np.abs(across[:, one] - across[:, other]) < BODY_WIDTH * focal / nearer
        runs: list[tuple[int, int]] = []
        for first, last in _runs(overlap):
            if runs and first - runs[-1][1] <= least:
                runs[-1] = (runs[-1][0], last)
            else:
                runs.append((first, last))
        frames = len(overlap)
        found += [Crossing((one, other), *run) for run in runs if run[0] >= least and run[1] < frames - least]
    return sorted(found, key=lambda crossing: (crossing.first, crossing.dancers))


@dataclass(frozen=True, slots=True)
class IdentityScore:
    """How identities last."""

    crossings: int
    kept: int
    """Crossings after which both dancers have the identities that they had before, and two different ones."""
    switches: int
    """How often a dancer's identity is another than the last that they had."""
    found: float
    """Share of dancers and frames with an identity."""

    @property
    def kept_share(self) -> float:
        """Share of crossings through which identities were kept; 1 without crossings."""
        return self.kept / self.crossings if self.crossings else 1.0


def identity_score(found: Int64, crossings: Iterable[Crossing], fps: float) -> IdentityScore:
    """Return how identities (F, D), -1 for nobody, last through the film and its crossings.

    Before and after a crossing a dancer's identity is the most frequent one of `APART_S`.
    """
    span = round(APART_S * fps)
    total = kept = 0
    for crossing in crossings:
        total += 1
        before = [_usual(found[max(crossing.first - span, 0) : crossing.first, who]) for who in crossing.dancers]
        after = [_usual(found[crossing.last + 1 : crossing.last + 1 + span, who]) for who in crossing.dancers]
        kept += before == after and -1 not in before and before[0] != before[1]
    switches = 0
    for who in range(found.shape[1]):
        known = found[found[:, who] >= 0, who]
        switches += int((np.diff(known) != 0).sum())
    return IdentityScore(total, kept, switches, float((found >= 0).mean()))


def _usual(found: Int64) -> int:
    """Return the most frequent identity, or -1."""
    known = found[found >= 0]
    return int(np.bincount(known).argmax()) if known.size else -1


# -- gestures and steps ----------------------------------------------------------------------------------------------

ARMS_UP: Final = "both arms up"
CROUCH: Final = "crouch"
JUMP: Final = "jump"
GESTURES: Final = (ARMS_UP, CROUCH, JUMP)
ARMS_OVER_HEAD: Final = 0.12
"""Both wrists are so far over the joint of the head [m]."""
CROUCHED: Final = 0.68
"""Share of their standing height that the hips are lower than."""
OFF_FLOOR: Final = 0.05
"""Both feet, heel and ball, are so far over the floor [m]."""
SHORTEST_S: Final = {ARMS_UP: 0.2, CROUCH: 0.2, JUMP: 0.1}
"""How long a gesture lasts at least [s]."""


@dataclass(frozen=True, slots=True)
class GestureEvent:
    """A gesture at the time of its beginning [s]."""

    kind: str
    time: float


def find_gestures(joints: Float64, rate: float, scale: float = 1.0) -> list[GestureEvent]:
    """Return the gestures of `GESTURES` in true joints (F, J, 3) [m], in time order, by what they are in space."""
    body = joints / scale
    wrists, head = body[:, _HANDS, 1].min(axis=1), body[:, _HEAD, 1]
    soles = np.minimum(body[:, _FEET, 1] - SOLE_BELOW_ANKLE, body[:, _BALLS, 1] - TOES_OVER_SOLE).min(axis=1)
    lasts = {
        ARMS_UP: wrists > head + ARMS_OVER_HEAD,
        CROUCH: body[:, 0, 1] < CROUCHED * STANDING_HIPS,
        JUMP: soles > OFF_FLOOR,
    }
    events = [
        GestureEvent(kind, first / rate)
        for kind, held in lasts.items()
        for first, last in _runs(held)
        if last - first + 1 >= SHORTEST_S[kind] * rate
    ]
    return sorted(events, key=lambda event: (event.time, event.kind))


def true_gestures(truth: FilmTruth, dancer: int) -> list[GestureEvent]:
    """Return the gestures that a dancer of a film makes."""
    return find_gestures(truth.joints[:, dancer], truth.fps, truth.scale)


def event_score(found: Iterable[float], truth: Iterable[float], tolerance: float) -> Score:
    """Return how many events [s] fit true ones within `tolerance` [s], each used once, as many pairs as possible."""
    own, true = sorted(found), sorted(truth)
    hits = place = 0
    for time in own:
        while place < len(true) and true[place] < time - tolerance:
            place += 1
        if place < len(true) and true[place] <= time + tolerance:
            hits += 1
            place += 1
    return Score(hits, len(own) - hits, len(true) - hits)


def gesture_score(
    found: Sequence[GestureEvent], truth: Sequence[GestureEvent], tolerance: float = 0.3
) -> dict[str, Score]:
    """Return the score of each kind of gesture that was found or is true, by name; add them for that of all."""
    kinds = sorted({event.kind for event in (*found, *truth)})
    return {
        kind: event_score(
            (event.time for event in found if event.kind == kind),
            (event.time for event in truth if event.kind == kind),
            tolerance,
        )
        for kind in kinds
    }


def step_share(found: Sequence[str | None], truth: Sequence[str]) -> float:
    """Return the share of measures whose step was recognised; None: no answer. NaN without measures.

    ValueError if their numbers differ.
    """
    if len(found) != len(truth):
        raise ValueError(f"{len(found)} recognised measures, {len(truth)} true ones")
    return sum(own == true for own, true in zip(found, truth, strict=True)) / len(truth) if truth else np.nan


def _runs(on: Bool) -> list[tuple[int, int]]:
    """Return first and last index of each run of True in (F,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], on, [False])).astype(np.int8)))
    return [(int(first), int(stop) - 1) for first, stop in edges.reshape(-1, 2)]
