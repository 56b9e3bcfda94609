"""The screensaver is inhibited during a show and restored afterwards."""

import ctypes
import subprocess
import sys
from time import monotonic

import pytest

from live.render.window import screensaver as awake
from live.render.window.screensaver import RESET_PERIOD, ScreensaverInhibitor, x11_display
from live.render.window.window import Window
from tests.fixtures.two_monitor_x import TwoMonitorX


class _Info(ctypes.Structure):
    """XScreenSaverInfo of libXss."""

    _fields_ = (
        ("window", ctypes.c_ulong), ("state", ctypes.c_int), ("kind", ctypes.c_int),
        ("til_or_since", ctypes.c_ulong), ("idle", ctypes.c_ulong), ("eventMask", ctypes.c_ulong),
    )  # fmt: skip


class IdleMonitor:
    """Another client of the X server that reads the idle time."""

    def __init__(self, display: str) -> None:
        self._x11, self._saver = ctypes.CDLL("libX11.so.6"), ctypes.CDLL("libXss.so.1")
        self._x11.XOpenDisplay.restype = ctypes.c_void_p
        self._display = ctypes.c_void_p(self._x11.XOpenDisplay(display.encode()))
        self._x11.XDefaultRootWindow.restype = ctypes.c_ulong
        self._root = ctypes.c_ulong(self._x11.XDefaultRootWindow(self._display))

    def idle(self) -> float:
        """Idle time [s] reported by the server."""
        info = _Info()
        assert self._saver.XScreenSaverQueryInfo(self._display, self._root, ctypes.byref(info))
        return info.idle / 1000.0

    def close(self) -> None:
        self._x11.XCloseDisplay(self._display)


@pytest.mark.x11
def test_refresh_resets_idle_time(stage_x: TwoMonitorX) -> None:
    try:
        watcher = IdleMonitor(stage_x.display)
    except OSError:
        pytest.skip("libXss is not installed (Debian: libxss1)")
    window = Window("stage", size=(64, 64))
    keeper = ScreensaverInhibitor(x11_display()).start()
    try:
        assert "XResetScreenSaver" in keeper.methods
        assert "XScreenSaverSuspend" in keeper.methods
        deadline = monotonic() + 30.0
        while watcher.idle() < 0.2:
            assert monotonic() < deadline
        before = watcher.idle()
        keeper.refresh(0.0)
        while watcher.idle() >= before:
            assert monotonic() < deadline, "the idle time went on"
        later = watcher.idle()
        while watcher.idle() < later + 0.05:
            assert monotonic() < deadline
        settled = watcher.idle()
        keeper.refresh(RESET_PERIOD - 0.1)  # not yet again
        assert watcher.idle() >= settled
    finally:
        keeper.stop()
        window.close()
        watcher.close()
    keeper.refresh(2 * RESET_PERIOD)  # does nothing, and does not fail
    assert keeper.methods == []


@pytest.mark.x11
def test_screensaver_timeout_is_restored_afterwards(stage_x: TwoMonitorX) -> None:
    stage_x.run("xset", "s", "77", "33")
    window = Window("stage", size=(64, 64))
    keeper = ScreensaverInhibitor(x11_display()).start()
    keeper.refresh(0.0)
    keeper.stop()
    window.close()
    assert b"timeout:  77    cycle:  33" in stage_x.run("xset", "q")
    stage_x.run("xset", "s", "default")


def test_system_inhibit_process_ends_with_show(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    """A child process holds the lock until its standard input ends."""
    log = tmp_path / "log"
    program = f"import sys; open({str(log)!r}, 'w').write('held'); sys.stdin.read()"
    monkeypatch.setattr(awake, "_INHIBIT_COMMANDS", {sys.platform: (sys.executable, "-c", program)})
    keeper = ScreensaverInhibitor().start()
    child = keeper._child
    assert child is not None
    deadline = monotonic() + 60.0
    while not log.exists() or log.read_text() != "held":
        assert monotonic() < deadline
    assert child.poll() is None
    keeper.stop()
    assert child.poll() is not None


def test_show_continues_without_inhibit_method(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(awake, "_INHIBIT_COMMANDS", {sys.platform: ("no-such-program-anywhere",)})
    keeper = ScreensaverInhibitor().start()
    keeper.refresh(0.0)
    assert keeper.methods == [] or sys.platform == "win32"
    keeper.stop()

    def refuse(*_: object, **__: object) -> None:
        raise OSError("no processes left")

    monkeypatch.setattr(awake, "_INHIBIT_COMMANDS", {sys.platform: (sys.executable,)})
    monkeypatch.setattr(subprocess, "Popen", refuse)
    ScreensaverInhibitor().start().stop()
