"""Compiler and trial run of custom passes (user shaders).

A custom pass is first tried in a separate process, because a shader may loop forever or crash the driver.

python -m live.render.custom_pass < passes.json
"""

import json
import re
import subprocess
import sys
from functools import lru_cache
from typing import Any, Final

import moderngl

from live.base.custom_pass import CustomShader, parse_custom_pass
from live.base.errors import PersonError
from live.render.camera import FAR, NEAR
from live.render.shader import bind_blocks, source

_LINE: Final = re.compile(r"\b0(?::(\d+)|\((\d+)\))")
"""A line number in a driver's log: 0:12(3) or 0(12)."""


def compile_pass(ctx: moderngl.Context, own: CustomShader) -> moderngl.Program:
    """Return the compiled program of a pass; PersonError with file and line if it does not compile."""
    ends = (("NEAR", NEAR), ("FAR", FAR))
    footer = source("own_footer.glsl").split("\n", 1)[1]
    text = f"{source('own_header.glsl', ends)}#line 1\n{own.source}\n{footer}"
    try:
        linked = ctx.program(vertex_shader=source("full_vertex.glsl", (("OWN", 1),)), fragment_shader=text)
    except moderngl.Error as error:
        raise PersonError(first_error(own.name, str(error))) from None
    bind_blocks(linked)
    return linked


def first_error(name: str, log: str) -> str:
    """Return the first error that a driver's log reports for the pass `name`, with file and line."""
    for line in log.splitlines():
        match = _LINE.search(line)
        if match is not None and "warning" not in line.casefold():
            number = match.group(1) or match.group(2)
            words = line[match.end() :].lstrip("(): 0123456789").strip()
            return f"passes/{name}.glsl, line {number}: {words}"
    words = " ".join(line.strip() for line in log.splitlines() if line.strip(" =-"))
    return f"passes/{name}.glsl: {words[:300]}"


TIME_LIMIT_S: Final = 20.0
"""Seconds allowed for drawing a small picture with the passes, including the start of the process."""
TRIAL_SIZE: Final = (64, 36)
_NO_OPENGL: Final = 3
"""Exit code where there is no headless OpenGL: the trial is inconclusive."""


def try_passes(passes: tuple[CustomShader, ...], *, limit: float = TIME_LIMIT_S) -> None:
    """Raise PersonError if one of the passes does not compile, does not end, or crashes its process.

    Thread: any; waits for the process. Results are cached.
    """
    problem = _trial_error(passes, limit) if passes else ""
    if problem:
        raise PersonError(problem)


@lru_cache(maxsize=64)
def _trial_error(passes: tuple[CustomShader, ...], limit: float) -> str:
    order = json.dumps([[one.name, one.source] for one in passes])
    names = ", ".join(f"passes/{one.name}.glsl" for one in passes)
    command = [sys.executable, "-m", "live.render.custom_pass"]
    try:
        done = subprocess.run(command, input=order, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return f"{names}: not done after {limit:g} s; check for a loop that never ends"
    except OSError as error:
        return f"{names}: cannot be tried: {error.strerror}"
    if done.returncode in (0, _NO_OPENGL):
        return ""
    return done.stdout.strip() or f"{names}: the driver crashed ({done.returncode})"


def main() -> int:
    """Compile and draw the passes read from standard input; print the problem to standard output."""
    from live.render.headless import NoOpenGL, create_headless_context

    given: list[Any] = json.load(sys.stdin)
    try:
        ctx = create_headless_context()
    except NoOpenGL:
        return _NO_OPENGL
    try:
        for name, text in given:
            _draw(ctx, parse_custom_pass(name, text))
    except PersonError as error:
        print(error)
        return 1
    return 0


def _draw(ctx: Any, own: CustomShader) -> None:
    from live.render.shader import set_uniform

    program = compile_pass(ctx, own)
    texture = ctx.texture(TRIAL_SIZE, 4, bytes(range(256)) * (TRIAL_SIZE[0] * TRIAL_SIZE[1] // 64))
    target = ctx.simple_framebuffer(TRIAL_SIZE)
    target.use()
    for unit, name in enumerate(("own_light_", "own_last_", "own_depth_", "own_shape_", "own_who_"), start=1):
        texture.use(unit)
        set_uniform(program, name, unit)
    for name, value in {
        "amount": 1.0,
        "beat": 1.3,
        "tempo": 120.0,
        "energy": 0.5,
        "size": TRIAL_SIZE,
        "own_part_": (1.0, 1.0, 0.0, 0.0),
        "time": 2.0,
    }.items():
        set_uniform(program, name, value)
    for known in own.parameters:
        for value in (known.low, known.high, known.start):  # a loop may end with one value and not with another
            set_uniform(program, known.name, value)
            ctx.vertex_array(program, []).render(vertices=3)
    ctx.vertex_array(program, []).render(vertices=3)
    ctx.finish()


if __name__ == "__main__":
    sys.exit(main())
