"""Repair of tracking faults (T161): faulty frames are replaced by a smooth bridge between the good ones around them."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.cleanup.glitch_detection import Glitch, measure_shocks
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks

MAX_GAP: Final = 0.35
"""Longer gaps [s] are not bridged: cut the recording there or solve it again."""
SMOOTHNESS_LIMIT: Final = 0.7
"""A repair is accepted if it stays below this share of the shock limit."""
MAX_MARGIN: Final = 0.12
"""Maximum of good frames on either side that a bridge may replace [s]."""


@dataclass(frozen=True, slots=True)
class Repair:
    """Result of the repair of one fault."""

    glitch: Glitch
    done: bool
    """False if the recording was left unchanged."""
    first_frame: int
    last_frame: int
    """Range of the replaced frames (if `done`)."""
    joints: tuple[str, ...]
    """Replaced joints."""
    note: str
    """Description in one line."""


def repair(
    motion: SourceMotion, glitches: list[Glitch], *, fps: float | None = None
) -> tuple[SourceMotion, list[Repair]]:
    """Return the motion with its faults bridged, and the changes; all other frames and joints stay bit-identical.

    Rotations and positions are bridged from the last good frame to the first good one by Hermite cubics that keep the
    velocities at both ends (rotations in the tangent space, so that they follow SLERP's great circle if the velocities
    allow). If the root is at fault the whole body is bridged, else the joints at fault and their descendants. Gaps
    longer than `MAX_KEY_INTERVAL` and faults without a smooth bridge stay unchanged, with a note.
    """
    rate = fps or motion.header_fps
    tracks = body_tracks(motion, fps=rate)
    limit = SMOOTHNESS_LIMIT * measure_shocks(tracks).kick_limit
    done: list[Repair] = []
    for glitch in glitches:
        whole = tracks.names[0] in glitch.at_fault  # in some files the root is an ancestor of the hips
        joints = list(range(motion.joint_count)) if whole else _with_descendants(motion, glitch)
        motion, report = _repair_glitch(motion, glitch, joints, rate, limit)
        done.append(report)
    return motion, done


def _repair_glitch(
    motion: SourceMotion, glitch: Glitch, joints: list[int], rate: float, limit: float
) -> tuple[SourceMotion, Repair]:
    names = tuple(motion.names[j] for j in joints)
    first, last = glitch.first_frame, glitch.last_frame
    inner = (first + 1, last - 1) if glitch.kind == "jump" else (first, last)
    if (inner[1] - inner[0] + 1) / rate > MAX_GAP:
        return motion, _unrepaired(glitch, names, f"{(last - first + 1) / rate:.2f} s is too long to bridge")
    for margin in range(1, 2 + round(MAX_MARGIN * rate)):
        a, b = inner[0] - 1 - margin, inner[1] + 1 + margin
        if a < 1 or b > motion.frame_count - 2:
            return motion, _unrepaired(glitch, names, "too close to an end of the recording: drop those frames")
        bridged = _bridge(motion, joints, a, b)
        seen = body_tracks(_slice_frames(bridged, a - 1, b + 2), fps=rate)
        kick = np.linalg.norm(np.diff(seen.positions, 2, axis=0), axis=-1)
        if kick.max() <= limit:
            note = f"{glitch.kind}: frames {a + 1} to {b - 1} of {_describe_joints(names, motion)} bridged"
            return bridged, Repair(glitch, True, a + 1, b - 1, names, note)
    return motion, _unrepaired(glitch, names, "no smooth bridge found")


def _unrepaired(glitch: Glitch, joints: tuple[str, ...], why: str) -> Repair:
    note = f"{glitch.kind}: frames {glitch.first_frame} to {glitch.last_frame} left unchanged: {why}"
    return Repair(glitch, False, glitch.first_frame, glitch.last_frame, joints, note)


def _describe_joints(names: tuple[str, ...], motion: SourceMotion) -> str:
    if len(names) == motion.joint_count:
        return "the whole body"
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def _with_descendants(motion: SourceMotion, glitch: Glitch) -> list[int]:
    """Return the joints at fault and their descendants, ascending."""
    taken = np.zeros(motion.joint_count, np.bool_)
    for joint, parent in enumerate(motion.parents):
        taken[joint] = motion.names[joint] in glitch.at_fault or (parent >= 0 and taken[parent])
    return [int(joint) for joint in np.flatnonzero(taken)]


def _slice_frames(motion: SourceMotion, start: int, stop: int) -> SourceMotion:
    return replace(motion, translation=motion.translation[start:stop], rotation=motion.rotation[start:stop])


def _bridge(motion: SourceMotion, joints: list[int], a: int, b: int) -> SourceMotion:
    """Replace frames a + 1 to b - 1 by a bridge from frame a to frame b that keeps the velocities there."""
    steps = b - a
    s = (np.arange(1, steps) / steps)[:, None, None]
    translation, rotation = motion.translation.copy(), motion.rotation.copy()
    place, turn = motion.translation[:, joints], motion.rotation[:, joints]
    translation[a + 1 : b, joints] = place[a] + _hermite(
        s, place[b] - place[a], steps * (place[a] - place[a - 1]), steps * (place[b + 1] - place[b])
    )
    whole = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(turn[a]), turn[b]))
    start = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(turn[a - 1]), turn[a]))
    end = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(turn[b]), turn[b + 1]))
    vector = _hermite(s, whole, steps * start, steps * _tangent(whole, end))
    rotation[a + 1 : b, joints] = quaternion.mul(turn[a], quaternion.from_rotation_vector(vector))
    return replace(motion, translation=translation, rotation=rotation)


def _hermite(s: Float, end_value: Float, start: Float, end: Float) -> Float64:
    """Cubic from 0 at s = 0 to `end_value` at s = 1 with the given velocities at both ends."""
    return np.asarray((s**3 - 2 * s**2 + s) * start + (3 * s**2 - 2 * s**3) * end_value + (s**3 - s**2) * end)


def _tangent(vector: Float, spin: Float) -> Float:
    """Velocity of the rotation vector at which exp(vector) rotates with `spin` in its own axes (inverse right
    Jacobian)."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    safe = np.maximum(angle, 1e-4)
    factor = 1.0 / safe**2 - (1.0 + np.cos(safe)) / (2.0 * safe * np.maximum(np.sin(safe), 1e-4))
    cross = np.cross(vector, spin)
    return np.asarray(spin + 0.5 * cross + factor * np.cross(vector, cross))
