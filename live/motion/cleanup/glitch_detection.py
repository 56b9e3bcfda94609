"""Detection of tracking faults in a recording (T161): missing or frozen stretches, swapped limbs, pops, jumps, noise.

Optical capture has three causes of faults: hidden markers, exchanged paths, noise. In joint data they appear as
outliers in acceleration (shocks), as left and right limbs that swap, or as joints frozen at the last pose.
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from live.base.arrays import Bool, Float, Float64, Int32
from live.motion import quaternion
from live.motion.retarget.body_tracks import BodyTracks

PAIRS: Final = (("LowerArm", "Hand"), ("LowerLeg", "Foot"))
"""Joints that are swapped together: arms, legs."""
SWAP_DISTANCE_RATIO: Final = 0.35
"""At a swap the exchanged limbs move at most this share of the unexchanged distance."""


def find_swaps(tracks: BodyTracks, kick_limit: float, start: int = 0) -> list[tuple[int, int, list[int], float]]:
    """Return (first frame, last frame, columns, distance of the swapped joints [m]) of every swapped stretch.

    If limbs are exchanged an odd number of times, the last stretch extends to the end.
    """
    found: list[tuple[int, int, list[int], float]] = []
    for pair in PAIRS:
        columns = [[tracks.column(side + joint) for side in ("left", "right")] for joint in pair]
        known = [(left, right) for left, right in columns if left is not None and right is not None]
        if not known:
            continue
        left = tracks.positions[start:, [c[0] for c in known]]
        right = tracks.positions[start:, [c[1] for c in known]]
        straight, crossed = _travelled_distance(left, right, left, right), _travelled_distance(left, right, right, left)
        steps = start + np.flatnonzero((crossed < SWAP_DISTANCE_RATIO * straight) & (straight > 4.0 * kick_limit))
        every = sorted(column for c in known for column in c)
        for first, last in zip(steps[::2], [*steps[1::2], tracks.frame_count - 1], strict=False):
            apart = float(np.linalg.norm(left[first - start] - right[first - start], axis=-1).max())
            found.append((int(first) + 1, int(last), every, apart))
    return found


def _travelled_distance(left: Float64, right: Float64, left_after: Float64, right_after: Float64) -> Float64:
    """Return the distance from each frame to the next, summed over both sides and all joints [m], shape (T - 1,)."""
    steps = np.linalg.norm(left_after[1:] - left[:-1], axis=-1) + np.linalg.norm(right_after[1:] - right[:-1], axis=-1)
    return np.asarray(steps.sum(axis=-1))


MAX_ACCELERATION: Final = 350.0
"""[m/s²]: in 50,000 faultless frames of salsa at 60 Hz the maximum is 280; faults have 440 to 2,300."""
MIN_KICK: Final = 0.06
"""Minimum kick (twice the deviation from the joint's path) that counts [m], however short a frame is."""
LOW_RATE_KICK: Final = 0.25
"""The same for low frame rates, where `MAX_ACCELERATION` would be too lenient."""
LOW_RATE_RATIO: Final = 3.0
"""Minimum ratio to the kick that 1 of 200 frames of the recording exceeds, at low frame rates."""
TWIST: Final = np.radians(40.0)
TWIST_RATE: Final = np.radians(2000.0)
"""Maximum change of a joint's rotation per frame [rad, rad/s]; wrists reach 1,700 degrees per second."""


@dataclass(frozen=True, slots=True, eq=False)
class ShockMeasure:
    """Change of velocity of each joint at each frame; 0 for the first and the last frame, which cannot be judged."""

    kick: Float64
    """Second difference of the position, |p(t-1) - 2 p(t) + p(t+1)| [m], shape (T, B)."""
    twist: Float64
    """Second difference of the rotation relative to the parent [rad], shape (T, B)."""
    kick_limit: float
    """Largest plausible kick at this frame rate [m]."""
    twist_limit: float

    @property
    def severity(self) -> Float64:
        """The larger of kick and twist relative to its limit; 1 or more is a fault, shape (T, B)."""
        return np.maximum(self.kick / self.kick_limit, self.twist / self.twist_limit)


def measure_shocks(tracks: BodyTracks, start: int = 0) -> ShockMeasure:
    """Return kicks and twists of every frame after `start`; earlier frames are 0."""
    kick = np.zeros(tracks.positions.shape[:2])
    twist = np.zeros_like(kick)
    if tracks.frame_count - start > 2:
        kick[start + 1 : -1] = np.linalg.norm(np.diff(tracks.positions[start:], 2, axis=0), axis=-1)
        turn = quaternion.mul(tracks.rotation[start + 1 :], quaternion.inverse(tracks.rotation[start:-1]))
        twist[start + 1 : -1] = rotation_angle(quaternion.mul(turn[1:], quaternion.inverse(turn[:-1])))
    usual = float(np.percentile(kick[start + 1 : -1], 99.5)) if tracks.frame_count - start > 2 else 0.0
    fast = MAX_ACCELERATION / tracks.rate**2
    limit = max(MIN_KICK, min(fast, max(LOW_RATE_KICK, LOW_RATE_RATIO * usual)))
    return ShockMeasure(kick, twist, limit, max(float(TWIST), float(TWIST_RATE) / tracks.rate))


def rotation_angle(rotation: Float) -> Float64:
    """Return the angle of unit quaternions [rad], 0 to pi, shape (...)."""
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(rotation[..., 1:], axis=-1), np.abs(rotation[..., 0])))


STILL_THRESHOLD: Final = 1e-6
"""Changes below this per frame [rad, m] count as none: even a standing body moves more."""
MIN_FROZEN_TIME: Final = 0.1
"""Minimum duration of a held pose [s]: shorter ones occur in files written at a higher rate than captured."""
ABRUPT_STOP_RATE: Final = np.radians(40.0)
"""A joint that turns faster than this [rad/s] just before or after was frozen by the recording."""
TRACKED_SHARE: Final = 0.5
"""Joints that move in fewer than this share of all frames are not tracked at all."""
MIN_FROZEN_JOINTS: Final = 2
"""Minimum number of joints: a single one is a knee or elbow at its limit in the capture program."""
MOVING_SPEED: Final = 0.05
"""The rest of the body must move faster than this [m/s] meanwhile, else the dancer holds a pose."""


def find_frozen(tracks: BodyTracks, start: int = 0) -> list[tuple[int, int, list[int]]]:
    """Return (first, last frame of the held pose, columns) of frozen joints.

    All joints are returned where the whole body stops and resumes abruptly.
    """
    if tracks.frame_count - start < 4:
        return []
    turn = rotation_angle(quaternion.mul(tracks.rotation[start + 1 :], quaternion.inverse(tracks.rotation[start:-1])))
    way = np.linalg.norm(np.diff(tracks.positions[start:], axis=0), axis=-1)
    still = turn < STILL_THRESHOLD
    alive = np.flatnonzero((~still).mean(axis=0) >= TRACKED_SHARE)
    shortest = max(3, round(MIN_FROZEN_TIME * tracks.rate))
    found: dict[tuple[int, int], list[int]] = {}
    for column in alive:
        for first, last in _still_runs(still[:, column], shortest):
            beside = [turn[place, column] for place in (first - 1, last) if 0 <= place < len(turn)]
            moving = float(np.median(way[first:last].max(axis=1))) * tracks.rate > MOVING_SPEED
            whole = bool((way[first:last] < STILL_THRESHOLD).all())
            if (
                max(beside, default=0.0) * tracks.rate > ABRUPT_STOP_RATE
                and (moving or whole)
                and first > 0
                and last < len(turn)
            ):
                found.setdefault((start + first, start + last), []).append(int(column))
    return [
        (first, last, columns) for (first, last), columns in sorted(found.items()) if len(columns) >= MIN_FROZEN_JOINTS
    ]


def _still_runs(still: Bool, shortest: int) -> list[tuple[int, int]]:
    """Return (first, last) frame of still stretches of at least `shortest` frames."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False])).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a + 1 >= shortest]


GlitchKind = Literal["missing", "frozen", "swapped", "pop", "jump", "noise"]

MIN_FRAMES: Final = 8
"""Shorter recordings [frames] are not checked."""
SHOCK_GAP: Final = 0.06
"""Shocks of one body part within this time [s] belong to one fault."""
MAX_POP_TIME: Final = 0.2
"""Longer bursts [s] are noise."""
EDGE_SEVERITY: Final = 0.5
"""Shocks of this severity adjacent to a fault belong to it."""
CAUSE_SHARE: Final = 0.3
"""A joint whose rotation explains this share of a kick is at fault."""
SINGLE_FRAME_RATIO: Final = 1.6
"""Of two consecutive shocks, one larger by this ratio marks a single bad frame."""
REST_ANGLE: Final = 1e-4
"""A body whose joints are all rotated by less than this [rad] was not tracked."""


@dataclass(frozen=True, slots=True)
class Glitch:
    """One fault. Frames count from 0, both ends included; a jump has the last frame before and the first after it."""

    kind: GlitchKind
    """"missing": all joints at rest; "frozen": held while others move; "swapped": left is right; "pop": away and back
    within `MAX_POP_TIME`; "jump": away and not back; "noise": a longer stretch that jitters."""
    first_frame: int
    last_frame: int
    joints: tuple[str, ...]
    """Joints that move wrongly, as named in the file."""
    at_fault: tuple[str, ...]
    """Joints whose own rotation is the cause (for the root also its position); a repair replaces these."""
    size_m: float
    """Lower bound of the largest deviation [m]."""

    @property
    def frames(self) -> range:
        """All frames of the fault."""
        return range(self.first_frame, self.last_frame + 1)


def find_glitches(tracks: BodyTracks, parents: Int32, start: int = 0) -> list[Glitch]:
    """Return all faults from frame `start` on (after a T-pose and its run-in), in order of time.

    `parents` (J,) is the file's. Nothing within human limits is reported: a small fault passes as dancing.
    """
    if tracks.frame_count - start < MIN_FRAMES:
        return []
    shocks = measure_shocks(tracks, start)
    found = [
        Glitch("swapped", first, last, _joint_names(tracks, columns), _joint_names(tracks, columns), size)
        for first, last, columns, size in find_swaps(tracks, shocks.kick_limit, start)
    ]
    explained = [edge for swap in found for edge in (swap.first_frame, swap.last_frame + 1)]
    for first, last, columns in find_frozen(tracks, start):
        names = _joint_names(tracks, columns)
        kind: GlitchKind = "missing" if _at_rest(tracks, first, last) else "frozen"
        found.append(Glitch(kind, first, last, names, names, _missed_distance(tracks, first, last, columns)))
        explained += [first, last, last + 1]
    for first, last, columns in _clusters(shocks, tracks, parents):
        if not any(first <= edge <= last + 1 for edge in explained):
            found.append(_make_glitch(tracks, shocks, parents, first, last, columns))
    return sorted(found, key=lambda glitch: (glitch.first_frame, glitch.last_frame, glitch.joints))


def _body_parts(tracks: BodyTracks, parents: Int32) -> list[list[int]]:
    """Return columns of the limbs and of the trunk with the head: shocks of different parts are different faults."""
    limbs: list[list[int]] = []
    for top in ("leftUpperLeg", "rightUpperLeg", "leftUpperArm", "rightUpperArm"):
        above = tracks.body.joint(top)
        limbs.append([c for c, joint in enumerate(tracks.joints) if above in _ancestors(parents, int(joint))])
    taken = {column for limb in limbs for column in limb}
    return [*limbs, [c for c in range(len(tracks.joints)) if c not in taken]]


def _ancestors(parents: Int32, joint: int) -> list[int]:
    """Return the joint and all its ancestors."""
    path = [joint]
    while parents[path[-1]] >= 0:
        path.append(int(parents[path[-1]]))
    return path


def _clusters(shocks: ShockMeasure, tracks: BodyTracks, parents: Int32) -> list[tuple[int, int, list[int]]]:
    """Return (first shock, last shock, columns) of every fault; body parts with a common cause share one fault."""
    severity = shocks.severity
    gap = max(3, round(SHOCK_GAP * tracks.rate))
    found: list[tuple[int, int, list[int]]] = []
    for columns in _body_parts(tracks, parents):
        worst = severity[:, columns].max(axis=1, initial=0.0)
        hits = np.flatnonzero(worst >= 1.0)
        for group in np.split(hits, np.flatnonzero(np.diff(hits) > gap) + 1) if hits.size else []:
            first, last = int(group[0]), int(group[-1])
            while worst[first - 1] >= EDGE_SEVERITY:
                first -= 1
            while worst[last + 1] >= EDGE_SEVERITY:
                last += 1
            found.append((first, last, [c for c in columns if severity[first : last + 1, c].max() >= EDGE_SEVERITY]))
    merged: list[tuple[int, int, list[int]]] = []
    for first, last, columns in sorted(found):
        causes = set(_faulty_joints(tracks, shocks, parents, slice(first, last + 1), columns))
        for place, (a, b, others) in enumerate(merged):
            if first <= b and causes & set(_faulty_joints(tracks, shocks, parents, slice(a, b + 1), others)):
                merged[place] = (a, max(b, last), others + columns)
                break
        else:
            merged.append((first, last, columns))
    return merged


def _make_glitch(
    tracks: BodyTracks, shocks: ShockMeasure, parents: Int32, first: int, last: int, columns: list[int]
) -> Glitch:
    window = slice(max(first - 1, 0), last + 2)
    size = 0.5 * float(shocks.kick[window][:, columns].max())
    causes = _faulty_joints(tracks, shocks, parents, window, columns)
    kind, first, last = _classify(tracks, shocks, first, last, columns)
    return Glitch(kind, first, last, _joint_names(tracks, columns), causes, size)


def _classify(
    tracks: BodyTracks, shocks: ShockMeasure, first: int, last: int, columns: list[int]
) -> tuple[GlitchKind, int, int]:
    """Classify the shocks from `first` to `last`; returns the kind and the frames to report."""
    if last - first < 2:
        # one bad frame gives kicks 1 : 2 : 1, a jump 1 : 1
        kicks = shocks.severity[[first, last]][:, columns].max(axis=1)
        if last == first or max(kicks) > SINGLE_FRAME_RATIO * min(kicks):
            frame = first if kicks[0] >= kicks[1] else last
            return "pop", frame, frame
        return "jump", first, last
    before = tracks.positions[first, columns] - tracks.positions[max(first - 1, 0), columns]
    way = tracks.positions[last, columns] - tracks.positions[first, columns]
    off = float(np.linalg.norm(way / (last - first) - before, axis=-1).max())
    if (last - first - 1) / tracks.rate > MAX_POP_TIME:
        return "noise", first + 1, last - 1
    if off >= shocks.kick_limit:
        return "jump", first, last
    return "missing" if _at_rest(tracks, first + 1, last - 1) else "pop", first + 1, last - 1


def _at_rest(tracks: BodyTracks, first: int, last: int) -> bool:
    return bool((rotation_angle(tracks.rotation[first : last + 1]) < REST_ANGLE).all())


def _faulty_joints(
    tracks: BodyTracks, shocks: ShockMeasure, parents: Int32, window: slice, columns: list[int]
) -> tuple[str, ...]:
    """Return joints whose rotations explain the kicks of `columns`: rotation times lever arm, compared along the
    ancestors."""
    at = {int(joint): column for column, joint in enumerate(tracks.joints)}
    kicks, twists = shocks.kick[window].max(axis=0), shocks.twist[window].max(axis=0)
    frame = window.start + int(np.argmax(shocks.kick[window][:, columns].max(axis=1)))
    guilty = {c for c in columns if twists[c] >= shocks.twist_limit}
    loudest = max(columns, key=lambda c: float(kicks[c]))
    kicked = {c for c in columns if kicks[c] >= shocks.kick_limit}
    if not guilty or kicks[loudest] >= EDGE_SEVERITY * shocks.kick_limit:
        kicked.add(loudest)
    for column in kicked:
        above = [at[j] for j in _ancestors(parents, int(tracks.joints[column]))[1:] if j in at]
        if not above:
            guilty.add(column)
            continue
        levers = np.linalg.norm(tracks.positions[frame, [column]] - tracks.positions[frame, above], axis=-1)
        parts = levers * twists[above]
        parts[-1] += kicks[above[-1]]
        guilty |= {c for part, c in zip(parts, above, strict=True) if part >= CAUSE_SHARE * parts.max()}
    return _joint_names(tracks, sorted(guilty))


def _missed_distance(tracks: BodyTracks, first: int, last: int, columns: list[int]) -> float:
    """Return the largest distance [m] that a joint of the rest of the body moved meanwhile."""
    others = [c for c in range(len(tracks.joints)) if c not in columns] or columns
    way = tracks.positions[min(last + 1, tracks.frame_count - 1), others] - tracks.positions[first, others]
    return float(np.linalg.norm(way, axis=-1).max())


def _joint_names(tracks: BodyTracks, columns: list[int]) -> tuple[str, ...]:
    return tuple(tracks.names[c] for c in sorted(set(columns)))
