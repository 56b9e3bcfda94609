"""Making of a step from what a performer danced: a recording as of `live steps add`, read as the next start reads it.

The take is written as a motion file with its description into a folder of its own and read from there, with its feet
planted and its contacts found, so that a step is the same clip bit by bit now and after the next start.
"""

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.base.errors import PersonError
from live.graph.library_insert import insert_clips
from live.graph.motion_graph import MotionGraph
from live.library.add_step import MAX_NAMES
from live.library.step_folder import load_folder, varied_steps, with_path_variants
from live.library.step_writer import append_step
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import smoothstep
from live.motion.editing.tempo_forms import tempo_forms
from live.motion.formats.bvh_writer import FRAME_RATE, write_bvh
from live.motion.forward_kinematics import forward_kinematics
from live.motion.step_clip import StepClip
from live.show.capture.danced_poses import LEAD_OUT_BEATS, Take
from live.show.patch.patch import Patch

JOIN_BEATS: Final = 1.0
"""Beats at the end in which a step is led back to the pose in which it began, ..."""
MAX_JOIN_M: Final = 0.25
"""... if it ends at most so far from it (mean over the joints, after turn and shift)."""
BPM_DIGITS: Final = 3
_HEAD_UP: Final = np.array((0.0, 0.0, 1.0))
_Y: Final = np.array((0.0, 1.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class LearntStep:
    """A step that was learnt: its clips, the graph with them, and its files."""

    clips: tuple[StepClip, ...]
    graph: MotionGraph
    files: dict[str, bytes]
    """Contents by name: the motion file, then its description."""
    fits_tempo: bool
    """Whether the next start, at the tempo of the patch, would dance it, too."""


def learn_step(
    take: Take, graph: MotionGraph, patch: Patch, span: tuple[float, float], folder: Path | None
) -> LearntStep:
    """Return the step of a take that is over, inserted into `graph`; PersonError if it cannot be danced.

    `span`: tempo of the show [bpm]; `folder`: where its files will be put, whose names stay as they are. Slow.
    """
    if take.beats_per_measure != graph.library.beats_per_measure:
        raise PersonError(f"it has {take.beats_per_measure} beats a measure, the steps have another metre")
    bpm, clip = take_clip(take)
    stem = _free_stem(take.name, folder)
    fields = {
        "file": f"{stem}.bvh", "name": take.name, "bpm": bpm,
        "first_beat_s": round(take.beats_per_measure * 60.0 / bpm, 6),
        "beats_per_measure": take.beats_per_measure, "measures": take.measures, "repair": True,
    }  # fmt: skip
    description = append_step("", fields, {"name": f"learnt from {take.performer}"})
    assert description is not None
    files = {f"{stem}.bvh": write_bvh(clip, rate=None).encode(), f"{stem}.toml": description.encode()}
    with tempfile.TemporaryDirectory(prefix="learnt-") as place:
        for name, contents in files.items():
            (Path(place) / name).write_bytes(contents)
        read = load_folder(Path(place))
    chosen = with_path_variants(read)
    formed = tempo_forms(chosen + varied_steps(chosen, patch.variations, patch.seed), span)
    clips = chosen if formed.refused else formed.clips
    grown = insert_clips(graph, clips)
    index = grown.library.step_index(take.name)
    if index is None or not len(grown.entries(index)):
        raise PersonError("no step of the library ends or begins as it does", "begin and end it standing on both feet")
    return LearntStep(tuple(clips), grown, files, not formed.refused)


def take_clip(take: Take) -> tuple[float, Clip]:
    """Return the tempo at which a take was danced [bpm], and its motion: a measure before it, itself, a little more.

    Samples are even in beats, so that its measures are as long as each other. Where there are no poses, the nearest one
    is held.
    """
    beats, times = take.stamp.T
    inside = (beats >= take.first) & (beats <= take.end)
    slope = np.polyfit(times[inside] - times[inside][0], beats[inside], 1)[0]
    bpm = round(float(np.clip(60.0 * slope, 20.0, 400.0)), BPM_DIGITS)
    size = take.beats_per_measure
    count = round((take.end + LEAD_OUT_BEATS - take.first + size) * 60.0 / bpm * FRAME_RATE)
    moments = take.first - size + np.arange(count) * bpm / 60.0 / FRAME_RATE
    root, rotation = _poses_at(take, moments)
    root, rotation = _joined_ends(take, moments, root, rotation)
    contact = np.zeros((count, 2), np.bool_)  # found when the file is read
    return bpm, Clip(
        take.name, np.ascontiguousarray(root, np.float32),
        np.ascontiguousarray(quaternion.align_signs(rotation), np.float32), FRAME_RATE, contact,
    )  # fmt: skip


def _poses_at(take: Take, moments: Float) -> tuple[Float64, Float64]:
    """Return hips (M, 3) and rotations (M, J, 4) at these beats (M,)."""
    beats = take.stamp[:, 0]
    after = np.clip(np.searchsorted(beats, moments), 1, len(beats) - 1)
    part = np.clip((moments - beats[after - 1]) / np.maximum(beats[after] - beats[after - 1], 1e-9), 0.0, 1.0)
    hips, rotation = take.hips.astype(np.float64), take.rotation.astype(np.float64)
    root = hips[after - 1] * (1.0 - part[:, None]) + hips[after] * part[:, None]
    return root, np.asarray(quaternion.slerp(rotation[after - 1], rotation[after], part[:, None]), np.float64)


def _joined_ends(take: Take, moments: Float, root: Float64, rotation: Float64) -> tuple[Float64, Float64]:
    """Lead the end back to the pose of the beginning if it is near to it, so that the step can be repeated."""
    ends, turned = _poses_at(take, np.array((take.first, take.end)))
    yaw = [np.arctan2(*quaternion.rotate(one, _HEAD_UP)[[0, 2]]) for one in turned[:, 0]]
    turn = quaternion.from_axis_angle(_Y, np.asarray(yaw[1] - yaw[0]))
    wanted = turned[0].copy()
    wanted[0] = quaternion.mul(turn, wanted[0])
    stand = np.array([(0.0, ends[0, 1], 0.0), (0.0, ends[1, 1], 0.0)])
    position, _ = forward_kinematics(stand, np.stack([wanted, turned[1]]))
    if np.linalg.norm(position[0] - position[1], axis=-1).mean() > MAX_JOIN_M:
        return root, rotation
    away = quaternion.mul(quaternion.inverse(turned[1]), wanted)  # the same for all samples, in each joint's own axes
    away = away * np.where(away[..., :1] < 0.0, -1.0, 1.0)
    share = smoothstep((moments - take.end + JOIN_BEATS) / JOIN_BEATS)
    still = np.zeros_like(away)
    still[..., 0] = 1.0
    bent = quaternion.slerp(still[None], away[None], share[:, None])
    root = root.copy()
    root[:, 1] += share * (ends[0, 1] - ends[1, 1])
    return root, np.asarray(quaternion.mul(rotation, bent), np.float64)


def _free_stem(name: str, folder: Path | None) -> str:
    """Return a file name without its ending that no file of the folder has."""
    plain = re.sub(r"[^\w]+", "_", name.casefold(), flags=re.ASCII).strip("_") or "learnt"
    for number in range(1, MAX_NAMES):
        stem = plain if number == 1 else f"{plain}-{number}"
        if folder is None or not any((folder / f"{stem}{ending}").exists() for ending in (".bvh", ".toml")):
            return stem
    raise PersonError(f"{folder} holds {MAX_NAMES} files called {plain}", "choose another name")


def save_step(step: LearntStep, folder: Path | None) -> str:
    """Put the files of a step into the show's folder of steps; return why it cannot be kept, empty if it is."""
    if folder is None:
        return "the show has no folder of steps of its own"
    made: list[Path] = []
    try:
        for name, contents in step.files.items():
            path = folder / name
            with path.open("xb") as file:
                made.append(path)
                file.write(contents)
    except OSError as error:
        for path in made:
            path.unlink(missing_ok=True)
        return f"{folder} cannot be written: {error.strerror}"
    return ""
