"""Structure: which steps may follow which, whatever their poses look like (T135, T136).

A step that is said to end in a pose leads only to steps that are said to begin in it, and to those of which nobody has
said anything. A step that transfers the weight ends on the other foot: its repeat is an instance of the other side.
"""

import numpy as np
import numpy.typing as npt

from live.graph.library import StepLibrary
from live.motion.step_clip import StepClip

Bool = npt.NDArray[np.bool_]


def may_follow(library: StepLibrary) -> Bool:
    """Whether the clip of node v may follow that of node u as far as its structure goes, shape (N, N)."""
    clips = [library.clips[clip] for clip in library.node_clip]
    ends = [plain_pose(clip.end_pose) for clip in clips]
    begins = [plain_pose(clip.begin_pose) for clip in clips]
    numbers = {name: number for number, name in enumerate(sorted({*ends, *begins} - {""}))}
    end, begin = (np.array([numbers.get(name, -1) for name in names]) for names in (ends, begins))
    agree = (end[:, None] == begin[None]) | (end[:, None] < 0) | (begin[None] < 0)
    transfers = np.array([clip.weight_transfer for clip in clips])
    side = np.array([begun_side(clip) for clip in clips])
    same_step = library.node_step[:, None] == library.node_step[None]
    repeats = same_step & transfers[:, None] & transfers[None] & (side[:, None] == side[None])
    return np.asarray(agree & ~repeats, np.bool_)


def plain_pose(name: str) -> str:
    """The name of a pose as names are compared: case and blanks do not matter."""
    return " ".join(name.casefold().split())


def begun_side(clip: StepClip) -> str:
    """The side on which a step is begun: the leading foot; if nobody has told it, as it was danced or mirrored."""
    return clip.leading_foot or ("mirrored" if clip.mirrored else "as danced")


def unmatched_poses(library: StepLibrary) -> dict[str, str]:
    """Steps whose variations all end, or all begin, in poses that no clip matches: step → why, in words (T043)."""
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
