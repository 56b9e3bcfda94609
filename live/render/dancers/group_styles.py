"""Styles of all groups as a uniform block, the draw lists that they need, and each dancer's colours.

A dancer's colours are cloth in the group's colour, tights, skin and hair, with individual variation.
"""

from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.picture_parameters import (
    GROUP_PARAMETERS,
    PART_COUNT,
    STYLE_ADDRESS_PREFIX,
    STYLE_SIZE,
    STYLES_START,
)
from live.render.shader import STYLE_VECTORS, STYLES_BINDING

LISTS: Final = (
    "all", "mirrored", "near", "far", "bodies near", "bodies far", "ink near", "ink far", "particles", "ribbons",
    "trails", "xray", "close", "bodies close", "ink close",
)  # fmt: skip
"""Draw lists: `all` cast shadows, `mirrored` are visible in the floor, `close`, `near` and `far` are plain lit bodies;
the others are drawn in a style."""
NEARNESS: Final = ("close", "near", "far")
"""Lit bodies by level of detail, in drawing order: the near ones hide others."""
_PLAIN: Final = ("all", "mirrored", *NEARNESS)
_PLACES: Final = {
    name.removeprefix(STYLE_ADDRESS_PREFIX): known.first - STYLES_START for name, known in GROUP_PARAMETERS.items()
}


_ON_BODIES: Final = tuple(
    name
    for name in (address.removeprefix(STYLE_ADDRESS_PREFIX) for address in GROUP_PARAMETERS)
    if name not in ("solid", "particles", "ribbons", "trails", "variety", "sheen") and "/" not in name
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
        self.variety: Float32 = np.full(PART_COUNT, 0.2, np.float32)
        self.sheen: Float32 = np.ones(PART_COUNT, np.float32)
        """Variation and sheen of the clothes by group."""

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
        self.variety, self.sheen = of("variety").astype(np.float32), of("sheen").astype(np.float32)

    def _lists(self) -> Int32:
        masks, bits = self.masks, np.zeros(PART_COUNT, np.int32)
        of = {"all": masks["casting"], "mirrored": masks["casting"]}
        of |= {name: masks[name] for name in ("particles", "ribbons", "trails", "xray")}
        for where in NEARNESS:
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


CLOTH: Final = 0
TIGHTS: Final = 1
SKIN: Final = 2
HAIR: Final = 3
MATERIALS: Final = 4
IDENTITY: Final = 4
"""Texel after the materials: the dancer's group (no square root), and three random numbers."""
WARDROBE_TEXELS: Final = 5
"""Texels per dancer in the wardrobe texture."""

_SHEEN: Final = (0.30, 0.30, 0.14, 0.35)
_DARK_SKIN, _PALE_SKIN = (0.20, 0.098, 0.058), (0.56, 0.33, 0.225)
_BLACK_HAIR, _BROWN_HAIR = (0.012, 0.009, 0.008), (0.070, 0.035, 0.016)
_SATURATION: Final = 1.25
"""Saturation of cloth relative to the group's colour, because light on it makes it paler."""
_VARIETY: Final = 0.2
_SEED: Final = 7


def dancer_colours(
    group: Int32, colours: Float32, variety: Float32 | None = None, sheen: Float32 | None = None
) -> npt.NDArray[np.uint8]:
    """Return the colours of A dancers as square roots of linear RGB and sheen, 0 to 255, shape (A, 5 texels, 4).

    group (A,) indexes `colours` (G, 3), `variety` and `sheen` (G,), modulo their length. `variety`: variation of
    colours in a group (default 0.2); `sheen` of its clothes (default 1). The same dancer always looks the same.
    """
    draw = np.random.default_rng(_SEED).random((len(group), 4))
    differ = np.full((len(group), 1), _VARIETY) if variety is None else variety[group % len(variety)][:, None]
    shine = np.ones((len(group), 1)) if sheen is None else sheen[group % len(sheen)][:, None]
    cloth = colours[group % len(colours)].astype(np.float64)
    grey = cloth @ np.array([0.2126, 0.7152, 0.0722])
    cloth = np.maximum(grey[:, None] + _SATURATION * (cloth - grey[:, None]), 0.0)
    cloth *= 0.61 + np.minimum(1.3 * differ, 0.7) * (draw[:, :1] - 0.5)
    turn = 0.5 * differ * (draw[:, 1:2] - 0.5)  # a little of the neighbouring hue
    cloth = np.where(
        turn > 0.0, (1.0 - turn) * cloth + turn * cloth[:, [1, 2, 0]], (1.0 + turn) * cloth - turn * cloth[:, [2, 0, 1]]
    )
    out = np.empty((len(group), WARDROBE_TEXELS, 4))
    out[:, CLOTH, :3] = cloth
    out[:, TIGHTS, :3] = cloth * np.array([0.34, 0.33, 0.36])
    out[:, SKIN, :3] = _mix(_DARK_SKIN, _PALE_SKIN, np.sqrt(draw[:, 2:3]))
    out[:, HAIR, :3] = _mix(_BLACK_HAIR, _BROWN_HAIR, draw[:, 3:4] ** 2)
    out[:, :MATERIALS, :3] = np.sqrt(np.clip(out[:, :MATERIALS, :3], 0.0, 1.0))
    out[:, :MATERIALS, 3] = np.array(_SHEEN)
    out[:, CLOTH : TIGHTS + 1, 3] *= np.minimum(shine, 1.0 / max(_SHEEN))
    out[:, IDENTITY, 0], out[:, IDENTITY, 1:] = (group % PART_COUNT) / 255.0, draw[:, [1, 2, 3]]
    return np.ascontiguousarray(np.rint(out * 255.0), np.uint8)


def _mix(
    a: tuple[float, float, float], b: tuple[float, float, float], part: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    return np.array(a) * (1.0 - part) + np.array(b) * part
