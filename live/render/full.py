"""A program that is drawn over a whole picture: what most passes are."""

import moderngl

from live.render.gl_release import release_all
from live.render.shader import program, set_uniform


class Full:
    """One fragment shader with the triangle that it is drawn by."""

    def __init__(
        self, ctx: moderngl.Context, fragment: str, constants: tuple[tuple[str, int | float], ...] = ()
    ) -> None:
        self._program = program(ctx, "full_vertex.glsl", fragment, constants)
        self._triangle = ctx.vertex_array(self._program, [])

    def set(self, name: str, value: object) -> None:
        """Set a uniform."""
        set_uniform(self._program, name, value)

    def draw(self, target: moderngl.Framebuffer, **textures: moderngl.Texture) -> None:
        """Draw into `target`; each texture by the name of its sampler."""
        target.use()
        for unit, (name, texture) in enumerate(textures.items(), start=1):
            texture.use(unit)
            set_uniform(self._program, name, unit)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free both."""
        release_all(self._triangle, self._program)
