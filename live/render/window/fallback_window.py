"""Black window below the show's window, so that the desktop stays hidden if an engine ends.

It has no OpenGL, keys or focus; X11 paints the background. Wayland does not let a program place a window below others,
so there is no fallback window (except with XWayland).
"""

import ctypes
import sys
from typing import Any, Final

from live.render.window.monitors import Monitor, list_monitors, match_monitor, start_glfw

TITLE: Final = "ChoreoGraphics Live, behind the picture"


class NoFallbackWindow(RuntimeError):
    """No fallback window is possible here; the message states why."""


class FallbackWindow:
    """The fallback window, hidden at first. Thread: main thread only, like all of GLFW."""

    def __init__(self) -> None:
        """Raises NoFallbackWindow where there is no X server."""
        if not start_glfw():
            raise NoFallbackWindow("there is no screen")
        import glfw

        self._glfw: Any = glfw
        if sys.platform != "linux" or glfw.get_platform() != glfw.PLATFORM_X11:
            raise NoFallbackWindow("only X11 can place a window below others")
        self._x11 = ctypes.CDLL("libX11.so.6")
        self._monitor: Monitor | None = None
        self._handle = self._open()
        self._display = ctypes.c_void_p(ctypes.cast(self._glfw.get_x11_display(), ctypes.c_void_p).value)
        self._window = ctypes.c_ulong(self._glfw.get_x11_window(self._handle))
        self._x11.XSetWindowBackground(self._display, self._window, ctypes.c_ulong(0))

    def _open(self) -> Any:
        glfw = self._glfw
        glfw.default_window_hints()
        for hint in (glfw.VISIBLE, glfw.DECORATED, glfw.FOCUSED, glfw.FOCUS_ON_SHOW, glfw.RESIZABLE):
            glfw.window_hint(hint, False)
        glfw.window_hint(glfw.CLIENT_API, glfw.NO_API)
        window = glfw.create_window(64, 64, TITLE, None, None)
        if not window:
            raise NoFallbackWindow("the display server creates no window")
        glfw.set_input_mode(window, glfw.CURSOR, glfw.CURSOR_HIDDEN)
        return window

    def cover(self, monitor: Monitor) -> None:
        """Cover a monitor, below all other windows on it."""
        glfw = self._glfw
        self._monitor = monitor
        glfw.set_window_pos(self._handle, *monitor.position)
        glfw.set_window_size(self._handle, *monitor.size)
        self._x11.XLowerWindow(self._display, self._window)  # before mapping, so that it is never above others
        glfw.show_window(self._handle)
        self._x11.XLowerWindow(self._display, self._window)
        self._x11.XClearWindow(self._display, self._window)
        self._x11.XFlush(self._display)

    def hide(self) -> None:
        """Hide the window."""
        self._monitor = None
        self._glfw.hide_window(self._handle)

    def wait(self, seconds: float) -> None:
        """Process GLFW events for so long, and follow the monitor if it was moved or reconnected."""
        self._glfw.wait_events_timeout(seconds)
        covered = self._monitor
        if covered is None:
            return
        now = match_monitor(covered, list_monitors())
        if now is not None and (now.position, now.size) != (covered.position, covered.size):
            self.cover(now)

    def close(self) -> None:
        """Close the window."""
        self._glfw.destroy_window(self._handle)
