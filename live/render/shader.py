"""Shader sources: read from `shaders/`, with `#include "name.glsl"` and named constants put in."""

from functools import cache
from importlib import resources
from typing import Final

import moderngl

VERSION: Final = "#version 410 core"
"""The newest GLSL of macOS, and enough."""
WORN: Final = (("WORN", 1),)
"""Constants of programs that draw characters with images of their own."""
FRAME_BINDING: Final = 0
"""Where the block of uniforms that all programs share is bound."""
STYLES_BINDING: Final = 1
"""Where the block of the groups' styles is bound."""


@cache
def _read(name: str) -> str:
    return (resources.files("live.render") / "shaders" / name).read_text(encoding="utf-8")


def source(name: str, constants: tuple[tuple[str, int | float], ...] = ()) -> str:
    """The text of a shader with its includes; `constants` become #define lines.

    Raises FileNotFoundError for an unknown name.
    """
    lines = [VERSION] + [f"#define {key} {value}" for key, value in constants]
    seen: set[str] = set()

    def add(file: str) -> None:
        if file in seen:
            return
        seen.add(file)
        for line in _read(file).splitlines():
            if line.startswith("#include"):
                add(line.split('"')[1])
            else:
                lines.append(line)

    add(name)
    return "\n".join(lines) + "\n"


def program(
    ctx: moderngl.Context, vertex: str, fragment: str, constants: tuple[tuple[str, int | float], ...] = ()
) -> moderngl.Program:
    """Compile and link two shader files; binds the shared blocks `Frame` and `Styles` where the program uses them."""
    linked = ctx.program(vertex_shader=source(vertex, constants), fragment_shader=source(fragment, constants))
    for name, binding in (("Frame", FRAME_BINDING), ("Styles", STYLES_BINDING)):
        if name in linked:
            block = linked[name]
            assert isinstance(block, moderngl.UniformBlock)
            block.binding = binding
    return linked


def set_uniform(linked: moderngl.Program, name: str, value: object) -> None:
    """Set a uniform if the program kept it: compilers drop what a variant does not use."""
    if name in linked:
        uniform = linked[name]
        assert isinstance(uniform, moderngl.Uniform)
        uniform.value = value
