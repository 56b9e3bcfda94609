"""Shader loader: sources with `#include "name.glsl"` and constants, compiled with errors reported by file and line.

Sources come from the folders of `shaders/`. A developer may replace some by files elsewhere (`set_override_folder`).
Two includes are made from the rows of the picture's parameters, so that a new one needs no line here: shaders call a
function for each, light_haze() for `/dance/light/haze`, style_ink_width(group) for a group's `/dance/draw/ink/width`.
"""

import re
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Final, Protocol

import moderngl

from live.base.errors import PersonError
from live.base.parameter import Parameter
from live.base.picture_parameters import (
    GROUP_PARAMETERS,
    PARAMETERS,
    PART_COUNT,
    STYLE_ADDRESS_PREFIX,
    STYLE_SIZE,
    STYLES_START,
)

VERSION: Final = "#version 410 core"
"""The newest GLSL version of macOS."""
WORN: Final = (("WORN", 1),)
"""Constants of programs that draw characters with their images."""
HEAD: Final = (("HEAD", 1),)
"""Constants of programs that draw heads and hair."""
FRAME_BINDING: Final = 0
"""Binding of the uniform block that all programs share."""
STYLES_BINDING: Final = 1
"""Binding of the uniform block with the groups' styles."""
CORNERS_BINDING: Final = 2
"""Binding of the uniform block with the corners of elements."""
PICTURE_BINDING: Final = 3
"""Binding of the uniform block with the picture's parameters."""
_BLOCKS: Final = {
    "Frame": FRAME_BINDING, "Styles": STYLES_BINDING, "Corners": CORNERS_BINDING, "Picture": PICTURE_BINDING,
}  # fmt: skip
SHARED_TEXTURES: Final = {"beam_map": 12, "ripple_map": 13, "noise_map": 14, "gobo_map": 15}
"""Texture units of the samplers that all programs share: `live/render/worlds` fills them."""
MAX_FILE_BYTES: Final = 1_000_000
"""Maximum size of a shader file [bytes]."""
_LINE: Final = re.compile(r"\b0(?::(\d+)|\((\d+)\))")
"""A line number in a driver's log: 0:12(3) (Mesa), 0(12) (NVIDIA), ERROR: 0:12 (Apple, AMD)."""

_override_folders: list[Path] = []  # a developer's folder, if there is one


_PREFIX: Final = "/dance/"
PICTURE_SIZE: Final = max(row.first + row.size for row in PARAMETERS)
"""Numbers in the block `Picture`: the picture's parameters, as in a parameter row."""
PICTURE_VECTORS: Final = -(-PICTURE_SIZE // 4)
"""Vectors of the block `Picture`."""
STYLE_VECTORS: Final = -(-STYLE_SIZE // 4)
"""Vectors of each group in the block `Styles`."""


def _function(name: str, argument: str, numbers: list[str]) -> str:
    kind, value = ("float", numbers[0]) if len(numbers) == 1 else ("vec3", f"vec3({', '.join(numbers)})")
    return f"{kind} {name}({argument}) {{ return {value}; }}"


def _places(rows: Iterable[Parameter], start: int) -> Iterator[tuple[str, list[tuple[int, str]]]]:
    """Yield the address of each row, with vector and component of its numbers in a block that begins at `start`."""
    for row in rows:
        first = row.first - start
        yield row.address, [(place // 4, "xyzw"[place % 4]) for place in range(first, first + row.size)]


def _picture_block() -> Iterator[str]:
    yield f"layout(std140) uniform Picture {{ vec4 picture_numbers[{PICTURE_VECTORS}]; }};"
    for address, places in _places(PARAMETERS, 0):
        name = address.removeprefix(_PREFIX).replace("/", "_")
        yield _function(name, "", [f"picture_numbers[{vector}].{part}" for vector, part in places])


def _styles_block() -> Iterator[str]:
    yield f"layout(std140) uniform Styles {{ vec4 styles[{PART_COUNT * STYLE_VECTORS}]; }};"
    styles = (row for row in GROUP_PARAMETERS.values() if row.address.startswith(STYLE_ADDRESS_PREFIX))
    for address, places in _places(styles, STYLES_START):
        name = "style_" + address.removeprefix(STYLE_ADDRESS_PREFIX).replace("/", "_")
        numbers = [f"styles[group * {STYLE_VECTORS} + {vector}].{part}" for vector, part in places]
        yield _function(name, "int group", numbers)


_HEAD: Final = "// Made from the rows of live/base/picture_parameters.py."
PARAMETER_BLOCKS: Final = {
    name: "\n".join((_HEAD, *lines)) + "\n"
    for name, lines in (("picture_values.glsl", _picture_block()), ("style_values.glsl", _styles_block()))
}
"""The texts, by the names of the includes."""


@cache
def _files() -> dict[str, Traversable]:
    """Return the built-in files by name; folders have no meaning."""
    folders = (resources.files("live.render") / "shaders").iterdir()
    return {file.name: file for folder in folders if folder.is_dir() for file in folder.iterdir()}


def shader_names() -> list[str]:
    """Return the names of all shaders."""
    return sorted([*_files(), *PARAMETER_BLOCKS])


def builtin_text(name: str) -> str:
    """Return the text of a built-in file. Raises FileNotFoundError for an unknown name."""
    if name in PARAMETER_BLOCKS:
        return PARAMETER_BLOCKS[name]
    file = _files().get(name)
    if file is None:
        raise FileNotFoundError(name)
    return file.read_text(encoding="utf-8")


def set_override_folder(folder: Path | None) -> None:
    """Prefer files in `folder` to the built-in ones from now on, and read them again; None: built-in ones only.

    Compiled programs do not change.
    """
    _override_folders[:] = [] if folder is None else [folder]
    _read.cache_clear()
    _lines.cache_clear()


@cache
def _read(name: str) -> str:
    for folder in _override_folders:
        try:
            if (folder / name).stat().st_size <= MAX_FILE_BYTES:
                return (folder / name).read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            continue
        except OSError as error:
            raise PersonError(f"{folder / name}: {error.strerror}") from None
    return builtin_text(name)


@cache
def _lines(name: str) -> tuple[list[str], list[str], list[int]]:
    """Return the lines of a file, the place of each for messages, and the indices of those that include a file."""
    lines = _read(name).splitlines()
    places = [f"shaders/{name}, line {number}" for number in range(1, len(lines) + 1)]
    return lines, places, [at for at, line in enumerate(lines) if line.startswith("#include")]


def source(name: str, constants: tuple[tuple[str, int | float], ...] = ()) -> str:
    """Return the text of a shader with its includes; `constants` become #define lines.

    Raises FileNotFoundError for an unknown name.
    """
    return _assemble(name, constants)[0]


def _assemble(name: str, constants: tuple[tuple[str, int | float], ...]) -> tuple[str, list[str]]:
    """Return the text, and the origin of each line (#line is not enough, because drivers drop its file)."""
    lines = [VERSION] + [f"#define {key} {value}" for key, value in constants]
    places = [f"shaders/{name}"] * len(lines)
    seen: set[str] = set()

    def add(file: str) -> None:
        if file in seen:
            return
        seen.add(file)
        own, own_places, includes = _lines(file)
        begin = 0
        for at in includes:
            lines.extend(own[begin:at])
            places.extend(own_places[begin:at])
            add(_include_name(own[at], file, at + 1))
            begin = at + 1
        lines.extend(own[begin:])
        places.extend(own_places[begin:])

    add(name)
    return "\n".join(lines) + "\n", places


def _include_name(line: str, file: str, place: int) -> str:
    parts = line.split('"')
    if len(parts) < 3 or parts[1] not in shader_names():
        raise PersonError(f"shaders/{file}, line {place}: there is no such file to include: {line.strip()}")
    return parts[1]


def compile_program(
    ctx: moderngl.Context, vertex: str, fragment: str, constants: tuple[tuple[str, int | float], ...] = ()
) -> moderngl.Program:
    """Compile and link two shader files; binds the uniform blocks that the program uses.

    Raises PersonError, with file and line if the driver reports them.
    """
    (above, above_places), (below, below_places) = (_assemble(name, constants) for name in (vertex, fragment))
    try:
        linked = ctx.program(vertex_shader=above, fragment_shader=below)
    except moderngl.Error as error:
        log = str(error)
        raise PersonError(_first_error(log, above_places if "vertex_shader" in log else below_places)) from None
    bind_blocks(linked)
    linked.extra = {}
    for name, unit in SHARED_TEXTURES.items():
        set_uniform(linked, name, unit)
    return linked


def bind_blocks(linked: moderngl.Program) -> None:
    """Bind the uniform blocks that a program uses; each kind of block has a binding of its own."""
    for name, binding in _BLOCKS.items():
        if name in linked:
            block = linked[name]
            assert isinstance(block, moderngl.UniformBlock)
            block.binding = binding


def _first_error(log: str, places: list[str]) -> str:
    """Return the first error of a driver's log; `places`: the origin of each line of the text."""
    for line in log.splitlines():
        match = _LINE.search(line)
        if match is not None and "warning" not in line.casefold():
            number = int(match.group(1) or match.group(2))
            if 1 <= number <= len(places):
                return f"{places[number - 1]}: {line[match.end() :].lstrip('(): 0123456789').strip()}"
    words = " ".join(line.strip() for line in log.splitlines() if line.strip(" =-"))
    return f"{places[0]}: {words[:300]}"


def set_uniform(linked: moderngl.Program, name: str, value: object) -> None:
    """Set a uniform if the program has it (compilers drop unused ones) and it does not have this value already.

    `compile_program` gives a program the memory for that; `value` must be comparable, so no array.
    """
    known = linked.extra
    if known is not None:
        if known.get(name) == value:
            return
        known[name] = value
    uniform = linked.get(name, None)  # `in` would look through all members
    if uniform is not None:
        assert isinstance(uniform, moderngl.Uniform)
        uniform.value = value


class Releasable(Protocol):
    """An owner of OpenGL objects."""

    def release(self) -> None:
        """Free them."""


def release_all(*things: Releasable) -> None:
    """Free all of them, in order."""
    for thing in things:
        thing.release()


class FullscreenShader:
    """A fragment shader drawn over a whole target with one triangle."""

    def __init__(
        self, ctx: moderngl.Context, fragment: str, constants: tuple[tuple[str, int | float], ...] = ()
    ) -> None:
        self._program = compile_program(ctx, "full_vertex.glsl", fragment, constants)
        self._triangle = ctx.vertex_array(self._program, [])

    def set(self, name: str, value: object) -> None:
        """Set a uniform."""
        set_uniform(self._program, name, value)

    def draw(self, target: moderngl.Framebuffer, **textures: moderngl.Texture) -> None:
        """Draw into `target`; textures are given by sampler name."""
        target.use()
        for unit, (name, texture) in enumerate(textures.items(), start=1):
            texture.use(unit)
            set_uniform(self._program, name, unit)
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free both."""
        release_all(self._triangle, self._program)
