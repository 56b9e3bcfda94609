"""Window inputs as frozen values, and the queue that collects them from GLFW's callbacks.

Pixels are those of the framebuffer, from the upper left corner, x to the right and y down.
"""

from dataclasses import dataclass
from typing import Any, TypeAlias


@dataclass(frozen=True, slots=True)
class KeyPressed:
    """A key went down (its repetitions are not reported); `name` as in "space", "escape", "f", "1", "left", "f5"."""

    name: str
    shift: bool = False
    control: bool = False


@dataclass(frozen=True, slots=True)
class PointerMoved:
    """The pointer is now at (x, y) [pixels]."""

    x: float
    y: float
    shift: bool = False


@dataclass(frozen=True, slots=True)
class PointerPressed:
    """The main button went down at (x, y) [pixels]."""

    x: float
    y: float
    shift: bool = False


@dataclass(frozen=True, slots=True)
class PointerReleased:
    """The main button came up at (x, y) [pixels]."""

    x: float
    y: float
    shift: bool = False


@dataclass(frozen=True, slots=True)
class Resized:
    """The framebuffer has a new size (width, height) [pixels]."""

    size: tuple[int, int]


@dataclass(frozen=True, slots=True)
class CloseRequested:
    """The user asked to close the window; it stays open until the program closes it."""


@dataclass(frozen=True, slots=True)
class MonitorsChanged:
    """A monitor was connected or disconnected; the window has already been moved."""


WindowInput: TypeAlias = (
    KeyPressed | PointerMoved | PointerPressed | PointerReleased | Resized | CloseRequested | MonitorsChanged
)

QUEUE_LIMIT = 1024
"""Maximum number of inputs between two polls; further ones are dropped."""

_NAMED_KEYS = (
    *("space", "escape", "tab", "backspace", "insert", "delete", "pause"),
    *("right", "left", "down", "up", "home", "end", "page_up", "page_down"),
)


def _physical_names(glfw: Any) -> dict[int, str]:
    """Return names of keys that are the same on every keyboard layout, by GLFW's key number."""
    names = {getattr(glfw, f"KEY_F{number}"): f"f{number}" for number in range(1, 26)}
    for digit in range(10):  # the digit row by position: some layouts need shift for digits
        names[getattr(glfw, f"KEY_{digit}")] = names[getattr(glfw, f"KEY_KP_{digit}")] = str(digit)
    for word in _NAMED_KEYS:
        names[getattr(glfw, f"KEY_{word.upper()}")] = word
    names[glfw.KEY_ENTER] = names[glfw.KEY_KP_ENTER] = "enter"
    return names


class InputQueue:
    """Collects the inputs that GLFW reports for one window while events are polled.

    Thread: main thread only, like all of GLFW.
    """

    def __init__(self, glfw: Any, window: Any) -> None:
        self._glfw = glfw
        self._window = window
        self._physical = _physical_names(glfw)
        self._inputs: list[WindowInput] = []
        self._shift = False
        self.framebuffer_size: tuple[int, int] = glfw.get_framebuffer_size(window)
        self._window_size: tuple[int, int] = glfw.get_window_size(window)
        self._pointer: tuple[float, float] = glfw.get_cursor_pos(window)
        glfw.set_key_callback(window, self._on_key)
        glfw.set_mouse_button_callback(window, self._on_button)
        glfw.set_cursor_pos_callback(window, self._on_move)
        glfw.set_framebuffer_size_callback(window, self._on_framebuffer_size)
        glfw.set_window_size_callback(window, self._on_window_size)
        glfw.set_window_close_callback(window, self._on_close)

    def pop_all(self) -> list[WindowInput]:
        """Return the inputs since the last call, in order; only the last of consecutive pointer moves."""
        taken, self._inputs = self._inputs, []
        return taken

    def put(self, value: WindowInput) -> None:
        """Append an input; a pointer move replaces one immediately before it."""
        if isinstance(value, PointerMoved) and self._inputs and isinstance(self._inputs[-1], PointerMoved):
            self._inputs[-1] = value
        elif len(self._inputs) < QUEUE_LIMIT:
            self._inputs.append(value)

    def key_name(self, key: int, scancode: int) -> str:
        """Return the key's name: the letter of the keyboard layout, or by position if that is not ASCII."""
        if key in self._physical:
            return self._physical[key]
        written = self._glfw.get_key_name(key, scancode)
        text = written.decode("utf-8", "replace") if isinstance(written, bytes) else written or ""
        if len(text) == 1 and text.isascii() and text.isprintable():
            return text.lower()
        return chr(key).lower() if 32 < key < 127 else ""

    def _on_key(self, _window: Any, key: int, scancode: int, action: int, modifiers: int) -> None:
        if key in (self._glfw.KEY_LEFT_SHIFT, self._glfw.KEY_RIGHT_SHIFT):
            self._shift = action != self._glfw.RELEASE
        elif action == self._glfw.PRESS:
            self._shift = bool(modifiers & self._glfw.MOD_SHIFT)
            name = self.key_name(key, scancode)
            if name:
                self.put(KeyPressed(name, self._shift, bool(modifiers & self._glfw.MOD_CONTROL)))

    def _pixels(self) -> tuple[float, float]:
        """Return the pointer in framebuffer pixels, which differ from screen coordinates on high-density displays."""
        (x, y), (width, height), (columns, rows) = self._pointer, self.framebuffer_size, self._window_size
        return x * width / max(columns, 1), y * height / max(rows, 1)

    def _on_button(self, _window: Any, button: int, action: int, modifiers: int) -> None:
        if button != self._glfw.MOUSE_BUTTON_LEFT:
            return
        self._shift = bool(modifiers & self._glfw.MOD_SHIFT)
        # position of the last move: in a fast drag, GLFW's current position is already elsewhere
        kind = PointerPressed if action == self._glfw.PRESS else PointerReleased
        self.put(kind(*self._pixels(), self._shift))

    def _on_move(self, _window: Any, x: float, y: float) -> None:
        self._pointer = (x, y)
        self.put(PointerMoved(*self._pixels(), self._shift))

    def _on_framebuffer_size(self, _window: Any, width: int, height: int) -> None:
        if width > 0 and height > 0 and (width, height) != self.framebuffer_size:  # a minimised window has size 0
            self.framebuffer_size = (width, height)
            self.put(Resized((width, height)))

    def _on_window_size(self, window: Any, width: int, height: int) -> None:
        self._window_size = (width, height)
        self._pointer = self._glfw.get_cursor_pos(window)  # GLFW reports no move if the window moves under the pointer

    def _on_close(self, window: Any) -> None:
        self._glfw.set_window_should_close(window, False)
        self.put(CloseRequested())
