"""Springs of character files: VRM 0.x (secondaryAnimation), VRM 1.0 (VRMC_springBone), else found by bone names."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from typing import Final

from live.motion.formats.gltf_document import JsonObject
from live.motion.formats.gltf_skeleton import NodeTree
from live.render.characters.bone_names import plain_name

Vector = tuple[float, float, float]
_DOWN: Final[Vector] = (0.0, -1.0, 0.0)


@dataclass(frozen=True, slots=True)
class SpringBone:
    """A bone that swings, in the file's nodes and units."""

    node: int
    tail: int
    """Node at its end; -1: none, it ends 7 cm beyond its node in the direction from its parent, as in VRM 0.x."""
    stiffness: float
    drag: float
    gravity: Vector
    """In the world [m/s per tick's second]."""
    radius: float
    centre: int
    """Node in whose space inertia is computed, -1: the world."""
    colliders: tuple[int, ...]
    """Numbers of the colliders that it collides with."""


@dataclass(frozen=True, slots=True)
class Collider:
    """A sphere or capsule that a node carries, in the node's space."""

    node: int
    start: Vector
    end: Vector
    radius: float


@dataclass(frozen=True, slots=True)
class Springs:
    """All springs of a file, parents first."""

    bones: tuple[SpringBone, ...] = ()
    colliders: tuple[Collider, ...] = ()
    source: str = ""
    """Where they come from: `VRM`, `bone names`, or nothing."""


NO_SPRINGS: Final = Springs()
LIMIT: Final = 1000
"""Maximum number of bones and colliders that are read."""


def springs_of(root: JsonObject, nodes: NodeTree) -> Springs:
    """Return the springs that a VRM defines; MotionFileError for references that lead nowhere."""
    extensions = root.object("extensions") if root.has("extensions") else None
    if extensions is None:
        return NO_SPRINGS
    if extensions.has("VRMC_springBone"):
        springs = extensions.object("VRMC_springBone")
        return _sorted(_bones_1(springs, nodes), _colliders_1(springs, nodes), nodes)
    if extensions.has("VRM") and extensions.object("VRM").has("secondaryAnimation"):
        animation = extensions.object("VRM").object("secondaryAnimation")
        groups, colliders = _colliders_0(animation, nodes)
        return _sorted(_bones_0(animation, nodes, groups), colliders, nodes)
    return NO_SPRINGS


def _sorted(bones: Iterator[SpringBone], colliders: tuple[Collider, ...], nodes: NodeTree) -> Springs:
    """Return springs with each node once, parents first."""
    place = {node: number for number, node in enumerate(nodes.order)}
    unique: dict[int, SpringBone] = {}
    for bone in islice(bones, 20 * LIMIT):
        if bone.node not in unique and len(unique) < LIMIT:
            unique[bone.node] = bone
    return Springs(tuple(sorted(unique.values(), key=lambda bone: place[bone.node])), colliders[:LIMIT], "VRM")


# -- VRM 1.0 ---------------------------------------------------------------------------------------------------------


def _colliders_1(springs: JsonObject, nodes: NodeTree) -> tuple[Collider, ...]:
    found = []
    for row in springs.elements("colliders"):
        node, shape = row.integer("node", below=nodes.count), row.object("shape")
        if shape.has("capsule"):
            capsule = shape.object("capsule")
            start, end = _vector(capsule, "offset"), _vector(capsule, "tail")
            found.append(Collider(node, start, end, max(capsule.number("radius", 0.0), 0.0)))
        elif shape.has("sphere"):
            sphere = shape.object("sphere")
            centre = _vector(sphere, "offset")
            found.append(Collider(node, centre, centre, max(sphere.number("radius", 0.0), 0.0)))
        else:  # a shape of an extension: nothing collides with it
            found.append(Collider(node, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0))
    return tuple(found)


def _bones_1(springs: JsonObject, nodes: NodeTree) -> Iterator[SpringBone]:
    count = springs.length("colliders")
    groups = [row.integers("colliders", below=count) for row in springs.elements("colliderGroups")]
    for spring in islice(springs.elements("springs"), LIMIT):
        used = _collider_numbers(spring, groups)
        centre = spring.integer("center", below=nodes.count) if spring.has("center") else -1
        rows = list(spring.elements("joints"))
        for row, following in pairwise(rows):
            power = row.number("gravityPower", 0.0)
            x, y, z = (part * power for part in _vector(row, "gravityDir", _DOWN))
            yield SpringBone(
                row.integer("node", below=nodes.count), following.integer("node", below=nodes.count),
                max(row.number("stiffness", 1.0), 0.0), _share(row.number("dragForce", 0.5)), (x, y, z),
                max(row.number("hitRadius", 0.0), 0.0), centre, used,
            )  # fmt: skip


def _collider_numbers(place: JsonObject, groups: list[list[int]]) -> tuple[int, ...]:
    """Return the numbers of all colliders in the groups that a spring names."""
    named = (number for group in place.integers("colliderGroups", below=len(groups)) for number in groups[group])
    return tuple(dict.fromkeys(islice(named, LIMIT)))


def _vector(place: JsonObject, key: str, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
    x, y, z = place.numbers(key, 3, default)
    return x, y, z


def _share(value: float) -> float:
    return min(max(value, 0.0), 1.0)


# -- VRM 0.x ---------------------------------------------------------------------------------------------------------


def _colliders_0(animation: JsonObject, nodes: NodeTree) -> tuple[list[list[int]], tuple[Collider, ...]]:
    groups: list[list[int]] = []
    found: list[Collider] = []
    for group in animation.elements("colliderGroups"):
        node = group.integer("node", below=nodes.count)
        groups.append([])
        for row in group.elements("colliders"):
            x, y, z = _axes(row, "offset", 0.0)
            groups[-1].append(len(found))
            # z points backwards in VRM 0.x
            found.append(Collider(node, (x, y, -z), (x, y, -z), max(row.number("radius", 0.0), 0.0)))
    return groups, tuple(found)


def _bones_0(animation: JsonObject, nodes: NodeTree, groups: list[list[int]]) -> Iterator[SpringBone]:
    for group in islice(animation.elements("boneGroups"), LIMIT):
        power = group.number("gravityPower", 0.0)
        x, y, z = (part * power for part in _axes(group, "gravityDir", -1.0))
        has_centre = group.has("center") and group.number("center", -1.0) >= 0.0
        bone = SpringBone(
            -1, -1, max(group.number("stiffiness", 1.0), 0.0), _share(group.number("dragForce", 0.4)), (x, y, z),
            max(group.number("hitRadius", 0.02), 0.0), group.integer("center", below=nodes.count) if has_centre else -1,
            _collider_numbers(group, groups),
        )  # fmt: skip
        for top in group.integers("bones", below=nodes.count):
            yield from whole_chain(bone, top, nodes.children)


def _axes(place: JsonObject, key: str, down: float) -> Vector:
    if not place.has(key):
        return 0.0, down, 0.0
    vector = place.object(key)
    return vector.number("x", 0.0), vector.number("y", down), vector.number("z", 0.0)


def whole_chain(bone: SpringBone, top: int, children: list[list[int]]) -> Iterator[SpringBone]:
    """Yield the bone at `top` and at all nodes below it; a bone ends at its first child."""
    waiting, seen = [top], 0
    while waiting and seen < LIMIT:
        node, seen = waiting.pop(), seen + 1
        yield replace(bone, node=node, tail=children[node][0] if children[node] else -1)
        waiting += children[node][::-1]


# -- other files -----------------------------------------------------------------------------------------------------

_KINDS: Final[tuple[tuple[str, str, float, float, float, float], ...]] = (
    ("hair", r"hair|bang|fringe|ponytail|pony_tail|pigtail|twintail|braid|ahoge", 1.6, 0.35, 0.5, 0.015),
    ("cloth", r"skirt|dress|coat|cape|cloak|robe|cloth|apron|tassel|sash|ribbon|scarf|veil", 0.7, 0.4, 0.6, 0.02),
    ("tail", r"(?<!pony)(?<!pig)(?<!twin)tail(?![a-z])|antenna|feather|bunny_?ear|cat_?ear", 1.4, 0.3, 0.3, 0.02),
)
"""Kind, pattern of the names, stiffness, drag, gravity and radius [m] of bones that swing in files without springs."""


def springs_by_name(
    names: tuple[str, ...], parents: tuple[int, ...], order: tuple[int, ...], joints: frozenset[int], taken: set[int]
) -> Springs:
    """Return chains whose names say that they swing; `taken`: nodes that are joints, fingers or parts of the face.

    Stiffness, gravity and radii are for a body of the engine's size.
    """
    children: list[list[int]] = [[] for _ in parents]
    for node in order:
        if parents[node] >= 0 and node not in taken:
            children[parents[node]].append(node)
    plain = [plain_name(name) for name in names]
    bones: dict[int, SpringBone] = {}
    for node in order:
        if node in bones or node in taken or node not in joints:
            continue
        for _, pattern, stiffness, drag, gravity, radius in _KINDS:
            if re.search(pattern, plain[node]):
                bone = SpringBone(-1, -1, stiffness, drag, (0.0, -gravity, 0.0), radius, -1, ())
                for each in whole_chain(bone, node, children):
                    bones.setdefault(each.node, each)
                break
    place: Mapping[int, int] = {node: number for number, node in enumerate(order)}
    chosen = tuple(sorted(bones.values(), key=lambda bone: place[bone.node]))[:LIMIT]
    return Springs(chosen, (), "bone names") if chosen else NO_SPRINGS
