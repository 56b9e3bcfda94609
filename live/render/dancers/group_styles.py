"""Styles of all groups as a uniform block, and the draw lists that they need."""

from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.picture_parameters import (
    CLOTHES_NAMES,
    GROUP_PARAMETERS,
    PART_COUNT,
    STYLE_ADDRESS_PREFIX,
    STYLE_SIZE,
    STYLES_START,
)
from live.render.dancers.wardrobe import PLAIN_CLOTHES
from live.render.shader import STYLE_VECTORS, STYLES_BINDING

LISTS: Final = (
    "all", "mirrored", "near", "far", "bodies near", "bodies far", "ink near", "ink far", "particles", "ribbons",
    "trails", "xray",
)  # fmt: skip
"""Draw lists: `all` cast shadows, `mirrored` are visible in the floor, `near` and `far` are plain lit bodies; the
others are drawn in a style."""
_PLAIN: Final = ("all", "mirrored", "near", "far")
_PLACES: Final = {
    name.removeprefix(STYLE_ADDRESS_PREFIX): known.first - STYLES_START for name, known in GROUP_PARAMETERS.items()
}


_CLOTHES: Final = [_PLACES["variety"], _PLACES["sheen"], *range(_PLACES["accent"], _PLACES["accent"] + 4)]
_ON_BODIES: Final = tuple(
    name
    for name in (address.removeprefix(STYLE_ADDRESS_PREFIX) for address in GROUP_PARAMETERS)
    if name not in ("solid", "particles", "ribbons", "trails", "variety", "sheen", *CLOTHES_NAMES) and "/" not in name
)
"""Amounts that change how a lit body is drawn; the others are drawn beside it or belong to the clothes."""


class GroupStyles:
    """The block; call `apply_row` if the parameter row has changed. Masks are by group, shape (PART_COUNT,)."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._data = np.zeros((PART_COUNT, STYLE_VECTORS * 4), np.float32)
        self._buffer = ctx.buffer(reserve=self._data.nbytes, dynamic=True)
        self.has_effects = False
        """Whether any group is not drawn as plain lit bodies."""
        self.plain: Bool = np.ones(PART_COUNT, np.bool_)
        """Groups whose bodies are drawn plain and lit."""
        self.masks: dict[str, Bool] = {}
        """The groups that need each kind of drawing: bodies, casting (a shadow), ink, particles, ribbons, trails,
        xray."""
        self.list_bits: Int32 = np.full(PART_COUNT, sum(1 << LISTS.index(name) for name in _PLAIN), np.int32)
        """For each group the bits of the `LISTS` that its dancers are on, shape (PART_COUNT,)."""
        self.spacing = np.ones(PART_COUNT)
        """Beats between ghosts."""
        self.share = 1.0
        """Largest share of a dancer's points that any group shows, 0 to 1."""
        self.clothes: Float32 = np.tile(np.array(PLAIN_CLOTHES, np.float32), (PART_COUNT, 1))
        """The clothes of each group, see `wardrobe.PLAIN_CLOTHES`, shape (PART_COUNT, 6)."""

    def apply_row(self, row: Float64) -> None:
        """Apply a parameter row, shape (live.base.picture_parameters.ROW_SIZE,)."""
        own = row[STYLES_START:].reshape(PART_COUNT, STYLE_SIZE)
        self._data[:, :STYLE_SIZE] = own
        self._buffer.write(self._data)

        def of(name: str) -> Float64:
            return own[:, _PLACES[name]]

        solid, silhouette, ink, xray = (of(name) for name in ("solid", "silhouette", "ink", "xray"))
        fill = solid + silhouette + ink
        self.plain = (solid >= 1.0) & (sum(map(of, _ON_BODIES)) <= 0.0)
        self.masks = {name: of(name) > 0.0 for name in ("ink", "particles", "ribbons", "trails", "xray")}
        self.masks["bodies"] = (fill > 0.0) & ~self.plain
        self.masks["casting"] = fill + xray + of("particles") > 0.0
        self.has_effects = not self.plain.all() or any(
            self.masks[name].any() for name in ("particles", "ribbons", "trails")
        )
        self.list_bits[:] = self._lists()
        self.share = float((of("particles/share") * self.masks["particles"]).max())
        self.spacing = np.maximum(of("trails/spacing"), 0.25)
        self.clothes = own[:, _CLOTHES].astype(np.float32)

    def _lists(self) -> Int32:
        masks, bits = self.masks, np.zeros(PART_COUNT, np.int32)
        of = {"all": masks["casting"], "mirrored": masks["casting"]}
        of |= {name: masks[name] for name in ("particles", "ribbons", "trails", "xray")}
        for where in ("near", "far"):
            of |= {where: self.plain, f"bodies {where}": masks["bodies"], f"ink {where}": masks["ink"]}
        for name, mask in of.items():
            bits |= mask.astype(np.int32) << LISTS.index(name)
        return bits

    def bind(self) -> None:
        """Bind the block."""
        self._buffer.bind_to_uniform_block(STYLES_BINDING)

    def release(self) -> None:
        """Free the buffer."""
        self._buffer.release()
