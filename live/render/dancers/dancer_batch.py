"""Instanced drawing of all dancers: poses, skins, meshes of their pieces, colours and instance lists."""

from typing import Any, Final, Protocol

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64
from live.base.body.appearance import APPEARANCE_SIZE, BY_CHANCE
from live.base.body.catalogue import MEN
from live.base.stage_snapshot import Camera, Scene, StageView
from live.motion.skeleton import JOINT_COUNT
from live.render.adaptive_quality import Quality
from live.render.body.body_lookup import FAMILIES, characters_of, kinds_of, mesh_of, pieces_of
from live.render.body.body_mesh import BodyMesh
from live.render.camera import PicturePart, Size
from live.render.characters.character_buffers import CharacterBuffers
from live.render.characters.morphs import Morphs
from live.render.dancers.group_styles import GroupStyles
from live.render.dancers.instance_lists import BODY_REACH, InstanceLists, ViewVolume
from live.render.dancers.own_poses import OwnPoses
from live.render.dancers.skinning import POSE_TEXELS, SKIN_UNIT, MeshTexture, PoseTexture, SkinTexture, skin_levels
from live.render.dancers.wardrobe import WARDROBE_TEXELS, dancer_colours
from live.render.shader import release_all, set_uniform

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
    ("in_rest", "4f", 16),
)


def vertex_bytes(mesh: BodyMesh) -> bytes:
    layout = np.dtype([(name, *_NUMPY[form]) for name, form, _ in _ATTRIBUTES])
    data = np.zeros(len(mesh.position), layout)
    data["in_position"], data["in_normal"], data["in_openness"] = mesh.position, mesh.normal, mesh.openness
    data["in_joint"], data["in_weight"] = mesh.joint, np.rint(mesh.weight * 255.0)
    data["in_rest"][:, :3], data["in_rest"][:, 3] = mesh.place, mesh.part
    return data.tobytes()


_NUMPY: Final = {"3f": ("f4", 3), "4f": ("f4", 4), "1f": ("f4",), "4u1": ("u1", 4), "4f1": ("u1", 4)}


VERTEX_BYTES: Final = 52
MAX_SHORT_VERTICES: Final = 65_535
"""Maximum number of vertices for 16-bit indices."""


def index_bytes(mesh: BodyMesh) -> bytes:
    """Return the vertex indices of all triangles, in 16 bits if they suffice, else in 32."""
    return mesh.triangle.astype(np.uint32 if len(mesh.position) > MAX_SHORT_VERTICES else np.uint16).tobytes()


def attribute_layout(program: moderngl.Program) -> tuple[str, list[str]]:
    """Return buffer format and attribute names; attributes that the program does not use become padding."""
    form, names = [], []
    for name, kind, size in _ATTRIBUTES:
        if name in program:
            form.append(kind)
            names.append(name)
        else:
            form.append(f"{size}x")
    return " ".join(form), names


class DancerBatch:
    """Poses, skins, instance lists, bodies and the groups' styles; call `update`, then `skin` once a frame."""

    def __init__(self, ctx: moderngl.Context, scene: Scene, quality: Quality, size: Size | PicturePart) -> None:
        if scene.joint_count != JOINT_COUNT:
            raise ValueError(f"scene: joint_count {scene.joint_count}: the body has {JOINT_COUNT} joints")
        self._ctx, self.quality = ctx, quality
        self.styles = GroupStyles(ctx)
        self.kinds = kinds_of(scene)
        """Kinds of the pieces that this scene's dancers are drawn with, those of bodies first."""
        self._scene = scene
        self._men = np.array([kind.family == "body" and kind.body in MEN for kind in self.kinds])
        self._bodies = [kind for kind in self.kinds if kind.family in ("body", "character")]
        characters = characters_of(scene)
        self._characters = {name: CharacterBuffers(ctx, one) for name, one in characters.items()}
        self._own = OwnPoses(ctx, characters, [kind.body for kind in self._bodies]) if characters else None
        self.reach = max((one.reach for one in self._characters.values()), default=0.0)
        """Maximum distance of characters' surfaces from their joints [m]."""
        self._meshes: dict[tuple[Any, ...], tuple[moderngl.Buffer, moderngl.Buffer]] = {}
        self._vertex_arrays: dict[tuple[Any, ...], moderngl.VertexArray] = {}
        self._bound_programs: set[int] = set()
        self._poses, self._skin = PoseTexture(ctx), SkinTexture(ctx, self._own)

        def skinned(level: int, number: int) -> tuple[BodyMesh, Morphs | None]:
            kind = self.kinds[number]
            if kind.family != "character":
                return mesh_of(scene, kind, level), None
            mesh = characters[kind.body].levels[level]
            return mesh.body, mesh.morphs

        self._mesh_texture = MeshTexture(ctx, skinned, len(self.kinds))
        self._capacity = 0
        self.set_scene(scene)
        self.set_camera(scene.camera, size)

    def set_scene(self, scene: Scene) -> None:
        """Set the colours of a scene, and allocate for its dancers."""
        self._colours = np.array(scene.group_colours or ((0.8, 0.8, 0.8),), np.float32)
        if scene.dancer_count > self._capacity or self._capacity == 0:
            self._allocate(max(scene.dancer_count, 1))

    def set_quality(self, quality: Quality) -> None:
        """Draw bodies as detailed as this quality says."""
        self.quality = quality
        self._places = self._mesh_texture.places(skin_levels(quality))
        vertices = self._places[1]
        families = {kind.family for kind in self.kinds} - {"character"}
        members = [[at for at, kind in enumerate(self.kinds) if kind.family == family] for family in families]
        most = sum(vertices[:, which].max(axis=1) for which in members)
        characters = [at for at, kind in enumerate(self.kinds) if kind.family == "character"]
        self._skin.reserve(np.max([most, *vertices[:, characters].T], axis=0), vertices.size)
        self._bound_programs.clear()

    def set_camera(self, camera: Camera, size: Size | PicturePart) -> None:
        """Set camera and picture size, or the part that is drawn, for culling and level of detail."""
        self._view_volume = ViewVolume.of(camera, size)

    def set_colours(self, colours: npt.NDArray[np.floating]) -> None:
        """Set the groups' colours (G, 3), from the next frame on."""
        self._colours = colours.astype(np.float32)
        self._group[:] = -1

    def set_styles(self, row: npt.NDArray[np.float64]) -> None:
        """Set the groups' styles from a parameter row, from the next frame on."""
        before = self.styles.clothes
        self.styles.apply_row(row)
        if not np.array_equal(before, self.styles.clothes):
            self._group[:] = -1

    def _allocate(self, capacity: int) -> None:
        self._release_data()
        self._bound_programs.clear()
        self._capacity = capacity
        self._poses.allocate(capacity)
        width, self.rows = self._poses.texture.size
        self._skin.allocate(capacity, self.rows, len(FAMILIES))
        self.set_quality(self.quality)
        blocks = width // POSE_TEXELS
        self._wardrobe = self._ctx.texture((WARDROBE_TEXELS * blocks, self.rows), 4)
        self._wardrobe.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._group = np.full(capacity, -1, np.int32)
        self._instances = InstanceLists(self._ctx, capacity, len(self.kinds), len(FAMILIES))
        self._appearance = np.full((capacity, APPEARANCE_SIZE), BY_CHANCE - 1, np.int32)
        if self._own is not None:
            self._own.allocate(capacity, self.rows)

    @property
    def box(self) -> Float32:
        """Box around the joints of all visible dancers, shape (2, 3): lowest and highest x, y, z [m]; the lowest is
        above the highest if there are none."""
        return self._instances.box()

    def casting_box(self) -> tuple[Float64, Float64]:
        """Return lowest and highest x, y, z [m] of all dancers that may cast visible shadows; the lowest is above the
        highest if there are none."""
        low, high = self._instances.box(casting=True).astype(np.float64)
        reach = max(self.reach, BODY_REACH)
        return low - reach, high + reach

    @property
    def visibility(self) -> npt.NDArray[np.uint8]:
        """Bits of `render_kernels` for each dancer of this frame, shape (A,)."""
        return self._instances.visibility

    @property
    def capacity(self) -> int:
        """Number of dancers that buffers are allocated for; it grows with the number of dancers."""
        return self._capacity

    def reserve(self, view: StageView) -> None:
        """Allocate for the dancers of a view, of whom there may be more than in the scene."""
        count = len(view.joint_position)
        if count > self._capacity:
            self._allocate(count)

    def update(self, view: StageView, light: Float32) -> None:
        """Upload poses, colours and instance lists; `light` (3,): direction towards the key light."""
        if self.styles.has_effects:
            self.styles.bind()
        self.reserve(view)
        count = len(view.joint_position)
        changed = not np.array_equal(view.appearance, self._appearance[:count])
        if changed:
            self._appearance[:count] = view.appearance
            self._instances.piece[:count] = pieces_of(self.kinds, self._scene, view.appearance)
            if self._own is not None:
                self._own.set_bodies(self._instances.piece[:count, 0])
        meshes, skin = self._places, self._skin
        self._instances.fill(view, self._view_volume, light, self.quality, self.styles, self.reach, meshes, skin)
        self._poses.upload(view)
        if self._own is not None:
            self._own.update(view)
        if changed or not np.array_equal(view.group, self._group[:count]):
            self._upload_colours(view, count)

    def skin(self) -> None:
        """Compute poses and skins of this frame, before any pass draws a dancer."""
        self._ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._poses.draw()
        self._skin.draw(self._poses.texture, self._mesh_texture)
        self._skin.texture.use(SKIN_UNIT)  # nothing else uses these two units
        self._wardrobe.use(WARDROBE_UNIT)

    def _upload_colours(self, view: StageView, count: int) -> None:
        """Upload the dancers' colours; only needed if groups or their colours have changed."""
        self._group[:count] = view.group
        blocks, rows = self._wardrobe.width // WARDROBE_TEXELS, self.rows
        padded = np.zeros((blocks * rows, WARDROBE_TEXELS, 4), np.uint8)
        men = self._men[self._instances.piece[:count, 0]]
        padded[:count] = dancer_colours(view.group, self._colours, self.styles.clothes, view.appearance, men)
        columns = padded.reshape(blocks, rows, WARDROBE_TEXELS, 4).transpose(1, 0, 2, 3)
        self._wardrobe.write(np.ascontiguousarray(columns))

    def count(self, which: str) -> int:
        """Return the number of dancers on a list."""
        return sum(self._instances.count(which, body) for body in range(len(self._bodies)))

    def _mesh(self, level: int, kind: int) -> tuple[moderngl.Buffer, moderngl.Buffer]:
        key = level, kind
        if key not in self._meshes:
            mesh = mesh_of(self._scene, self.kinds[kind], level)
            self._meshes[key] = self._ctx.buffer(vertex_bytes(mesh)), self._ctx.buffer(index_bytes(mesh))
        return self._meshes[key]

    def draw(
        self,
        program: moderngl.Program,
        level: int,
        which: str = "all",
        poses: moderngl.Texture | None = None,
        character_program: moderngl.Program | None = None,
        head_program: moderngl.Program | None = None,
    ) -> None:
        """Draw the dancers on a list (`live.render.dancers.group_styles.LISTS`) with a program that includes
        `skin.glsl`, in the current poses or in those of the texture `poses`; heads and hair with `head_program`, which
        paints faces, and characters with `character_program`, which shows their images, if they are given."""
        programs = {"head": head_program, "hair": head_program, "character": character_program}
        for at, kind in enumerate(self.kinds):
            count = self._instances.count(which, at)
            if count == 0:
                continue
            own = programs.get(kind.family)
            linked = program if own is None else own
            character = self._characters[kind.body] if kind.family == "character" and own is not None else None
            key = (linked.glo, level, which, at)
            if key not in self._vertex_arrays:
                vertices, indices = self._mesh(level, at)
                form, names = attribute_layout(linked)
                content = [(vertices, form, *names)] if names else []
                content.append(self.instances(linked, which, at))
                content += [] if character is None else [character.content(linked, level)]
                size = 4 if vertices.size // VERTEX_BYTES > MAX_SHORT_VERTICES else 2
                self._vertex_arrays[key] = self._ctx.vertex_array(linked, content, indices, index_element_size=size)
            self.bind_program(linked)
            if poses is not None:
                poses.use(POSE_UNIT)
            if character is None:
                self._vertex_arrays[key].render(moderngl.TRIANGLES, instances=count)
            else:
                character.render(linked, self._vertex_arrays[key], count)

    def instances(self, program: moderngl.Program, which: str, kind: int) -> tuple[Any, ...]:
        """Return buffer, format and attribute name of the pieces of a kind on a list, for a program's vertex arrays."""
        skinned = "in_instance" in program
        form, name = ("2i/i", "in_instance") if skinned else ("1i 4x/i", "in_dancer")
        return self._instances.buffer(which, kind), form, name

    def draw_geometry(
        self, program: moderngl.Program, which: str, make: "VertexFactory", mode: int, vertices: int = -1
    ) -> None:
        """Draw other geometry for each dancer on a list: `make(body)` returns its buffer, format and attribute names,
        and is called once per body; `vertices` of it are drawn, all if -1."""
        for at, body in enumerate(self._bodies):
            count = self._instances.count(which, at)
            if count == 0:
                continue
            key = (program.glo, which, at)
            if key not in self._vertex_arrays:
                self._vertex_arrays[key] = self._ctx.vertex_array(
                    program, [make(body.body), self.instances(program, which, at)]
                )
            self.bind_program(program)
            self._vertex_arrays[key].render(mode, vertices=vertices, instances=count)

    def bind_program(self, program: moderngl.Program) -> None:
        """Prepare a program for drawing in the current poses; skins and wardrobe are bound by `skin`."""
        if program.glo not in self._bound_programs:
            self._bound_programs.add(program.glo)
            set_uniform(program, "poses", POSE_UNIT)
            set_uniform(program, "pose_layout", (self.rows, POSE_TEXELS))
            set_uniform(program, "wardrobe", WARDROBE_UNIT)
            set_uniform(program, "wardrobe_rows", self.rows)
            set_uniform(program, "skin", SKIN_UNIT)
            set_uniform(program, "skin_shift", self._skin.shift)
        if "poses" in program:
            self._poses.texture.use(POSE_UNIT)

    def _release_data(self) -> None:
        for array in self._vertex_arrays.values():
            array.release()
        self._vertex_arrays.clear()
        if self._capacity:
            release_all(self._wardrobe, self._instances)
            self._capacity = 0

    def release(self) -> None:
        """Free all buffers and the texture."""
        self._release_data()
        for vertices, indices in self._meshes.values():
            vertices.release()
            indices.release()
        self._meshes.clear()
        own = () if self._own is None else (self._own,)
        release_all(*self._characters.values(), *own, self._poses, self._skin, self._mesh_texture, self.styles)


class VertexFactory(Protocol):
    """Factory of the vertices that are drawn for a dancer with a given body."""

    def __call__(self, body: str) -> tuple[Any, ...]:
        """Return buffer, format and attribute names for the body of that name."""
