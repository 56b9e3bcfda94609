"""Garments in pictures: the particles of a view in a texture, grids that are drawn over them, and who is drawn."""

from typing import Any, Final

import moderngl
import numpy as np

from live.base.arrays import Float64, Int32
from live.base.stage_snapshot import StageView
from live.motion.cloth.garment_catalogue import PATTERN_NAMES, PATTERNS
from live.motion.cloth.pattern import Pattern
from live.render.dancers.dancer_batch import WARDROBE_UNIT, DancerBatch
from live.render.dancers.wardrobe import CLOTH, HAIR
from live.render.render_kernels import CASTING, CLOSE, FAR, MIRRORED, NEAR, VISIBLE
from live.render.shader import Releasable, release_all, set_uniform

PARTICLES_UNIT: Final = 9
"""Texture unit of the particles."""
_SHIFT: Final = 10
"""Binary logarithm of the texture's width."""
_INSTANCE: Final = np.dtype([("dancer", "i4"), ("first", "i4")])
_KINDS: Final = {"cloth": (CLOTH, 0), "hair": (HAIR, 1), "ribbon": (CLOTH, 2)}
"""Material of the dancer's colours and number in the shader of their surface, by the kind of a pattern."""
_NEARER: Final = {"cloth": 0.018, "hair": 0.010, "ribbon": 0.0}
"""How much nearer the depth of a garment is than its place [m], by kind."""
_DETAIL: Final = {"fine": (1 / 3, 1 / 3), "folded": (1.0, 0.5), "usual": (1.0, 1.0), "coarse": (2.0, 2.0)}
"""Rows and columns between two vertices; folds run down, so columns matter more."""
GARMENT_LISTS: Final = ("shadow", "mirror", "near", "far", "styled near", "styled far", "ink near", "ink far")
"""Draw lists, as those of bodies."""


def grid_mesh(pattern: Pattern, down: float, along: float) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return the vertices (row, column) (V, 2) float32 and triangles (T, 3) int32 of a pattern, with a vertex every so
    many rows `down` and columns `along`: whole numbers, or parts of one."""

    def places(last: int, every: float) -> np.ndarray[Any, Any]:
        if every < 1.0:
            return np.arange(round(last / every) + 1) / round(1.0 / every)
        return np.append(np.arange(0, last, round(every)), last)

    rows_at = places(pattern.rows - 1, down)
    columns_at = places(pattern.columns - (not pattern.closed), along)
    rows, columns = np.meshgrid(rows_at, columns_at, indexing="ij")
    vertices = np.stack([rows.ravel(), columns.ravel()], axis=1).astype(np.float32)
    at = np.arange(len(vertices)).reshape(len(rows_at), len(columns_at))
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


class GarmentMeshes:
    """The garments of a picture; call `update` once a frame, then `draw`."""

    def __init__(self, ctx: moderngl.Context, *, fine: bool) -> None:
        """`fine`: smooth between the particles, for a graphics card."""
        self._ctx, self.fine = ctx, fine
        self._texture = self._make_texture(1)
        self._grids: dict[tuple[str, str], tuple[moderngl.Buffer, moderngl.Buffer]] = {}
        self._lists: dict[tuple[str, str], tuple[moderngl.Buffer, int]] = {}
        self._arrays: dict[tuple[int, str, str], tuple[moderngl.VertexArray, moderngl.Buffer]] = {}
        self._wardrobe_rows = 1
        self.any = False
        """Whether any garment is drawn."""
        self.box: Float64 | None = None
        """Box around all particles, shape (2, 3): lowest and highest x, y, z [m]; None: there are none."""

    def _make_texture(self, height: int) -> moderngl.Texture:
        texture = self._ctx.texture((1 << _SHIFT, height), 3, dtype="f4")
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._staging = np.zeros((height << _SHIFT, 3), np.float32)
        return texture

    def update(self, view: StageView, crowd: DancerBatch) -> None:
        """Upload the particles of a view, and list the garments of those dancers whose bodies are drawn."""
        garments, count = view.cloth_garment, len(view.cloth_position)
        self.any = bool(len(garments))
        self.box = None
        self._lists = {key: (buffer, 0) for key, (buffer, _) in self._lists.items()}
        if not self.any:
            return
        self._wardrobe_rows = crowd.rows
        height = (count >> _SHIFT) + 1
        if height > self._texture.height:
            self._texture.release()
            self._texture = self._make_texture(height + height // 4)
        self._staging[:count] = view.cloth_position
        self.box = np.stack([view.cloth_position.min(axis=0), view.cloth_position.max(axis=0)]).astype(np.float64)
        self._texture.write(self._staging[: height << _SHIFT], viewport=(0, 0, 1 << _SHIFT, height))
        seen = crowd.visibility[garments[:, 0]]
        styles, group = crowd.styles, view.group[garments[:, 0]] % len(crowd.styles.plain)
        visible, near = (seen & VISIBLE) > 0, (seen & (NEAR | CLOSE)) > 0
        far = visible & ((seen & FAR) > 0) & ~near
        near &= visible
        plain, bodies = styles.plain[group], styles.masks.get("bodies", ~styles.plain)[group]
        ink, casting = (styles.masks[name][group] if name in styles.masks else plain for name in ("ink", "casting"))
        chosen = {
            "shadow": casting & ((seen & CASTING) > 0), "mirror": casting & ((seen & MIRRORED) > 0),
            "near": plain & near, "far": plain & far, "styled near": bodies & near, "styled far": bodies & far,
            "ink near": ink & near & ~plain, "ink far": ink & far & ~plain,
        }  # fmt: skip
        for name, who in chosen.items():
            if who.any():
                self._list(name, garments[who])

    def _list(self, name: str, garments: Int32) -> None:
        order = np.argsort(garments[:, 1], kind="stable")
        kinds, first = np.unique(garments[order, 1], return_index=True)
        ends = np.append(first[1:], len(garments))
        for kind, begin, end in zip(kinds.tolist(), first.tolist(), ends.tolist(), strict=True):
            key = name, PATTERN_NAMES[kind]
            data = np.ascontiguousarray(garments[order[begin:end]][:, [0, 2]], np.int32)
            buffer = self._lists.get(key, (None, 0))[0]
            if buffer is None or buffer.size < data.nbytes:
                if buffer is not None:
                    buffer.release()
                buffer = self._ctx.buffer(reserve=max(64 * _INSTANCE.itemsize, 2 * data.nbytes), dynamic=True)
            buffer.write(data)
            self._lists[key] = buffer, end - begin

    def _grid(self, name: str, detail: str) -> tuple[moderngl.Buffer, moderngl.Buffer]:
        if (name, detail) not in self._grids:
            vertices, triangles = grid_mesh(PATTERNS[name], *_DETAIL[detail])
            self._grids[name, detail] = self._ctx.buffer(vertices.tobytes()), self._ctx.buffer(triangles.tobytes())
        return self._grids[name, detail]

    def draw(self, program: moderngl.Program, which: str) -> None:
        """Draw the garments of a list with a program that includes `garment.glsl`; both sides are drawn."""
        if which in ("shadow", "mirror"):
            detail = "usual" if self.fine else "coarse"
        elif "far" in which:
            detail = "folded" if self.fine else "coarse"
        else:
            detail = "fine" if self.fine else "usual"
        drawn = [(key[1], *found) for key, found in self._lists.items() if key[0] == which and found[1]]
        if not drawn:
            return
        self._texture.use(PARTICLES_UNIT)
        set_uniform(program, "particles", PARTICLES_UNIT)
        set_uniform(program, "particles_shift", _SHIFT)
        set_uniform(program, "wardrobe", WARDROBE_UNIT)
        set_uniform(program, "wardrobe_rows", self._wardrobe_rows)
        for name, buffer, count in drawn:
            pattern, key = PATTERNS[name], (program.glo, name, which)
            known = self._arrays.get(key)
            if known is None or known[1] is not buffer:
                if known is not None:
                    known[0].release()
                vertices, triangles = self._grid(name, detail)
                content = [(vertices, "2f", "in_cell"), (buffer, "2i/i", "in_worn")]
                known = self._ctx.vertex_array(program, content, triangles, index_element_size=4), buffer
                self._arrays[key] = known
            set_uniform(program, "nearer", _NEARER[pattern.kind])
            set_uniform(program, "grid", (pattern.rows, pattern.columns, int(pattern.closed)))
            set_uniform(program, "cell", (pattern.spacing, float(np.mean(pattern.widths))))
            set_uniform(program, "garment", _KINDS[pattern.kind])
            set_uniform(program, "garment_size", (pattern.length, float(np.mean(pattern.widths)) * pattern.columns))
            known[0].render(moderngl.TRIANGLES, instances=count)

    def release(self) -> None:
        """Free everything."""
        owned: list[Releasable] = [array for array, _ in self._arrays.values()]
        owned += [buffer for buffer, _ in self._lists.values()]
        owned += [buffer for both in self._grids.values() for buffer in both]
        release_all(*owned, self._texture)
