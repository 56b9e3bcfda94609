"""Which node of a character is which of the engine's joints, and which joint every other node goes with."""

from collections.abc import Mapping

from live.motion.formats.file_error import MotionFileError, shown
from live.motion.retarget.joint_mapping import find_body_among, split_name
from live.motion.skeleton import SKELETON
from live.render.characters.model import Model

NEEDED = (
    "hips", "head", "leftUpperArm", "leftLowerArm", "rightUpperArm", "rightLowerArm", "leftUpperLeg", "leftLowerLeg",
    "leftFoot", "rightUpperLeg", "rightLowerLeg", "rightFoot",
)  # fmt: skip
"""Joints without which a character cannot dance."""


def find_joints(model: Model, said: Mapping[str, str]) -> dict[str, int | None]:
    """For each of the engine's joints the node of the character, None where there is none.

    A VRM says it; other files are known by their names and hierarchy (Mixamo, Rigify, Unreal's mannequin and others);
    `said` gives nodes by name and rules. MotionFileError if a joint that is needed is missing.
    """
    found: dict[str, int | None] = dict.fromkeys(SKELETON.names)
    if model.bones:
        found |= {name: model.bones[name] for name in SKELETON.names if name in model.bones}
    else:
        found |= _by_names(model)
    for joint, name in said.items():
        found[joint] = _named(model, joint, name)
    missing = [name for name in NEEDED if found[name] is None]
    if missing:
        some = ", ".join(shown(model.names[node]) for node in sorted(model.joints)[:8])
        raise MotionFileError(
            model.file, None, f"no {', no '.join(missing)} found among its bones ({some} ...)",
            f'say which they are: joints = {{ {missing[0]} = "NAME" }}',
        )  # fmt: skip
    nodes = [node for node in found.values() if node is not None]
    twice = next((node for node in nodes if nodes.count(node) > 1), None)
    if twice is not None:
        both = [joint for joint, node in found.items() if node == twice]
        words = f"{model.names[twice]!r} would be {' and '.join(both)}"
        raise MotionFileError(model.file, None, words, "say which they are: joints = { ... }")
    return found


def _named(model: Model, joint: str, name: str) -> int:
    if joint not in SKELETON.names:
        known = ", ".join(SKELETON.names)
        raise MotionFileError(model.file, None, f"{shown(joint)} is no joint of a dancer", f"one of {known}")
    for node in (*sorted(model.joints), *range(len(model.names))):
        if model.names[node] == name:
            return int(node)
    some = ", ".join(model.names[node] for node in sorted(model.joints)[:12])
    raise MotionFileError(model.file, None, f"no bone is called {shown(name)}", f"there are: {some} ...")


def _by_names(model: Model) -> dict[str, int | None]:
    bones = set(model.joints)
    for node in model.joints:
        parent = model.parents[node]
        while parent >= 0 and parent not in bones:
            bones.add(parent)
            parent = model.parents[parent]
    nodes = [node for node in model.order if node in bones]
    place = {node: at for at, node in enumerate(nodes)}
    parents = [place.get(model.parents[node], -1) for node in nodes]
    body = find_body_among([model.names[node] for node in nodes], parents)
    found = {name: None if at is None else nodes[at] for name, at in body.joints.items()}
    if found["head"] is None and body.spine:
        _numbered_neck(model, found, nodes[body.spine[-1]])
    return found


def _numbered_neck(model: Model, found: dict[str, int | None], chest: int) -> None:
    """Rigify numbers its spine up into the head: what goes on from the chest under the same word is neck and head."""
    chain = [chest]
    while True:
        word = split_name(model.names[chain[-1]])
        above = (node for node in model.order if model.parents[node] == chain[-1])
        nearest = next((node for node in above if split_name(model.names[node]) == word), None)
        if nearest is None:
            break
        chain.append(nearest)
    if len(chain) > 1:
        found["head"] = chain[-1]
        found["neck"] = chain[1] if len(chain) > 2 else None


def owners(model: Model, joints: Mapping[str, int | None]) -> list[int]:
    """For each node the engine's joint that it goes with: its own or that of the nearest above; hips above those."""
    own = {node: SKELETON.index(name) for name, node in joints.items() if node is not None}
    result = [SKELETON.index("hips")] * len(model.names)
    for node in model.order:
        parent = model.parents[node]
        if node in own:
            result[node] = own[node]
        elif parent >= 0:
            result[node] = result[parent]
    return result
