"""The program of a pass of somebody's own, and what drivers say where there is none."""

import re
from typing import Final

import moderngl

from live.base.custom_pass import OwnPass
from live.base.errors import PersonError
from live.render.camera import FAR, NEAR
from live.render.shader import FRAME_BINDING, source

_LINE: Final = re.compile(r"\b0(?::(\d+)|\((\d+)\))")
"""A line in the words of a driver: 0:12(3) or 0(12)."""


def compiled(ctx: moderngl.Context, own: OwnPass) -> moderngl.Program:
    """The program of a pass; PersonError with its file and line if it is none."""
    ends = (("NEAR", NEAR), ("FAR", FAR))
    footer = source("own_footer.glsl").split("\n", 1)[1]
    text = f"{source('own_header.glsl', ends)}#line 1\n{own.source}\n{footer}"
    try:
        linked = ctx.program(vertex_shader=source("full_vertex.glsl"), fragment_shader=text)
    except moderngl.Error as error:
        raise PersonError(problem_of(own.name, str(error))) from None
    if "Frame" in linked:
        block = linked["Frame"]
        assert isinstance(block, moderngl.UniformBlock)
        block.binding = FRAME_BINDING
    return linked


def problem_of(name: str, log: str) -> str:
    """What a driver says of the pass `name`, with file and line."""
    for line in log.splitlines():
        match = _LINE.search(line)
        if match is not None and "warning" not in line.casefold():
            number = match.group(1) or match.group(2)
            words = line[match.end() :].lstrip("(): 0123456789").strip()
            return f"passes/{name}.glsl, line {number}: {words}"
    words = " ".join(line.strip() for line in log.splitlines() if line.strip(" =-"))
    return f"passes/{name}.glsl: {words[:300]}"
