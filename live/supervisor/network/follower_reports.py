"""How machines that stand by are: they tell their leader once a second, and the leader tells the operator."""

from collections.abc import Iterable
from typing import Any, Final

from live.clock.ticks import TICK
from live.supervisor.network.leadership import Leadership
from live.supervisor.network.peer_messages import HIGHEST, FollowerState, Restart, format_message
from live.supervisor.network.peers import Link
from live.supervisor.process import Child
from live.supervisor.supervisor_config import Report

LONGEST_WHY: Final = 400
"""Most characters of a reason from another machine."""
STATE_EVERY: Final = 1.0
"""Seconds between two reports of a machine that stands by."""
CANNOT_KEPT: Final = 60.0
"""Seconds for which a machine that could not stand by is told of."""
MOST_CANNOT: Final = 32


class FollowerReports:
    """Both ends of these reports. Thread: the supervisor's."""

    def __init__(self) -> None:
        self._cannot: dict[str, tuple[float, str]] = {}  # machines that could not follow: when, and why
        self._state_at = 0.0

    # -- by a machine that stands by -------------------------------------------------------------------------------

    def tell(self, leader: Link, engine: Child | None, report: Report, now: float) -> None:
        """Tell the leader how far this machine is, once a second."""
        if now < self._state_at:
            return
        self._state_at = now + STATE_EVERY
        tick = 0 if engine is None else min(engine.heartbeat.tick, HIGHEST - 1)
        leader.channel.send_line(format_message(FollowerState(tick, report.compared, report.different)))

    # -- by the leader ---------------------------------------------------------------------------------------------

    def note_cannot(self, name: str, why: str, now: float) -> None:
        """Note that a machine cannot stand by."""
        self._cannot.pop(name, None)
        self._cannot[name] = now, why
        if len(self._cannot) > MOST_CANNOT:
            del self._cannot[next(iter(self._cannot))]

    def rows(self, links: Iterable[Link], lead: Leadership, now: float) -> list[dict[str, Any]]:
        """Return state and lateness of each machine that follows this one, and of those that could not, lately."""
        self._cannot = {name: held for name, held in self._cannot.items() if now - held[0] < CANNOT_KEPT}
        found = []
        for link in links:
            if not link.follows:
                continue
            state = link.state
            self._cannot.pop(link.peer.name, None)
            found.append({
                "name": link.peer.name, "process": link.peer_name,
                "state": "ready" if lead.is_ready(link.name) else "follows",
                "why": "takes over next" if link.name == lead.deputy else "",
                "late_ms": round(1e3 * TICK * max(link.state_tick - state.tick, 0), 1),
                "silent_ms": round(1e3 * lead.silence(link.name, now), 1),
                "compared": state.compared, "different": state.different,
            })  # fmt: skip
        for name, (at, why) in self._cannot.items():
            silent_ms = round(1e3 * (now - at), 1)
            found.append({"name": name, "process": "", "state": "refused", "why": why, "silent_ms": silent_ms})
        return found


def order_restart(links: Iterable[Link], name: str, process: str) -> None:
    """Order a machine that stands by to start again."""
    for link in links:
        if link.follows and (link.peer.name, link.peer_name) == (name, process):
            link.channel.send_line(format_message(Restart()))


def one_line(words: object) -> str:
    """Return text of another machine as one short line without control characters."""
    return "".join(mark if mark.isprintable() else " " for mark in str(words)[:LONGEST_WHY])
