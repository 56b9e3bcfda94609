"""Trails: what was bright in the picture before stays and fades in beats, however many pictures there are in one."""

from typing import Final

import moderngl

from live.base.picture import BY_ADDRESS
from live.render.full import Full
from live.render.gl_release import release_all
from live.render.pass_context import HDR, Making, Moment, Surfaces

_ROOT: Final = "/dance/pass/trails"
_AMOUNT: Final = BY_ADDRESS[_ROOT].first
_BEATS: Final = BY_ADDRESS[f"{_ROOT}/beats"].first
_ZOOM: Final = BY_ADDRESS[f"{_ROOT}/zoom"].first
_COLOUR: Final = BY_ADDRESS[f"{_ROOT}/colour"].where


_STRENGTH: Final = 0.55
"""How bright a trail begins: less than the dancer, so that she stands out from it."""


class TrailsPass:
    """Keeps what its last picture left. A smaller amount shortens the trails, so that they fade in and out."""

    needs_surfaces = False

    def __init__(self, making: Making) -> None:
        self._ctx = making.ctx
        self._full, self._keep = (Full(making.ctx, "trails_fragment.glsl", (("SHOWN", shown),)) for shown in (1, 0))
        self._drew = False
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        self._textures = [self._ctx.texture(size, 4, dtype=HDR) for _ in range(2)]
        for texture in self._textures:
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
            texture.repeat_x = texture.repeat_y = False
        self._targets = [self._ctx.framebuffer([texture]) for texture in self._textures]
        self._turn = 0
        self._drew = False

    def active(self, moment: Moment) -> bool:
        """While its amount is not 0."""
        here = moment.amount(_AMOUNT) > 0.0
        if not here:
            self._drew = False  # what was kept is old when it is switched on again
        return here

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` and what is left of the picture before."""
        half = max(moment.amount(_BEATS) * moment.amount(_AMOUNT), 1e-3)
        there = self._drew and not moment.cut
        # a colour is what is left of white after one half-life
        tint = [min(max(value, 1e-3), 1.0) ** (moment.beats / half) for value in moment.frame.row[_COLOUR].tolist()]
        last, turn = self._textures[self._turn], 1 - self._turn
        for full, into, strength in ((self._keep, self._targets[turn], 1.0), (self._full, target, _STRENGTH)):
            full.set("left", strength * 0.5 ** (moment.beats / half) if there else 0.0)
            full.set("shrink", 2.0 ** (-moment.amount(_ZOOM) * moment.beats))
            full.set("tint", tuple(tint))
            full.draw(into, light=source, last=last)
        self._turn, self._drew = turn, True

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]: nothing is left of the last one."""
        release_all(*self._targets, *self._textures)
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._textures, self._full, self._keep)
