"""Skinning: every body's vertices are moved once per frame, into a texture that shadow, mirror and picture read.

OpenGL 4.1 has neither compute shaders nor storage buffers, so both steps draw into textures: from positions and
rotations of the joints to dual quaternions (the pose texture), and from these to the vertices of all bodies that any
list draws (the skin).
"""

from collections.abc import Callable
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Int32
from live.base.body.expression import FACE_SIZE
from live.base.stage_snapshot import StageView
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.adaptive_quality import Quality
from live.render.body.body_mesh import COARSE, BodyMesh
from live.render.body.drawn_joints import (
    DETAIL_JOINTS,
    DRAWN_COUNT,
    DRIVERS,
    EXPRESSION_SIZE,
    driver_rows,
    shader_rows,
)
from live.render.characters.morphs import NORMAL_RANGE, RANGE, Morphs
from live.render.characters.own_joints import FIRST
from live.render.dancers.own_poses import MORPH_TEXELS, OwnPoses
from live.render.shader import Releasable, compile_program, release_all, set_uniform

UInt32 = np.ndarray[tuple[int, ...], np.dtype[np.uint32]]

SKINS: Final = ("coarse", "near", "far", "close", "xray")
"""What is skinned: the bodies of shadows and mirror, of near, far and close dancers, and around x-ray skeletons."""
SKIN_UNIT: Final = 8
"""Texture unit of the skin."""
_POSE_UNIT, _ROTATION_UNIT, _EXPRESSION_UNIT, _MESH_UNIT, _ROWS_UNIT, _LIST_UNIT = 0, 1, 2, 1, 2, 3
_OWN_UNIT, _MORPH_INDEX_UNIT, _MORPH_UNIT = 4, 5, 6
_MESH_SHIFT: Final = 12
_LIST_SHIFT: Final = 10
_SKIN_SHIFT: Final = 10
"""Binary logarithms of the textures' widths; the skin of a crowd too large for this width is wider."""
_RESERVED: Final = 1 << 22
"""Texels (of 16 bytes) that are reserved at first for the worst case; a skin that needs more grows while drawing."""


POSE_TEXELS: Final = 2 * DRAWN_COUNT
"""Texels of a dancer's pose."""
_WIDEST: Final = max(POSE_TEXELS, 3 * JOINT_COUNT)
"""Texels of a dancer in the widest of the pose's textures."""


def skin_levels(quality: Quality) -> tuple[int, ...]:
    """Return the level of detail of each of `SKINS`."""
    return COARSE, quality.near_level, quality.far_level, quality.close_level, quality.ghost_level


def pose_texture(ctx: moderngl.Context, capacity: int) -> moderngl.Texture:
    """Create a texture for the poses of `capacity` dancers (see `pose_texels`); ValueError if it is too large."""
    limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
    rows = min(capacity, limit)
    width = -(-capacity // rows) * _WIDEST
    if width > limit:
        raise ValueError(f"{capacity} dancers: this graphics driver can hold {limit // _WIDEST * limit}")
    return _texture(ctx, (width // _WIDEST * POSE_TEXELS, rows), 4, "f4")


_CONSTANTS: Final = (
    ("JOINTS", JOINT_COUNT), ("DETAILS", len(DETAIL_JOINTS)), ("DRIVERS", len(DRIVERS)),
    ("EXPRESSION", EXPRESSION_SIZE),
)  # fmt: skip
_MORPHS: Final = (("MORPH_TEXELS", MORPH_TEXELS), ("MORPH_RANGE", RANGE), ("NORMAL_RANGE", NORMAL_RANGE))


class PoseTexture:
    """The pose texture `texture`, drawn from the joints of a moment by the graphics card; call `allocate` first."""

    texture: moderngl.Texture

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = compile_program(ctx, "bare_vertex.glsl", "pose_fragment.glsl", _CONSTANTS)
        set_uniform(self._program, "joint_position", _POSE_UNIT)
        set_uniform(self._program, "joint_rotation", _ROTATION_UNIT)
        set_uniform(self._program, "expression", _EXPRESSION_UNIT)
        set_uniform(self._program, "detail", [tuple(row) for row in shader_rows().reshape(-1, 4).tolist()])
        set_uniform(self._program, "driver", [tuple(row) for row in driver_rows().reshape(-1, 4).tolist()])
        set_uniform(self._program, "rest", [tuple(joint) for joint in SKELETON.rest_positions().tolist()])
        self._triangle = ctx.vertex_array(self._program, [])
        self._owned: list[Releasable] = []

    def allocate(self, capacity: int) -> None:
        """Make room for so many dancers; ValueError if the driver cannot hold them."""
        release_all(*self._owned)
        self.texture = pose_texture(self._ctx, capacity)
        width, self.rows = self.texture.size
        blocks = width // POSE_TEXELS
        self._position = _texture(self._ctx, (3 * JOINT_COUNT * blocks, self.rows), 1, "f4")
        self._rotation = _texture(self._ctx, (JOINT_COUNT * blocks, self.rows), 4, "f4")
        self._expression = _texture(self._ctx, (EXPRESSION_SIZE * blocks, self.rows), 1, "f4")
        self._expressions = np.zeros((capacity, EXPRESSION_SIZE), np.float32)
        self._target = self._ctx.framebuffer([self.texture])
        self._owned = [self._target, self._position, self._rotation, self._expression, self.texture]

    def upload(self, view: StageView) -> None:
        """Upload joints, faces and hands of a moment."""
        count = len(view.joint_position)
        expression = self._expressions[:count]
        expression[:, :FACE_SIZE] = view.face
        expression[:, FACE_SIZE:] = view.hand.reshape(count, EXPRESSION_SIZE - FACE_SIZE)
        for block, first in enumerate(range(0, count, self.rows)):
            height = min(count - first, self.rows)
            for texture, joints, width in (
                (self._position, view.joint_position, 3 * JOINT_COUNT),
                (self._rotation, view.joint_rotation, JOINT_COUNT),
                (self._expression, expression, EXPRESSION_SIZE),
            ):
                texture.write(joints[first : first + height], viewport=(block * width, 0, width, height))

    def draw(self) -> None:
        """Compute the poses of all dancers; without depth test, culling and blending."""
        self._target.use()
        self._position.use(_POSE_UNIT)
        self._rotation.use(_ROTATION_UNIT)
        self._expression.use(_EXPRESSION_UNIT)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._owned, self._triangle, self._program)


class MeshTexture:
    """The meshes of all kinds in one texture: two texels per vertex, position and joints, then normal and weights.

    If some are characters, two more textures hold what their faces move: see `skin_fragment.glsl`.
    """

    texture: moderngl.Texture
    morph_index: moderngl.Texture | None = None
    morphs: moderngl.Texture | None = None

    def __init__(
        self, ctx: moderngl.Context, mesh_of: Callable[[int, int], tuple[BodyMesh, Morphs | None]], kinds: int
    ) -> None:
        """`mesh_of`: returns the mesh of a level of detail and a kind, 0 to `kinds` - 1, and what moves it if it is a
        character's."""
        self._ctx, self._mesh_of, self._kinds = ctx, mesh_of, kinds
        self._index, self._entry = np.zeros(0, np.uint32), np.zeros((0, 4), np.uint32)
        self._has_morphs = False
        self._first: dict[tuple[int, int], tuple[int, int]] = {}
        self._texels = np.zeros((0, 2, 4), np.uint32)
        self._owned: list[Releasable] = []

    def places(self, levels: tuple[int, ...]) -> tuple[Int32, Int32]:
        """Return the first vertex and the number of vertices of each kind at each level, both (len(levels), K); meshes
        that are not there yet are added."""
        fresh = []
        end = len(self._texels)
        for level in levels:
            for kind in range(self._kinds):
                if (level, kind) not in self._first:
                    mesh, morphs = self._mesh_of(level, kind)
                    fresh.append((_mesh_texels(mesh), morphs))
                    self._first[level, kind] = end, len(mesh.position)
                    end += len(mesh.position)
        if fresh:
            self._texels = np.concatenate([self._texels, *(texels for texels, _ in fresh)])
            self._add_morphs([(morphs, len(texels)) for texels, morphs in fresh])
            self._upload()
        found = np.array([[self._first[level, kind] for kind in range(self._kinds)] for level in levels], np.int32)
        return np.ascontiguousarray(found[..., 0]), np.ascontiguousarray(found[..., 1])

    def _add_morphs(self, added: list[tuple[Morphs | None, int]]) -> None:
        """Add what moves the vertices of some meshes; each with its number of vertices."""
        counts = [np.zeros(vertices, np.uint32) if morphs is None else morphs.count for morphs, vertices in added]
        count = np.concatenate(counts)
        first = len(self._entry) + np.cumsum(count, dtype=np.uint32) - count
        self._index = np.concatenate([self._index, first << 8 | count])
        entries = [morphs.entry for morphs, _ in added if morphs is not None]
        self._has_morphs |= bool(entries)
        self._entry = np.concatenate([self._entry, *entries])

    def _upload(self) -> None:
        release_all(*self._owned)
        self.texture = self._make(self._texels.reshape(-1, 4))
        self._owned = [self.texture]
        if self._has_morphs:
            self.morph_index, self.morphs = self._make(self._index[:, None]), self._make(self._entry)
            self._owned += [self.morph_index, self.morphs]

    def _make(self, texels: UInt32) -> moderngl.Texture:
        width, components = 1 << _MESH_SHIFT, texels.shape[1]
        rows = max(-(-len(texels) // width), 1)
        padded = np.zeros((rows * width, components), np.uint32)
        padded[: len(texels)] = texels
        made = _texture(self._ctx, (width, rows), components, "u4")
        made.write(padded)
        return made

    def bind(self) -> None:
        """Bind the textures for `SkinTexture.draw`."""
        self.texture.use(_MESH_UNIT)
        if self.morph_index is not None and self.morphs is not None:
            self.morph_index.use(_MORPH_INDEX_UNIT)
            self.morphs.use(_MORPH_UNIT)

    def release(self) -> None:
        """Free the texture."""
        release_all(*self._owned)


def _mesh_texels(mesh: BodyMesh) -> UInt32:
    texels = np.zeros((len(mesh.position), 2, 4), np.uint32)
    texels[:, 0, :3] = mesh.position.view(np.uint32)
    texels[:, 1, :3] = mesh.normal.view(np.uint32)
    texels[:, 0, 3] = np.ascontiguousarray(mesh.joint, np.uint8).view("<u4")[:, 0]
    texels[:, 1, 3] = np.rint(mesh.weight * 255.0).astype(np.uint8).view("<u4")[:, 0]
    return texels


class SkinTexture:
    """The skinned vertices of a frame, whose layout `fill_lists` writes; call `allocate` and `reserve` first."""

    texture: moderngl.Texture

    def __init__(self, ctx: moderngl.Context, own: OwnPoses | None = None) -> None:
        """`own`: the own joints of characters, if there are any."""
        self._ctx, self._own = ctx, own
        constants = () if own is None else (("OWN_FIRST", FIRST), *(_MORPHS if own.has_morphs else ()))
        self._program = compile_program(ctx, "bare_vertex.glsl", "skin_fragment.glsl", constants)
        if own is not None:
            for name, value in (
                ("own_poses", _OWN_UNIT), ("morph_index", _MORPH_INDEX_UNIT), ("morphs", _MORPH_UNIT),
                ("own_texels", own.texels),
            ):  # fmt: skip
                set_uniform(self._program, name, value)
        for name, value in (
            ("poses", _POSE_UNIT), ("meshes", _MESH_UNIT), ("skin_rows", _ROWS_UNIT), ("skin_list", _LIST_UNIT),
            ("mesh_shift", _MESH_SHIFT), ("list_shift", _LIST_SHIFT),
        ):  # fmt: skip
            set_uniform(self._program, name, value)
        self._triangle = ctx.vertex_array(self._program, [])
        self._limit = int(ctx.info["GL_MAX_TEXTURE_SIZE"])
        self.rows = np.zeros((self._limit, 4), np.int32)
        """What each row of the texture holds (see `fill_lists`)."""
        self.shift = _SKIN_SHIFT
        """Binary logarithm of the texture's width."""
        self._used, self._height = 0, 0
        self._lists: list[Releasable] = []
        self._owned: list[Releasable] = []

    def allocate(self, capacity: int, pose_rows: int, pieces: int) -> None:
        """Make room for the numbers of so many dancers of so many pieces, whose poses fill so many rows."""
        set_uniform(self._program, "pose_layout", (pose_rows, POSE_TEXELS))
        release_all(*self._lists)
        self._capacity = capacity
        rows = (len(SKINS) * pieces * capacity >> _LIST_SHIFT) + 2
        self.dancers = np.zeros(rows << _LIST_SHIFT, np.int32)
        """The dancers of all skins."""
        self._list = _texture(self._ctx, (1 << _LIST_SHIFT, rows), 1, "i4")
        self._lists = [self._list]

    def reserve(self, most_vertices: Int32, parts: int) -> None:
        """Make room for dancers of at most so many vertices in each skin, (len(SKINS),), in so many pieces of the
        texture; ValueError if they cannot be held."""
        coarse, near, far, close, xray = most_vertices.tolist()
        most = self._capacity * (coarse + max(near, far, close) + xray)
        partly = parts  # each skin of each kind begins a row
        while (most >> self.shift) + partly > self._limit:
            self.shift += 1
        if 1 << self.shift > self._limit:
            raise ValueError(f"{self._capacity} dancers: this graphics driver cannot hold so many skins")
        height = (min(most, _RESERVED) >> self.shift) + partly
        if height > self._height or self.texture.width != 1 << self.shift:
            self._make(height)

    def _make(self, height: int) -> None:
        release_all(*self._owned)
        self._height = height
        self.texture = _texture(self._ctx, (1 << self.shift, height), 4, "u4")
        self._layout = _texture(self._ctx, (height, 1), 4, "i4")
        self._target = self._ctx.framebuffer([self.texture])
        self._owned = [self._target, self._layout, self.texture]

    def upload(self, used: int) -> None:
        """Upload the first `used` of `rows`, and `dancers`; a texture that is too small grows."""
        self._used = used
        if used > self._height:
            self._make(min(used + used // 2, self._limit))
        if used:
            self._layout.write(self.rows[:used], viewport=(0, 0, used, 1))
            last = int(self.rows[used - 1, 3]) + self._capacity  # no skin has more dancers than there are
            height = min((last >> _LIST_SHIFT) + 1, self._list.height)
            self._list.write(self.dancers[: height << _LIST_SHIFT], viewport=(0, 0, 1 << _LIST_SHIFT, height))

    def draw(self, poses: moderngl.Texture, meshes: MeshTexture) -> None:
        """Move the vertices of all skins; without depth test, culling and blending."""
        if not self._used:
            return
        self._target.viewport = (0, 0, 1 << self.shift, self._used)
        self._target.use()
        poses.use(_POSE_UNIT)
        meshes.bind()
        if self._own is not None:
            self._own.texture.use(_OWN_UNIT)
        self._layout.use(_ROWS_UNIT)
        self._list.use(_LIST_UNIT)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._owned, *self._lists, self._triangle, self._program)


def _texture(ctx: moderngl.Context, size: tuple[int, int], components: int, dtype: str) -> moderngl.Texture:
    texture = ctx.texture(size, components, dtype=dtype)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    texture.repeat_x = texture.repeat_y = False
    return texture
