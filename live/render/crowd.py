"""The dancers on the graphics side: their poses in a texture, their colours, and who is drawn how finely."""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.stage_view import Camera, Scene, StageView
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.body import BodyMesh, build_body
from live.render.camera import view_matrix
from live.render.kernels import pose_texels
from live.render.quality import Quality
from live.render.shader import set_uniform
from live.render.wardrobe import MATERIALS, dress

Float32 = npt.NDArray[np.float32]

POSE_UNIT: Final = 0
"""Texture unit of the pose texture."""
WARDROBE_UNIT: Final = 7
"""Texture unit of the dancers' colours."""
_ATTRIBUTES: Final = (
    ("in_position", "3f", 12),
    ("in_normal", "3f", 12),
    ("in_openness", "1f", 4),
    ("in_joint", "4u1", 4),
    ("in_weight", "4f1", 4),
)


def _vertex_bytes(mesh: BodyMesh) -> bytes:
    layout = np.dtype([(name, *_NUMPY[form]) for name, form, _ in _ATTRIBUTES])
    data = np.zeros(len(mesh.position), layout)
    data["in_position"], data["in_normal"], data["in_openness"] = mesh.position, mesh.normal, mesh.openness
    data["in_joint"], data["in_weight"] = mesh.joint, np.rint(mesh.weight * 255.0)
    return data.tobytes()


_NUMPY: Final = {"3f": ("f4", 3), "1f": ("f4",), "4u1": ("u1", 4), "4f1": ("u1", 4)}


def _layout(program: moderngl.Program) -> tuple[str, list[str]]:
    """Buffer format and attribute names: what the program does not use becomes padding."""
    form, names = [], []
    for name, kind, size in _ATTRIBUTES:
        if name in program:
            form.append(kind)
            names.append(name)
        else:
            form.append(f"{size}x")
    return " ".join(form), names


class Crowd:
    """Owns pose texture, instance lists (near, far, all) and the body's buffers; `update` once a frame."""

    def __init__(self, ctx: moderngl.Context, scene: Scene, quality: Quality) -> None:
        if scene.joint_count != JOINT_COUNT:
            raise ValueError(f"scene: joint_count {scene.joint_count}: the body has {JOINT_COUNT} joints")
        self._ctx, self.quality = ctx, quality
        self._rest = np.ascontiguousarray(SKELETON.rest_positions(), np.float32)
        self._meshes: dict[int, tuple[moderngl.Buffer, moderngl.Buffer]] = {}
        self._vertex_arrays: dict[tuple[int, int, str], moderngl.VertexArray] = {}
        self._capacity = 0
        self.fit(scene)

    def fit(self, scene: Scene) -> None:
        """Take colours and camera of a scene, and room for its dancers."""
        self._colours = np.array(scene.look.group_colours or ((0.8, 0.8, 0.8),), np.float32)
        self.look_from(scene.camera)
        if scene.dancer_count > self._capacity or self._capacity == 0:
            self._allocate(max(scene.dancer_count, 1))

    def look_from(self, camera: Camera) -> None:
        """Take a camera: the dancers nearest to it are drawn more finely."""
        self._forward = np.ascontiguousarray(-view_matrix(camera)[2, :3], np.float32)

    def recolour(self, colours: npt.NDArray[np.floating]) -> None:
        """Take the groups' colours (G, 3), from the next frame on."""
        self._colours = colours.astype(np.float32)
        self._group[:] = -1

    def _allocate(self, capacity: int) -> None:
        self._release_data()
        self._capacity = capacity
        limit = int(self._ctx.info["GL_MAX_TEXTURE_SIZE"])
        self._rows = min(capacity, limit)
        blocks = -(-capacity // self._rows)
        width = blocks * 2 * JOINT_COUNT
        if width > limit:
            raise ValueError(f"{capacity} dancers: this graphics driver holds {limit // (2 * JOINT_COUNT) * limit}")
        self._texels = np.zeros((self._rows, width, 4), np.float32)
        self._poses = self._ctx.texture((width, self._rows), 4, dtype="f4")
        self._poses.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._wardrobe = self._ctx.texture((MATERIALS * blocks, self._rows), 4)
        self._wardrobe.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._group = np.full(capacity, -1, np.int32)
        self._indices = np.arange(capacity, dtype=np.float32)
        self._chosen = np.zeros(capacity, np.float32)
        self._distance = np.zeros(capacity, np.float32)
        self._lists = {name: self._ctx.buffer(reserve=capacity * 4, dynamic=True) for name in ("all", "near", "far")}
        self._counts = {"all": 0, "near": 0, "far": 0}

    def update(self, view: StageView) -> None:
        """Upload poses, colours and the lists of near and far dancers."""
        count = len(view.joint_position)
        if count > self._capacity:
            self._allocate(count)
        there = self._there(view)
        self._counts = {"all": len(there), "near": 0, "far": 0}
        if len(there) == 0:
            return
        pose_texels(view.joint_position, view.joint_rotation, self._rest, self._texels)
        self._poses.write(self._texels)
        if not np.array_equal(view.group, self._group[:count]):
            self._dress(view, count)
        self._lists["all"].write(there)
        self._split(view, there)

    def _there(self, view: StageView) -> Float32:
        """Numbers of the dancers who are drawn, as the lists of instances hold them."""
        indices = self._indices[: len(view.present)]
        return indices if view.present.all() else np.ascontiguousarray(indices[view.present])

    def _dress(self, view: StageView, count: int) -> None:
        """New clothes, only when somebody changes group."""
        self._group[:count] = view.group
        blocks, rows = self._wardrobe.width // MATERIALS, self._rows
        padded = np.zeros((blocks * rows, MATERIALS, 4), np.uint8)
        padded[:count] = dress(view.group, self._colours)
        columns = padded.reshape(blocks, rows, MATERIALS, 4).transpose(1, 0, 2, 3)
        self._wardrobe.write(np.ascontiguousarray(columns))

    def _split(self, view: StageView, there: Float32) -> None:
        count = len(there)
        near = min(self.quality.near_count, count)
        if near == count:
            self._counts["near"] = count
            self._lists["near"].write(there)
            return
        distance = np.matmul(view.joint_position[:, 0], self._forward, out=self._distance[: len(view.present)])
        order = np.argpartition(distance if count == len(distance) else distance[view.present], near)
        np.take(there, order, out=self._chosen[:count], mode="clip")
        self._lists["near"].write(self._chosen[:near])
        self._lists["far"].write(self._chosen[near:count])
        self._counts["near"], self._counts["far"] = near, count - near

    def _mesh(self, level: int) -> tuple[moderngl.Buffer, moderngl.Buffer]:
        if level not in self._meshes:
            mesh = build_body(level)
            self._meshes[level] = (
                self._ctx.buffer(_vertex_bytes(mesh)),
                self._ctx.buffer(mesh.triangle.astype(np.uint16).tobytes()),
            )
        return self._meshes[level]

    def draw(self, program: moderngl.Program, level: int, which: str = "all") -> None:
        """Draw the dancers of a list ("all", "near", "far") with a program that includes `skin.glsl`."""
        count = self._counts[which]
        if count == 0:
            return
        key = (program.glo, level, which)
        if key not in self._vertex_arrays:
            vertices, indices = self._mesh(level)
            form, names = _layout(program)
            self._vertex_arrays[key] = self._ctx.vertex_array(
                program,
                [(vertices, form, *names), (self._lists[which], "1f/i", "in_dancer")],
                indices,
                index_element_size=2,
            )
        set_uniform(program, "poses", POSE_UNIT)
        set_uniform(program, "pose_layout", (self._rows, 2 * JOINT_COUNT))
        set_uniform(program, "wardrobe", WARDROBE_UNIT)
        set_uniform(program, "wardrobe_rows", self._rows)
        self._poses.use(POSE_UNIT)
        self._wardrobe.use(WARDROBE_UNIT)
        self._vertex_arrays[key].render(moderngl.TRIANGLES, instances=count)

    def _release_data(self) -> None:
        for array in self._vertex_arrays.values():
            array.release()
        self._vertex_arrays.clear()
        if self._capacity:
            self._poses.release()
            self._wardrobe.release()
            for buffer in self._lists.values():
                buffer.release()
            self._capacity = 0

    def release(self) -> None:
        """Free all buffers and the texture."""
        self._release_data()
        for vertices, indices in self._meshes.values():
            vertices.release()
            indices.release()
        self._meshes.clear()
