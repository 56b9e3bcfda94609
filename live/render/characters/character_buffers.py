"""GPU buffers of a character: images and vertex attributes."""

from typing import Any, Final

import moderngl
import numpy as np

from live.render.characters.character import Character
from live.render.shader import release_all, set_uniform

IMAGE_UNIT: Final = 9
"""Texture unit of the character's images."""
_ATTRIBUTES: Final = (("in_uv", "2f", 8), ("in_tint", "4f1", 4), ("in_finish", "4f1", 4))


class CharacterBuffers:
    """Images and vertex attributes of a character, drawn by `Crowd.draw` with programs compiled with WORN."""

    def __init__(self, ctx: moderngl.Context, character: Character) -> None:
        self._ctx, self._two_sided = ctx, character.two_sided
        self._extras = character.extras.tobytes()
        self.reach = character.reach
        """Maximum distance of the surface from its joints [m]."""
        layers = character.layers
        size = layers.shape[2], layers.shape[1], layers.shape[0]
        self._images = ctx.texture_array(size, 4, np.ascontiguousarray(layers).tobytes())
        self._images.build_mipmaps()
        self._images.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        self._levels = {}
        for level, mesh in character.levels.items():
            kinds = [("uv", "f4", 2), ("tint", "u1", 4), ("finish", "u1", 4)]
            data = np.zeros(len(mesh.uv), np.dtype(kinds))
            data["uv"], data["tint"] = mesh.uv, np.rint(np.clip(mesh.tint, 0.0, 1.0) * 255.0)
            data["finish"] = np.rint(np.clip(mesh.finish * (1.0, 255.0, 255.0, 255.0), 0.0, 255.0))
            self._levels[level] = ctx.buffer(data.tobytes())

    def content(self, program: moderngl.Program, level: int) -> tuple[Any, ...]:
        """Return buffer, format and attribute names for a vertex array of a level."""
        form = " ".join(kind if name in program else f"{size}x" for name, kind, size in _ATTRIBUTES)
        return self._levels[level], form, *(name for name, _, _ in _ATTRIBUTES if name in program)

    def render(self, program: moderngl.Program, array: moderngl.VertexArray, count: int) -> None:
        """Draw the character for `count` dancers; back faces of two-sided characters are not culled."""
        set_uniform(program, "images", IMAGE_UNIT)
        self._images.use(IMAGE_UNIT)
        if "worn_extras" in program:
            extras = program["worn_extras"]
            assert isinstance(extras, moderngl.Uniform)
            extras.write(self._extras)
        if self._two_sided:
            self._ctx.disable(moderngl.CULL_FACE)
        array.render(moderngl.TRIANGLES, instances=count)
        if self._two_sided:
            self._ctx.enable(moderngl.CULL_FACE)

    def release(self) -> None:
        """Free everything."""
        release_all(self._images, *self._levels.values())
