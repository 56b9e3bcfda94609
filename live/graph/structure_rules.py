"""Structure rules: which steps may follow which, independent of pose distance (T135, T136).

A step with a named end pose leads only to steps with the same begin pose, and to steps without a named one. A step
that transfers the weight ends on the other foot, so its repeat is an instance of the other side.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from live.base.arrays import Bool, Int32, Int64
from live.motion.step_clip import StepClip

UNREACHABLE = 1 << 20
"""Hops to a step that cannot be reached."""

if TYPE_CHECKING:
    from live.graph.step_library import StepLibrary


@dataclass(frozen=True, slots=True, eq=False)
class StructureCodes:
    """The structure of N nodes as two numbers at each end, so that pairs can be compared without a table (N, N)."""

    leaving: Int32
    """For each node as the first of a pair: its end pose (-1: any) and what may not follow (-1: nothing), (N, 2)."""
    entering: Int32
    """For each node as the second: its begin pose (-1: any) and what it may not follow (-1: nothing), (N, 2)."""


def structure_codes(library: "StepLibrary") -> StructureCodes:
    """Return codes: u may be followed by v if the poses agree or one is -1, and the other numbers differ or are -1."""
    plain = {name: plain_pose(name) for clip in library.clips for name in (clip.end_pose, clip.begin_pose)}
    poses = {"": -1} | {name: number for number, name in enumerate(sorted({*plain.values()} - {""}))}
    sides: dict[tuple[str, str], int] = {}
    rows = []
    for clip in library.clips:
        repeat = sides.setdefault((clip.step, initial_side(clip)), len(sides)) if clip.weight_transfer else -1
        rows.append((poses[plain[clip.end_pose]], poses[plain[clip.begin_pose]], repeat))
    codes = np.array(rows, np.int32)[library.node_clip]
    return StructureCodes(*(np.ascontiguousarray(codes[:, columns]) for columns in ((0, 2), (1, 2))))


def variation_codes(library: "StepLibrary") -> Int32:
    """Return a number for the variation that each of N nodes belongs to: its step, side and direction of travel."""
    numbers: dict[tuple[str, bool, str], int] = {}
    codes = [numbers.setdefault((c.step, c.mirrored, c.direction), len(numbers)) for c in library.clips]
    return np.array(codes, np.int32)[library.node_clip]


def may_follow_between(library: "StepLibrary", first: Int64, second: Int64) -> Bool:
    """The same for the nodes `first` (R,) and `second` (M,), shape (R, M)."""
    codes = structure_codes(library)
    leaving, entering = codes.leaving[first, None], codes.entering[None, second]
    agree = (leaving[..., 0] == entering[..., 0]) | (leaving[..., 0] < 0) | (entering[..., 0] < 0)
    return np.asarray(agree & ~((leaving[..., 1] == entering[..., 1]) & (leaving[..., 1] >= 0)), np.bool_)


def plain_pose(name: str) -> str:
    """Return a pose name normalized for comparison: case and blanks do not matter."""
    return " ".join(name.casefold().split())


def initial_side(clip: StepClip) -> str:
    """Return the side on which a step begins: the leading foot; if not given, as danced or mirrored."""
    return clip.leading_foot or ("mirrored" if clip.mirrored else "as danced")


def unmatched_poses(library: "StepLibrary") -> dict[str, str]:
    """Return steps whose variations all end, or all begin, in poses that no clip matches: step → reason (T043)."""
    begins = {plain_pose(clip.begin_pose) for clip in library.clips}
    ends = {plain_pose(clip.end_pose) for clip in library.clips}
    words: dict[str, str] = {}
    for name in library.steps:
        own = [clip for clip in library.clips if clip.step == name]
        if "" not in begins and not any(plain_pose(clip.end_pose) in {"", *begins} for clip in own):
            words[name] = f"ends in {_listed({clip.end_pose for clip in own})}, in which no step begins"
        elif "" not in ends and not any(plain_pose(clip.begin_pose) in {"", *ends} for clip in own):
            words[name] = f"begins in {_listed({clip.begin_pose for clip in own})}, in which no step ends"
    return words


def _listed(names: set[str]) -> str:
    return " or ".join(repr(name) for name in sorted(names))
