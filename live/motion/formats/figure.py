"""Which nodes of a glTF file are the dancer's joints: a VRM's humanoid bones, a skin's joints, or what moves."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.motion.formats.file_error import MotionFileError
from live.motion.formats.json_place import JsonPlace
from live.motion.formats.nodes import Nodes

JOINT_LIMIT: Final = 1000
_END_WORDS: Final = ("end", "tip", "nub", "leaf", "site", "effector")
_HUMANOIDS: Final = ("VRMC_vrm_animation", "VRMC_vrm")


@dataclass(frozen=True, slots=True)
class Figure:
    """The dancer among the nodes of a file."""

    joints: tuple[int, ...]
    """Nodes that are joints, parents first, the root first; the root has all others below it."""
    names: tuple[str, ...]
    """Their names: the humanoid bones' in a VRM (the engine's own words), else the nodes'."""
    ends: tuple[tuple[int, int], ...]
    """Leaf nodes that only mark where a bone ends, as (joint's place in `joints`, node)."""
    skin: int | None
    """The skin whose bind pose is the rest pose; None for a VRM (its nodes rest in T-pose) and without skins."""
    faces_back: bool
    """True for VRM 0.x, whose models face -z."""
    warnings: tuple[str, ...]


def find_figure(root: JsonPlace, nodes: Nodes, animated: set[int]) -> Figure:
    """The dancer: the humanoid of a VRM or VRMA file, else the skeleton with most `animated` joints.

    Raises MotionFileError if nothing is animated or if there are more than 1000 joints.
    """
    warnings: list[str] = []
    bones, faces_back = _humanoid(root, nodes)
    skin: int | None = None
    if bones:
        chosen = set(bones)
    else:
        chosen, skin = _skeleton(root, nodes, animated, warnings)
    top = nodes.common(sorted(chosen))
    if top is None:
        raise root.error("nodes", "with motion do not hang together", "one figure (armature) expected")
    chosen.add(top)
    joints = [node for node in nodes.order if node in chosen]
    if len(joints) > JOINT_LIMIT:
        raise root.error("skins", f"have {len(joints)} joints", f"at most {JOINT_LIMIT} expected")
    names = _unlike([bones.get(node) or nodes.name(node) for node in joints], keep=set(bones.values()))
    ends = tuple(
        (place, child)
        for place, node in enumerate(joints)
        for child in nodes.children[node]
        if child not in chosen and not nodes.children[child] and _marks_end(nodes, child)
    )
    return Figure(tuple(joints), tuple(names), ends[:JOINT_LIMIT], skin, faces_back, tuple(warnings))


def _marks_end(nodes: Nodes, node: int) -> bool:
    place = nodes.place(node)
    words = nodes.name(node).lower()
    return not place.has("mesh") and not place.has("camera") and any(words.endswith(word) for word in _END_WORDS)


def _humanoid(root: JsonPlace, nodes: Nodes) -> tuple[dict[int, str], bool]:
    """Node → humanoid bone, and whether the model faces -z; empty for a file that is no VRM."""
    if not root.has("extensions"):
        return {}, False
    extensions = root.object("extensions")
    for name in _HUMANOIDS:
        if extensions.has(name) and extensions.object(name).has("humanoid"):
            bones = extensions.object(name).object("humanoid").object("humanBones")
            found = {bones.object(bone).whole("node", below=nodes.count): bone for bone in bones.names()}
            return found, False
    if extensions.has("VRM") and extensions.object("VRM").has("humanoid"):  # VRM 0.x
        humanoid = extensions.object("VRM").object("humanoid")
        rows = humanoid.elements("humanBones")
        return {row.whole("node", below=nodes.count): row.text("bone") for row in rows if row.text("bone")}, True
    return {}, False


def _skeleton(root: JsonPlace, nodes: Nodes, animated: set[int], warnings: list[str]) -> tuple[set[int], int | None]:
    """Joints of the skin with most animated joints (and its number) and of all below; without skins all that moves."""
    skins = [skin.wholes("joints", below=nodes.count) for skin in root.elements("skins")]
    scores = [len(animated.intersection(joints)) for joints in skins]
    if not any(scores):
        return _moving_tree(root, nodes, animated), None
    best = int(np.argmax(scores))
    chosen = set(skins[best])
    top = nodes.common(sorted(chosen))
    below = set() if top is None else nodes.below({top})
    others = 0
    for joints, score in zip(skins, scores, strict=True):
        if below.isdisjoint(joints):
            others += score > 0
        else:
            chosen.update(below.intersection(joints))
    if others:
        warnings.append(
            f"{others + 1} skeletons move in the file: the one with most moving joints is read, the one of "
            f"{nodes.name(skins[best][0])!r}"
        )
    return chosen, best


def _moving_tree(root: JsonPlace, nodes: Nodes, animated: set[int]) -> set[int]:
    """Without skins: of the tree with most animated nodes these and all below them, meshes and cameras left out."""
    if not animated:
        raise MotionFileError(root.file, None, "no node is animated", "a file with a recorded motion expected")
    trees = [nodes.below({top}) & animated for top in nodes.order if nodes.parents[top] < 0]
    moving = max(trees, key=len)
    helpers = (nodes.place(node) for node in range(nodes.count))
    bare = {n for n, place in enumerate(helpers) if not place.has("mesh") and not place.has("camera")}
    return moving | (nodes.below(moving) & bare)


def _unlike(names: list[str], keep: set[str]) -> list[str]:
    """Names of which no two are alike: later ones get a number; those in `keep` are theirs alone."""
    taken = set(keep)
    result = []
    for name in names:
        if name in keep:
            keep = keep - {name}
        elif name in taken:
            number = 2
            while f"{name}.{number}" in taken:
                number += 1
            name = f"{name}.{number}"
        taken.add(name)
        result.append(name)
    return result
