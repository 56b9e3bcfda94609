"""Figures of gateways for the show's status: checked as they come, and a row for each."""

import math
from collections import Counter
from typing import Any, Final

import numpy as np

SILENT_SECONDS: Final = 2.0
"""Seconds without voices after which a connected gateway is told to be silent."""
TOLD_SECONDS: Final = 60.0
"""Seconds for which a gateway that was refused is told of; it tries again every few seconds."""
MOST_TURNED_AWAY: Final = 64
LONGEST_NAME: Final = 64


class TurnedAway:
    """Gateways that did not fit, for the status. Thread: one."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[float, str, str, str]] = {}  # when it came last, machine, version, why

    def add(self, name: str, where: str, version: str, why: str, now: float) -> None:
        """Note one."""
        self.remove(name)
        self._known[name[:LONGEST_NAME]] = now, where, printable(version)[:40], printable(why)
        if len(self._known) > MOST_TURNED_AWAY:
            del self._known[next(iter(self._known))]

    def remove(self, name: str) -> None:
        """Forget one: it fits now."""
        self._known.pop(name[:LONGEST_NAME], None)

    def rows(self, now: float) -> list[dict[str, Any]]:
        """Return a row for each of the last minute, as `connected_row`."""
        return [
            {"name": printable(name), "machine": where, "state": "refused", "why": why, "version": version,
             "phones": 0, "most": 0, "silent_ms": round(1e3 * (now - at)), "clock_ms": 0.0, "late_ms": 0.0,
             "gone": True, "lies": 0}
            for name, (at, where, version, why) in self._known.items() if now - at < TOLD_SECONDS
        ]  # fmt: skip


def printable(text: str) -> str:
    """Return text of another machine without control characters."""
    return "".join(mark if mark.isprintable() else " " for mark in text)


def connected_row(
    name: str, where: str, facts: dict[str, Any], *, phones: int, most: int, silent: float, gone: bool, lies: int
) -> dict[str, Any]:
    """Return the row of a gateway that has been let in. `facts`: as it told them; `silent`: seconds without voices."""
    state = "gone" if gone else "silent" if silent > SILENT_SECONDS else "serves"
    version = printable(str(facts.get("version", "")))[:40]
    return {
        "name": name, "machine": where, "state": state, "why": "", "version": version,
        "phones": phones, "most": most, "silent_ms": round(1e3 * silent), "clock_ms": facts.get("clock_ms", 0.0),
        "late_ms": facts.get("late_ms", [0.0, 0.0])[-1], "gone": gone, "lies": lies,
    }  # fmt: skip


def checked_facts(facts: dict[Any, Any]) -> dict[str, Any]:
    """Return a gateway's facts; an error of some kind if they are of other types, or numbers that are none."""
    found: dict[str, Any] = {name: int(facts[name]) for name in ("messages", "crowded", "missed_frames")}
    found |= {name: float(facts[name]) for name in ("voices", "clock_ms")}
    found |= {name: [float(value) for value in facts[name]][:2] or [0.0] for name in ("late_ms", "ways_ms")}
    if not all(math.isfinite(each) for value in found.values() for each in np.atleast_1d(value)):
        raise ValueError("figures expected")
    found["version"] = str(facts["version"])
    reasons = list(dict(facts["refused"]).items())[:64]
    found["refused"] = {str(why)[:60]: int(count) for why, count in reasons}
    found["held"] = {str(key)[:20]: [int(each) for each in value][:8] for key, value in dict(facts["held"]).items()}
    return found


def merged_facts(told: list[dict[str, Any]], refused: Counter[str]) -> dict[str, Any]:
    """Return the facts of all gateways together; those of the slowest where there is no sum. `refused`: inputs that
    were refused beside them, by reason."""
    total, held = Counter(refused), dict[str, Any]()
    for facts in told:
        total.update({str(why): int(count) for why, count in facts.get("refused", {}).items()})
        held |= facts.get("held", {})
    return {
        "messages": sum(facts.get("messages", 0) for facts in told),
        "crowded": max((facts.get("crowded", 0) for facts in told), default=0),
        "voices": round(sum(facts.get("voices", 0.0) for facts in told), 2),
        "missed_frames": sum(facts.get("missed_frames", 0) for facts in told),
        "late_ms": _slowest(told, "late_ms"), "ways_ms": _slowest(told, "ways_ms"),
        "held": held, "refused": dict(total),
    }  # fmt: skip


def _slowest(told: list[dict[str, Any]], name: str) -> list[float]:
    rows = [facts[name] for facts in told if name in facts]
    return max(rows, key=lambda row: row[-1], default=[0.0, 0.0])
