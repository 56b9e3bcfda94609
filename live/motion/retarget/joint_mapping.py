"""Mapping of a recording's joints to the engine's, by name and hierarchy, else by shape (`body_shape.py`).

Names alone are ambiguous: `LeftShoulder` is the clavicle in one family of files and the upper arm in another, `LeftLeg`
is the shin next to `LeftUpLeg`, `LeftFoot` the toes next to `LeftAnkle`. Limbs are therefore searched as whole chains,
each joint below the previous one; the trunk lies between the common ancestors of the legs and the arms.
"""

import re
from collections import Counter
from collections.abc import Sequence
from typing import Final

from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_shape import find_body_by_shape
from live.motion.retarget.source_body import SourceBody
from live.motion.skeleton import SKELETON

_TOKEN: Final = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", re.ASCII)
_GLUED_SIDE: Final = re.compile(r"(?<![A-Za-z])([LR])(?=[A-Z][A-Z][a-z])")
_SIDES: Final = {"left": "left", "l": "left", "right": "right", "r": "right"}
_HELPERS: Final = ("end", "nub", "tip", "site", "twist", "roll", "effector", "ik", "pole")

# candidate words per engine joint, the most reliable first
_LEG: Final[dict[str, tuple[str, ...]]] = {
    "UpperLeg": ("thigh", "upleg", "upperleg", "femur", "thighbend", "uleg", "hip"),
    "LowerLeg": ("shin", "calf", "lowerleg", "lowleg", "loleg", "knee", "tibia", "lleg", "leg"),
    "Foot": ("ankle", "foot"),
}
_ARM: Final[dict[str, tuple[str, ...]]] = {
    "UpperArm": ("upperarm", "uparm", "shldr", "shldrbend", "humerus", "uarm", "arm", "shoulder"),
    "LowerArm": ("forearm", "lowerarm", "lowarm", "loarm", "forearmbend", "farm", "elbow", "radius"),
}
_HAND: Final = ("wrist", "hand")
_ACCLAIM_HAND: Final = ("hand", "wrist")
"""Acclaim skeletons split the forearm: the bone `lwrist` is its last third, `lhand` begins at the wrist."""
_TOES: Final = ("toebase", "toes", "toe", "ball", "ballfoot", "foot")
_CLAVICLE: Final = ("clavicle", "collar", "scapula", "shoulder")
_HEAD: Final = ("head", "face", "skull", "chead")  # jC1Head: a joint of Xsens
_ACCLAIM: Final = (
    "hipjoint", "femur", "tibia", "foot", "toes", "clavicle", "humerus", "radius", "wrist", "hand", "fingers", "thumb",
)  # fmt: skip
"""Bones that the Acclaim format names in lower case after an l or r: lfemur."""
_WORDS: Final = frozenset(
    (*(word for words in (*_LEG.values(), *_ARM.values(), _HAND, _TOES, _CLAVICLE, _HEAD) for word in words),
     *_ACCLAIM, "spine", "chest", "neck", "hips", "pelvis", "upper", "lower", "up", "fore")
)  # fmt: skip
"""Words that say what a joint is."""
_PREFIX_SHARE: Final = 0.6
"""Least share of the names that begin with a prefix."""
_MAX_NAME: Final = 200
"""Characters of a name that are read."""
_MAX_PREFIX: Final = 4
"""Most words of a prefix."""
_MIN_NAMED: Final = 8
"""With fewer joints nothing counts as a prefix."""
_MAX_CANDIDATES: Final = 4
"""Limit of joints tried per name: with hundreds of equal names the chain search would be too slow."""


def map_joints(motion: SourceMotion) -> dict[str, str | None]:
    """Return for each of the engine's joints the name of the source joint, or None."""
    return {name: None if j is None else motion.names[j] for name, j in find_body(motion).joints.items()}


def find_body(motion: SourceMotion) -> SourceBody:
    """Find the body in a recording's skeleton: by names, else by its shape. Missing joints are None (see
    `SourceBody.missing`)."""
    body = find_body_among(motion.names, motion.parents.tolist())
    return (find_body_by_shape(motion) or body) if body.missing else body


def find_body_among(names: Sequence[str], parents: Sequence[int]) -> SourceBody:
    """Find the body among joints given by names and parents (-1: none), parents first."""
    return _BodyFinder(names, parents).find()


def _tokens(name: str) -> list[str]:
    """Words of a name without its name space; an L or R in front of another capital is a word: "LUArm" → l, u, arm."""
    return [word.lower() for word in _TOKEN.findall(_GLUED_SIDE.sub(r"\1 ", name.rsplit(":", 1)[-1][:_MAX_NAME]))]


def common_prefix(names: Sequence[str]) -> tuple[str, ...]:
    """Return the words with which most names begin and which say nothing: "CC_Base_L_Thigh" → cc, base.

    Character makers put their name, or that of the character, in front of every joint.
    """
    split = [_tokens(name) for name in names]
    prefix: list[str] = []
    while len(names) >= _MIN_NAMED and len(prefix) < _MAX_PREFIX:
        words = [one[len(prefix)] for one in split if one[: len(prefix)] == prefix and len(one) > len(prefix) + 1]
        word, count = Counter(words).most_common(1)[0] if words else ("", 0)
        if count < _PREFIX_SHARE * len(names) or word in _SIDES or word in _WORDS:
            break
        prefix.append(word)
    return tuple(prefix)


def split_name(name: str, prefix: Sequence[str] = ()) -> tuple[str, str]:
    """Return side ("left", "right" or "") and stem of a joint name: "mixamorig:LeftUpLeg" → ("left", "upleg").

    `prefix`: words to leave out if it begins with them.
    """
    tokens = _tokens(name)
    if prefix and tokens[: len(prefix)] == list(prefix) and len(tokens) > len(prefix):
        tokens = tokens[len(prefix) :]
    name = name.rsplit(":", 1)[-1]
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
        prefix = common_prefix(names)
        for joint, name in enumerate(names):
            self._by_name.setdefault(split_name(name, prefix), []).append(joint)

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
        if joints["leftShoulder"] is None and joints["rightShoulder"] is None:
            self._unnamed_clavicles(joints)
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

    def _unnamed_clavicles(self, joints: dict[str, int | None]) -> None:
        """Take the joints between the trunk and both upper arms as clavicles."""
        arms = joints["leftUpperArm"], joints["rightUpperArm"]
        chest = self._common_ancestor(*arms)
        if chest is None:
            return
        paths = [self._path_below(self._parent(arm), self._ancestors(chest)) for arm in arms]
        if paths[0] and len(paths[0]) == len(paths[1]):
            joints["leftShoulder"], joints["rightShoulder"] = paths[0][0], paths[1][0]

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
