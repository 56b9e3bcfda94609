"""Writer for GLB files: joints under VRM names, skinned meshes (spindles or bodies), one animation (glTF 2.0)."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt
import pygltflib as gltf

from live.base.errors import PersonError
from live.motion.clip import Clip, resample
from live.motion.formats.bone_mesh import bone_mesh
from live.motion.formats.stage_motion import DancerMotion, FigureMesh, StageMotion
from live.motion.skeleton import JOINT_COUNT, SKELETON

FRAME_RATE: Final = 60.0
"""Keys per second in written files."""
GENERATOR: Final = "ChoreoGraphics Live"
MAX_GLB_BYTES: Final = 2**32 - 2**20
"""Lengths in a GLB file have 32 bits."""
_KINDS: Final = {1: gltf.SCALAR, 3: gltf.VEC3, 4: gltf.VEC4, 16: gltf.MAT4}
_COMPONENTS: Final = {"f4": gltf.FLOAT, "u1": gltf.UNSIGNED_BYTE, "u2": gltf.UNSIGNED_SHORT}


def write_glb(clip: Clip, *, rate: float | None = FRAME_RATE) -> bytes:
    """Return the clip as a GLB file, `rate` keys per second (None: one key per sample of the clip).

    Metres, Y up, +z forward, as in glTF and the engine. For compatibility: nodes rest in the T-pose without rotations,
    and the inverse bind matrices agree; the skin lists every joint, all below one root; the skinned mesh is not a
    child of a joint; times ascend from 0 with min and max given; all data are aligned to four bytes. Blender makes an
    armature of the skin, keeps the names, and converts to Z up; its keys have the right times at any scene frame rate.
    VRMC_vrm_animation maps joints to humanoid bones, so the file renamed to .vrma animates any VRM avatar.
    """
    if rate is not None:
        clip = resample(clip, rate)
    dancer = DancerMotion("dancer", "", clip, np.ones(clip.sample_count, np.bool_))
    document, buffer = _document(clip.name, (dancer,), clip.sample_count, clip.sample_rate)
    bones = {name: {"node": joint} for joint, name in enumerate(SKELETON.names)}
    document.extensionsUsed = ["VRMC_vrm_animation"]
    document.extensions = {"VRMC_vrm_animation": {"specVersion": "1.0", "humanoid": {"humanBones": bones}}}
    return _to_bytes(document, buffer)


def write_stage_glb(motion: StageMotion) -> bytes:
    """Return all dancers of a show as one GLB file, as `write_glb` does it: each has a skeleton and a skin, and all are
    channels of one animation. Who is not on the stage has the scale 0. The group stands in the extras of the root.

    PersonError if it would be longer than a GLB file can be.
    """
    size = motion.sample_count * len(motion.dancers) * (JOINT_COUNT * 16 + 12)
    if size > MAX_GLB_BYTES:
        raise PersonError(
            f"{len(motion.dancers)} dancers with {motion.sample_count} frames need {size / 1e9:.1f} GB, and a GLB file "
            f"holds {MAX_GLB_BYTES / 1e9:.1f}",
            "give fewer frames per second (--fps 30) or a part of the show",
        )
    document, buffer = _document(motion.name, motion.dancers, motion.sample_count, motion.sample_rate)
    return _to_bytes(document, buffer)


def _document(
    name: str, dancers: Sequence[DancerMotion], sample_count: int, sample_rate: float
) -> "tuple[gltf.GLTF2, _Buffer]":
    """Return the document and its data: nodes, a mesh for each colour, a skin for each dancer, and the animation."""
    buffer = _Buffer()
    document = gltf.GLTF2(asset=gltf.Asset(version="2.0", generator=GENERATOR))
    colours = list(dict.fromkeys(dancer.colour for dancer in dancers))
    figures = _Figures(buffer, document, colours)
    document.scene = 0
    document.scenes = [gltf.Scene(name=name, nodes=[])]
    document.nodes, document.skins = [], []
    document.materials = [_material(number, colour) for number, colour in enumerate(colours)]
    document.meshes = []
    matrices = buffer.add(_inverse_bind_matrices())
    animation = gltf.Animation(name=name, samplers=[], channels=[])
    times = buffer.add((np.arange(sample_count) / sample_rate).astype(np.float32), bounds=True)
    for number, dancer in enumerate(dancers):
        base = len(document.nodes)
        root = base + JOINT_COUNT
        figure = "figure" if len(dancers) == 1 else f"{dancer.name}, figure"
        document.nodes += [
            *_joints(base),
            gltf.Node(name=dancer.name, children=[base], extras={"group": dancer.group} if dancer.group else {}),
            gltf.Node(name=figure, mesh=figures.mesh(dancer), skin=number),
        ]
        joints = list(range(base, root))
        skin = gltf.Skin(name=dancer.name, joints=joints, skeleton=root, inverseBindMatrices=matrices)
        document.skins.append(skin)
        document.scenes[0].nodes += [root, root + 1]
        _animate(animation, dancer, base, times, buffer)
        if not dancer.present.all():
            _hide(animation, dancer, root, sample_rate, buffer)
    document.animations = [animation]
    return document, buffer


def _to_bytes(document: gltf.GLTF2, buffer: "_Buffer") -> bytes:
    document.accessors, document.bufferViews = buffer.accessors, buffer.views
    document.buffers = [gltf.Buffer(byteLength=len(buffer.data))]
    document.set_binary_blob(bytes(buffer.data))
    return b"".join(document.save_to_bytes())


class _Buffer:
    """The growing binary chunk: each array gets a separate view and accessor."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[gltf.BufferView] = []
        self.accessors: list[gltf.Accessor] = []

    def add(self, array: npt.NDArray[np.generic], *, target: int | None = None, bounds: bool = False) -> int:
        """Append an array (n,) or (n, width) and return its accessor index. `bounds` writes min and max."""
        table = np.ascontiguousarray(array.reshape(len(array), -1))
        self.views.append(gltf.BufferView(buffer=0, byteOffset=len(self.data), byteLength=table.nbytes, target=target))
        self.data += table.tobytes()
        self.data += bytes(-len(self.data) % 4)
        self.accessors.append(
            gltf.Accessor(
                bufferView=len(self.views) - 1,
                componentType=_COMPONENTS[table.dtype.str[1:]],
                count=len(table),
                type=_KINDS[table.shape[1]],
                min=table.min(axis=0).tolist() if bounds else None,
                max=table.max(axis=0).tolist() if bounds else None,
            )
        )
        return len(self.accessors) - 1


def _joints(base: int) -> list[gltf.Node]:
    """Return the engine's skeleton in its rest pose, the nodes from `base` on; without rotations this is the T-pose."""
    return [
        gltf.Node(
            name=name,
            translation=[round(float(metres), 6) for metres in SKELETON.offsets[joint]],
            children=[base + int(child) for child in np.flatnonzero(SKELETON.parents == joint)],
        )
        for joint, name in enumerate(SKELETON.names)
    ]


def _material(number: int, colour: tuple[float, float, float]) -> gltf.Material:
    surface = gltf.PbrMetallicRoughness(baseColorFactor=[*colour, 1.0], metallicFactor=0.0, roughnessFactor=0.8)
    return gltf.Material(name="figure" if number == 0 else f"figure {number + 1}", pbrMetallicRoughness=surface)


def _inverse_bind_matrices() -> npt.NDArray[np.float32]:
    """Return the matrices from mesh space to joint space in the rest pose, (J, 16), column-major."""
    matrices = np.tile(np.eye(4, dtype=np.float32), (JOINT_COUNT, 1, 1))
    matrices[:, 3, :3] = -SKELETON.rest_positions()
    return matrices.reshape(JOINT_COUNT, 16)


class _Figures:
    """The meshes of a document: one for each figure in each colour; those of a figure share their data."""

    def __init__(self, buffer: _Buffer, document: gltf.GLTF2, colours: Sequence[tuple[float, float, float]]) -> None:
        self._buffer, self._document, self._colours = buffer, document, colours
        self._bones = bone_mesh()
        self._data: dict[int, tuple[gltf.Attributes, int]] = {}
        self._meshes: dict[tuple[int, int], int] = {}

    def mesh(self, dancer: DancerMotion) -> int:
        """Return the number of the mesh of a dancer."""
        figure, material = dancer.figure or self._bones, self._colours.index(dancer.colour)
        key = id(figure), material
        if key not in self._meshes:
            attributes, indices = self._shared(figure)
            primitive = gltf.Primitive(attributes=attributes, indices=indices, material=material)
            self._meshes[key] = len(self._document.meshes)
            self._document.meshes.append(gltf.Mesh(name="figure", primitives=[primitive]))
        return self._meshes[key]

    def _shared(self, figure: FigureMesh) -> tuple[gltf.Attributes, int]:
        if id(figure) not in self._data:
            add = self._buffer.add
            attributes = gltf.Attributes(
                POSITION=add(figure.positions, target=gltf.ARRAY_BUFFER, bounds=True),
                NORMAL=add(figure.normals, target=gltf.ARRAY_BUFFER),
                JOINTS_0=add(figure.joints, target=gltf.ARRAY_BUFFER),
                WEIGHTS_0=add(figure.weights, target=gltf.ARRAY_BUFFER),
            )
            self._data[id(figure)] = attributes, add(figure.indices, target=gltf.ELEMENT_ARRAY_BUFFER)
        return self._data[id(figure)]


def _animate(animation: gltf.Animation, dancer: DancerMotion, base: int, times: int, buffer: _Buffer) -> None:
    """Add the hips' translation and all rotations as channels that share one time array."""
    rotation = dancer.rotation_xyzw()
    _add_channel(animation, base, gltf.TRANSLATION, times, dancer.clip.root_position, buffer)
    for joint in range(JOINT_COUNT):
        _add_channel(animation, base + joint, gltf.ROTATION, times, rotation[:, joint], buffer)


def _hide(animation: gltf.Animation, dancer: DancerMotion, root: int, sample_rate: float, buffer: _Buffer) -> None:
    """Add steps of the root's scale: 1 while the dancer is on the stage, else 0."""
    at = dancer.presence_changes()
    times = buffer.add((at / sample_rate).astype(np.float32), bounds=True)
    scale = np.repeat(dancer.present[at].astype(np.float32)[:, None], 3, axis=1)
    _add_channel(animation, root, gltf.SCALE, times, scale, buffer, gltf.ANIM_STEP)


def _add_channel(
    animation: gltf.Animation, node: int, path: str, times: int, values: npt.NDArray[np.float32], buffer: _Buffer,
    interpolation: str = gltf.ANIM_LINEAR,
) -> None:  # fmt: skip
    sampler = gltf.AnimationSampler(input=times, output=buffer.add(values), interpolation=interpolation)
    target = gltf.AnimationChannelTarget(node=node, path=path)
    animation.channels.append(gltf.AnimationChannel(sampler=len(animation.samplers), target=target))
    animation.samplers.append(sampler)
