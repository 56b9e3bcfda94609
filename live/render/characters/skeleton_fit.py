"""Fitting of characters to the engine's skeleton, so that they can be animated like the generated bodies.

A character's nodes are mapped to joints. Then it is rotated, scaled, posed and warped until every joint lies at its
position in the rest pose. The warp interpolates the joints' displacements with multiquadrics (Hardy 1971): joints are
matched exactly, and displacement changes smoothly between them, so limbs and clothes keep their shape. Soles lie on the
floor; head, hands and toes move rigidly.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float, Float64, Int64
from live.motion import quaternion
from live.motion.formats.file_error import MotionFileError, quoted
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_shape import find_body_by_shape
from live.motion.retarget.joint_mapping import find_body_among, split_name
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.characters.model import Model

REQUIRED_JOINTS = (
    "hips", "head", "leftUpperArm", "leftLowerArm", "rightUpperArm", "rightLowerArm", "leftUpperLeg", "leftLowerLeg",
    "leftFoot", "rightUpperLeg", "rightLowerLeg", "rightFoot",
)  # fmt: skip
"""Joints that every character must have."""


def find_joints(model: Model, overrides: Mapping[str, str]) -> dict[str, int | None]:
    """Return the character's node for each of the engine's joints, or None.

    VRM files define the mapping; for others it is derived from names and hierarchy (Mixamo, Rigify, Unreal's mannequin
    and others). `overrides` replaces it by node names. MotionFileError if a needed joint is missing.
    """
    found: dict[str, int | None] = dict.fromkeys(SKELETON.names)
    if model.bones:
        found |= {name: model.bones[name] for name in SKELETON.names if name in model.bones}
    else:
        found |= _joints_by_name(model)
    for joint, name in overrides.items():
        found[joint] = _node_named(model, joint, name)
    missing = [name for name in REQUIRED_JOINTS if found[name] is None]
    if missing:
        some = ", ".join(quoted(model.names[node]) for node in sorted(model.joints)[:8])
        raise MotionFileError(
            model.file, None, f"no {', no '.join(missing)} found among its bones ({some} ...)",
            f'define them: joints = {{ {missing[0]} = "NAME" }}',
        )  # fmt: skip
    nodes = [node for node in found.values() if node is not None]
    twice = next((node for node in nodes if nodes.count(node) > 1), None)
    if twice is not None:
        both = [joint for joint, node in found.items() if node == twice]
        words = f"{model.names[twice]!r} would be {' and '.join(both)}"
        raise MotionFileError(model.file, None, words, "define them: joints = { ... }")
    return found


def _node_named(model: Model, joint: str, name: str) -> int:
    if joint not in SKELETON.names:
        known = ", ".join(SKELETON.names)
        raise MotionFileError(model.file, None, f"{quoted(joint)} is no joint of a dancer", f"one of {known}")
    for node in (*sorted(model.joints), *range(len(model.names))):
        if model.names[node] == name:
            return int(node)
    some = ", ".join(model.names[node] for node in sorted(model.joints)[:12])
    raise MotionFileError(model.file, None, f"no bone is called {quoted(name)}", f"there are: {some} ...")


def _joints_by_name(model: Model) -> dict[str, int | None]:
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
    if body.missing:
        body = find_body_by_shape(_still_motion(model, nodes, parents)) or body
    found = {name: None if at is None else nodes[at] for name, at in body.joints.items()}
    if body.by_shape:
        _heavy_head(model, found)
    if found["head"] is None and body.spine:
        _numbered_neck(model, found, nodes[body.spine[-1]])
    return found


def _heavy_head(model: Model, found: dict[str, int | None]) -> None:
    """Correct the head of a body found by its shape: of the chain from the trunk, which may go on into long hair, the
    bone that moves most of the surface."""
    top, trunk = found["head"], [found[name] for name in ("upperChest", "chest", "spine")]
    if top is None:
        return
    chain = [top]
    while model.parents[chain[0]] >= 0 and model.parents[chain[0]] not in trunk:
        chain.insert(0, model.parents[chain[0]])
    moved = moved_surface(model)
    head = max(range(len(chain)), key=lambda at: float(moved[chain[at]]))
    found["head"], found["neck"] = chain[head], chain[0] if head > 0 else None


def moved_surface(model: Model) -> Float64:
    """Return the sum of the skin weights of each node, (N,)."""
    moved = np.zeros(len(model.names))
    for part in model.parts:
        np.add.at(moved, part.node.reshape(-1), part.weight.reshape(-1))
    return moved


def _still_motion(model: Model, nodes: list[int], parents: list[int]) -> SourceMotion:
    """Return the rest pose of nodes as a recording of one frame, in the world's axes."""
    place = model.node_position[nodes]
    offset = place - np.where(np.array(parents)[:, None] >= 0, place[parents], 0.0)
    still = np.tile((1.0, 0.0, 0.0, 0.0), (1, len(nodes), 1))
    names = tuple(model.names[node] for node in nodes)
    none = np.zeros(0, np.int32)
    return SourceMotion(
        model.file, names, np.array(parents, np.int32), offset, none, np.zeros((0, 3)), offset[None], still, None,
        frame_time=1.0, frames_declared=1, channel_count=0,
    )  # fmt: skip


def _numbered_neck(model: Model, found: dict[str, int | None], chest: int) -> None:
    """Find neck and head in Rigify's numbered spine: the bones above the chest with the same name stem."""
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


def joint_of_node(model: Model, joints: Mapping[str, int | None]) -> list[int]:
    """Return the engine's joint that moves each node: its own or that of the nearest ancestor; hips if none."""
    own = {node: SKELETON.index(name) for name, node in joints.items() if node is not None}
    result = [SKELETON.index("hips")] * len(model.names)
    for node in model.order:
        parent = model.parents[node]
        if node in own:
            result[node] = own[node]
        elif parent >= 0:
            result[node] = result[parent]
    return result


_REST: Final = SKELETON.rest_positions().astype(np.float64)
_SMOOTHING_RADIUS: Final = 0.05
"""Radius around a joint in which the displacement is nearly constant [m]."""
_BLOCK: Final = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Warp:
    """Smooth displacement of space by multiquadrics (K centres)."""

    centre: Float64
    """[m], shape (K, 3)."""
    spread: Float64
    """Weight of each centre, then the constant, shape (K + 1, 3)."""

    @staticmethod
    def of(position: Float64, place: Float64, weight: Float64) -> "Warp":
        """Return the warp that moves joints from `place` (J, 3) to the rest pose, for a body with vertices `position`
        (V, 3) of skin weights `weight` (V, J)."""
        start, end = _anchors(position, place, weight)
        moved, count = end - start, len(start)
        if np.abs(moved).max() < 1e-9:
            return Warp(start[:0], np.zeros((1, 3)))
        system = np.zeros((count + 1, count + 1))
        system[:count, :count] = _kernel(start, start)
        system[:count, count] = system[count, :count] = 1.0
        spread = np.linalg.lstsq(system, np.vstack([moved, np.zeros((1, 3))]), rcond=1e-10)[0]
        return Warp(start, np.asarray(spread, np.float64))

    def apply(self, position: Float64) -> Float64:
        """Return displaced positions (V, 3)."""
        out, count = position.copy(), len(self.centre)
        for first in range(0, len(out) if count else 0, _BLOCK):
            some = slice(first, first + _BLOCK)
            out[some] += _kernel(position[some], self.centre) @ self.spread[:count] + self.spread[count]
        return out


@dataclass(frozen=True, slots=True, eq=False)
class RestTransform:
    """What moves a character from its file's rest pose to the engine's."""

    axes: Float64
    """The character's left, up and forward directions as rows, shape (3, 3)."""
    origin: Float64
    """[file units, along these axes], shape (3,)."""
    scale: float
    """Metres per unit."""
    turn: Float64
    """Rotation of each joint's part of the body, quaternions, shape (J, 4)."""
    shift: Float64
    """Then its translation [m], shape (J, 3)."""
    warp: Warp

    def apply(self, point: Float64, joint: Int64) -> Float64:
        """Return points (P, 3) of the file [file units] that joints (P,) carry, in the engine's rest pose [m]."""
        placed = (point @ self.axes.T - self.origin) * self.scale
        return self.warp.apply(np.asarray(quaternion.rotate(self.turn[joint], placed) + self.shift[joint], np.float64))

    def apply_to_vectors(self, vector: Float64, joint: Int64) -> Float64:
        """Return vectors (P, 3) of the file, turned and scaled like the parts of joints (P,), but not warped."""
        return np.asarray(quaternion.rotate(self.turn[joint], vector @ self.axes.T * self.scale), np.float64)


def _kernel(a: Float64, b: Float64) -> Float64:
    squared = ((a[:, None, :] - b[None, :, :]) ** 2).sum(axis=2)
    return np.asarray(-np.sqrt(squared + _SMOOTHING_RADIUS * _SMOOTHING_RADIUS))


def _anchors(position: Float64, place: Float64, weight: Float64) -> tuple[Float64, Float64]:
    """Return the warp's control points before and after: joints, soles, and points around head, hands and toes."""
    start, end = [*place], [*_REST]

    def carry(joint: int, offset: Float64) -> None:
        start.append(place[joint] + offset)
        end.append(_REST[joint] + offset)

    head = SKELETON.index("head")
    own = position[weight[:, head] > 0.5] - place[head]
    if len(own):
        low, high = own.min(axis=0), own.max(axis=0)
        middle = 0.5 * (low + high)
        for axis in range(3):
            for edge in (low, high):
                offset = middle.copy()
                offset[axis] = edge[axis]
                if offset[1] >= 0.0:
                    carry(head, offset)
    for side, out in (("left", 1.0), ("right", -1.0)):
        foot, toes, hand = (SKELETON.index(side + each) for each in ("Foot", "Toes", "Hand"))
        carry(hand, np.array([0.17 * out, 0.0, 0.0]))
        for joint in (foot, toes):
            start.append(place[joint] * (1.0, 0.0, 1.0))
            end.append(_REST[joint] * (1.0, 0.0, 1.0))
        start.append((place[toes] + (0.0, 0.0, 0.07)) * (1.0, 0.0, 1.0))
        end.append((_REST[toes] + (0.0, 0.0, 0.07)) * (1.0, 0.0, 1.0))
    return np.array(start), np.array(end)


_TRUNK: Final = ("hips", "spine", "chest", "upperChest", "neck", "head")
_LIMBS: Final = tuple(
    (side + bone, side + tip)
    for side in ("left", "right")
    for bone, tip in (
        ("UpperArm", "LowerArm"), ("LowerArm", "Hand"), ("UpperLeg", "LowerLeg"), ("LowerLeg", "Foot"),
    )
)  # fmt: skip
"""Bones that are rotated to their directions in the rest pose: from a joint to the next."""
_BLEND_WIDTH: Final = 0.035
"""Half-width of the weight blend at a joint that the character lacks [m]."""


def _joint(name: str) -> int:
    return SKELETON.index(name)


@dataclass(frozen=True, slots=True, eq=False)
class FittedCharacter:
    """All parts of a character, concatenated, in the engine's rest pose (V vertices)."""

    position: Float64
    """[m], shape (V, 3)."""
    normal: Float64
    """Unit, shape (V, 3)."""
    weight: Float64
    """Skin weights for the engine's joints, rows sum to 1, shape (V, J)."""
    height: float
    """Height of the character in its file [m]."""
    max_joint_offset: float
    """Maximum distance of joints from the rest pose after scaling [m], which measures different proportions."""
    transform: RestTransform
    """From the file's rest pose."""


def fit(
    model: Model, joints: Mapping[str, int | None], fingers: Mapping[str, tuple[int, ...]] = MappingProxyType({})
) -> FittedCharacter:
    """Fit a character to the skeleton; `joints` as from `find_joints`, `fingers` as from `find_details`: with them its
    palms look down. MotionFileError if that is impossible."""
    own = joint_of_node(model, joints)
    weight = _weights(model, own)
    position = np.concatenate([part.position for part in model.parts])
    normal = np.concatenate([part.normal for part in model.parts])
    axes = _axes(model, joints)
    position, normal, places = position @ axes.T, normal @ axes.T, model.node_position @ axes.T
    known = np.array([joints[name] is not None for name in SKELETON.names])
    place = np.array([places[joints[name] or 0] for name in SKELETON.names])
    scale = _scale(model, place)
    height = float(np.ptp(position[:, 1]))
    feet = weight[:, [_joint(side + each) for side in ("left", "right") for each in ("Foot", "Toes")]].sum(axis=1) > 0.5
    floor = position[feet if feet.any() else slice(None), 1].min()
    ankles = place[[_joint("leftFoot"), _joint("rightFoot")]].mean(axis=0)
    origin = np.array([place[_joint("hips"), 0], floor, ankles[2] - _REST[_joint("leftFoot"), 2] / scale])
    position, place = (position - origin) * scale, (place - origin) * scale
    _fill_in(place, known)
    _raise_toes(place)
    weight = _split_weights(weight, position, place, known)
    turn = _limb_turns(place, {name: (places[chain[0]] - origin) * scale for name, chain in fingers.items()})
    shift, place = _limb_shifts(place, turn)
    position, normal = _pose_limbs(position, normal, weight, turn, shift)
    if not np.isfinite(position).all():
        raise MotionFileError(model.file, None, "its bones lie in one place", "a character in its rest pose expected")
    moved = float(np.linalg.norm(place - _REST, axis=1)[known].max())
    transform = RestTransform(axes, origin, scale, turn, shift, Warp.of(position, place, weight))
    return FittedCharacter(transform.warp.apply(position), normal, weight, height, moved, transform)


def _weights(model: Model, own: list[int]) -> Float64:
    owner = np.array(own)
    rows = []
    for part in model.parts:
        dense = np.zeros((len(part.position), JOINT_COUNT))
        lines = np.arange(len(dense))
        for column in range(part.node.shape[1]):
            np.add.at(dense, (lines, owner[part.node[:, column]]), part.weight[:, column])
        rows.append(dense)
    return np.concatenate(rows)


def _axes(model: Model, joints: Mapping[str, int | None]) -> Float64:
    """Return the character's left, up and forward directions as rows; up is one of the file's axes."""

    def at(name: str) -> Float64:
        return np.asarray(model.node_position[joints[name] or 0])

    rise = at("head") - 0.5 * (at("leftFoot") + at("rightFoot"))
    up = np.zeros(3)
    strongest = int(np.argmax(np.abs(rise)))
    up[strongest] = np.sign(rise[strongest])
    left = at("leftUpperLeg") - at("rightUpperLeg") + at("leftUpperArm") - at("rightUpperArm")
    left = left - up * (left @ up)
    if not np.linalg.norm(rise) > 1e-6 or not np.linalg.norm(left) > 1e-6:
        raise MotionFileError(model.file, None, "its bones lie in one place", "a character in its rest pose expected")
    left /= np.linalg.norm(left)
    return np.stack([left, up, np.cross(left, up)])


def _scale(model: Model, place: Float64) -> float:
    """Return the scale that makes the height of head over ankles equal to the rest pose's."""
    own = place[_joint("head"), 1] - 0.5 * (place[_joint("leftFoot"), 1] + place[_joint("rightFoot"), 1])
    legs = [np.linalg.norm(place[_joint(bone)] - place[_joint(tip)]) for bone, tip in _LIMBS if "Hand" not in tip]
    if not own > 1e-6 or min(legs) < 0.01 * own:
        raise MotionFileError(model.file, None, "some of its bones have no length", "correct joints = { ... }")
    return float((_REST[_joint("head"), 1] - _REST[_joint("leftFoot"), 1]) / own)


def _fill_in(place: Float64, known: npt.NDArray[np.bool_]) -> None:
    """Set positions for the joints that the character lacks, in `place` (J, 3)."""
    trunk = [_joint(name) for name in _TRUNK]
    for number, joint in enumerate(trunk):
        if known[joint]:
            continue
        below = trunk[number - 1]  # filled in already; the hips are always there
        above = next(each for each in trunk[number:] if known[each])  # the head is always there
        part = (_REST[joint, 1] - _REST[below, 1]) / (_REST[above, 1] - _REST[below, 1])
        place[joint] = place[below] + part * (place[above] - place[below])
    for side in ("left", "right"):
        shoulder, arm, fore, hand = (_joint(side + each) for each in ("Shoulder", "UpperArm", "LowerArm", "Hand"))
        foot, toes = _joint(side + "Foot"), _joint(side + "Toes")
        if not known[shoulder]:
            place[shoulder] = place[arm] + _REST[shoulder] - _REST[arm]
        if not known[hand]:
            place[hand] = place[fore] + (place[fore] - place[arm]) * (0.245 / 0.265)
        if not known[toes]:
            place[toes] = place[foot] + _REST[toes] - _REST[foot]
            place[toes, 1] = max(place[toes, 1], 0.02)


_LOWEST_TOES: Final = 0.016
"""Least height of the joints of the toes over the floor [m]."""


def _raise_toes(place: Float64) -> None:
    """Put joints of toes that lie almost on the floor at their height in the rest pose: the warp keeps the floor, and
    must not stretch the foot between both."""
    for joint in (_joint("leftToes"), _joint("rightToes")):
        if place[joint, 1] < _LOWEST_TOES:
            place[joint, 1] = _REST[joint, 1]


def _split_weights(weight: Float64, position: Float64, place: Float64, known: npt.NDArray[np.bool_]) -> Float64:
    """Move skin weights beyond a joint that the character lacks from its parent to that joint."""
    pairs = [(_TRUNK[n], _TRUNK[n + 1]) for n in range(len(_TRUNK) - 1)]
    pairs += [(side + a, side + b) for side in ("left", "right") for a, b in (("Foot", "Toes"), ("LowerArm", "Hand"))]
    for below, name in pairs:
        joint, parent = _joint(name), _joint(below)
        if known[joint]:
            continue
        along = place[joint] - place[parent]
        if name.endswith("Toes"):
            along = np.array([0.0, 0.0, 1.0])
        along = along / max(float(np.linalg.norm(along)), 1e-9)
        part = np.clip(((position - place[joint]) @ along) / (2.0 * _BLEND_WIDTH) + 0.5, 0.0, 1.0)
        part = part * part * (3.0 - 2.0 * part)
        gone = weight[:, parent] * part
        weight[:, joint] += gone
        weight[:, parent] -= gone
    return weight


_LEAST_ROLL: Final = 0.15
"""Hands whose palms look down, and which are straight, within this angle [rad] are not turned."""


def _limb_turns(place: Float64, knuckles: Mapping[str, Float64]) -> Float64:
    """Return the rotation of each joint's part of the body to its direction in the rest pose, (J, 4); `knuckles`: first
    joints of fingers by name [m]."""
    turn = np.tile((1.0, 0.0, 0.0, 0.0), (JOINT_COUNT, 1))
    for bone, tip in _LIMBS:
        turn[_joint(bone)] = quaternion.from_two_vectors(
            place[_joint(tip)] - place[_joint(bone)], _REST[_joint(tip)] - _REST[_joint(bone)]
        )
    for side in ("left", "right"):
        arm, hand = _joint(side + "LowerArm"), _joint(side + "Hand")
        turn[hand] = turn[arm]
        if side + "Index" in knuckles and side + "Little" in knuckles:
            roll = _palm_roll(quaternion.rotate(turn[arm], knuckles[side + "Little"] - knuckles[side + "Index"]))
            for joint, share in ((hand, 1.0), (arm, 0.5)):  # half of it along the forearm
                about = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(share * roll))
                turn[joint] = quaternion.mul(about, turn[joint])
        if side + "Middle" in knuckles:
            way = quaternion.rotate(turn[hand], knuckles[side + "Middle"] - place[hand])
            outwards = np.array([1.0 if side == "left" else -1.0, 0.0, 0.0])
            if (
                np.linalg.norm(way) > 1e-4
                and np.arccos(np.clip(quaternion.unit(way) @ outwards, -1.0, 1.0)) > _LEAST_ROLL
            ):
                turn[hand] = quaternion.mul(quaternion.from_two_vectors(way, outwards), turn[hand])
        ahead = (place[_joint(side + "Toes")] - place[_joint(side + "Foot")]) * (1.0, 0.0, 1.0)
        if np.linalg.norm(ahead) > 0.02:
            turn[_joint(side + "Foot")] = quaternion.from_two_vectors(ahead, np.array([0.0, 0.0, 1.0]))
        turn[_joint(side + "Toes")] = turn[_joint(side + "Foot")]
    return turn


def _palm_roll(across: Float) -> float:
    """Return the angle about x that turns the direction from index to little finger backwards, so that the palm looks
    down; 0 if it is small or the fingers lie in one place."""
    if not np.hypot(across[1], across[2]) > 1e-4:
        return 0.0
    roll = float(np.angle(np.exp(1j * (-0.5 * np.pi - np.arctan2(across[2], across[1])))))
    return roll if abs(roll) > _LEAST_ROLL else 0.0


def _limb_shifts(place: Float64, turn: Float64) -> tuple[Float64, Float64]:
    """Return the translations that follow the rotations, and the places of the joints after both, (J, 3)."""
    posed = place.copy()
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            posed[joint] = posed[parent] + quaternion.rotate(turn[parent], place[joint] - place[parent])
    return posed - quaternion.rotate(turn, place), posed


def _pose_limbs(
    position: Float64, normal: Float64, weight: Float64, turn: Float64, shift: Float64
) -> tuple[Float64, Float64]:
    """Return positions and normals rotated to the rest pose, with the skin blended by dual quaternions."""
    dual = 0.5 * quaternion.mul(np.concatenate([np.zeros((JOINT_COUNT, 1)), shift], axis=1), turn)
    main = turn[weight.argmax(axis=1)]
    sign = np.where(main @ turn.T < 0.0, -1.0, 1.0) * weight
    real, other = sign @ turn, sign @ dual
    length = np.maximum(np.linalg.norm(real, axis=1, keepdims=True), 1e-9)
    real, other = real / length, other / length
    move = 2.0 * quaternion.mul(other, quaternion.inverse(real))[:, 1:]
    placed = np.asarray(quaternion.rotate(real, position) + move, np.float64)
    return placed, np.asarray(quaternion.rotate(real, normal), np.float64)
