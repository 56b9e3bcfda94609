"""Tests of shader sources: includes, constants, the GLSL version for macOS, and edited shader folders."""

import ast
import io
import re
from collections.abc import Iterator
from pathlib import Path

import moderngl
import numpy as np
import numpy.typing as npt
import pytest
from rich.console import Console

from live.app.adaptive_quality import ShaderWatch, use_shader_folder
from live.base.errors import PersonError
from live.render.adaptive_quality import SOFTWARE
from live.render.renderer import Renderer
from live.render.shader import VERSION, _first_error, builtin_text, set_override_folder, shader_names, source
from tests.places import ROOT
from tests.render.test_renderer import read, scene, standing


def test_includes_are_expanded_once_and_constants_follow_version() -> None:
    text = source("dancer_fragment.glsl", (("SOFT", 1),))
    lines = text.splitlines()
    assert lines[0] == "#version 410 core"
    assert lines[1] == "#define SOFT 1"
    assert text.count("uniform Frame") == 1
    assert "#include" not in text


def test_unknown_shader_is_refused() -> None:
    with pytest.raises(FileNotFoundError):
        source("no_such_shader.glsl")


@pytest.fixture
def shader_folder(tmp_path: Path) -> Iterator[Path]:
    """A folder whose shaders override the built-in ones."""
    set_override_folder(tmp_path)
    yield tmp_path
    set_override_folder(None)


@pytest.mark.parametrize(
    ("log", "told"),
    [
        ("fragment_shader\n===\n0:3(12): warning: x\n0:2(12): error: `x' undeclared", "b.glsl, line 1: error: "),
        ("0(1) : warning\n0(3) : error C1503: undefined variable", "c.glsl, line 7: error C1503"),
        ("ERROR: 0:2: Use of undeclared identifier 'x'", "b.glsl, line 1: Use of"),
        ("Linker: no main", "a.glsl: Linker: no main"),
    ],
)
def test_file_and_line_are_read_from_log_of_every_driver(log: str, told: str) -> None:
    assert _first_error(log, ["a.glsl", "b.glsl, line 1", "c.glsl, line 7"]).startswith(told)


def test_missing_include_is_reported_with_file_and_line(shader_folder: Path) -> None:
    (shader_folder / "grade_fragment.glsl").write_text('\n#include "frame.glsl"\n#include "nothing.glsl"\n')
    with pytest.raises(PersonError, match=r"shaders/grade_fragment.glsl, line 3: there is no such file"):
        source("grade_fragment.glsl")


@pytest.mark.long
@pytest.mark.gl
def test_edited_shader_is_reloaded_and_invalid_edit_keeps_last_valid(
    gl_context: moderngl.Context, shader_folder: Path
) -> None:
    renderer = Renderer(gl_context, scene(1), size=(64, 36), quality=SOFTWARE)
    target, view, watched = gl_context.simple_framebuffer((64, 36)), standing(), []

    def drawn() -> npt.NDArray[np.uint8]:
        for _ in range(2):
            renderer.draw(view, target)
        return read(target)

    watch = ShaderWatch(shader_folder, renderer.reload_shaders)

    def edit(name: str, text: str) -> None:
        (shader_folder / name).write_text(text)
        for _ in range(3):
            watched.append(None)
            watch.check(float(len(watched)))

    usual = drawn()
    finish = builtin_text("finish.glsl")
    edit("finish.glsl", finish.replace("return film(", "return 0.3 * film("))
    dark = drawn()
    assert watch.reloads == 1
    assert 0.1 < dark.mean() / usual.mean() < 0.9
    edit("finish.glsl", finish.replace("vec3 film(vec3 light) {", "vec3 film(vec3 light) { lihgt *= 2.0;"))
    line = finish[: finish.index("vec3 film")].count("\n") + 1
    assert watch.problem.startswith(f"shaders/finish.glsl, line {line}: ")
    assert "lihgt" in watch.problem
    assert watch.problem.endswith("the last good one stays in use")
    np.testing.assert_array_equal(drawn(), dark)
    edit("finish.glsl", finish)
    assert (watch.reloads, watch.problem) == (2, "")
    np.testing.assert_array_equal(drawn(), usual)
    renderer.release()
    target.release()


def test_missing_shader_folder_is_created_with_all_shaders(tmp_path: Path) -> None:
    console, folder = Console(file=io.StringIO()), tmp_path / "looks" / "mine"
    try:
        use_shader_folder(folder, console)
        assert sorted(each.name for each in folder.iterdir()) == shader_names()
        (folder / "shwon.glsl").write_text("")
        use_shader_folder(folder, console)
        assert "shwon.glsl is none of the program's shaders" in console.file.getvalue()
    finally:
        set_override_folder(None)
    (tmp_path / "empty").mkdir()
    with pytest.raises(PersonError, match="none of the program's shaders is there"):
        use_shader_folder(tmp_path / "empty", console)


# -- OpenGL 4.1 core, the newest of macOS: `conftest.py` asks Mesa for no more, in every test --

NEWER = re.compile(
    r"#extension|\bbinding\s*=|\bbuffer\s+\w+\s*\{|\bu?image(2D|Buffer|3D)\b|\bimage(Store|Load)\b|\bshared\s+\w+\s+\w+"
    r"|layout\s*\(\s*location[^)]*\)\s*uniform|\batomic\w+\(|\bgl_GlobalInvocationID\b|\bfindMSB\(|\btextureQueryLevels\("
)
"""What GLSL 4.10 does not have, or macOS refuses."""
NEWER_CALLS = {"compute_shader", "bind_to_storage_buffer", "bind_to_image", "line_width", "memory_barrier"}
"""Of moderngl: OpenGL 4.2 and later, or refused by a forward-compatible core context."""


@pytest.mark.parametrize("name", shader_names())
def test_shaders_ask_for_nothing_newer(name):
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", source(name), flags=re.DOTALL)
    assert VERSION == "#version 410 core"
    assert text.count("#version") == 1
    assert not NEWER.findall(text)


def test_calls_ask_for_nothing_newer():
    found = [
        f"{path.name}: {node.attr}"
        for path in (ROOT / "live" / "render").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and node.attr in NEWER_CALLS
    ]
    assert not found


@pytest.mark.gl
def test_the_tests_draw_with_a_forward_compatible_context_of_4_1(gl_context):
    if "Mesa" not in str(gl_context.info["GL_VERSION"]):
        pytest.skip("only Mesa can be asked for an older version")
    assert gl_context.version_code == 410
    above = f"{VERSION}\nvoid main() {{ gl_Position = vec4(0.0); }}"
    below = f"{VERSION}\nlayout(binding = 1) uniform sampler2D t;\nout vec4 c;\nvoid main() {{ c = vec4(0.0); }}"
    with pytest.raises(moderngl.Error, match="binding"):
        gl_context.program(vertex_shader=above, fragment_shader=below)
    gl_context.line_width = 3.0
    assert gl_context.error == "GL_INVALID_VALUE"  # forward-compatible
    gl_context.line_width = 1.0
