"""Monitors by their place: "right of primary", "left of DUMMY0", "below 2"."""

import re

from live.render.window.monitors import Monitor, UnknownMonitor, find_monitor, list_monitors

_PLACE = re.compile(r"\s*(left of|right of|above|below)\s+(.+?)\s*", re.IGNORECASE)


def find_place(text: str, monitors: list[Monitor] | None = None) -> Monitor:
    """The monitor that is meant: `primary`, a place beside another one (the nearest there), a number or a name.

    `monitors` is what to choose from (default: those connected now), the primary one first. Raises `UnknownMonitor`.
    """
    there = list_monitors() if monitors is None else monitors
    if text.strip().casefold() == "primary" and there:
        return there[0]
    match = _PLACE.fullmatch(text)
    if match is None:
        return find_monitor(text, monitors)
    side, other = match[1].casefold(), find_place(match[2], there)
    beside = [(far, each) for each in there if (far := _distance(side, other, each)) is not None]
    if not beside:
        listing = "".join(f"\n  {monitor}" for monitor in there)
        raise UnknownMonitor(f"there is no monitor {side} {other.name}; there is:{listing}")
    return min(beside, key=lambda found: found[0])[1]


def _distance(side: str, other: Monitor, each: Monitor) -> float | None:
    """How far a monitor lies on that side of another one, middle to middle; None if it does not."""
    (x, y), (across, down) = _middle(each), _middle(other)
    right, below = x - across, y - down
    ahead = {"left of": -right, "right of": right, "above": -below, "below": below}[side]
    aside = abs(below if side.endswith("of") else right)
    return ahead + 2.0 * aside if ahead > 0.0 and aside <= 2.0 * ahead else None


def _middle(monitor: Monitor) -> tuple[float, float]:
    return monitor.position[0] + 0.5 * monitor.size[0], monitor.position[1] + 0.5 * monitor.size[1]
