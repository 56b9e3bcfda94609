"""The node tree of a glTF file, and which of its nodes are the dancer's joints.

Joints are a VRM's humanoid bones, a skin's joints, or the animated nodes. The rest pose is the bind pose of the skin if
there is one, because the nodes hold whichever pose was exported.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.gltf_accessors import AccessorReader
from live.motion.formats.gltf_document import JsonObject

NODE_LIMIT: Final = 20_000
UNIFORM_SCALE_TOLERANCE: Final = 0.01
"""Relative difference up to which the three factors of a scale count as equal."""


@dataclass(frozen=True, slots=True, eq=False)
class NodeTransform:
    """A node's local rest transform: scale, then rotation, then translation."""

    translation: Float
    """Shape (3,) [m]."""
    rotation: Float
    """Unit quaternion (w, x, y, z), shape (4,)."""
    scale: Float
    """Factors along x, y, z, shape (3,); all above zero."""


class NodeTree:
    """The validated node tree of a file: every node has at most one parent, and there are no cycles."""

    def __init__(self, root: JsonObject) -> None:
        self._root = root
        self.count = root.length("nodes")
        if self.count > NODE_LIMIT:
            raise root.error("nodes", f"has {self.count} elements", f"at most {NODE_LIMIT} expected")
        self.parents = [-1] * self.count
        self.children: list[list[int]] = []
        for index, node in enumerate(root.elements("nodes")):
            self.children.append(node.integers("children", below=self.count))
            for child in self.children[-1]:
                if self.parents[child] >= 0:
                    raise node.error("children", f"names node {child}, which already has a parent", "a tree expected")
                self.parents[child] = index
        self.order = self._parents_first()

    def _parents_first(self) -> list[int]:
        waiting = [node for node in range(self.count) if self.parents[node] < 0][::-1]
        order = []
        while waiting:  # depth first
            order.append(waiting.pop())
            waiting += self.children[order[-1]][::-1]
        if len(order) < self.count:
            lost = sorted(set(range(self.count)) - set(order))[0]
            raise self._root.error("nodes", f"form a cycle (node {lost})", "a tree expected")
        return order

    def json_object(self, node: int) -> JsonObject:
        """Return the JSON object of one node."""
        return self._root.element("nodes", node)

    def name(self, node: int) -> str:
        """Return the node's name, or its number if it has none; one line of at most 200 characters."""
        return " ".join(self.json_object(node).text("name").split())[:200] or f"node {node}"

    def descendants(self, tops: set[int]) -> set[int]:
        """Return these nodes and all their descendants."""
        found = set(tops)
        waiting = list(tops)
        while waiting:
            news = [child for child in self.children[waiting.pop()] if child not in found]
            found.update(news)
            waiting += news
        return found

    def common_ancestor(self, nodes: list[int]) -> int | None:
        """Return the lowest common ancestor of `nodes`, itself one of them if possible; None if their roots differ."""
        wanted = set(nodes)
        below = [0] * self.count
        for node in reversed(self.order):
            below[node] += node in wanted
            if below[node] == len(wanted):
                return node
            if self.parents[node] >= 0:
                below[self.parents[node]] += below[node]
        return None

    def rest(self, node: int) -> NodeTransform:
        """Return the node's rest transform, from its matrix or its three parts."""
        place = self.json_object(node)
        if place.has("matrix"):
            return _decompose(place)
        turn = np.array(place.numbers("rotation", 4, (0.0, 0.0, 0.0, 1.0)))
        if np.linalg.norm(turn) < 1e-6:
            raise place.error("rotation", "is zero", "a unit quaternion expected")
        scale = np.array(place.numbers("scale", 3, (1.0, 1.0, 1.0)))
        if not (scale > 1e-9).all():
            raise place.error(
                "scale",
                f"is {scale.tolist()}",
                "factors above zero expected; in Blender Object > Apply > All Transforms, then export",
            )
        translation = np.array(place.numbers("translation", 3, (0.0, 0.0, 0.0)))
        return NodeTransform(translation, quaternion.unit(turn)[[3, 0, 1, 2]], scale)


def _decompose(place: JsonObject) -> NodeTransform:
    """Return translation, rotation and scale of a matrix (column-major in the file); shear is refused."""
    matrix = np.array(place.numbers("matrix", 16, ())).reshape(4, 4).T
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    if not (scale > 1e-9).all() or np.linalg.det(matrix[:3, :3] / scale) < 0.9:
        raise place.error("matrix", "mirrors, shears or flattens", "apply the transformation and export again")
    turn = quaternion.from_columns(*(matrix[:3, n] / scale[n] for n in range(3)))
    return NodeTransform(matrix[:3, 3].copy(), turn, scale)


def uniform_scale(scale: Float) -> float:
    """Return the geometric mean of the three factors."""
    return float(np.exp(np.mean(np.log(scale))))


def is_uniform(scale: Float) -> bool:
    """Whether the three factors are equal within 1 %."""
    return bool(scale.max() <= scale.min() * (1.0 + UNIFORM_SCALE_TOLERANCE))


JOINT_LIMIT: Final = 1000
_END_WORDS: Final = ("end", "tip", "nub", "leaf", "site", "effector")
_HUMANOIDS: Final = ("VRMC_vrm_animation", "VRMC_vrm")


@dataclass(frozen=True, slots=True)
class JointSelection:
    """The dancer among the nodes of a file."""

    joints: tuple[int, ...]
    """Nodes that are joints, root first, parents before children; the root is an ancestor of all others."""
    names: tuple[str, ...]
    """Their names: humanoid bone names in a VRM (those of the engine), else node names."""
    ends: tuple[tuple[int, int], ...]
    """Leaf nodes that only mark the end of a bone, as (index in `joints`, node)."""
    skin: int | None
    """The skin whose bind pose is the rest pose; None for a VRM (its nodes are in T-pose) and without skins."""
    faces_back: bool
    """True for VRM 0.x, whose models face -z."""
    warnings: tuple[str, ...]


def find_joints(root: JsonObject, nodes: NodeTree, animated: set[int]) -> JointSelection:
    """Return the dancer: the humanoid of a VRM or VRMA file, else the skeleton with most `animated` joints.

    Raises MotionFileError if nothing is animated or if there are more than 1000 joints.
    """
    warnings: list[str] = []
    bones, faces_back = _humanoid(root, nodes)
    skin: int | None = None
    if bones:
        chosen = set(bones)
    else:
        chosen, skin = _skeleton(root, nodes, animated, warnings)
    top = nodes.common_ancestor(sorted(chosen))
    if top is None:
        raise root.error("nodes", "with motion are not in one tree", "one figure (armature) expected")
    chosen.add(top)
    joints = [node for node in nodes.order if node in chosen]
    if len(joints) > JOINT_LIMIT:
        raise root.error("skins", f"have {len(joints)} joints", f"at most {JOINT_LIMIT} expected")
    names = _unique_names([bones.get(node) or nodes.name(node) for node in joints], keep=set(bones.values()))
    ends = tuple(
        (place, child)
        for place, node in enumerate(joints)
        for child in nodes.children[node]
        if child not in chosen and not nodes.children[child] and _marks_end(nodes, child)
    )
    return JointSelection(tuple(joints), tuple(names), ends[:JOINT_LIMIT], skin, faces_back, tuple(warnings))


def _marks_end(nodes: NodeTree, node: int) -> bool:
    place = nodes.json_object(node)
    words = nodes.name(node).lower()
    return not place.has("mesh") and not place.has("camera") and any(words.endswith(word) for word in _END_WORDS)


def _humanoid(root: JsonObject, nodes: NodeTree) -> tuple[dict[int, str], bool]:
    """Return node → humanoid bone, and whether the model faces -z; empty if the file is not a VRM."""
    if not root.has("extensions"):
        return {}, False
    extensions = root.object("extensions")
    for name in _HUMANOIDS:
        if extensions.has(name) and extensions.object(name).has("humanoid"):
            bones = extensions.object(name).object("humanoid").object("humanBones")
            found = {bones.object(bone).integer("node", below=nodes.count): bone for bone in bones.names()}
            return found, False
    if extensions.has("VRM") and extensions.object("VRM").has("humanoid"):  # VRM 0.x
        humanoid = extensions.object("VRM").object("humanoid")
        rows = humanoid.elements("humanBones")
        return {row.integer("node", below=nodes.count): row.text("bone") for row in rows if row.text("bone")}, True
    return {}, False


def _skeleton(
    root: JsonObject, nodes: NodeTree, animated: set[int], warnings: list[str]
) -> tuple[set[int], int | None]:
    """Return the joints of the skin with most animated joints and of skins below it, and its index.

    Without skins: all animated nodes, and None.
    """
    skins = [skin.integers("joints", below=nodes.count) for skin in root.elements("skins")]
    scores = [len(animated.intersection(joints)) for joints in skins]
    if not any(scores):
        return _moving_tree(root, nodes, animated), None
    best = int(np.argmax(scores))
    chosen = set(skins[best])
    top = nodes.common_ancestor(sorted(chosen))
    below = set() if top is None else nodes.descendants({top})
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


def _moving_tree(root: JsonObject, nodes: NodeTree, animated: set[int]) -> set[int]:
    """Return the animated nodes of the tree with most of them, and all nodes below, without meshes and cameras."""
    if not animated:
        raise MotionFileError(root.file, None, "no node is animated", "a file with a recorded motion expected")
    trees = [nodes.descendants({top}) & animated for top in nodes.order if nodes.parents[top] < 0]
    moving = max(trees, key=len)
    helpers = (nodes.json_object(node) for node in range(nodes.count))
    bare = {n for n, place in enumerate(helpers) if not place.has("mesh") and not place.has("camera")}
    return moving | (nodes.descendants(moving) & bare)


def _unique_names(names: list[str], keep: set[str]) -> list[str]:
    """Return unique names: duplicates get a number; names in `keep` are never changed."""
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


MAX_SHEAR: Final = 0.05
"""A bind matrix that deviates more than this from a uniformly scaled rotation is ignored."""


def bind_rotations(skin: JsonObject, joints: list[int], accessors: AccessorReader) -> dict[int, Float]:
    """Return the world rotation of each joint node in the bind pose, quaternions (4,); empty without bind matrices.

    The inverse of an inverse bind matrix is the joint's transform in mesh space. The rotation of mesh space itself is
    ignored; it does not matter when a pose is compared with its own rest pose.
    """
    if not skin.has("inverseBindMatrices"):
        return {}
    matrices = accessors.read(skin.integer("inverseBindMatrices", below=1 << 40), "MAT4")
    if len(matrices) < len(joints):
        words = f"has {len(matrices)} matrices for {len(joints)} joints"
        raise skin.error("inverseBindMatrices", words, "one for each joint expected")
    found: dict[int, Float] = {}
    for joint, numbers in zip(joints, matrices, strict=False):
        columns = numbers.reshape(4, 4)[:3, :3]  # column-major in the file: the rows here are columns
        size = np.cbrt(np.linalg.det(columns))
        if size > 1e-9 and np.abs(columns @ columns.T / size**2 - np.eye(3)).max() < MAX_SHEAR:
            turn = quaternion.from_columns(*quaternion.unit(columns))
            found[joint] = quaternion.inverse(turn)
    return found


def rest_rotations(parents: list[int], nodes: Float64, bound: list[Float | None]) -> Float64:
    """Return the local rotations of the rest pose, (J, 4): those of the skin if known, else those of the nodes.

    `nodes` (J, 4) are the nodes' local rotations, `bound` the skin's world rotations; parents come first.
    """
    world = np.empty_like(nodes)
    local = np.empty_like(nodes)
    for joint, parent in enumerate(parents):
        known = bound[joint]
        if parent < 0:
            world[joint] = nodes[joint] if known is None else known
            local[joint] = world[joint]
        else:
            world[joint] = quaternion.mul(world[parent], nodes[joint]) if known is None else known
            local[joint] = quaternion.mul(quaternion.inverse(world[parent]), world[joint])
    return local
