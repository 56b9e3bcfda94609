"""The body in a skeleton whose joint names say nothing, found by its shape and hierarchy.

Two limbs of a pair hang from one joint and are as long as each other. Of the longest pairs the arms are the one that
is reached through the trunk of the other. Each limb has two long bones in a row. Toes, or else the knees, point ahead;
that tells left from right.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.formats.source_motion import LocalPose, SourceMotion, rest_pose, world_pose
from live.motion.retarget.source_body import SourceBody
from live.motion.skeleton import SKELETON

SAME_LENGTH: Final = 0.15
"""Largest difference of the lengths of a pair of limbs, as a share."""
MIN_LIMB: Final = 0.35
"""Least length of a limb as a share of the longest chain of the skeleton: shorter pairs are fingers, eyes or ears."""
LEGS_TO_ARMS: Final = 1.15
"""Least ratio of the two long bones of a leg to those of an arm: else the skeleton hangs from its shoulders."""
MIN_BONE: Final = 0.02
"""Shorter bones, as a share of their limb, are joints on top of each other."""
LOOKED_AT: Final = 200
"""Most frames from which the direction ahead is told."""
MAX_JOINTS: Final = 500
MAX_LIMBS: Final = 6
MAX_PAIRS: Final = 24
"""Most joints, long limbs of one joint, and pairs that are looked at: a hostile file must not take long."""
MIN_AHEAD: Final = 0.02
"""Least length of the direction ahead, as a share of the legs: below it left and right are not told apart."""


SIDES: Final = ("left", "right")
_Bones = tuple[int, int, int, int | None]


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two limbs below `parent`, as chains of joints; the first bone of each leads to its first joint."""

    parent: int
    chains: tuple[tuple[int, ...], tuple[int, ...]]
    bones: tuple[_Bones, _Bones]
    """Of each limb the joints before, between and after its two long bones, and the next one, if any."""
    length: float


def find_body_by_shape(motion: SourceMotion) -> SourceBody | None:
    """Return the body of a skeleton with arms, legs and a head; None if the shape is not clearly a body."""
    parents = motion.parents.tolist()
    if len(parents) > MAX_JOINTS:
        return None
    bone = _bone_lengths(motion)
    children: list[list[int]] = [[] for _ in parents]
    for joint, parent in enumerate(parents):
        if parent >= 0:
            children[parent].append(joint)
    reach = np.zeros(len(parents))
    for joint in reversed(range(len(parents))):  # parents come first
        reach[joint] = bone[joint] + max((reach[child] for child in children[joint]), default=0.0)
    found = _legs_and_arms(_limb_pairs(children, reach, bone), parents, bone)
    if found is None:
        return None
    legs, arms = found
    leg_sides = _left_first(motion, legs, arms)
    if leg_sides is None:
        return None
    joints: dict[str, int | None] = dict.fromkeys(SKELETON.names)
    for side, leg, arm in zip(SIDES, leg_sides, _arms_beside(motion, legs, arms, leg_sides), strict=True):
        joints |= _named(side, ("UpperLeg", "LowerLeg", "Foot", "Toes"), legs.bones[leg])
        joints |= _named(side, ("UpperArm", "LowerArm", "Hand"), arms.bones[arm][:3])
        before = [joint for joint in arms.chains[arm] if joint < arms.bones[arm][0]]
        joints[f"{side}Shoulder"] = before[0] if before else None
    spine = _between(arms.parent, legs.parent, parents)
    neck = _neck(arms, children, reach, set(motion.end_parents.tolist()))
    joints |= {"hips": legs.parent, "spine": spine[0]}
    if len(spine) > 1:
        joints["chest"] = spine[len(spine) // 2]
        joints["upperChest"] = spine[-1] if len(spine) > 2 else None
    if neck:
        joints["head"] = neck.pop()
        joints["neck"] = neck[0] if neck else None
    return SourceBody(joints, tuple(spine), tuple(neck), by_shape=True)


def _named(side: str, names: tuple[str, ...], joints: Sequence[int | None]) -> dict[str, int | None]:
    return {side + name: joint for name, joint in zip(names, joints, strict=True)}


def _neck(arms: _Pair, children: list[list[int]], reach: Float64, ended: set[int]) -> list[int]:
    """The joints from the neck to the head, bottom up: the longest chain beside the arms.

    The last of three or more is the tip of the head, unless it has an End Site itself (`ended`).
    """
    beside = [child for child in children[arms.parent] if child not in (arms.chains[0][0], arms.chains[1][0])]
    if not beside:
        return []
    neck = [max(beside, key=lambda joint: float(reach[joint]))]
    while len(children[neck[-1]]) == 1:
        neck.append(children[neck[-1]][0])
    return neck[:-1] if len(neck) > 2 and not children[neck[-1]] and neck[-1] not in ended else neck


def _bone_lengths(motion: SourceMotion) -> Float64:
    """Length of the bone from the parent of each joint, median over frames, 0 for the root, shape (J,)."""
    lengths = np.median(np.linalg.norm(motion.translation, axis=-1), axis=0)
    lengths[motion.parents < 0] = 0.0
    return np.asarray(lengths)


def _limb_pairs(children: list[list[int]], reach: Float64, bone: Float64) -> list[_Pair]:
    """Pairs of equally long chains that begin at one joint, the longest first."""
    pairs = []
    for parent, below in enumerate(children):
        long = sorted((c for c in below if reach[c] >= MIN_LIMB * reach.max()), key=lambda c: -reach[c])[:MAX_LIMBS]
        best = [
            (one, other)
            for number, one in enumerate(long)
            for other in long[number + 1 :]
            if reach[one] - reach[other] <= SAME_LENGTH * reach[one]
        ]
        for one, other in best:
            chains = _main_chain(one, children, reach), _main_chain(other, children, reach)
            bones = _long_bones(chains[0], bone), _long_bones(chains[1], bone)
            if len(chains[0]) == len(chains[1]) and bones[0] is not None and bones[1] is not None:
                pairs.append(_Pair(parent, chains, (bones[0], bones[1]), float(reach[one])))
    return sorted(pairs, key=lambda pair: -pair.length)[:MAX_PAIRS]


def _main_chain(joint: int, children: list[list[int]], reach: Float64) -> tuple[int, ...]:
    chain = [joint]
    while children[chain[-1]]:
        chain.append(max(children[chain[-1]], key=lambda child: (reach[child], -child)))
    return tuple(chain)


def _legs_and_arms(pairs: list[_Pair], parents: list[int], bone: Float64) -> tuple[_Pair, _Pair] | None:
    """The two pairs of which one lies above the other: not in its limbs, but in the trunk that begins beside them."""

    def size(pair: _Pair) -> float:
        _, middle, end, _ = pair.bones[0]
        return float(bone[middle] + bone[end])

    for legs in pairs:
        for arms in pairs:
            path = _between(arms.parent, legs.parent, parents)
            beside = path and path[0] not in {chain[0] for chain in legs.chains}
            if beside and size(legs) >= LEGS_TO_ARMS * size(arms):
                return legs, arms
    return None


def _between(joint: int, above: int, parents: list[int]) -> list[int]:
    """Joints from below `above` to `joint`, top down; empty if `joint` is not below it."""
    path: list[int] = []
    while joint >= 0 and joint != above:
        path.insert(0, joint)
        joint = parents[joint]
    return path if joint == above else []


def _long_bones(chain: tuple[int, ...], bone: Float64) -> _Bones | None:
    """The joints before, between and after the two longest bones in a row of a limb, and the next one, if any."""
    kept = [chain[0], *(joint for joint in chain[1:] if bone[joint] > MIN_BONE * bone[list(chain)].sum())]
    if len(kept) < 3:
        return None
    first = max(range(len(kept) - 2), key=lambda n: min(bone[kept[n + 1]], bone[kept[n + 2]]))
    following = kept[first + 3] if first + 3 < len(kept) else None
    return kept[first], kept[first + 1], kept[first + 2], following


def _some_frames(motion: SourceMotion) -> Float64:
    """World positions in some frames and in the rest pose, (n, J, 3)."""
    frames = np.unique(np.linspace(0, motion.frame_count - 1, LOOKED_AT).astype(np.int64))
    posed = world_pose(motion.parents, LocalPose(motion.translation[frames], motion.rotation[frames])).positions
    return np.concatenate([posed, rest_pose(motion).positions])


def _left_first(motion: SourceMotion, legs: _Pair, arms: _Pair) -> tuple[int, int] | None:
    """The order of the legs with the left one first; None if that is not clear."""
    places = _some_frames(motion)
    up = places[:, arms.parent] - places[:, legs.parent]
    across = places[:, legs.bones[0][0]] - places[:, legs.bones[1][0]]
    ahead = np.zeros_like(up)
    for upper, lower, foot, toes in legs.bones:
        ahead += places[:, lower] - 0.5 * (places[:, upper] + places[:, foot])
        if toes is not None:
            ahead += places[:, toes] - places[:, foot]
    size = np.linalg.norm(up, axis=-1) * np.linalg.norm(across, axis=-1) * legs.length
    told = float(np.mean(np.sum(np.cross(up, ahead) * across, axis=-1) / np.maximum(size, 1e-12)))
    return None if abs(told) < MIN_AHEAD else (0, 1) if told > 0.0 else (1, 0)


def _arms_beside(motion: SourceMotion, legs: _Pair, arms: _Pair, order: tuple[int, int]) -> tuple[int, int]:
    """The order of the arms in which each hangs on the side of its leg."""
    places = _some_frames(motion)
    hips = places[:, legs.bones[order[0]][0]] - places[:, legs.bones[order[1]][0]]
    shoulders = places[:, arms.bones[0][0]] - places[:, arms.bones[1][0]]
    return (0, 1) if float(np.sum(hips * shoulders, axis=-1).sum()) > 0.0 else (1, 0)
