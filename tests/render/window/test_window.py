"""The window on a real X server with two monitors: position, picture, keys, pointer, unplugged monitors."""

from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import glfw
import numpy as np
import pytest

from live.render.headless import FrameReader, OffscreenTarget
from live.render.window.monitors import Monitor, UnknownMonitor, find_monitor, list_monitors, pop_messages
from live.render.window.window import CHECK_PERIOD, NoWindow, Window
from live.render.window.window_input import (
    CloseRequested,
    KeyPressed,
    MonitorsChanged,
    PointerMoved,
    PointerPressed,
    PointerReleased,
    Resized,
    WindowInput,
)
from tests.fixtures.two_monitor_x import FIRST, SECOND, TwoMonitorX

RED = (255, 0, 0)

Open = Callable[..., Window]


@pytest.fixture
def open_window(stage_x: TwoMonitorX) -> Iterator[Open]:
    """Opens a window named "stage"; it is closed after the test."""
    windows: list[Window] = []

    def open_it(**options: Any) -> Window:
        options.setdefault("size", (320, 200))
        windows.append(Window("stage", **options))
        return windows[-1]

    yield open_it
    for window in windows:
        window.close()


def pump(window: Window, until: Callable[[list[WindowInput]], bool]) -> list[WindowInput]:
    """Run a red frame loop until a condition on the inputs received holds; fails after a minute."""
    inputs: list[WindowInput] = []
    deadline = monotonic() + 60.0
    while True:
        inputs += window.poll()
        window.target.use()
        window.target.clear(1.0, 0.0, 0.0)
        window.swap()
        if until(inputs):
            return inputs
        assert monotonic() < deadline, f"not within a minute; there were only {inputs}"


def run_frames(window: Window, count: int) -> list[WindowInput]:
    """Run a red frame loop for a number of frames."""
    left = iter(range(count))
    return pump(window, lambda _: next(left, None) is None)


def window_place(window: Window) -> tuple[int, int, int, int]:
    """Position and size of the window on the desktop."""
    handle = window._handle
    return *glfw.get_window_pos(handle), *glfw.get_window_size(handle)


def window_is_at(window: Window, *wanted: int) -> Callable[[list[WindowInput]], bool]:
    return lambda _: window_place(window) == wanted


def red_shares(x_server: TwoMonitorX) -> tuple[float, float]:
    """Share of the first and of the second monitor that shows red."""
    red = np.all(x_server.screenshot() == RED, axis=2)
    first = red[: FIRST[1], : FIRST[0]]
    second = red[: SECOND[1], FIRST[0] : FIRST[0] + SECOND[0]]
    return float(first.mean()), float(second.mean()) if second.size else 0.0


@pytest.mark.long
@pytest.mark.x11
def test_fullscreen_window_covers_second_monitor(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"), fullscreen=True)
    run_frames(window, 5)
    assert window_place(window) == (640, 0, 800, 600)
    assert window.size == SECOND
    assert window.target.size == SECOND
    assert red_shares(stage_x) == (0.0, 1.0)
    assert glfw.get_input_mode(window._handle, glfw.CURSOR) == glfw.CURSOR_HIDDEN
    assert window.ctx.version_code >= 410
    assert pop_messages() == []


@pytest.mark.x11
def test_window_opens_centred_on_its_monitor(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("DUMMY1"))
    run_frames(window, 5)
    assert window_place(window) == (880, 200, 320, 200)
    assert not window.fullscreen
    first, second = red_shares(stage_x)
    assert first == 0.0
    assert second == pytest.approx(320 * 200 / (800 * 600))


@pytest.mark.x11
def test_default_monitor_is_primary(open_window: Open) -> None:
    window = open_window(fullscreen=True)
    run_frames(window, 5)
    assert window_place(window) == (0, 0, *FIRST)


@pytest.mark.long
@pytest.mark.x11
def test_pressed_keys_are_received(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"), fullscreen=True)
    run_frames(window, 3)
    stage_x.run("xdotool", "key", "space", "key", "1", "key", "b", "key", "ctrl+f", "key", "shift+s", "key", "Escape")
    stage_x.run("xdotool", "key", "F5", "key", "Left")
    inputs = pump(window, lambda inputs: KeyPressed("left") in inputs)
    keys = [each for each in inputs if isinstance(each, KeyPressed)]
    assert keys == [
        KeyPressed("space"),
        KeyPressed("1"),
        KeyPressed("b"),
        KeyPressed("f", control=True),
        KeyPressed("s", shift=True),
        KeyPressed("escape"),
        KeyPressed("f5"),
        KeyPressed("left"),
    ]
    assert window_place(window) == (640, 0, 800, 600), "no key closes or moves the window by itself"


@pytest.mark.long
@pytest.mark.x11
def test_pointer_position_is_in_picture_pixels(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"), fullscreen=True)
    run_frames(window, 3)
    stage_x.run("xdotool", "mousemove", "740", "100", "mousedown", "1", "mousemove", "790", "250")
    stage_x.run("xdotool", "mouseup", "1", "click", "3", "keydown", "shift", "click", "1", "keyup", "shift")
    inputs = pump(window, lambda inputs: sum(isinstance(each, PointerReleased) for each in inputs) == 2)
    assert [each for each in inputs if not isinstance(each, PointerMoved)] == [
        PointerPressed(100.0, 100.0),
        PointerReleased(150.0, 250.0),
        PointerPressed(150.0, 250.0, shift=True),
        PointerReleased(150.0, 250.0, shift=True),
    ]
    assert PointerMoved(150.0, 250.0) in inputs


@pytest.mark.x11
def test_fullscreen_toggles_on_and_off(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("1"))
    glfw.set_window_pos(window._handle, 700, 50)  # somebody drags it over to the second monitor
    pump(window, window_is_at(window, 700, 50, 320, 200))
    window.toggle_fullscreen()
    inputs = pump(window, lambda inputs: window_place(window) == (640, 0, 800, 600) and Resized(SECOND) in inputs)
    assert inputs.count(Resized(SECOND)) == 1
    assert window.fullscreen
    assert window.monitor.name == "DUMMY1"
    assert red_shares(stage_x) == (0.0, 1.0)
    window.toggle_fullscreen()
    pump(window, window_is_at(window, 700, 50, 320, 200))
    assert glfw.get_input_mode(window._handle, glfw.CURSOR) == glfw.CURSOR_NORMAL
    assert pop_messages() == []


@pytest.mark.x11
def test_enlarged_window_is_filled_to_its_edges(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"))
    run_frames(window, 3)
    stage_x.run("xdotool", "search", "--name", "^stage$", "windowsize", "500", "320")
    pump(window, lambda inputs: Resized((500, 320)) in inputs)
    run_frames(window, 3)
    assert window.target.viewport == (0, 0, 500, 320)
    assert window.target.size == (500, 320)
    _, second = red_shares(stage_x)
    assert second == pytest.approx(500 * 320 / (800 * 600))


@pytest.mark.long
@pytest.mark.x11
def test_picture_is_copied_and_read_completely_after_resize(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"))
    run_frames(window, 3)
    window.toggle_fullscreen()
    pump(window, lambda _: window.size == SECOND)
    drawn = OffscreenTarget(window.ctx, SECOND)
    drawn.framebuffer.use()
    drawn.framebuffer.clear(0.0, 0.0, 1.0)
    drawn.framebuffer.clear(0.0, 1.0, 0.0, viewport=(0, 0, 800, 300))  # the lower half
    window.ctx.copy_framebuffer(window.target, drawn.framebuffer)
    reader = FrameReader(window.ctx, SECOND)
    picture = reader.read(window.target).copy()
    window.swap()
    window.ctx.finish()
    assert np.all(picture[:300] == (0, 0, 255))
    assert np.all(picture[300:] == (0, 255, 0))
    shown = stage_x.screenshot()[:600, 640:1440]
    np.testing.assert_array_equal(shown, picture)


@pytest.mark.long
@pytest.mark.x11
def test_window_returns_to_replugged_projector(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"), fullscreen=True)
    run_frames(window, 3)
    stage_x.unplug_second()
    pump(window, lambda inputs: MonitorsChanged() in inputs)
    assert window_place(window) == (160, 80, 320, 200), "it moved at once"
    run_frames(window, 3)
    assert window.fullscreen, "it still means to be full screen"
    assert glfw.get_input_mode(window._handle, glfw.CURSOR) == glfw.CURSOR_NORMAL
    assert red_shares(stage_x)[0] == pytest.approx(320 * 200 / (640 * 360)), "the show goes on, on the first monitor"
    stage_x.plug_both()
    pump(window, lambda inputs: MonitorsChanged() in inputs)
    assert window_place(window) == (640, 0, 800, 600), "it moved back at once"
    run_frames(window, 3)
    assert red_shares(stage_x) == (0.0, 1.0)
    assert window.size == SECOND
    assert glfw.get_input_mode(window._handle, glfw.CURSOR) == glfw.CURSOR_HIDDEN


@pytest.mark.x11
def test_monitor_replugged_within_one_frame_keeps_window(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"), fullscreen=True)
    run_frames(window, 3)
    stage_x.unplug_second()
    stage_x.plug_both()
    run_frames(window, 5)
    assert window_place(window) == (640, 0, 800, 600)
    assert red_shares(stage_x) == (0.0, 1.0)


@pytest.mark.x11
def test_fullscreen_window_follows_moved_monitor(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("2"), fullscreen=True)
    run_frames(window, 3)
    stage_x.run("xrandr", "--output", "DUMMY1", "--mode", "640x360", "--pos", "700x20")
    run_frames(window, CHECK_PERIOD + 5)
    assert window_place(window) == (700, 20, 640, 360)
    assert window.size == (640, 360)


@pytest.mark.x11
def test_plain_window_stays_after_monitor_changes(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("1"))
    before = window_place(window)
    stage_x.unplug_second()
    pump(window, lambda inputs: MonitorsChanged() in inputs)
    stage_x.plug_both()
    pump(window, lambda inputs: MonitorsChanged() in inputs)
    assert window_place(window) == before


@pytest.mark.x11
def test_refused_fullscreen_falls_back_to_borderless_window(
    open_window: Open, stage_x: TwoMonitorX, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = open_window(monitor=find_monitor("2"))
    run_frames(window, 3)
    allowed: Any = glfw.set_window_monitor

    def refuse(handle: Any, monitor: Any, *window_place: int) -> None:
        if monitor is None:
            allowed(handle, monitor, *window_place)

    monkeypatch.setattr(glfw, "set_window_monitor", refuse)
    window.toggle_fullscreen()
    pump(window, window_is_at(window, 640, 0, 800, 600))
    run_frames(window, 3)
    assert not glfw.get_window_attrib(window._handle, glfw.DECORATED)
    assert red_shares(stage_x) == (0.0, 1.0)
    window.toggle_fullscreen()
    pump(window, window_is_at(window, 880, 200, 320, 200))
    assert glfw.get_window_attrib(window._handle, glfw.DECORATED)


@pytest.mark.x11
def test_close_is_only_requested(open_window: Open, stage_x: TwoMonitorX) -> None:
    window = open_window(monitor=find_monitor("1"))
    run_frames(window, 3)
    stage_x.ask_to_close("stage")
    pump(window, lambda inputs: CloseRequested() in inputs)
    run_frames(window, 3)
    assert window_place(window) == (160, 80, 320, 200), "the window is still there"
    window.close()
    window.close()


@pytest.mark.x11
def test_glfw_errors_are_collected_and_not_printed(open_window: Open, capfd: pytest.CaptureFixture[str]) -> None:
    window = open_window()
    for _ in range(3):
        glfw.set_window_attrib(window._handle, 0x7777, True)
    (complaint,) = pop_messages()
    assert pop_messages() == []
    printed = capfd.readouterr()  # some graphics drivers print words of their own
    assert complaint.partition(" (GLFW")[0] not in printed.out + printed.err
    assert "GLFW" not in printed.out + printed.err


@pytest.mark.x11
def test_disconnected_monitor_error_lists_monitors(open_window: Open) -> None:
    gone = Monitor(3, "HDMI-7", (0, 0), (640, 480), 60.0)
    with pytest.raises(UnknownMonitor, match=r"HDMI-7 is not connected any more.*DUMMY0.*DUMMY1"):
        open_window(monitor=gone)


@pytest.mark.x11
def test_window_can_be_opened_after_another(open_window: Open) -> None:
    for _ in range(2):
        window = open_window(monitor=list_monitors()[1], fullscreen=True)
        run_frames(window, 3)
        window.close()


@pytest.mark.usefixtures("no_screen")
def test_missing_screen_error_suggests_headless() -> None:
    with pytest.raises(NoWindow, match=r"DISPLAY.*--headless"):
        Window("stage")
