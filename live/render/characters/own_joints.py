"""Joints that a character has besides the skeleton's: fingers, eyes, lids and jaw, and bones that swing.

Fingers and face move like the engine's own detail joints (`live.render.body.drawn_joints`), but about the places where
the character has its bones. The numbers of these joints in a mesh follow those of the drawn joints.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int32
from live.motion import quaternion
from live.motion.cloth.spring_rig import MAX_SPRINGS
from live.motion.skeleton import JOINT_COUNT
from live.render.body.drawn_joints import DETAIL_JOINTS, DRAWN_COUNT, Term
from live.render.characters.detail_bones import DetailBones
from live.render.characters.expressions import BLINKS, MOUTH, Expressions
from live.render.characters.model import Model
from live.render.characters.skeleton_fit import FittedCharacter
from live.render.characters.spring_fit import FittedSprings

FIRST: Final = DRAWN_COUNT
"""Number of a character's first own joint in its mesh."""
LIMIT: Final = 255 - DRAWN_COUNT
"""Maximum number of own joints: numbers are bytes."""
assert MAX_SPRINGS + 35 <= LIMIT
_BENDS: Final[Mapping[int, tuple[tuple[str, float], ...]]] = {
    1: (("Proximal", 1.2),),
    2: (("Proximal", 1.0), ("Intermediate", 1.1)),
    3: (("Proximal", 1.0), ("Intermediate", 1.0), ("Distal", 1.0)),
}
"""The engine's finger joint whose bend each phalanx has, and the share, by the number of phalanges."""
_JAW: Final = 1.2
_NO_TERM: Final[Term] = (0, (0.0, 0.0, 0.0))
_DETAIL: Final = {joint.name: joint for joint in DETAIL_JOINTS}


@dataclass(frozen=True, slots=True, eq=False)
class OwnJoints:
    """M own joints, parents first."""

    names: tuple[str, ...]
    parent: Int32
    """Own joint above, -1: none; shape (M,)."""
    joint: Int32
    """The skeleton's joint that carries it, shape (M,)."""
    rest: Float32
    """Place in the rest pose [m], shape (M, 3)."""
    column: Int32
    """Columns of the expression that turn it, shape (M, 2)."""
    turn: Float32
    """Rotation vector for 1 in each of these columns [rad], shape (M, 2, 3)."""
    spring: Int32
    """The bone of the character's `SpringRig` whose rotation it has, -1: none; shape (M,)."""
    node: tuple[int, ...]
    """Its node in the file."""

    @property
    def count(self) -> int:
        """Number of own joints M."""
        return len(self.names)


def own_joints(
    model: Model,
    details: DetailBones,
    fitted: FittedCharacter,
    springs: FittedSprings,
    owner: list[int],
    fixed: set[int],
) -> OwnJoints:
    """Return the own joints of a character. `owner`: the skeleton's joint that carries each node; `fixed`: nodes that
    are joints of the skeleton."""

    def place_of(node: int) -> Float64:
        return np.asarray(fitted.transform.apply(model.node_position[[node]], np.array([owner[node]]))[0])

    turned = _turned_nodes(model, details, place_of)
    place = {node: number for number, node in enumerate(springs.nodes)}
    order = [node for node in model.order if node in turned or node in place]
    number = {node: at for at, node in enumerate(order)}
    joint = np.array([owner[node] for node in order], np.int64).reshape(-1)
    rest = fitted.transform.apply(model.node_position[order].reshape(-1, 3), joint) if order else np.zeros((0, 3))
    terms = [turned.get(node, ("", (_NO_TERM, _NO_TERM)))[1] for node in order]
    return OwnJoints(
        names=tuple(turned[node][0] if node in turned else model.names[node] for node in order),
        parent=np.array([_parent(model, node, number, fixed) for node in order], np.int32),
        joint=joint.astype(np.int32),
        rest=np.ascontiguousarray(rest, np.float32),
        column=np.array([[term[0] for term in pair] for pair in terms], np.int32).reshape(-1, 2),
        turn=np.array([[term[1] for term in pair] for pair in terms], np.float32).reshape(-1, 2, 3),
        spring=np.array([place.get(node, -1) for node in order], np.int32),
        node=tuple(order),
    )


def _turned_nodes(
    model: Model, details: DetailBones, place_of: Callable[[int], Float64]
) -> dict[int, tuple[str, tuple[Term, Term]]]:
    """Return for the nodes that an expression turns their names and terms; `place_of`: places in the rest pose."""
    found: dict[int, tuple[str, tuple[Term, Term]]] = {}
    for name, chain in details.fingers.items():
        lean = _lean(name, place_of(chain[1]) - place_of(chain[0]) if len(chain) > 1 else None)
        for phalanx, (node, (which, share)) in enumerate(zip(chain, _BENDS[len(chain)], strict=True), start=1):
            like = _DETAIL[name + which]
            first = _scaled(like.first, share)
            first = _straightened(first, lean) if which == "Proximal" else _turned(first, lean)
            found[node] = f"{name}{phalanx}", (first, _turned(like.second, lean))
    for name, node in details.face.items():
        if not _is_shaped(name, model.expressions):
            like = _DETAIL[name]
            found[node] = name, (_scaled(like.first, _JAW if name == "jaw" else 1.0), like.second)
    return found


def _is_shaped(name: str, expressions: Expressions) -> bool:
    """Whether blend shapes move what this bone would."""
    if name == "jaw":
        return MOUTH in expressions.binds
    return name.endswith("Lid") and (bool(expressions.both_eyes) or any(each in expressions.binds for each in BLINKS))


def _lean(name: str, way: Float64 | None) -> Float64:
    """Return the rotation from the direction of the engine's finger to that of the character's."""
    own = np.subtract(_DETAIL[name + "Intermediate"].pivot, _DETAIL[name + "Proximal"].pivot)
    if way is None or not np.linalg.norm(way) > 1e-6:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return np.asarray(quaternion.from_two_vectors(own, way), np.float64)


def _straightened(term: Term, lean: Float64) -> Term:
    """Return the rotation that brings a finger which leans to where the engine's ends."""
    closed = quaternion.mul(quaternion.from_rotation_vector(np.array(term[1])), quaternion.inverse(lean))
    x, y, z = quaternion.to_rotation_vector(closed).tolist()
    return term[0], (x, y, z)


def _turned(term: Term, lean: Float64) -> Term:
    """Return a rotation about an axis that leans like the finger."""
    x, y, z = quaternion.rotate(lean, np.array(term[1])).tolist()
    return term[0], (x, y, z)


def _scaled(term: Term, share: float) -> Term:
    x, y, z = term[1]
    return term[0], (share * x, share * y, share * z)


def _parent(model: Model, node: int, number: Mapping[int, int], fixed: set[int]) -> int:
    above = model.parents[node]
    while above >= 0 and above not in fixed:
        if above in number:
            return number[above]
        above = model.parents[above]
    return -1


def own_of_node(model: Model, own: OwnJoints, fixed: set[int]) -> list[int]:
    """Return the own joint that moves each node: its own or that of the nearest ancestor below a joint; -1: none."""
    number = {node: at for at, node in enumerate(own.node)}
    found = [-1] * len(model.names)
    for node in model.order:
        parent = model.parents[node]
        if node in number:
            found[node] = number[node]
        elif node not in fixed and parent >= 0:
            found[node] = found[parent]
    return found


def own_weights(model: Model, own: OwnJoints, fixed: set[int]) -> Float32:
    """Return the skin weights of all parts' vertices for the own joints, (V, M)."""
    owner = np.array(own_of_node(model, own, fixed), np.int64)
    rows = []
    for part in model.parts:
        dense = np.zeros((len(part.position), own.count + 1), np.float32)  # the last column: none
        lines = np.arange(len(dense))
        for column in range(part.node.shape[1]):
            np.add.at(dense, (lines, owner[part.node[:, column]]), part.weight[:, column].astype(np.float32))
        rows.append(dense[:, :-1])
    return np.concatenate(rows) if rows else np.zeros((0, own.count), np.float32)


def drawn_weights(weight: Float64, own: OwnJoints, owned: Float32) -> Float32:
    """Return skin weights (V, DRAWN_COUNT + M): those of the skeleton (V, J) less those of the own joints (V, M)."""
    whole = np.zeros((len(weight), FIRST + own.count), np.float32)
    carrier = np.zeros((own.count, JOINT_COUNT), np.float32)
    carrier[np.arange(own.count), own.joint] = 1.0
    whole[:, :JOINT_COUNT] = np.maximum(weight - owned @ carrier, 0.0)
    whole[:, FIRST:] = owned
    return whole
