"""Fingers, eyes, lids and jaw of a character: found by their names, fingers else by how they branch from the hand.

One table of patterns holds the names of VRM, Mixamo, Ready Player Me, MakeHuman's and MPFB's rigs, Rigify, Unreal,
3ds Max's Biped and others. A pattern is searched in a name without its name space, side and separators.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.body.expression import FINGERS
from live.render.characters.bone_names import plain_name
from live.render.characters.model import Model

SIDES: Final = ("left", "right")
MAX_PHALANGES: Final = 3
"""Bones of a finger that bend; further ones only mark its tip."""

_PATTERNS: Final[tuple[tuple[str, str], ...]] = (
    ("Thumb", r"thumb|finger1(?=[-_. ]\d)|finger0\d?$|finger_?a(?![a-z])"),
    ("Index", r"index|pointer|forefinger|finger2(?=[-_. ]\d)|finger1\d?$|finger_?b(?![a-z])"),
    ("Middle", r"middle|midfinger|(?:^|[-_. ])mid[-_. ]?\d|finger3(?=[-_. ]\d)|finger2\d?$|finger_?c(?![a-z])"),
    ("Ring", r"ring|finger4(?=[-_. ]\d)|finger3\d?$|finger_?d(?![a-z])"),
    ("Little", r"pinky|pinkie|little|smallfinger|finger5(?=[-_. ]\d)|finger4\d?$|finger_?e(?![a-z])"),
)
"""Pattern of each finger: by word, by MakeHuman's numbers (finger1-1 is the thumb), by Biped's (Finger0 is it)."""
_DEEPEST: Final = 50
_PALM: Final = re.compile(r"metacarpal|carpal|palm|inhand|(?:^|[-_. ])hand$")
"""Bones within the palm, which stay with the hand; a thumb's metacarpal bends."""
_TIP: Final = re.compile(r"(?:^|[-_. ])?(?:end|tip|nub|leaf)(?:[-_. ]?[lr])?$|twist|roll|helper|_ik$")
_FACE: Final[tuple[tuple[str, str], ...]] = (
    ("Lid", r"(?:upper|up|top)[-_. ]?(?:eye)?lid|eyelid[-_. ]?(?:upper|up|top)|lid[-_. ]t(?![a-z0-9])|orbicularis03|"
            r"eyelid(?!.*(?:low|bot))"),
    ("Eye", r"^(?:[a-z]+[-_. ])*(?:face)?[-_. ]?eye(?:ball)?(?:[-_. ]?[lr]|[-_. ]?\d+)?$|"
            r"^(?:l|r|left|right)[-_. ]?eye(?:ball)?$"),
)  # fmt: skip
_JAW: Final = re.compile(r"(?:^|[-_. ])(?:lower)?jaw(?:bone)?(?:[-_. ]?(?:master|root|\d+))?$|mandible")


@dataclass(frozen=True, slots=True)
class DetailBones:
    """Nodes of a character that its fingers and its face move."""

    fingers: Mapping[str, tuple[int, ...]]
    """Phalanges from the palm to the tip, at most three, by side and finger, such as "leftIndex"."""
    face: Mapping[str, int]
    """Eyes, upper lids and jaw, named like the detail joints of the drawn body."""

    @property
    def missing(self) -> tuple[str, ...]:
        """What was not found, in words."""
        lost = [
            f"{side} fingers" for side in SIDES if not any(side + finger in self.fingers for finger in FINGERS)
        ]  # fmt: skip
        for side in SIDES:
            some = [finger for finger in FINGERS if side + finger not in self.fingers]
            if 0 < len(some) < len(FINGERS):
                lost += [f"{side} {finger.lower()} finger" for finger in some]
        return (*lost, *(name for name in ("leftEye", "rightEye", "jaw") if name not in self.face))


def find_details(model: Model, joints: Mapping[str, int | None]) -> DetailBones:
    """Return the fingers and face bones; `joints`: the node of each of the engine's joints."""
    names = _plain_names(model)
    taken = {node for node in joints.values() if node is not None}
    fingers: dict[str, tuple[int, ...]] = {}
    for side in SIDES:
        hand = joints[f"{side}Hand"]
        if hand is None:
            continue
        below = [node for node in _descendants(model, hand) if node not in taken]
        named = _named_fingers(model, names, below)
        fingers |= {side + finger: chain for finger, chain in (named or _branching_fingers(model, hand, below)).items()}
    taken |= {node for chain in fingers.values() for node in chain}
    return DetailBones(fingers, _face_bones(model, names, joints, taken))


def _plain_names(model: Model) -> list[str]:
    """Return all names to compare; humanoid bones of a VRM under their own."""
    names = list(model.names)
    for bone, node in model.bones.items():
        names[node] = bone
    return [plain_name(name) for name in names]


def _descendants(model: Model, top: int) -> list[int]:
    below, found = {top}, []
    for node in model.order:
        if model.parents[node] in below:
            below.add(node)
            found.append(node)
    return found


def _finger_of(name: str) -> str | None:
    glued = name.replace("_", "") if "finger" in name and "-" not in name else name
    for finger, pattern in _PATTERNS:
        if re.search(pattern, name) or re.search(pattern, re.sub(r"[lr]$", "", glued)):
            return finger
    return None


def _named_fingers(model: Model, names: list[str], below: list[int]) -> dict[str, tuple[int, ...]]:
    found: dict[str, list[int]] = {}
    for node in below:  # parents first
        name = names[node]
        finger = _finger_of(name)
        palm = _PALM.search(name) is not None and finger != "Thumb"
        if finger is None or palm or _TIP.search(name):
            continue
        chain = found.setdefault(finger, [])
        if not chain or (len(chain) < MAX_PHALANGES and _is_below(model, node, chain[-1])):
            chain.append(node)
    if "Thumb" in found and len(found) == 2:  # one chain for all fingers
        found = {finger if finger == "Thumb" else "Middle": chain for finger, chain in found.items()}
    moved = {finger: tuple(chain[:MAX_PHALANGES]) for finger, chain in found.items()}
    return moved if len(moved) >= 2 else {}


def _is_below(model: Model, node: int, top: int) -> bool:
    """Whether a node is below another, at most `_DEEPEST` nodes."""
    for _ in range(_DEEPEST):
        if node < 0 or node == top:
            break
        node = model.parents[node]
    return node == top


def _branching_fingers(model: Model, hand: int, below: list[int]) -> dict[str, tuple[int, ...]]:
    """Return the fingers of a hand whose names say nothing: chains of two bones or more, the one that begins nearest to
    the wrist is the thumb, and the others follow by their distance from it."""
    kids: dict[int, list[int]] = {}
    for node in below:
        kids.setdefault(model.parents[node], []).append(node)
    chains = []
    for node in below:
        if len(kids.get(model.parents[node], ())) < 2 and model.parents[node] != hand:
            continue
        chain = [node]
        while len(kids.get(chain[-1], ())) == 1:
            chain.append(kids[chain[-1]][0])
        if not kids.get(chain[-1]) and len(chain) >= 2:
            chains.append(tuple(chain[:MAX_PHALANGES]))
    if not 3 <= len(chains) <= len(FINGERS):
        return {}
    place = model.node_position
    away = [float(np.linalg.norm(place[chain[0]] - place[hand])) for chain in chains]
    thumb = chains[int(np.argmin(away))]
    others = sorted(
        (chain for chain in chains if chain is not thumb),
        key=lambda chain: float(np.linalg.norm(place[chain[0]] - place[thumb[0]])),
    )
    order = {5: FINGERS, 4: ("Thumb", "Index", "Middle", "Little"), 3: ("Thumb", "Index", "Middle")}[len(chains)]
    return dict(zip(order, (thumb, *others), strict=True))


def _face_bones(model: Model, names: list[str], joints: Mapping[str, int | None], taken: set[int]) -> dict[str, int]:
    head = joints["head"]
    if head is None:
        return {}
    found: dict[str, int] = {}
    below = [node for node in _descendants(model, head) if node not in taken]
    left = _left_direction(model, joints)
    for kind, pattern in _FACE:
        matching = [node for node in below if re.search(pattern, names[node]) and node not in found.values()]
        if not matching:
            continue
        across = {node: float((model.node_position[node] - model.node_position[head]) @ left) for node in matching}
        for side, sign in (("left", 1.0), ("right", -1.0)):
            own = [node for node in matching if across[node] * sign > 1e-6]
            if own:
                found[side + kind] = own[0]  # the topmost
    jaw = next((node for node in below if _JAW.search(names[node])), None)
    return found | ({} if jaw is None else {"jaw": jaw})


def _left_direction(
    model: Model, joints: Mapping[str, int | None]
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    left, right = joints["leftUpperArm"], joints["rightUpperArm"]
    assert left is not None  # both are required
    assert right is not None
    return np.asarray(model.node_position[left] - model.node_position[right])
