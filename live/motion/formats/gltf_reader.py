"""Reader for glTF, GLB and VRM animations.

Nodes become joints relative to their parent joints: chains of nodes are composed, and scales are folded into the
translations. Channels are sampled at one frame rate.
"""

from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.formats.file_error import MAGNITUDE_LIMIT, MotionFileError, quoted
from live.motion.formats.gltf_accessors import AccessorReader, Resolve
from live.motion.formats.gltf_animation import Animation, Channel, CurveReader, FrameTimes, list_animations
from live.motion.formats.gltf_document import MAGIC, GltfFile, JsonObject, open_gltf
from live.motion.formats.gltf_skeleton import (
    JointSelection,
    NodeTransform,
    NodeTree,
    bind_rotations,
    find_joints,
    is_uniform,
    rest_rotations,
    uniform_scale,
)
from live.motion.formats.motion_format import MotionFile, MotionFormat
from live.motion.formats.source_motion import FileWarning, SourceMotion
from live.motion.formats.stage_motion import StageFiles, StageMotion

_IDENTITY: Final = np.array((1.0, 0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class ChainTransform:
    """Transform of the last node of a chain relative to the parent of the first, over T frames."""

    translation: Float
    """In world metres, shape (T, 3)."""
    rotation: Float
    """Unit quaternions, shape (T, 4)."""
    scale: float
    """Accumulated scale including the last node: world metres per unit below it."""


class LocalMotion:
    """Transforms of node chains under one animation; each scale is one constant factor."""

    def __init__(
        self,
        nodes: NodeTree,
        curves: CurveReader,
        channels: dict[tuple[int, str], Channel],
        used: set[int],
        carrying: set[int],
    ) -> None:
        """`channels` by node and path; `used` are the nodes of all chains, `carrying` those with a joint below them."""
        self._nodes, self._curves, self._channels = nodes, curves, channels
        self.warnings: list[str] = []
        self._rests = {node: self._rest(node, node in carrying) for node in sorted(used)}

    def rest_transform(self, chain: list[int], scale: float) -> ChainTransform:
        """Return the chain in the rest pose, T = 1; `scale` is the accumulated scale above it."""
        return self._compose(chain, scale, {}, np.zeros(1))

    def sample(self, chain: list[int], scale: float, times: Float64) -> ChainTransform:
        """Return the chain at `times` (T,) [s]."""
        return self._compose(chain, scale, self._channels, times)

    def _rest(self, node: int, carries: bool) -> NodeTransform:
        """Return the node's rest transform; an animated scale replaces its scale."""
        rest = self._nodes.rest(node)
        scale, name = rest.scale, repr(self._nodes.name(node))
        channel = self._channels.get((node, "scale"))
        if channel is not None:
            values = self._curves.curve(channel).values
            if not (values > 1e-9).all():
                raise channel.place.error("", f"scales {name} to nothing", "factors above zero expected")
            scale = np.median(values, axis=0)
            if carries and not all(is_uniform(column) for column in values.T):
                self.warnings.append(f"the scale of {name} changes: its median is used")
        if carries and not is_uniform(scale):
            self.warnings.append(f"the scale of {name} differs along its axes: their mean is used, bones are inexact")
        return NodeTransform(rest.translation, rest.rotation, scale)

    def _compose(
        self, chain: list[int], scale: float, channels: dict[tuple[int, str], Channel], times: Float64
    ) -> ChainTransform:
        translation: Float = np.zeros((len(times), 3))
        rotation: Float = np.broadcast_to(_IDENTITY, (len(times), 4))
        for node in chain:
            rest = self._rests[node]
            moves, turns = channels.get((node, "translation")), channels.get((node, "rotation"))
            move = rest.translation if moves is None else self._curves.curve(moves).sample(times)
            turn = rest.rotation if turns is None else self._curves.curve(turns).sample(times)
            translation = translation + quaternion.rotate(rotation, scale * move)
            rotation = quaternion.mul(rotation, turn)
            scale *= uniform_scale(rest.scale)
        return ChainTransform(translation, quaternion.unit(rotation), scale)


Array = TypeVar("Array", npt.NDArray[np.float64], npt.NDArray[np.int32])

SHOWN_NAMES: Final = 6
_BASE_BYTES: Final = 32_000_000
"""Memory [bytes] always allowed for the frames; more for larger files."""
_HALF_TURN: Final = np.array((0.0, 0.0, 1.0, 0.0))


def parse_gltf(data: bytes, file: str, resolve: Resolve | None = None) -> SourceMotion:
    """Parse a .glb, .gltf, .vrm or .vrma file with an animation; `file` is its name for messages.

    Units are metres and Y is up by the format. Joints are the humanoid bones of a VRM (under their VRM names), else
    the joints of the skin that moves most, else the animated nodes. Nodes between and above them are folded in with
    their scale. VRM 0.x models face -z and are turned by 180°. All channels are sampled at one rate, that of the keys.
    The rest pose is that of the skin's inverse bind matrices, else that of the nodes.

    `resolve` returns the content of a file next to this one by its bare name (a .gltf with its .bin); without it one
    file is expected. Raises only MotionFileError for any other content; memory is bounded by 64 MB + 20 times the
    data.
    """
    try:
        return _Reader(open_gltf(data, file), resolve).read()
    except MemoryError:
        raise MotionFileError(file, None, "not enough memory", "a shorter animation expected") from None


class _Reader:
    def __init__(self, gltf: GltfFile, resolve: Resolve | None) -> None:
        self._gltf = gltf
        self._root = JsonObject(gltf.json, "", gltf.file)
        self._nodes = NodeTree(self._root)
        self._accessors = AccessorReader(gltf, resolve)
        self._curves = CurveReader(self._accessors, gltf.size)
        self._warnings: list[str] = []

    def read(self) -> SourceMotion:
        """Return the animation with most channels on the dancer's joints."""
        animations = list_animations(self._root, self._nodes)
        animated = {c.node for animation in animations for c in animation.channels if c.path != "scale"}
        if not animated:
            what = "an avatar (meshes and bones)" if self._root.length("skins") else "a model"
            remedy = "export it with its animation, or use this avatar's motion file (.vrma, .bvh, .glb)"
            raise MotionFileError(self._gltf.file, None, f"{what} without an animation that moves a joint", remedy)
        figure = find_joints(self._root, self._nodes, animated)
        self._warnings += figure.warnings
        chains = self._chains(figure)
        nodes = {node for chain in chains for node in chain}
        animation = self._select_animation(animations, nodes)
        channels = {(c.node, c.path): c for c in animation.channels if c.node in nodes}
        return self._motion(figure, chains, channels)

    def _select_animation(self, animations: list[Animation], nodes: set[int]) -> Animation:
        counts = [sum(c.node in nodes and c.path != "scale" for c in a.channels) for a in animations]
        best = int(np.argmax(counts))
        if not counts[best]:
            raise self._root.error("animations", "move no joint of the dancer", "a recorded dance expected")
        others = [a.name for a, count in zip(animations, counts, strict=True) if count and a is not animations[best]]
        if others:
            names = ", ".join(quoted(name) for name in others[:SHOWN_NAMES])
            names += f" and {len(others) - SHOWN_NAMES} more" if len(others) > SHOWN_NAMES else ""
            self._warnings.append(
                f"{len(others) + 1} animations: {quoted(animations[best].name)} moves most joints and is read, "
                f"not {names}; to use another, export it alone"
            )
        return animations[best]

    def _chains(self, figure: JointSelection) -> list[list[int]]:
        """Return for each joint the nodes from below its parent joint (for the root: from the top) down to itself."""
        chosen = set(figure.joints)
        chains = []
        for joint in figure.joints:
            chain, node = [joint], self._nodes.parents[joint]
            while node >= 0 and (node not in chosen or joint == figure.joints[0]):
                chain.append(node)
                node = self._nodes.parents[node]
            chains.append(chain[::-1])
        return chains

    def _motion(
        self, figure: JointSelection, chains: list[list[int]], channels: dict[tuple[int, str], Channel]
    ) -> SourceMotion:
        joint_count = len(figure.joints)
        frames = self._curves.frames(list(channels.values()))
        self._check_size(frames, joint_count)
        places = {node: place for place, node in enumerate(figure.joints)}
        parents = [self._parent(places, joint) for joint in figure.joints]
        carrying = {node for place, chain in enumerate(chains) for node in (chain if place in parents else chain[:-1])}
        local = LocalMotion(self._nodes, self._curves, channels, {node for chain in chains for node in chain}, carrying)
        self._warnings += local.warnings
        scales = np.empty(joint_count)
        rest, moving = (_empty(count, joint_count) for count in (1, frames.count))
        times = frames.times()
        for place, chain in enumerate(chains):
            above = 1.0 if parents[place] < 0 else float(scales[parents[place]])
            still, moved = local.rest_transform(chain, above), local.sample(chain, above, times)
            scales[place] = still.scale
            for (translation, rotation), composed in ((rest, still), (moving, moved)):
                translation[:, place], rotation[:, place] = composed.translation, composed.rotation
        for translation, rotation in (rest, moving):
            if figure.faces_back:
                translation[:, 0] = quaternion.rotate(_HALF_TURN, translation[:, 0])
                rotation[:, 0] = quaternion.mul(_HALF_TURN, rotation[:, 0])
            if not (np.abs(translation) <= MAGNITUDE_LIMIT).all():  # catches NaN too
                raise self._root.error("nodes", "are scaled or moved too far", "places of at most 1e7 m expected")
        ends = [scales[place] * self._nodes.rest(node).translation for place, node in figure.ends]
        widths = {"translation": 3, "rotation": 4, "scale": 3}
        return SourceMotion(
            file=self._gltf.file,
            names=figure.names,
            parents=_read_only(np.array(parents, np.int32)),
            offsets=_read_only(rest[0][0]),
            end_parents=_read_only(np.array([place for place, _ in figure.ends], np.int32)),
            end_offsets=_read_only(np.array(ends, np.float64).reshape(-1, 3)),
            translation=_read_only(moving[0]),
            rotation=_read_only(moving[1]),
            rest_rotation=_read_only(self._rest_rotation(figure, parents, rest[1][0])),
            frame_time=1.0 / frames.rate,
            frames_declared=frames.count,
            channel_count=sum(widths[path] for _, path in channels),
            unit_m=1.0,
            up="Y",
            root_offset="replace",
            warnings=tuple(FileWarning(what) for what in self._warnings),
        )

    def _rest_rotation(self, figure: JointSelection, parents: list[int], nodes: Float64) -> Float64:
        if figure.skin is None:
            return nodes
        skin = self._root.element("skins", figure.skin)
        bound = bind_rotations(skin, skin.integers("joints", below=self._nodes.count), self._accessors)
        return rest_rotations(parents, nodes, [bound.get(joint) for joint in figure.joints])

    def _check_size(self, frames: FrameTimes, joints: int) -> None:
        if frames.count * (56 * joints + 400) > _BASE_BYTES + 12 * self._gltf.size:
            words = (
                f"{frames.count} frames ({frames.rate:g} per second) of {joints} joints from {self._gltf.size} bytes"
            )
            raise MotionFileError(self._gltf.file, None, words, "a shorter animation expected; cut it into pieces")

    def _parent(self, places: dict[int, int], joint: int) -> int:
        node = self._nodes.parents[joint]
        while node >= 0 and node not in places:
            node = self._nodes.parents[node]
        return places.get(node, -1)


def _empty(frames: int, joints: int) -> tuple[Float64, Float64]:
    return np.empty((frames, joints, 3)), np.empty((frames, joints, 4))


def _read_only(array: Array) -> Array:
    array.setflags(write=False)
    return array


def _external_buffers(file: MotionFile) -> tuple[str, ...]:
    buffers = open_gltf(file.data, file.name).json.get("buffers", [])  # already read, so well formed
    return tuple(one["uri"] for one in buffers if not one.get("uri", "data:").startswith("data:"))


def _write(clip: Clip) -> bytes:
    from live.motion.formats.gltf_writer import write_glb  # pygltflib loads slowly, and readers do not need it

    return write_glb(clip, rate=None)


def _write_stage(motion: StageMotion, suffix: str) -> StageFiles:
    from live.motion.formats.gltf_writer import write_stage_glb

    return {"": write_stage_glb(motion)}


GLTF: Final = MotionFormat(
    "glTF",
    (".glb", ".gltf", ".vrm", ".vrma"),
    lambda file: parse_gltf(file.data, file.name, lambda name: file.load(file.path.parent / name)),
    "glTF 2.0 with an animation, also as VRM",
    begins=(MAGIC,),
    write=_write,
    written=(".glb", ".vrma"),
    write_stage=_write_stage,
    stage_suffixes=(".glb",),
    companions={".gltf": ".bin"},
    external=_external_buffers,
)
