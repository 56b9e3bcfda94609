"""All is drawn with OpenGL 4.1 core, the newest of macOS: `conftest.py` asks Mesa for no more, in every test."""

import ast
import re

import moderngl
import pytest

from live.render.shader import VERSION, shader_names, source
from tests.places import ROOT

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
