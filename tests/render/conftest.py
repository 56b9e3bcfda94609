"""Fixtures of real displays and OpenGL contexts for the render tests."""

from collections.abc import Callable, Iterator
from functools import partial

import moderngl
import pytest

from live.render.headless import NoOpenGL, create_headless_context
from live.render.window.monitors import stop_glfw
from tests.fixtures import two_monitor_x as x_server
from tests.fixtures.two_monitor_x import TwoMonitorX
from tests.render.golden import check_golden


@pytest.fixture(scope="session")
def two_monitor_x(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TwoMonitorX]:
    """One X server with two monitors for the session; skips with a reason where none can run."""
    try:
        there, server = x_server.start(tmp_path_factory.mktemp("xorg"))
    except x_server.NoX as reason:
        pytest.skip(str(reason))
    yield there
    stop_glfw()  # Xlib ends the whole process when its server goes away under it
    x_server.stop(server)


@pytest.fixture
def stage_x(two_monitor_x: TwoMonitorX, monkeypatch: pytest.MonkeyPatch) -> Iterator[TwoMonitorX]:
    """The X server as this process' display, with both monitors connected and GLFW restarted."""
    two_monitor_x.plug_both()
    monkeypatch.setenv("DISPLAY", two_monitor_x.display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    stop_glfw()
    yield two_monitor_x
    stop_glfw()


@pytest.fixture
def no_screen(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine without a screen."""
    stop_glfw()
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    yield
    stop_glfw()


@pytest.fixture(scope="session")
def headless_context() -> moderngl.Context:
    """One headless OpenGL context for the session; skips with a reason where none can be created."""
    try:
        return create_headless_context()
    except NoOpenGL as reason:
        pytest.skip(str(reason))


@pytest.fixture
def gl_context(headless_context: moderngl.Context) -> Iterator[moderngl.Context]:
    """The headless context, made current for this test (a window of another test may have been current).

    moderngl makes the last program current again when it sets a uniform, even if that program was released;
    OpenGL records an error, which is read here so that no other test sees it.
    """
    with headless_context:
        _ = headless_context.error
        yield headless_context


@pytest.fixture
def golden(request: pytest.FixtureRequest, gl_context: moderngl.Context) -> Callable[..., None]:
    """Compare a picture with its golden picture: `golden(picture, "name", law=...)`, see `golden.py`; llvmpipe only."""
    if "llvmpipe" not in str(gl_context.info["GL_RENDERER"]):
        pytest.skip("golden pictures are compared on llvmpipe only")
    return partial(check_golden, regenerate=request.config.getoption("--regenerate-goldens"))
