"""Render pass for set pieces from files: lit like dancers, hiding them and hidden by them, casting shadows."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import moderngl
import numpy as np

from live.base.arrays import Float64
from live.base.picture_parameters import BY_ADDRESS, MAX_SCENERY
from live.base.stage_snapshot import SceneryFile
from live.motion.formats.file_error import MotionFileError
from live.render.media.set_model import SOFTWARE_TRIANGLES, place_on_stage, read_set_model
from live.render.pass_context import Moment, PassSetup, ScenePass
from live.render.shader import compile_program, release_all, set_uniform

_ROWS: Final = tuple(BY_ADDRESS[f"/dance/scenery/{number}"].first for number in range(1, MAX_SCENERY + 1))
_IMAGE_UNIT: Final = 2
_LAYOUT: Final = np.dtype(
    [("position", "f4", 3), ("normal", "f4", 3), ("openness", "f4"), ("uv", "f4", 2), ("tint", "u1", 4),
     ("finish", "u1", 4)]
)  # fmt: skip
_FORMATS: Final = (
    ("in_position", "3f", 12), ("in_normal", "3f", 12), ("in_openness", "1f", 4), ("in_uv", "2f", 8),
    ("in_tint", "4f1", 4), ("in_finish", "4f1", 4),
)  # fmt: skip
_PROGRAMS: Final = (
    ("scenery_vertex.glsl", "scenery_surface_fragment.glsl"),
    ("scenery_vertex.glsl", "scenery_fragment.glsl"),
    ("item_shadow_vertex.glsl", "scenery_shadow_fragment.glsl"),
)
_SURFACE, _LIT, _SHADOW = range(3)


@dataclass(slots=True, eq=False)
class _Piece:
    """One set piece on the graphics card."""

    number: int
    buffer: moderngl.Buffer
    indices: moderngl.Buffer
    images: moderngl.Texture | moderngl.TextureArray
    arrays: list[moderngl.VertexArray]
    extras: bytes
    two_sided: bool
    box: Float64
    amount: float = 0.0


class SceneryPass(ScenePass):
    """Draws the set pieces; costs nothing while none is visible."""

    def __init__(self, making: PassSetup) -> None:
        """A file that was lost or damaged since it was checked is left out, and told."""
        self._ctx = making.ctx
        self._problems: list[str] = []
        self._programs: list[moderngl.Program] = []
        self._pieces: list[_Piece] = []
        if not any(said.file for said in making.scene.scenery):
            return
        self._programs = [compile_program(making.ctx, *files) for files in _PROGRAMS]
        limit = SOFTWARE_TRIANGLES if making.quality.samples == 0 else 0
        for number, said in enumerate(making.scene.scenery):
            if not said.file:
                continue
            try:
                self._pieces.append(self._load(number, said, limit))
            except MotionFileError as error:
                self._problems.append(f"scenery {Path(said.file).name}: {error.problem}; it is left out")

    def _load(self, number: int, said: SceneryFile, limit: int) -> _Piece:
        ctx, model = self._ctx, read_set_model(Path(said.file))
        model = model.simplified(limit) if limit else model
        position, normal, openness = place_on_stage(model, said)
        data = np.zeros(len(position), _LAYOUT)
        data["position"], data["normal"], data["openness"] = position, normal, openness[:, 0]
        data["uv"] = model.surface[:, :2]
        data["tint"] = np.rint(np.clip(model.surface[:, 2:6], 0.0, 1.0) * 255.0)
        data["finish"] = np.rint(np.clip(model.surface[:, 6:10] * (1.0, 255.0, 255.0, 1.0), 0.0, 255.0))
        buffer, indices = ctx.buffer(data.tobytes()), ctx.buffer(model.triangle.astype(np.uint32).tobytes())
        layers = model.layers
        images = ctx.texture_array((layers.shape[2], layers.shape[1], layers.shape[0]), 4, np.ascontiguousarray(layers))
        images.build_mipmaps()
        images.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        arrays = [ctx.vertex_array(linked, [_content(linked, buffer)], indices) for linked in self._programs]
        box = np.array([position.min(axis=0), position.max(axis=0)], np.float64)
        return _Piece(number, buffer, indices, images, arrays, model.extras.tobytes(), model.two_sided, box)

    @property
    def problems(self) -> list[str]:
        """Files that are left out."""
        return list(self._problems)

    def active(self, moment: Moment) -> bool:
        """Whether any set piece is visible."""
        self.box = None
        for piece in self._pieces:
            piece.amount = moment.parameter(_ROWS[piece.number])
            if piece.amount > 0.0:
                low, high = piece.box if self.box is None else self.box
                self.box = np.array([np.minimum(low, piece.box[0]), np.maximum(high, piece.box[1])])
        return self.box is not None

    def _visible(self) -> Iterator[_Piece]:
        return (piece for piece in self._pieces if piece.amount > 0.0)

    def draw_shadows(self) -> None:
        """Draw the shadows of the visible pieces into the bound layers of the floor map."""
        for piece in self._visible():
            set_uniform(self._programs[_SHADOW], "amount", piece.amount)
            piece.arrays[_SHADOW].render(moderngl.TRIANGLES)

    def draw_surfaces(self, moment: Moment) -> None:
        """See `ScenePass`."""
        self._draw(_SURFACE)

    def draw_lit(self, moment: Moment) -> None:
        """See `ScenePass`."""
        moment.floor.use(1)
        set_uniform(self._programs[_LIT], "floor_map", 1)
        self._draw(_LIT)

    def _draw(self, which: int) -> None:
        linked = self._programs[which]
        self._ctx.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        set_uniform(linked, "images", _IMAGE_UNIT)
        for piece in self._visible():
            if piece.two_sided:
                self._ctx.disable(moderngl.CULL_FACE)
            piece.images.use(_IMAGE_UNIT)
            set_uniform(linked, "amount", piece.amount)
            if "worn_extras" in linked:
                linked["worn_extras"].write(piece.extras)  # type: ignore[union-attr]
            piece.arrays[which].render(moderngl.TRIANGLES)
            self._ctx.enable(moderngl.CULL_FACE)

    def release(self) -> None:
        """Free everything."""
        for piece in self._pieces:
            release_all(*piece.arrays, piece.images, piece.buffer, piece.indices)
        release_all(*self._programs)


def _content(program: moderngl.Program, buffer: moderngl.Buffer) -> tuple[Any, ...]:
    """Return buffer, format and attribute names for a vertex array; what the program does not use is padding."""
    form = " ".join(kind if name in program else f"{size}x" for name, kind, size in _FORMATS)
    return buffer, form, *(name for name, _, _ in _FORMATS if name in program)
