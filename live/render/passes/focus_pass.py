"""Depth of field: what lies off the focus spreads into circles, as through a lens of this diameter.

The circle of confusion is that of a thin lens (Potmesil and Chakravarty 1981, A lens and aperture camera model); it is
gathered from a smaller picture (after Gustafsson 2018, Bokeh depth of field in a single pass).
"""

import math
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float64
from live.base.picture_parameters import BY_ADDRESS
from live.base.stage_snapshot import Camera, StageView
from live.render.camera import FAR, NEAR, view_matrix
from live.render.headless import is_software
from live.render.pass_context import HDR, NO_MEMORY, Memory, Moment, PassSetup, Surfaces
from live.render.shader import FullscreenShader, release_all
from live.render.uniforms import WALL_DISTANCE

_ROOT: Final = "/dance/pass/focus"
_AMOUNT: Final = BY_ADDRESS[_ROOT].first
_DISTANCE: Final = BY_ADDRESS[f"{_ROOT}/distance"].first
_APERTURE: Final = BY_ADDRESS[f"{_ROOT}/aperture"].first
_SPOTS: Final = tuple(BY_ADDRESS[f"/dance/spot/{number}"].first for number in range(1, 5))
_DIVISORS: Final = (2, 3)
"""The gathered picture has 1/n of the size: on a graphics card, where the processor draws."""
_TAPS: Final = (24, 16)
_TILE: Final = 8
"""Side of a tile of the gathered picture [pixels]."""
_LARGEST: Final = 1.0 / 26.0
"""Largest radius of a circle, as a share of the picture's height."""
_CHEST: Final = 1.2
"""Height of a person on whom the focus lies [m]."""
_NEAREST: Final = 0.5
"""Nearest distance of the focus [m]."""
_CENTRE: Final = 0.2
"""The automatic focus lies on a dancer who is no farther from the picture's middle than this share of the depth."""
_HALF_LIFE_S: Final = 0.2
"""Half-life of the automatic focus' approach [s]."""
_MEMORY_HALF_LIVES: Final = 60.0
"""After so many half-lives no bit of the distance depends on where the focus was."""
_CONSTANTS: Final = (("NEAR", NEAR), ("FAR", FAR), ("WALL_BEHIND", WALL_DISTANCE))


class FocusPass:
    """Draws the picture with depth of field."""

    needs_surfaces = True

    def __init__(self, making: PassSetup) -> None:
        ctx = self._ctx = making.ctx
        slow = is_software(ctx)
        self._divisor = _DIVISORS[slow]
        self._spread = FullscreenShader(ctx, "focus_spread_fragment.glsl", _CONSTANTS)
        self._most = [FullscreenShader(ctx, "tile_radius_fragment.glsl") for _ in range(2)]
        self._gather = FullscreenShader(ctx, "focus_gather_fragment.glsl", (("TAPS", _TAPS[slow]),))
        self._final = FullscreenShader(
            ctx, "focus_fragment.glsl", (*_CONSTANTS, ("SMALLEST", float(self._divisor + 0.5)))
        )
        self._inverse: float | None = None
        self._time = 0.0
        self._make(making.size)

    def _make(self, size: tuple[int, int]) -> None:
        small = max(size[0] // self._divisor, 1), max(size[1] // self._divisor, 1)
        tiles = -(-small[0] // _TILE), -(-small[1] // _TILE)
        self._textures = [self._ctx.texture(each, 4, dtype=HDR) for each in (small, small, tiles, tiles)]
        for texture in self._textures:
            texture.repeat_x = texture.repeat_y = False
            texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._textures[0].filter = (moderngl.NEAREST, moderngl.NEAREST)  # radii between two things belong to neither
        self._targets = [self._ctx.framebuffer([texture]) for texture in self._textures]

    @staticmethod
    def memory(row: Float64) -> Memory:
        """Return how long the automatic focus approaches in a picture with these parameters."""
        moves = row[_AMOUNT] > 0.0 and row[_DISTANCE] <= 0.0
        return Memory(seconds=_MEMORY_HALF_LIVES * _HALF_LIFE_S) if moves else NO_MEMORY

    def follow(self, moment: Moment) -> None:
        """Move the automatic focus in a moment that is not drawn."""
        self._focus(moment)

    @staticmethod
    def reach(height: float, row: Float64) -> float:
        """Return how far from a pixel it looks, with these parameters, in a picture of this height [pixels]."""
        return _LARGEST * height + 3.0 * max(_DIVISORS)

    def active(self, moment: Moment) -> bool:
        """Whether its amount is not 0."""
        used = moment.parameter(_AMOUNT) > 0.0
        if not used:
            self._inverse = None
        return used

    def draw(
        self, source: moderngl.Texture, target: moderngl.Framebuffer, surfaces: Surfaces | None, moment: Moment
    ) -> None:
        """Draw `source` with depth of field."""
        assert surfaces is not None
        focus = self._focus(moment)
        camera, height = moment.uniforms.camera, moment.uniforms.height
        lens = moment.parameter(_AMOUNT) * moment.parameter(_APERTURE)
        widest = 0.5 * height * spread_of(lens, focus, camera.field_of_view_deg)
        spread, gathered, tiles, around = self._textures
        small = 1.0 / self._divisor
        self._spread.set("focus", focus)
        self._spread.set("widest", widest * small)
        self._spread.set("apart", 0.5 * (self._divisor - 1))
        self._spread.set("most", _LARGEST * height * small)
        self._spread.draw(self._targets[0], light=source, depth=surfaces.depth)
        for shader, side, into, read in zip(self._most, (_TILE, 0), (2, 3), (spread, tiles), strict=True):
            shader.set("tile", side)
            shader.draw(self._targets[into], source=read)
        self._gather.set("tile", float(_TILE))
        self._gather.draw(self._targets[1], spread=spread, tiles=around)
        self._final.set("focus", focus)
        self._final.set("widest", widest)
        self._final.set("most", _LARGEST * height * small)
        self._final.draw(target, light=source, gathered=gathered, spread=spread, depth=surfaces.depth)

    def _focus(self, moment: Moment) -> float:
        """Return the distance of the focus [m]: the set one, or the automatic one, which moves softly."""
        said, view = moment.parameter(_DISTANCE), moment.view
        if said > 0.0:
            self._inverse = None
            return max(said, _NEAREST)
        levels = [moment.parameter(row) for row in _SPOTS]
        wanted = 1.0 / automatic_distance(view, moment.uniforms.camera, levels)
        passed = view.time - self._time
        self._time = view.time
        if self._inverse is None or moment.cut or not 0.0 <= passed < 1.0:
            self._inverse = wanted
        self._inverse = wanted + (self._inverse - wanted) * 0.5 ** (passed / _HALF_LIFE_S)
        return 1.0 / self._inverse

    def resize(self, size: tuple[int, int]) -> None:
        """New size of the picture [pixels]."""
        release_all(*self._targets, *self._textures)
        self._make(size)

    def release(self) -> None:
        """Free everything."""
        release_all(*self._targets, *self._textures, self._spread, *self._most, self._gather, self._final)


def spread_of(lens: float, focus: float, field_of_view_deg: float) -> float:
    """Return the diameter of the circle of what is infinitely far, as a share of the picture's height, through a lens
    of this diameter that is focused at a distance [m].

    What is at distance d has (d - focus) / d of it: similar triangles between lens and focal plane.
    """
    return lens / (2.0 * focus * math.tan(0.5 * math.radians(field_of_view_deg)))


def automatic_distance(view: StageView, camera: Camera, spots: list[float]) -> float:
    """Return the distance along the camera's axis [m] of the brightest follow spot, else of the dancer nearest to the
    picture's middle, else of the camera's target. `spots`: levels of the follow spots."""
    matrix = view_matrix(camera)
    if max(spots) > 0.0:
        x, z = view.spot[int(np.argmax(spots))]
        return max(-float(matrix[2, :3] @ (x, _CHEST, z) + matrix[2, 3]), _NEAREST)
    away = math.dist(camera.eye, camera.target)
    if view.present.any():
        place = view.joint_position[view.present, 0] @ matrix[:3, :3].T + matrix[:3, 3]
        depth = np.maximum(-place[:, 2], _NEAREST)
        aside = np.abs(place[:, 0]) / depth
        aside[-place[:, 2] < _NEAREST] = np.inf
        cost = aside + 0.02 * np.abs(depth - away)
        best = int(np.argmin(cost))
        if aside[best] < _CENTRE:
            return float(depth[best])
    return max(away, _NEAREST)
