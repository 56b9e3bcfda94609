"""Mapping of a recording's joints to the engine's, by name and hierarchy.

Names alone are ambiguous: `LeftShoulder` is the clavicle in one family of files and the upper arm in another, `LeftLeg`
is the shin next to `LeftUpLeg`, `LeftFoot` the toes next to `LeftAnkle`. Limbs are therefore searched as whole chains,
each joint below the previous one; the trunk lies between the common ancestors of the legs and the arms.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from live.motion.formats.source_motion import SourceMotion
from live.motion.skeleton import SKELETON

_TOKEN: Final = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", re.ASCII)
_SIDES: Final = {"left": "left", "l": "left", "right": "right", "r": "right"}
_HELPERS: Final = ("end", "nub", "tip", "site", "twist", "roll", "effector", "ik", "pole")

# candidate words per engine joint, the most reliable first
_LEG: Final[dict[str, tuple[str, ...]]] = {
    "UpperLeg": ("thigh", "upleg", "upperleg", "femur", "hip"),
    "LowerLeg": ("shin", "calf", "lowerleg", "lowleg", "loleg", "knee", "tibia", "leg"),
    "Foot": ("ankle", "foot"),
}
_ARM: Final[dict[str, tuple[str, ...]]] = {
    "UpperArm": ("upperarm", "uparm", "shldr", "humerus", "arm", "shoulder"),
    "LowerArm": ("forearm", "lowerarm", "lowarm", "loarm", "elbow", "radius"),
}
_HAND: Final = ("wrist", "hand")
_ACCLAIM_HAND: Final = ("hand", "wrist")
"""Acclaim skeletons split the forearm: the bone `lwrist` is its last third, `lhand` begins at the wrist."""
_TOES: Final = ("toebase", "toes", "toe", "ball", "foot")
_CLAVICLE: Final = ("clavicle", "collar", "scapula", "shoulder")
_HEAD: Final = ("head", "face", "skull")
_ACCLAIM: Final = (
    "hipjoint", "femur", "tibia", "foot", "toes", "clavicle", "humerus", "radius", "wrist", "hand", "fingers", "thumb",
)  # fmt: skip
"""Bones that the Acclaim format names in lower case after an l or r: lfemur."""
_MAX_CANDIDATES: Final = 4
"""Limit of joints tried per name: with hundreds of equal names the chain search would be too slow."""
_REQUIRED: Final = (
    *(side + joint for side in ("left", "right") for joint in ("UpperLeg", "LowerLeg", "Foot", "UpperArm", "LowerArm")),
    "hips",  # missing if a leg is the root
)


@dataclass(frozen=True, slots=True)
class SourceBody:
    """The joints of a recording that make up its body, as indices into `SourceMotion.names`."""

    joints: dict[str, int | None]
    """For each of the engine's 22 joints the source joint's index, or None."""
    spine: tuple[int, ...]
    """All trunk joints above the hips, bottom up; the last one is the parent of the arms; may be empty."""
    neck: tuple[int, ...]
    """All joints between the trunk and the head, bottom up; may be empty."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Required engine joints that were not found."""
        return tuple(name for name in _REQUIRED if self.joints[name] is None)

    def joint(self, name: str) -> int:
        """Return the source joint of a required engine joint; raises KeyError if there is none."""
        index = self.joints[name]
        if index is None:
            raise KeyError(name)
        return index


def map_joints(motion: SourceMotion) -> dict[str, str | None]:
    """Return for each of the engine's joints the name of the source joint, or None."""
    return {name: None if j is None else motion.names[j] for name, j in find_body(motion).joints.items()}


def find_body(motion: SourceMotion) -> SourceBody:
    """Find the body in a recording's skeleton; missing joints are None (see `SourceBody.missing`)."""
    return find_body_among(motion.names, motion.parents.tolist())


def find_body_among(names: Sequence[str], parents: Sequence[int]) -> SourceBody:
    """Find the body among joints given by names and parents (-1: none), parents first."""
    return _BodyFinder(names, parents).find()


def split_name(name: str) -> tuple[str, str]:
    """Return side ("left", "right" or "") and stem of a joint name: "mixamorig:LeftUpLeg" → ("left", "upleg")."""
    name = name.rsplit(":", 1)[-1]
    tokens = [token.lower() for token in _TOKEN.findall(name)]
    side, stem = "", []
    for place, token in enumerate(tokens):
        glued = next((word for word in ("left", "right") if token.startswith(word)), "")
        if not side and token in _SIDES:
            side = _SIDES[token]
        elif not side and place == 0 and token[:1] in _SIDES and token[1:] in _ACCLAIM:
            side = _SIDES[token[:1]]
            stem.append(token[1:])
        elif not side and place == 0 and glued:
            side = glued
            stem.append(token.removeprefix(glued))
        else:
            stem.append(token)
    if name.startswith("__") or (stem and stem[-1] in _HELPERS) or any(word in ("twist", "roll") for word in stem):
        return "", ""
    while len(stem) > 1 and stem[0] in ("bip", "character", "bone", "def", "org", "m", "j", "b"):
        stem = stem[1:]
    return side, "".join(stem)


class _BodyFinder:
    def __init__(self, names: Sequence[str], parents: Sequence[int]) -> None:
        self._parents = list(parents)
        self._by_name: dict[tuple[str, str], list[int]] = {}
        for joint, name in enumerate(names):
            self._by_name.setdefault(split_name(name), []).append(joint)

    def find(self) -> SourceBody:
        joints: dict[str, int | None] = dict.fromkeys(SKELETON.names)
        for side in ("left", "right"):
            self._find_limb(joints, side, _LEG)
            self._find_limb(joints, side, _ARM)
            joints[side + "Toes"] = self._find_below(joints[side + "Foot"], side, _TOES)
            radius = joints[side + "LowerArm"] in self._by_name.get((side, "radius"), [])
            joints[side + "Hand"] = self._find_below(
                joints[side + "LowerArm"], side, _ACCLAIM_HAND if radius else _HAND
            )
            joints[side + "Shoulder"] = self._clavicle(joints[side + "UpperArm"], side)
        hips = self._common_ancestor(joints["leftUpperLeg"], joints["rightUpperLeg"])
        joints["hips"] = hips
        chest = self._common_ancestor(
            joints["leftShoulder"] if joints["leftShoulder"] is not None else joints["leftUpperArm"],
            joints["rightShoulder"] if joints["rightShoulder"] is not None else joints["rightUpperArm"],
        )
        below = [] if hips is None else self._ancestors(hips)
        spine = self._path_below(chest, below)
        head = self._find_below(hips if chest is None else self._ancestors(chest)[-1], "", _HEAD)
        neck = self._path_below(self._parent(head), [*below, *spine])
        self._assign_trunk(joints, spine, neck, head)
        return SourceBody(joints, tuple(spine), tuple(neck))

    @staticmethod
    def _assign_trunk(joints: dict[str, int | None], spine: list[int], neck: list[int], head: int | None) -> None:
        if spine:
            joints["spine"] = spine[0]
        if len(spine) == 2:
            joints["chest"] = spine[1]
        elif len(spine) > 2:
            joints["chest"], joints["upperChest"] = spine[len(spine) // 2], spine[-1]
        joints["neck"], joints["head"] = (neck[0] if neck else None), head

    def _find_limb(self, joints: dict[str, int | None], side: str, words: dict[str, tuple[str, ...]]) -> None:
        chain = self._chain(None, side, list(words.values()))
        for name, joint in zip(words, chain or [], strict=False):
            joints[side + name] = joint

    def _chain(self, above: int | None, side: str, words: list[tuple[str, ...]]) -> list[int] | None:
        """Return the first joints that match one word of each entry, each below the previous one."""
        if not words:
            return []
        for word in words[0]:
            for joint in self._by_name.get((side, word), [])[:_MAX_CANDIDATES]:
                if above is None or above in self._ancestors(joint)[1:]:
                    rest = self._chain(joint, side, words[1:])
                    if rest is not None:
                        return [joint, *rest]
        return None

    def _find_below(self, above: int | None, side: str, words: tuple[str, ...]) -> int | None:
        found = None if above is None else self._chain(above, side, [words])
        return found[0] if found else None

    def _clavicle(self, arm: int | None, side: str) -> int | None:
        if arm is None:
            return None
        above = self._ancestors(arm)[1:]
        return next((j for word in _CLAVICLE for j in self._by_name.get((side, word), []) if j in above), None)

    def _parent(self, joint: int | None) -> int | None:
        return None if joint is None or self._parents[joint] < 0 else self._parents[joint]

    def _ancestors(self, joint: int) -> list[int]:
        """Return the joint and all its ancestors, up to the root."""
        path = [joint]
        while self._parents[path[-1]] >= 0:
            path.append(self._parents[path[-1]])
        return path

    def _common_ancestor(self, a: int | None, b: int | None) -> int | None:
        """Return the lowest common ancestor."""
        if a is None or b is None:
            return None
        above = set(self._ancestors(b)[1:])
        return next((joint for joint in self._ancestors(a)[1:] if joint in above), None)

    def _path_below(self, joint: int | None, stop: list[int]) -> list[int]:
        """Return the joints between `stop` (exclusive) and `joint` (inclusive), bottom up; empty without a joint."""
        chain: list[int] = []
        while joint is not None and joint not in stop:
            chain.insert(0, joint)
            joint = self._parent(joint)
        return chain
