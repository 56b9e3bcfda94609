"""Fit of a file's springs to the engine's body: a `SpringRig` in the rest pose."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int64
from live.motion.cloth.spring_rig import HIT_RADIUS, MAX_COLLIDERS, MAX_SPRINGS, SpringRig
from live.motion.skeleton import SKELETON
from live.render.characters.model import Model
from live.render.characters.skeleton_fit import FittedCharacter, moved_surface
from live.render.characters.spring_reader import SpringBone, Springs

_LEAF: Final = 0.07
"""Length of a bone without a node at its end [m], as in VRM 0.x."""
_SHORTEST: Final = 0.002
"""Shorter bones do not swing [m]."""
_BODY: Final = (
    ("head", (0.0, 0.075, 0.012), (0.0, 0.095, 0.012), 0.095), ("neck", (0.0, 0.0, 0.0), (0.0, 0.06, 0.0), 0.055),
    ("upperChest", (0.0, 0.06, 0.0), (0.0, 0.0, 0.0), 0.12), ("chest", (0.0, 0.03, 0.0), (0.0, -0.08, 0.0), 0.11),
    ("hips", (0.055, 0.0, 0.0), (-0.055, 0.0, 0.0), 0.12),
    *((side + bone, (0.0, -0.02, 0.0), (0.0, -0.38, 0.0), size) for side in ("left", "right")
      for bone, size in (("UpperLeg", 0.085), ("LowerLeg", 0.055))),
    *((side + bone, (0.0, 0.0, 0.0), (0.24 * sign, 0.0, 0.0), size) for side, sign in (("left", 1.0), ("right", -1.0))
      for bone, size in (("UpperArm", 0.045), ("LowerArm", 0.038))),
)  # fmt: skip
"""Capsules of the body: joint, both ends relative to it, and the usual radius [m]."""
_OWN_COLLIDERS: Final = MAX_COLLIDERS - len(_BODY)
"""Maximum number of a file's own colliders."""
_RADIUS_SHARE: Final = 40.0
"""Percentile of the distances of the skin from a capsule's axis that is its radius."""
_RADIUS_RANGE: Final = (0.6, 1.5)
"""Range of radii, as shares of the usual ones."""


@dataclass(frozen=True, slots=True, eq=False)
class FittedSprings:
    """The springs of a character in the engine's rest pose."""

    rig: SpringRig
    nodes: tuple[int, ...]
    """The file's node of each bone of the rig."""
    source: str
    """`VRM`, `bone names`, or nothing."""
    notes: tuple[str, ...]

    @property
    def reach(self) -> float:
        """Maximum distance of bones' ends from the joint that carries them, however they swing [m]."""
        rig, rest, far = self.rig, SKELETON.rest_positions(), np.zeros(len(self.nodes))
        for bone, parent in enumerate(rig.parent.tolist()):
            begin = rest[rig.joint[bone]] if parent < 0 else rig.head[parent]
            below = 0.0 if parent < 0 else far[parent] - np.linalg.norm(rig.tail[parent] - rig.head[parent])
            way = np.linalg.norm(rig.head[bone] - begin) + np.linalg.norm(rig.tail[bone] - rig.head[bone])
            far[bone] = below + way
        return float(far.max(initial=0.0))


def fit_springs(
    model: Model, springs: Springs, fitted: FittedCharacter, owner: list[int], fixed: set[int]
) -> FittedSprings:
    """Return the rig of a file's springs. `owner`: the engine's joint that carries each node, `fixed`: nodes that are
    joints, fingers or parts of the face, and do not swing."""
    bones = [bone for bone in springs.bones if bone.node not in fixed]
    bones, notes = _strongest(model, bones)
    if not bones:
        return FittedSprings(SpringRig.empty(), (), "", notes)
    joint = np.array([owner[bone.node] for bone in bones], np.int64)
    head = fitted.transform.apply(model.node_position[[bone.node for bone in bones]], joint)
    tail = fitted.transform.apply(np.array([_end(model, bone, fitted.transform.scale) for bone in bones]), joint)
    kept = np.linalg.norm(tail - head, axis=1) > _SHORTEST
    bones = [bone for bone, long in zip(bones, kept.tolist(), strict=True) if long]
    if not bones:
        return FittedSprings(SpringRig.empty(), (), "", notes)
    joint, head, tail = joint[kept], head[kept], tail[kept]
    nodes = tuple(bone.node for bone in bones)
    settings = _settings(model, springs, bones, fitted)
    collider_joint, collider, numbers = _colliders(model, springs, bones, fitted, owner)
    hits = np.array([sum(1 << numbers[c] for c in bone.colliders if c in numbers) for bone in bones], np.int64)
    used = {c for bone in bones for c in bone.colliders}
    if len(used) > _OWN_COLLIDERS:
        notes += (f"of the {len(used)} colliders of its springs, {_OWN_COLLIDERS} are used",)
    body_joint, body = _body(fitted)
    hits |= _clear_of(body, tail, settings[:, HIT_RADIUS].astype(np.float64)) << len(collider)
    collider_joint, collider = np.concatenate([collider_joint, body_joint]), np.concatenate([collider, body])
    parents = _parents(model, nodes, fixed)
    rig = SpringRig(
        np.array(parents, np.int32), joint.astype(np.int32),
        np.array([-1 if bone.centre < 0 else owner[bone.centre] for bone in bones], np.int32), _float32(head),
        _float32(tail), settings, hits, collider_joint.astype(np.int32),
        _float32(collider),
    )  # fmt: skip
    return FittedSprings(rig, nodes, springs.source, notes)


def _strongest(model: Model, bones: list[SpringBone]) -> tuple[list[SpringBone], tuple[str, ...]]:
    """Return at most `MAX_SPRINGS` bones: whole chains, those first that move most of the surface."""
    if len(bones) <= MAX_SPRINGS:
        return bones, ()
    moved = moved_surface(model)
    known = {bone.node for bone in bones}
    root: dict[int, int] = {}
    total: dict[int, float] = {}
    for bone in bones:  # parents first
        above = next((node for node in _ancestors(model, bone.node) if node in known), bone.node)
        root[bone.node] = root.get(above, bone.node)
        total[root[bone.node]] = total.get(root[bone.node], 0.0) + float(moved[bone.node])
    order = sorted(total, key=lambda node: -total[node])
    chosen: set[int] = set()
    for top in order:
        chain = [bone.node for bone in bones if root[bone.node] == top]
        chosen.update(chain[: MAX_SPRINGS - len(chosen)])
    note = f"of its {len(bones)} springs, the {MAX_SPRINGS} that move most of the surface swing; the others are rigid"
    return [bone for bone in bones if bone.node in chosen], (note,)


def _ancestors(model: Model, node: int) -> list[int]:
    found = []
    while model.parents[node] >= 0:
        node = model.parents[node]
        found.append(node)
    return found


def _parents(model: Model, nodes: tuple[int, ...], fixed: set[int]) -> list[int]:
    """Return for each bone the nearest bone above, -1: none before a joint of the body."""
    number = {node: at for at, node in enumerate(nodes)}
    found = []
    for node in nodes:
        parent = -1
        for above in _ancestors(model, node):
            if above in number:
                parent = number[above]
            if above in number or above in fixed:
                break
        found.append(parent)
    return found


def _end(model: Model, bone: SpringBone, scale: float) -> Float64:
    place = model.node_position
    if bone.tail >= 0:
        return np.asarray(place[bone.tail])
    parent = model.parents[bone.node]
    way = place[bone.node] - place[parent] if parent >= 0 else np.array([0.0, -1.0, 0.0])
    length = float(np.linalg.norm(way))
    way = way / length if length > 1e-9 else np.array([0.0, -1.0, 0.0])
    return np.asarray(place[bone.node] + way * (_LEAF / scale))


def _node_scale(model: Model, node: int) -> float:
    return float(np.mean(np.linalg.norm(model.node_matrix[node, :3, :3], axis=0)))


def _settings(model: Model, springs: Springs, bones: list[SpringBone], fitted: FittedCharacter) -> Float32:
    """Return stiffness, drag, gravity and radius of all bones; those of a VRM are in its units."""
    own = springs.source == "VRM"
    scale, axes = (fitted.transform.scale, fitted.transform.axes) if own else (1.0, np.eye(3))
    rows = []
    for bone in bones:
        gravity = axes @ np.array(bone.gravity) * scale
        radius = bone.radius * (scale * _node_scale(model, bone.node) if own else 1.0)
        rows.append((bone.stiffness * scale, bone.drag, *gravity, radius))
    return _float32(np.array(rows))


def _colliders(
    model: Model, springs: Springs, bones: list[SpringBone], fitted: FittedCharacter, owner: list[int]
) -> tuple[Int64, Float64, dict[int, int]]:
    """Return joints and capsules (C, 7) of the colliders that bones use, and their numbers by those of the file."""
    used = [c for c in dict.fromkeys(c for bone in bones for c in bone.colliders) if c < len(springs.colliders)]
    used = [c for c in used if springs.colliders[c].radius > 0.0][:_OWN_COLLIDERS]
    shapes = [springs.colliders[c] for c in used]
    joint = np.array([owner[shape.node] for shape in shapes], np.int64)
    ends = [
        np.array([model.node_matrix[s.node, :3, :3] @ np.array(end) + model.node_position[s.node] for s, end in pairs])
        for pairs in ([(s, s.start) for s in shapes], [(s, s.end) for s in shapes])
    ]
    radius = [shape.radius * _node_scale(model, shape.node) * fitted.transform.scale for shape in shapes]
    if not used:
        return joint, np.zeros((0, 7)), {}
    placed = [fitted.transform.apply(end, joint) for end in ends]
    return joint, np.column_stack([*placed, radius]), {c: at for at, c in enumerate(used)}


def _body(fitted: FittedCharacter) -> tuple[Int64, Float64]:
    """Return joints and capsules of the own body, as thick as the skin is."""
    rest, main = SKELETON.rest_positions(), fitted.weight.argmax(axis=1)
    rows = []
    joints = [SKELETON.index(name) for name, *_ in _BODY]
    for joint, (_, start, end, usual) in zip(joints, _BODY, strict=True):
        a, b = rest[joint] + np.array(start), rest[joint] + np.array(end)
        mine = fitted.position[main == joint]
        radius = usual
        if len(mine) > 20:
            along = np.clip(((mine - a) @ (b - a)) / max(float((b - a) @ (b - a)), 1e-9), 0.0, 1.0)
            away = np.linalg.norm(mine - a - along[:, None] * (b - a), axis=1)
            low, high = (share * usual for share in _RADIUS_RANGE)
            radius = float(np.clip(np.percentile(away, _RADIUS_SHARE), low, high))
        rows.append((*a, *b, radius))
    return np.array(joints, np.int64), np.array(rows)


def _clear_of(collider: Float64, tail: Float64, radius: Float64) -> Int64:
    """Return the colliders that each bone's tip does not touch at rest, as bits: whoever grows out of a head must not
    be pushed away from it."""
    hits = np.zeros(len(tail), np.int64)
    for number, row in enumerate(collider):
        a, b = row[:3], row[3:6]
        along = np.clip(((tail - a) @ (b - a)) / max(float((b - a) @ (b - a)), 1e-9), 0.0, 1.0)
        away = np.linalg.norm(tail - a - along[:, None] * (b - a), axis=1)
        hits |= np.where(away > row[6] + radius, 1 << number, 0)
    return hits


def _float32(array: Float64) -> Float32:
    return np.ascontiguousarray(array, np.float32)
