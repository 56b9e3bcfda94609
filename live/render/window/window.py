"""Window with an OpenGL 4.1 core context (GLFW), full screen on a chosen monitor.

If that monitor is disconnected during a show, the window moves to a remaining one and the show continues; when the
monitor is reconnected, the window is full screen there again. Video modes are never changed. Vertical synchronisation
is requested but not relied upon.
"""

from typing import Any

import moderngl

from live.render.window.monitors import (
    Monitor,
    UnknownMonitor,
    match_monitor,
    monitor_changes,
    monitor_handles,
    pop_messages,
    screen_problem,
    start_glfw,
)
from live.render.window.window_input import InputQueue, MonitorsChanged, WindowInput

CHECK_PERIOD = 60
"""Polls between two checks of monitor positions, because a moved or resized monitor causes no event."""


class NoWindow(RuntimeError):
    """No window can be opened here; the message states the cause and the remedy."""


class _Loader:
    """Function loader for moderngl that uses GLFW's context, whatever its kind (GLX, EGL, Cocoa)."""

    def __init__(self, glfw: Any) -> None:
        self._glfw = glfw

    def load_opengl_function(self, name: str) -> int:
        return self._glfw.get_proc_address(name) or 0

    load = load_opengl_function

    def release(self) -> None:
        """Do nothing, because the window owns the context."""


class Window:
    """A window with its context. Thread: main thread only.

    `monitor`: where the window opens (default: the primary monitor). `size`: of the window when it is not full
    screen, in screen coordinates. `share_with`: another window, whose textures and buffers this one shares; then
    `swap` does not wait for the display.
    Raises `NoWindow` without a screen or OpenGL 4.1, `UnknownMonitor` if the monitor is disconnected.
    """

    def __init__(
        self,
        title: str,
        *,
        monitor: Monitor | None = None,
        fullscreen: bool = False,
        size: tuple[int, int] = (1280, 720),
        hidden: bool = False,
        share_with: "Window | None" = None,
    ) -> None:
        """`hidden`: the window is invisible until `reveal`."""
        if not start_glfw():
            raise NoWindow(f"no window can be opened: {screen_problem()}; without a screen, use --headless")
        import glfw

        self._glfw = glfw
        self._window_size = size
        self._restore_rect: tuple[int, int, int, int] | None = None
        self._fullscreen = fullscreen and not hidden
        self._covered_monitor: Monitor | None = None
        self._borderless = False
        self._seen_changes = monitor_changes()
        self._polls = 0
        self._monitor, handle = self._choose(monitor)
        covering = hidden and fullscreen
        self._window_size = self._monitor.size if covering else size  # so that renderers are created with this size
        other = None if share_with is None else share_with._handle
        self._handle: Any = self._open(title, handle if self._fullscreen else None, hidden, other)
        self._window_size = size
        glfw.make_context_current(self._handle)
        glfw.swap_interval(1 if share_with is None else 0)  # one display paces the show; waiting for two would add up
        loader: Any = _Loader(glfw)  # moderngl accepts any object with these methods, its stub only a dictionary
        self.ctx: moderngl.Context = moderngl.create_context(require=410, context=loader)
        self._inputs = InputQueue(glfw, self._handle)
        if self._fullscreen:
            self._update_placement(forced=not glfw.get_window_monitor(self._handle))
            self._show_cursor(False)
        self._fit_target()

    def _choose(self, monitor: Monitor | None) -> tuple[Monitor, Any]:
        """Return the current state and handle of the chosen monitor; the primary one by default."""
        there = monitor_handles()
        if not there:
            raise NoWindow("no window can be opened: no monitor is connected; without a screen, use --headless")
        listed = [each for each, _ in there]
        found = match_monitor(monitor, listed) if monitor else listed[0]
        if found is None:
            what = f"{monitor.name} is not connected any more" if monitor else ""
            raise UnknownMonitor(f"{what}; there is: {', '.join(map(str, listed))}")
        return next((each, handle) for each, handle in there if each is found)

    def _open(self, title: str, handle: Any, hidden: bool, other: Any) -> Any:
        """Create the GLFW window: full screen on the monitor `handle`, or centred on the chosen one."""
        glfw = self._glfw
        x, y, width, height = self._centred(self._monitor)
        glfw.default_window_hints()
        for hint, value in (
            (glfw.CONTEXT_VERSION_MAJOR, 4),
            (glfw.CONTEXT_VERSION_MINOR, 1),
            (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
            (glfw.OPENGL_FORWARD_COMPAT, True),
            (glfw.SAMPLES, 0),  # the renderer has its own
            (glfw.VISIBLE, not hidden),
            (glfw.AUTO_ICONIFY, False),  # keep the projector's picture while another window has focus
            (glfw.POSITION_X, x),
            (glfw.POSITION_Y, y),
            (glfw.REFRESH_RATE, round(self._monitor.refresh_hz) or glfw.DONT_CARE),
        ):
            glfw.window_hint(hint, value)
        for name in ("X11_CLASS_NAME", "X11_INSTANCE_NAME", "WAYLAND_APP_ID"):
            glfw.window_hint_string(getattr(glfw, name), "choreographics-live")
        if handle is not None:
            width, height = self._monitor.size
            self._covered_monitor = self._monitor
        pop_messages()
        window = glfw.create_window(width, height, title, handle, other)
        if not window:
            reason = "; ".join(pop_messages()) or "GLFW gave no reason"
            raise NoWindow(
                f"no window with OpenGL 4.1 can be opened: {reason}; "
                "install the graphics driver (Debian, Ubuntu: apt-get install libgl1 libegl1) or use --headless; "
                "`live render --out show.glb` writes the dancers' motion without OpenGL"
            )
        return window

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the framebuffer [pixels]."""
        return self._inputs.framebuffer_size

    @property
    def target(self) -> moderngl.Framebuffer:
        """The screen's framebuffer with its current size; do not keep it across frames."""
        return self.ctx.screen

    @property
    def fullscreen(self) -> bool:
        """Whether the window is in full-screen mode (also while its monitor is disconnected)."""
        return self._fullscreen

    @property
    def on_monitor(self) -> bool:
        """Whether the window is on its monitor; False if it is full screen and its monitor is disconnected."""
        return not self._fullscreen or self._covered_monitor is not None

    @property
    def monitor(self) -> Monitor:
        """The window's monitor, in its last known state."""
        return self._monitor

    def poll(self) -> list[WindowInput]:
        """Process GLFW events and return inputs since the last call; does not wait."""
        self._glfw.poll_events()
        self._polls += 1
        changes = monitor_changes()
        if changes != self._seen_changes:
            self._seen_changes = changes
            self._update_placement(forced=True)
            self._inputs.put(MonitorsChanged())
        elif self._fullscreen and self._polls % CHECK_PERIOD == 0:
            self._update_placement(forced=False)
        self._fit_target()
        return self._inputs.pop_all()

    def make_current(self) -> None:
        """Make this window's context current."""
        self._glfw.make_context_current(self._handle)

    def swap(self) -> None:
        """Present the picture drawn into `target`."""
        self._glfw.swap_buffers(self._handle)

    def toggle_fullscreen(self) -> None:
        """Switch to full screen on the monitor that shows most of the window, or back to the previous position."""
        if self._fullscreen:
            self._fullscreen = False
            self._leave_fullscreen()
        else:
            (x, y), (width, height) = self._glfw.get_window_pos(self._handle), self._glfw.get_window_size(self._handle)
            self._restore_rect = (x, y, width, height)
            self._monitor = self._monitor_under(self._restore_rect)
            self._fullscreen = True
            self._update_placement(forced=True)
        self._fit_target()

    def reveal(self, *, fullscreen: bool) -> None:
        """Show a window that was opened hidden."""
        self._glfw.poll_events()  # monitors may have changed since
        if fullscreen:
            self._fullscreen = True
            self._update_placement(forced=True)
        self._glfw.show_window(self._handle)
        if fullscreen:
            self._update_placement(forced=True)
        self._fit_target()

    def close(self) -> None:
        """Release the context and close the window; a second call does nothing."""
        if self._handle is not None:
            self.make_current()
            self.ctx.release()
            self._glfw.destroy_window(self._handle)
            self._handle = None

    def _update_placement(self, forced: bool) -> None:
        """Move a full-screen window to the current position of its monitor, or to a remaining one."""
        if not self._fullscreen:
            return
        there = monitor_handles()
        found = match_monitor(self._monitor, [monitor for monitor, _ in there])
        if found is None:
            if self._covered_monitor is not None:
                self._covered_monitor = None
                self._leave_fullscreen()
            return
        covered = self._covered_monitor
        if not forced and covered and (covered.position, covered.size) == (found.position, found.size):
            return
        self._monitor = self._covered_monitor = found
        self._cover(found, next(handle for monitor, handle in there if monitor is found))

    def _cover(self, monitor: Monitor, handle: Any) -> None:
        """Switch to full screen in the monitor's current mode; if that is refused, use a borderless window."""
        glfw, (width, height) = self._glfw, monitor.size
        rate = round(monitor.refresh_hz) or glfw.DONT_CARE
        self._show_cursor(False)
        glfw.set_window_monitor(self._handle, handle, 0, 0, width, height, rate)
        self._borderless = not glfw.get_window_monitor(self._handle)
        if self._borderless:
            glfw.set_window_attrib(self._handle, glfw.DECORATED, False)
            glfw.set_window_attrib(self._handle, glfw.FLOATING, True)
            glfw.set_window_pos(self._handle, *monitor.position)
            glfw.set_window_size(self._handle, width, height)

    def _leave_fullscreen(self) -> None:
        """Leave full screen: to the previous position, or centred on its monitor (the first one if disconnected)."""
        glfw = self._glfw
        self._covered_monitor = None
        self._show_cursor(True)
        if self._borderless:
            glfw.set_window_attrib(self._handle, glfw.DECORATED, True)
            glfw.set_window_attrib(self._handle, glfw.FLOATING, False)
            self._borderless = False
        there = [monitor for monitor, _ in monitor_handles()]
        home = match_monitor(self._monitor, there) or next(iter(there), self._monitor)
        place = self._restore_rect
        if place is None or not any(_overlap(place, monitor) for monitor in there):
            place = self._centred(home)
        glfw.set_window_monitor(self._handle, None, *place, glfw.DONT_CARE)

    def _monitor_under(self, place: tuple[int, int, int, int]) -> Monitor:
        """Return the monitor that shows most of (x, y, width, height); the current one if none shows any of it."""
        there = [monitor for monitor, _ in monitor_handles()]
        best = max(there, key=lambda monitor: _overlap(place, monitor), default=self._monitor)
        return best if _overlap(place, best) else match_monitor(self._monitor, there) or best

    def _centred(self, monitor: Monitor) -> tuple[int, int, int, int]:
        """Return the rectangle (x, y, width, height) of a window centred on a monitor, no larger than it."""
        (x, y), (columns, rows) = monitor.position, monitor.size
        width, height = min(self._window_size[0], columns), min(self._window_size[1], rows)
        return x + (columns - width) // 2, y + (rows - height) // 2, width, height

    def _show_cursor(self, shown: bool) -> None:
        glfw = self._glfw
        glfw.set_input_mode(self._handle, glfw.CURSOR, glfw.CURSOR_NORMAL if shown else glfw.CURSOR_HIDDEN)

    def _fit_target(self) -> None:
        """Set moderngl's screen to the current size, because it keeps its first one."""
        screen: Any = self.ctx.screen
        size = self._inputs.framebuffer_size
        if screen.size != size or screen.viewport != (0, 0, *size):
            screen.viewport = (0, 0, *size)
            screen._size = size  # moderngl offers no other way


def _overlap(place: tuple[int, int, int, int], monitor: Monitor) -> int:
    """Return the area of (x, y, width, height) that a monitor shows, in screen coordinates."""
    x, y, width, height = place
    (left, top), (columns, rows) = monitor.position, monitor.size
    across = min(x + width, left + columns) - max(x, left)
    down = min(y + height, top + rows) - max(y, top)
    return max(across, 0) * max(down, 0)
