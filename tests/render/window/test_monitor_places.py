"""Tests of monitors given by their position relative to others."""

import pytest

from live.render.window.monitors import Monitor, UnknownMonitor, resolve_monitor

DESK = Monitor(1, "eDP-1", (0, 1080), (1920, 1080), 60.0)
LEFT = Monitor(2, "HDMI-1", (-1280, 1080), (1280, 720), 60.0)
RIGHT = Monitor(3, "HDMI-2", (1920, 1080), (1280, 720), 60.0)
FAR = Monitor(4, "DP-1", (3200, 1080), (1280, 720), 60.0)
ABOVE = Monitor(5, "DP-2", (200, 0), (1280, 1080), 60.0)
ALL = [DESK, LEFT, RIGHT, FAR, ABOVE]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("primary", DESK), ("right of primary", RIGHT), ("Left Of Primary", LEFT), ("right of HDMI-2", FAR),
        ("above 1", ABOVE), ("below DP-2", DESK), ("left of right of primary", DESK), ("4", FAR), ("hdmi-1", LEFT),
    ],
)  # fmt: skip
def test_monitor_is_found_by_relative_position(text, expected):
    assert resolve_monitor(text, ALL) == expected


@pytest.mark.parametrize("text", ["right of DP-1", "below primary", "right of nothing", "beside 1", "right of"])
def test_unknown_position_error_lists_monitors(text):
    with pytest.raises(UnknownMonitor, match=r"HDMI-1 \(1280x720 at -1280,1080"):
        resolve_monitor(text, ALL)


def test_primary_is_refused_without_monitors():
    with pytest.raises(UnknownMonitor):
        resolve_monitor("primary", [])
