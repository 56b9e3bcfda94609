"""Takes: other clips of the same step that may be mixed into a measure, live (T044-T047), and its variations (T142)."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32, Int64
from live.graph.storage_kernels import alike_measures
from live.motion import quaternion
from live.motion.step_clip import StepClip

if TYPE_CHECKING:
    from live.graph.step_library import StepLibrary


NO_TAKE = -1
MOMENTS: Final = 16
"""Moments of a measure at which takes are compared."""
MAX_CONTACTS_DIFFERING: Final = 0.15
"""Share of the moments at which a foot may stand in one take and swing in the other: a mixture would drag that foot."""
MAX_JOINT_ANGLE: Final = np.radians(95.0)
"""Farthest that a joint may be turned from one take to the other [rad]. A mixture of poses farther apart resembles
neither, and near 180 degrees it flips from one side to the other."""
MAX_ROOT_ANGLE: Final = np.radians(45.0)
"""The same for how far the hips have turned since the beginning of the measure [rad]: feet that stand in both takes
would go round in their mixture."""
MAX_TAKES: Final = 64
"""Takes of one node. Of a measure with more, each has others, evenly over all, so that all of them are mixed in."""
BLOCK: Final = 256
"""Measures compared at a time with all others."""


@dataclass(frozen=True, slots=True, eq=False)
class Takes:
    """For each of N nodes, the nodes with the same measure of the same step in another take, as compressed rows."""

    start: Int32
    """Takes of node u are start[u] to start[u + 1], shape (N + 1,)."""
    node: Int32
    """Nodes, in library order."""
    drawn_start: Int32
    """The same for the takes that are drawn at random: of a measure with variations those and the takes of its own
    direction, of any other all."""
    drawn: Int32

    def count(self, nodes: Int32) -> Int32:
        """Return the number of takes that are drawn for each of `nodes` (A,), (A,)."""
        return np.asarray(self.drawn_start[nodes + 1] - self.drawn_start[nodes], np.int32)

    def draw(self, nodes: Int32, random: Float64) -> Int32:
        """Return one take for each of `nodes` (A,) by its `random` in [0, 1), NO_TAKE if there is none, (A,)."""
        count = self.count(nodes)
        place = self.drawn_start[nodes] + (random * count).astype(np.int32)
        found = (
            self.drawn[np.minimum(place, max(len(self.drawn) - 1, 0))]
            if len(self.drawn)
            else np.full_like(nodes, NO_TAKE)
        )
        return np.where(count > 0, found, NO_TAKE).astype(np.int32)


def find_takes(library: "StepLibrary", leaving: npt.NDArray[np.bool_] | None = None) -> Takes:
    """Return all takes of a library. Only clips of one structural variation are mixed (T046): same foot, same poses.

    The rule is that of `check_same_structure`; besides, the feet must stand at the same time and the poses resemble
    each other throughout, because recordings of one name may be unlike. Measures of a stream (T037), examples of moods
    (T143) and those that are `leaving` (N,) are not takes of any other. A variation is a take of the clip that it was
    made of, and of copies of a recorded one on other paths; it has no takes itself, because it is only mixed in.
    """
    numbers: dict[tuple[object, ...], int] = {}
    # key of a take: all that must be equal but the side; -1 if the clip has no takes
    alone = [clip.in_stream or bool(clip.mood) for clip in library.clips]
    kind = np.array([
        -1 if out else numbers.setdefault(_kind(clip), len(numbers))
        for out, clip in zip(alone, library.clips, strict=True)
    ])  # fmt: skip
    foot = np.array([("", "left", "right").index(clip.leading_foot) for clip in library.clips])
    mirrored = np.array([clip.mirrored for clip in library.clips])
    variation = np.array([clip.variation for clip in library.clips])
    origins: dict[bytes, int] = {}
    origin = np.array([origins.setdefault(_origin(clip), len(origins)) for clip in library.clips])
    clip = library.node_clip
    place = kind[clip].astype(np.int64) * (int(library.node_measure.max()) + 1) + library.node_measure
    place[kind[clip] < 0] = -1
    if leaving is not None:
        place[leaving] = -1
    order = np.argsort(place, kind="stable")
    contact, rotation = _moments(library)
    pairs = [np.zeros((2, 0), np.int64)]
    for group in np.split(order, np.flatnonzero(np.diff(place[order])) + 1):
        if len(group) < 2 or place[group[0]] < 0:
            continue
        own = clip[group]
        left, right, side = foot[own] == 1, foot[own] == 2, mirrored[own]
        for first in range(0, len(group), BLOCK):
            some = slice(first, first + BLOCK)
            told = (left | right)[some, None] & (left | right)[None]
            same = np.where(told, left[some, None] == left[None], side[some, None] == side[None])
            same &= own[some, None] != own[None]
            same &= (variation[own] == 0)[some, None]
            same &= (variation[own] == 0) | (origin[own][some, None] == origin[own])
            alike_measures(
                group[some], group, contact, rotation,
                int(MAX_CONTACTS_DIFFERING * 2 * MOMENTS), float(np.cos(0.5 * MAX_JOINT_ANGLE)),
                float(np.cos(0.5 * MAX_ROOT_ANGLE)), same,
            )  # fmt: skip
            for row in np.flatnonzero(same.sum(axis=1) > MAX_TAKES):
                found = np.flatnonzero(same[row])
                same[row] = False
                same[row, found[np.linspace(0, len(found) - 1, MAX_TAKES).astype(np.int64)]] = True
            one, other = np.nonzero(same)
            pairs.append(np.stack([group[first + one], group[other]]))
    node, take = np.concatenate(pairs, axis=1)
    order = np.lexsort((take, node))
    node, take = node[order], take[order]
    directions: dict[str, int] = {}
    varied = np.zeros(library.node_count, np.bool_)
    varied[node[variation[clip[take]] > 0]] = True
    way = np.array([directions.setdefault(one.direction, len(directions)) for one in library.clips])[clip]
    drawn = ~varied[node] | (way[node] == way[take])
    rows = np.arange(library.node_count + 1)
    start, drawn_start = (np.searchsorted(of, rows).astype(np.int32) for of in (node, node[drawn]))
    return Takes(start, take.astype(np.int32), drawn_start, take[drawn].astype(np.int32))


def take_kinds(library: "StepLibrary") -> Int64:
    """Return a number for each clip, equal for takes of one step on one side (T046); -1 for measures of streams and for
    clips that no join leads to."""
    numbers: dict[tuple[object, ...], int] = {}
    alone = [clip.in_stream or clip.unjoined for clip in library.clips]
    kinds = [(*_kind(clip), clip.leading_foot or clip.mirrored) for clip in library.clips]
    return np.array(
        [-1 if out else numbers.setdefault(kind, len(numbers)) for out, kind in zip(alone, kinds, strict=True)]
    )


def _moments(library: "StepLibrary") -> tuple[Bool, npt.NDArray[np.float32]]:
    """Return contacts (N, MOMENTS, 2) and local rotations (N, MOMENTS, J, 4) of every measure at even moments.

    The root's rotation is relative to the first moment.
    """
    share = (np.arange(MOMENTS) + 0.5) / MOMENTS
    at: Int64 = np.round(
        library.node_first[:, None] + share * (library.node_last - library.node_first)[:, None]
    ).astype(np.int64)
    rotation = library.clip_rotation[at]
    root = rotation[:, :, 0].astype(np.float64)
    rotation[:, :, 0] = quaternion.mul(quaternion.inverse(root[:, :1]), root)
    return library.clip_contact[at], rotation


def _origin(clip: StepClip) -> bytes:
    """Return what a clip and its variations have in common sample by sample: contacts if it was recorded, else the way
    of the hips, which contacts of sketched directions share."""
    return clip.clip.contact.tobytes() if clip.recorded else clip.clip.root_position.tobytes()


def _kind(clip: StepClip) -> tuple[object, ...]:
    return (
        clip.step, clip.measures, clip.beats_per_measure, clip.begin_pose, clip.end_pose, clip.weight_transfer,
        clip.tempo_form,
    )  # fmt: skip
