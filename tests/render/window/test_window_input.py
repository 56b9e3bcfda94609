"""GLFW callbacks converted to inputs, with a fake GLFW for keyboard and display."""

from collections.abc import Callable
from typing import Any

import glfw
import pytest

from live.render.window.window_input import (
    QUEUE_LIMIT,
    CloseRequested,
    InputQueue,
    KeyPressed,
    PointerMoved,
    PointerPressed,
    PointerReleased,
    Resized,
)

SHIFT, CONTROL = glfw.MOD_SHIFT, glfw.MOD_CONTROL


class OneWindowGlfw:
    """GLFW constants, one high-density window (twice as many pixels as screen coordinates), and a keyboard layout."""

    def __init__(self, layout: dict[int, str | None]) -> None:
        self.layout = layout
        self.callbacks: dict[str, Callable[..., None]] = {}
        self.should_close = True

    def __getattr__(self, name: str) -> Any:
        if name.startswith("set_") and name.endswith("_callback"):
            return lambda _window, callback: self.callbacks.__setitem__(name[4:-9], callback)
        assert name.isupper(), f"unexpected call of {name}"
        return getattr(glfw, name)

    def get_framebuffer_size(self, _window: Any) -> tuple[int, int]:
        return 1600, 1200

    def get_window_size(self, _window: Any) -> tuple[int, int]:
        return 800, 600

    def get_cursor_pos(self, _window: Any) -> tuple[float, float]:
        return 10.0, 20.0

    def get_key_name(self, key: int, _scancode: int) -> bytes | None:
        written = self.layout[key] if key in self.layout else chr(key).lower()
        return None if written is None else written.encode()

    def set_window_should_close(self, _window: Any, close: bool) -> None:
        self.should_close = close

    def press(self, key: int, modifiers: int = 0, action: int = glfw.PRESS) -> None:
        self.callbacks["key"](None, key, 0, action, modifiers)


def make_queue(layout: dict[int, str | None] | None = None) -> tuple[OneWindowGlfw, InputQueue]:
    fake = OneWindowGlfw(layout or {})
    return fake, InputQueue(fake, None)


@pytest.mark.parametrize(
    ("layout", "key", "name"),
    [
        ({}, glfw.KEY_B, "b"),
        ({glfw.KEY_Q: "a"}, glfw.KEY_Q, "a"),  # French: what is written on the key counts
        ({glfw.KEY_1: "&"}, glfw.KEY_1, "1"),  # French: 1 needs shift, but the key is meant
        ({glfw.KEY_B: "и"}, glfw.KEY_B, "b"),  # Russian: the key by its place
        ({}, glfw.KEY_KP_7, "7"),
        ({}, glfw.KEY_KP_ENTER, "enter"),
        ({}, glfw.KEY_PAGE_UP, "page_up"),
        ({}, glfw.KEY_ESCAPE, "escape"),
        ({}, glfw.KEY_F12, "f12"),
    ],
)
def test_key_names_follow_layout(layout: dict[int, str | None], key: int, name: str) -> None:
    fake, queue = make_queue(layout)
    fake.press(key)
    assert queue.pop_all() == [KeyPressed(name)]


def test_unnamed_keys_are_ignored() -> None:
    fake, queue = make_queue({glfw.KEY_WORLD_1: None, glfw.KEY_UNKNOWN: None, glfw.KEY_LEFT_ALT: None})
    for key in (glfw.KEY_WORLD_1, glfw.KEY_UNKNOWN, glfw.KEY_LEFT_ALT):
        fake.press(key)
    assert queue.pop_all() == []


def test_a_held_key_counts_once() -> None:
    fake, queue = make_queue()
    for action in (glfw.PRESS, glfw.REPEAT, glfw.REPEAT, glfw.RELEASE):
        fake.press(glfw.KEY_SPACE, action=action)
    assert queue.pop_all() == [KeyPressed("space")]
    assert queue.pop_all() == []


def test_modifiers_are_reported() -> None:
    fake, queue = make_queue()
    fake.press(glfw.KEY_F, CONTROL)
    fake.press(glfw.KEY_F, SHIFT | CONTROL)
    assert queue.pop_all() == [KeyPressed("f", control=True), KeyPressed("f", shift=True, control=True)]


def test_pointer_positions_are_framebuffer_pixels() -> None:
    fake, queue = make_queue()
    fake.callbacks["mouse_button"](None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, 0)
    fake.callbacks["cursor_pos"](None, 400.0, 150.5)
    fake.callbacks["mouse_button"](None, glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, 0)
    fake.callbacks["mouse_button"](None, glfw.MOUSE_BUTTON_RIGHT, glfw.PRESS, 0)
    assert queue.pop_all() == [PointerPressed(20.0, 40.0), PointerMoved(800.0, 301.0), PointerReleased(800.0, 301.0)]


def test_consecutive_moves_are_merged_but_not_across_clicks() -> None:
    fake, queue = make_queue()
    for x in (1.0, 2.0, 3.0):
        fake.callbacks["cursor_pos"](None, x, 0.0)
    fake.callbacks["mouse_button"](None, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, SHIFT)
    for x in (4.0, 5.0):
        fake.callbacks["cursor_pos"](None, x, 0.0)
    assert queue.pop_all() == [PointerMoved(6.0, 0.0), PointerPressed(6.0, 0.0, True), PointerMoved(10.0, 0.0, True)]


def test_shift_is_tracked_during_drag() -> None:
    fake, queue = make_queue()
    fake.press(glfw.KEY_LEFT_SHIFT, SHIFT)
    fake.callbacks["cursor_pos"](None, 1.0, 1.0)
    fake.press(glfw.KEY_B, SHIFT)
    fake.press(glfw.KEY_LEFT_SHIFT, 0, glfw.RELEASE)
    fake.callbacks["cursor_pos"](None, 2.0, 2.0)
    assert queue.pop_all() == [PointerMoved(2.0, 2.0, True), KeyPressed("b", shift=True), PointerMoved(4.0, 4.0)]


def test_queue_is_bounded() -> None:
    fake, queue = make_queue()
    for _ in range(3 * QUEUE_LIMIT):
        fake.press(glfw.KEY_SPACE)
    assert len(queue.pop_all()) == QUEUE_LIMIT
    fake.press(glfw.KEY_B)
    assert queue.pop_all() == [KeyPressed("b")]


def test_a_minimised_window_keeps_its_size() -> None:
    fake, queue = make_queue()
    fake.callbacks["framebuffer_size"](None, 0, 0)
    assert queue.framebuffer_size == (1600, 1200)
    fake.callbacks["framebuffer_size"](None, 1600, 1200)
    fake.callbacks["framebuffer_size"](None, 640, 480)
    assert queue.pop_all() == [Resized((640, 480))]


def test_close_is_only_requested() -> None:
    fake, queue = make_queue()
    fake.callbacks["window_close"](None)
    assert queue.pop_all() == [CloseRequested()]
    assert fake.should_close is False
