"""Tests of monitors given by number or name."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from live.render.window.monitors import (
    Monitor,
    UnknownMonitor,
    find_monitor,
    list_monitors,
    match_monitor,
    screen_problem,
)
from tests.control.waiting import wait_for
from tests.fixtures.two_monitor_x import FIRST, SECOND, TwoMonitorX
from tests.places import ROOT

DESK = Monitor(1, "eDP-1", (0, 0), (1920, 1200), 60.0)
LEFT = Monitor(2, "HDMI-1", (1920, 0), (1920, 1080), 50.0)
RIGHT = Monitor(3, "HDMI-2", (3840, 0), (1024, 768), 0.0)
THREE = [DESK, LEFT, RIGHT]


@pytest.mark.parametrize(
    ("text", "monitor"),
    [("1", DESK), ("3", RIGHT), ("HDMI-1", LEFT), ("hdmi-2", RIGHT), ("edp", DESK), (" 2 ", LEFT)],
)
def test_monitor_is_found_by_number_name_or_prefix(text: str, monitor: Monitor) -> None:
    assert find_monitor(text, THREE) is monitor


@pytest.mark.parametrize("text", ["0", "4", "-1", "VGA", "", "1.5", "²", "hdmi-1x"])
def test_unknown_monitor_error_lists_monitors(text: str) -> None:
    with pytest.raises(UnknownMonitor, match="is not a monitor") as caught:
        find_monitor(text, THREE)
    for word in ("1 eDP-1", "2 HDMI-1", "3 HDMI-2", "1920x1080 at 1920,0 50 Hz", "1024x768 at 3840,0)"):
        assert word in str(caught.value)


def test_ambiguous_prefix_is_refused() -> None:
    with pytest.raises(UnknownMonitor, match="means several monitors"):
        find_monitor("hdmi", THREE)


def test_exact_name_precedes_longer_name() -> None:
    longer = Monitor(2, "HDMI-10", (0, 0), (640, 480), 60.0)
    assert find_monitor("HDMI-1", [longer, LEFT]) is LEFT


def test_equal_names_are_distinguished_by_number_only() -> None:
    twins = [Monitor(1, "EPSON", (0, 0), (800, 600), 60.0), Monitor(2, "EPSON", (800, 0), (800, 600), 60.0)]
    assert find_monitor("2", twins) is twins[1]
    with pytest.raises(UnknownMonitor, match="means several monitors"):
        find_monitor("EPSON", twins)
    assert match_monitor(Monitor(5, "EPSON", (790, 10), (1280, 720), 50.0), twins) is twins[1]
    assert match_monitor(DESK, twins) is None


@pytest.mark.x11
def test_two_real_monitors_are_listed(stage_x: TwoMonitorX) -> None:
    monitors = list_monitors()
    assert [(each.index, each.name, each.position, each.size) for each in monitors] == [
        (1, "DUMMY0", (0, 0), FIRST),
        (2, "DUMMY1", (640, 0), SECOND),
    ]
    assert [each.refresh_hz for each in monitors] == [60.0, 60.0]
    assert screen_problem() == ""
    assert find_monitor("dummy1") == monitors[1]
    with pytest.raises(UnknownMonitor, match="several"):
        find_monitor("dummy")


@pytest.mark.x11
@pytest.mark.skipif(sys.platform != "linux", reason="Wayland is of Linux")
def test_x_server_is_used_in_wayland_session(stage_x: TwoMonitorX) -> None:
    code = "from live.render.window.monitors import list_monitors; print([each.name for each in list_monitors()])"
    environment = {**os.environ, "XDG_SESSION_TYPE": "wayland", "WAYLAND_DISPLAY": "wayland-77"}
    environment.pop("PYGLFW_LIBRARY_VARIANT", None)
    root = ROOT
    told = subprocess.run([sys.executable, "-c", code], env=environment, cwd=root, capture_output=True, check=True)
    assert told.stdout.decode().strip() == "['DUMMY0', 'DUMMY1']"


@pytest.mark.usefixtures("no_screen")
def test_missing_screen_gives_no_monitors_and_a_reason() -> None:
    assert list_monitors() == []
    assert "DISPLAY" in screen_problem()
    with pytest.raises(UnknownMonitor, match=r"there is none \(no screen"):
        find_monitor("1")


@pytest.mark.usefixtures("no_screen")
def test_unreachable_display_gives_no_monitors_and_a_reason(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DISPLAY", ":12345")
    assert list_monitors() == []
    assert ":12345" in screen_problem()
    assert capfd.readouterr() == ("", "")


ALONE = """
from live.render.window.monitors import list_monitors, screen_problem
print([each.name for each in list_monitors()], screen_problem())
"""


def wayland_only(**more: str) -> str:
    """What a process says of its monitors in a session of Wayland without XWayland."""
    environment = {**os.environ, "WAYLAND_DISPLAY": "wayland-77", "XDG_SESSION_TYPE": "tty", **more}
    for name in ("DISPLAY", "PYGLFW_LIBRARY_VARIANT"):
        environment.pop(name, None)
    told = subprocess.run([sys.executable, "-c", ALONE], env=environment, cwd=ROOT, capture_output=True, check=True)
    return told.stdout.decode()


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="Wayland is of Linux")
def test_a_wayland_compositor_with_which_glfw_cannot_start_is_a_reason() -> None:
    told = wayland_only()
    assert told.startswith("[] ")
    assert "Wayland compositor at wayland-77" in told
    assert "XWayland" in told


@pytest.mark.skipif(shutil.which("weston") is None, reason="needs weston")
def test_a_compositor_without_a_seat_does_not_end_the_process(tmp_path: Path) -> None:
    """GLFW 3.4 reads the version of the seat that is not there."""
    tmp_path.chmod(0o700)
    folder = {"XDG_RUNTIME_DIR": str(tmp_path)}
    command = ["weston", "--backend=headless-backend.so", "--socket=wayland-77", "--use-pixman"]
    weston = subprocess.Popen(
        command, env={**os.environ, **folder}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        assert wait_for((tmp_path / "wayland-77").exists, 20)
        assert wayland_only(**folder).startswith(("[] ", "['headless'"))  # the latter once GLFW is mended
    finally:
        weston.kill()
        weston.wait()
