"""Tests of drawing and reading back without a screen."""

import ctypes
import ctypes.util
from types import SimpleNamespace
from typing import Any

import moderngl
import numpy as np
import pytest

from live.render.headless import (
    FrameReader,
    NoOpenGL,
    OffscreenTarget,
    create_headless_context,
    is_software,
    release_headless_context,
)

SIZE = (61, 34)  # no multiple of four: rows of pixels are not aligned


def paint_halves(target: Any, upper: tuple[float, ...], lower: tuple[float, ...]) -> None:
    """One colour in the upper half, another in the lower half (OpenGL counts rows from below)."""
    _, _, width, height = target.viewport
    target.use()
    target.clear(*upper)
    target.clear(*lower, viewport=(0, 0, width, height // 2))


@pytest.mark.gl
def test_context_has_required_version(gl_context: moderngl.Context) -> None:
    assert gl_context.version_code >= 410
    assert gl_context.error == "GL_NO_ERROR"


@pytest.mark.gl
def test_picture_is_read_upright_in_rgb(gl_context: moderngl.Context) -> None:
    target = OffscreenTarget(gl_context, SIZE)
    paint_halves(target.framebuffer, (1.0, 0.0, 0.0), (0.0, 0.2, 1.0))
    picture = target.read()
    assert picture.shape == (34, 61, 3)
    assert picture.dtype == np.uint8
    assert np.all(picture[:17] == (255, 0, 0))
    assert np.all(picture[17:] == (0, 51, 255))
    target.release()


@pytest.mark.gl
def test_depth_test_hides_farther_triangle(gl_context: moderngl.Context) -> None:
    target = OffscreenTarget(gl_context, SIZE)
    target.framebuffer.use()
    target.framebuffer.clear(depth=0.5)
    program = gl_context.program(
        vertex_shader="#version 410\nuniform float z;"
        "const vec2 p[3] = vec2[3](vec2(-1, -1), vec2(3, -1), vec2(-1, 3));"
        "void main() { gl_Position = vec4(p[gl_VertexID], z, 1.0); }",
        fragment_shader="#version 410\nout vec4 colour; uniform vec3 c; void main() { colour = vec4(c, 1.0); }",
    )
    triangle = gl_context.vertex_array(program, [])
    gl_context.enable_only(moderngl.DEPTH_TEST)
    for z, colour in ((-0.5, (0.0, 1.0, 0.0)), (0.5, (1.0, 0.0, 0.0))):  # first before the cleared depth, then behind
        program["z"], program["c"] = z, colour
        triangle.render(moderngl.TRIANGLES, vertices=3)
    gl_context.enable_only(moderngl.NOTHING)
    assert np.all(target.read() == (0, 255, 0))
    target.release()


@pytest.mark.gl
def test_push_returns_previous_frame(gl_context: moderngl.Context) -> None:
    target = OffscreenTarget(gl_context, SIZE)
    seen: list[int] = []
    for number in range(5):
        target.framebuffer.use()
        target.framebuffer.clear(number / 255.0, 0.0, 0.0)
        picture = target.push()
        if picture is not None:
            assert np.ptp(picture[..., 0]) == 0
            seen.append(int(picture[0, 0, 0]))
    assert seen == [0, 1, 2, 3]
    last = target.flush()
    assert last is not None
    assert int(last[0, 0, 0]) == 4
    assert target.flush() is None
    target.release()


@pytest.mark.gl
@pytest.mark.parametrize("size", [(80, 50), (40, 20), (80, 20)])
def test_framebuffer_of_other_size_is_read_where_it_overlaps(
    gl_context: moderngl.Context, size: tuple[int, int]
) -> None:
    drawn = OffscreenTarget(gl_context, size)
    paint_halves(drawn.framebuffer, (1.0, 1.0, 0.0), (0.0, 1.0, 1.0))
    reader = FrameReader(gl_context, SIZE)
    picture = reader.read(drawn.framebuffer)
    expected = np.zeros((34, 61, 3), np.uint8)
    expected[: min(34, size[1] // 2), : size[0]] = (255, 255, 0)
    expected[size[1] // 2 : size[1], : size[0]] = (0, 255, 255)
    np.testing.assert_array_equal(picture, expected)
    reader.release()
    drawn.release()


@pytest.mark.gl
@pytest.mark.parametrize("size", [(0, 10), (10, -1), (10**6, 10)])
def test_invalid_size_is_refused(gl_context: moderngl.Context, size: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="cannot be drawn"):
        OffscreenTarget(gl_context, size)


@pytest.mark.parametrize(
    ("renderer", "software"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", True),
        ("Google SwiftShader", True),
        ("GDI Generic / Microsoft Basic Render Driver", True),
        ("NVIDIA H200/PCIe/SSE2", False),
        ("Mesa Intel(R) UHD Graphics 620 (KBL GT2)", False),
        ("Apple M2", False),
    ],
)
def test_software_renderer_is_recognized_by_name(renderer: str, software: bool) -> None:
    context: Any = SimpleNamespace(info={"GL_RENDERER": renderer})
    assert is_software(context) is software


def test_missing_egl_error_names_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(**_: Any) -> None:
        raise Exception("libEGL.so not loaded")

    monkeypatch.setattr(moderngl, "create_context", missing)
    with pytest.raises(NoOpenGL, match=r"libEGL\.so not loaded.*apt-get install .*libegl1 libgl1.*--out show\.glb"):
        create_headless_context()


@pytest.mark.gl
def test_released_context_is_not_current() -> None:
    """While an EGL context is current, GLX opens no window: BadAccess, and Xlib ends the process."""
    name = ctypes.util.find_library("EGL")
    if name is None:
        pytest.skip("there is no EGL here")
    egl = ctypes.CDLL(name)
    egl.eglGetCurrentContext.restype = ctypes.c_void_p
    before = egl.eglGetCurrentContext()
    try:
        ctx = create_headless_context()
    except NoOpenGL as reason:
        pytest.skip(str(reason))
    assert egl.eglGetCurrentContext() not in (None, before)
    release_headless_context(ctx)
    assert egl.eglGetCurrentContext() == before
