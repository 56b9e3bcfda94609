"""Answers about the steps of a show: what each is like, what may follow it, its motion, and what a sequence lacks."""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.base.errors import PersonError
from live.graph.build.nearest_pair_report import joint_gaps
from live.graph.motion_graph import MotionGraph
from live.graph.search.path_diagnostics import find_missing
from live.graph.search.sequence import parse_sequence
from live.graph.search.sequence_spec import specify
from live.graph.step_library import StepLibrary
from live.motion.clip import read_clip
from live.motion.editing.facing import heading_of
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip, measured_distance
from live.show.view.stage_frames import MAX_JOINT_DANCERS, joints_frame

MAX_MEASURES: Final = 64
"""Longest sequence that is checked at once [measures]."""
SAMPLES_PER_BEAT: Final = 8
MAX_TAKES: Final = 4
"""Takes of a step whose motion is told at once."""
MAX_STEPS: Final = 2000
FEET: Final = ("left", "right")
MAX_JOINTS: Final = 4
"""Joints that a missing join names: those farthest apart."""
NEAR: Final = 0.1
"""Joints that are nearer than this [m] are not named."""


def step_values(graph: MotionGraph) -> list[dict[str, Any]]:
    """Return what each step is like, and which steps may follow it and precede it."""
    library = graph.library
    count = min(len(library.steps), MAX_STEPS)
    follows = _followers(graph)
    rows = []
    for step in range(count):
        clips = [clip for clip in library.joined_clips if clip.step == library.steps[step]]
        facts = [_clip_values(clip) for clip in clips]
        one = facts[0]
        rows.append(
            {
                "name": library.steps[step],
                "measures": max(clip.measures for clip in clips),
                "beats": library.beats_per_measure,
                "takes": facts,
                **{key: one[key] for key in ("direction", "distance_m", "turn_deg", "begin_foot", "end_foot")},
                "follows": [library.steps[each] for each in np.flatnonzero(follows[step])[:MAX_STEPS].tolist()],
                "precedes": [library.steps[each] for each in np.flatnonzero(follows[:, step])[:MAX_STEPS].tolist()],
                "connected": bool(len(graph.entries(step))),
            }
        )
    return rows


def _followers(graph: MotionGraph) -> Any:
    """Return whether the step of each column may follow that of each row, (C, C)."""
    library = graph.library
    source = np.repeat(np.arange(library.node_count), np.diff(graph.edge_start))
    joins = (library.node_measure[source] == library.node_measures[source] - 1) & (
        library.node_measure[graph.edge_target] == 0
    )
    found = np.zeros((len(library.steps), len(library.steps)), np.bool_)
    found[library.node_step[source[joins]], library.node_step[graph.edge_target[joins]]] = True
    return found


def _clip_values(clip: StepClip) -> dict[str, Any]:
    begin, end = feet_of(clip)
    return {
        "take": clip.clip.name,
        "mirrored": clip.mirrored,
        "direction": clip.direction,
        "distance_m": round(measured_distance(clip), 2),
        "turn_deg": round(math.degrees(turn_of(clip))),
        "begin_foot": begin,
        "end_foot": end,
        "begin_pose": clip.begin_pose,
        "end_pose": clip.end_pose,
        "bpm": round(clip.bpm, 1),
        "author": clip.author,
        "style": clip.style,
    }


def feet_of(clip: StepClip) -> tuple[str, str]:
    """Return the foot that begins a step, and the one that is put down last: "left", "right", or "" if unknown."""
    first, last = int(clip.first), math.ceil(clip.first + clip.measures * clip.samples_per_measure)
    contact = clip.clip.contact[first : last + 1].astype(np.int8)
    lifted = [np.flatnonzero(contact[:, foot] == 0) for foot in range(2)]
    put_down = [np.flatnonzero(np.diff(contact[:, foot]) == 1) for foot in range(2)]
    begin = clip.leading_foot or _first(*(int(rows[0]) if len(rows) else None for rows in lifted))
    end = _first(*(-int(rows[-1]) if len(rows) else None for rows in put_down))
    return begin, end


def _first(left: int | None, right: int | None) -> str:
    """Return the foot whose number is smaller; "" for none, or for both at once."""
    if left == right:
        return ""
    return FEET[0] if right is None or (left is not None and left < right) else FEET[1]


def turn_of(clip: StepClip) -> float:
    """Return how far the body turns over a step [rad], whole turns included; positive to the dancer's left."""
    first, last = int(clip.first), math.ceil(clip.first + clip.measures * clip.samples_per_measure)
    heading = np.unwrap(heading_of(clip.clip.rotation[first : last + 1, 0]))
    return float(heading[-1] - heading[0])


def _find(library: StepLibrary, words: str) -> int:
    step = library.step_index(words)
    if step is None:
        raise PersonError(f"no step is called {words[:60]!r}", f"the steps are {', '.join(library.steps[:40])}")
    return step


def motion_frames(graph: MotionGraph, words: str, takes: Sequence[int]) -> Iterator[dict[str, Any] | bytes]:
    """Yield a text frame about takes (from 1) of a step, and for each a frame of joints, whose rows are samples.

    Joints are where the step puts them: it begins at (0, 0) and faces +z. PersonError for a step or take that is not
    there.
    """
    library = graph.library
    step = _find(library, words)
    clips = [clip for clip in library.joined_clips if clip.step == library.steps[step]]
    chosen = list(takes) or [1]
    wrong = [take for take in chosen if not 1 <= take <= len(clips)]
    if wrong:
        raise PersonError(f"{library.steps[step]!r} has no take {wrong[0]}", f"there are {len(clips)}")
    rows, frames = [], []
    for take in chosen[:MAX_TAKES]:
        clip = clips[take - 1]
        per_beat = max(1, min(SAMPLES_PER_BEAT, (MAX_JOINT_DANCERS - 1) // clip.beats))
        joints, contact = _sampled(clip, clip.beats * per_beat + 1)
        rows.append(
            {**_clip_values(clip), "number": take, "measures": clip.measures, "samples_per_beat": per_beat}
            | {"contact": (contact[:, 0] + 2 * contact[:, 1]).tolist()}
        )
        frames.append(joints_frame(take, joints))
    yield {"kind": "motion", "step": library.steps[step], "beats": library.beats_per_measure, "takes": rows}
    yield from frames


def _sampled(clip: StepClip, count: int) -> tuple[Any, Any]:
    """Return joints (count, J, 3) [m] and contacts (count, 2) at equal times of the step."""
    samples = np.linspace(clip.first, clip.first + clip.measures * clip.samples_per_measure, count)
    root, rotation, contact = read_clip(clip.clip, samples)
    root = root - root[0] * (1.0, 0.0, 1.0)
    return forward_kinematics(root, rotation)[0], np.asarray(contact, np.int8)


def sequence_values(graph: MotionGraph, words: str) -> dict[str, Any]:
    """Return the steps of a sequence, as in the score, and what would have to be recorded so that it can be danced.

    PersonError for words that are no sequence.
    """
    library = graph.library
    wanted = parse_sequence(words, library)
    total = sum(entry.measures for entry in wanted)
    if total > MAX_MEASURES:
        raise PersonError(f"a sequence of {total} measures", f"{MAX_MEASURES} at most at once")
    missing = []
    for one in find_missing(graph, specify(library, wanted)):
        row: dict[str, Any] = {
            "measure": one.measure, "from": one.source, "to": one.target, "needs": one.needs, "because": [],
        }  # fmt: skip
        if one.pair is not None:
            row |= _join_values(graph, *one.pair)
        missing.append(row)
    steps = [None if entry.step is None else library.steps[entry.step] for entry in wanted]
    return {"kind": "sequence", "steps": steps, "measures": total, "missing": missing}


def _join_values(graph: MotionGraph, u: int, v: int) -> dict[str, Any]:
    """Return why node v does not follow node u: poses, feet, and the joints that are too far apart."""
    library = graph.library
    one, other = library.clips[library.node_clip[u]], library.clips[library.node_clip[v]]
    end, begin = feet_of(one)[1], feet_of(other)[0]
    because = []
    if one.end_pose and other.begin_pose and one.end_pose.casefold() != other.begin_pose.casefold():
        because.append(f"{one.step!r} ends in {one.end_pose}, {other.step!r} begins in {other.begin_pose}")
    if end and end == begin:
        because.append(f"{one.step!r} ends on the {end} foot, {other.step!r} begins with it")
    gaps = joint_gaps(graph, u, v)
    far = _farthest(gaps)
    if len(far):
        names = [f"{_joint_words(joint)} {100.0 * gaps[joint]:.0f} cm" for joint in far.tolist()]
        because.append(f"apart from one end to the other beginning: {', '.join(names)}")
    return {"because": because, "joints": [[SKELETON.names[joint], round(float(gaps[joint]), 3)] for joint in far]}


def _farthest(gaps: Float64) -> Int64:
    order = np.argsort(-gaps)[:MAX_JOINTS]
    return np.asarray(order[gaps[order] > NEAR], np.int64)


def _joint_words(joint: int) -> str:
    """Return a joint's name in words: "left lower arm"."""
    name = SKELETON.names[joint]
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name)
