"""Gateways for phones and their reducer, as the supervisor tells operators of them, and restarts on their order.

The engine has the link to them, the supervisor that to the operators (`live cluster`). So once a second the engine
tells the supervisor what its own status says, and the supervisor hands orders down.
"""

from typing import TYPE_CHECKING, Any, Final

from live import __version__

if TYPE_CHECKING:
    from live.app.services.audience_service import AudienceService
    from live.supervisor.supervisor_link import SupervisorLink

TELL_EVERY: Final = 1.0
GATEWAY, REDUCER = "gateway", "reducer"
"""Kinds."""


class GatewayStatus:
    """Reports of one show's gateways. Thread: the show's."""

    def __init__(self, audience: "AudienceService", link: "SupervisorLink") -> None:
        self._audience, self._link = audience, link
        self._tell_at = 0.0
        self._told: set[tuple[str, str]] = set()

    def frame(self, now: float) -> None:
        """Tell the supervisor, and follow its orders; called after each frame. `now` [s]."""
        while (asked := self._link.pop_request("restart")) is not None:
            self.restart(str(asked.get("kind")), str(asked.get("name")), str(asked.get("process")))
        if now >= self._tell_at:
            self._tell_at = now + TELL_EVERY
            rows = self.rows()
            self._link.channel.send_json(alive="gateways", rows=rows)
            self._tell_refused(rows)

    def _tell_refused(self, rows: list[dict[str, Any]]) -> None:
        """Tell the person of each gateway that is refused, once."""
        refused = {(row["name"], row["why"]): row for row in rows if row["state"] == "refused"}
        for (name, why), row in refused.items():
            if (name, why) not in self._told:
                where = f" of {row['machine']}" if row["machine"] else ""
                self._link.send_note(f"gateway {name}{where} is refused: {why}")
        self._told = set(refused)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for the reducer and for each gateway: kind, name, process, version, state, why, machine (empty:
        this one), clock_ms, late_ms, silent_ms, load."""
        audience = self._audience
        facts, process = audience.facts(), "" if audience.pid is None else str(audience.pid)
        late = (facts.get("late_ms") or [0.0])[-1]
        first = {
            "process": process, "version": __version__, "state": "serves" if facts.get("late_ms") else "gone",
            "why": "", "machine": "", "clock_ms": 0.0, "late_ms": late, "silent_ms": 0.0,
        }  # fmt: skip
        phones = f"phones: {audience.phones}"
        told = facts.get("gateways")
        if not audience.has_reducer:
            return [{"kind": GATEWAY, "name": "here", **first, "load": phones}]
        gateways = [self._row(row) for row in told or ()]
        serving = sum(row["state"] == "serves" for row in gateways)
        return [{"kind": REDUCER, "name": REDUCER, **first, "load": f"gateways: {serving}, {phones}"}, *gateways]

    def _row(self, row: dict[str, Any]) -> dict[str, Any]:
        name, _, process = str(row["name"]).rpartition(" ")
        load = f"{row['phones']} of {row['most']} phones" + (f", {row['lies']} lies" if row["lies"] else "")
        kept = ("version", "state", "why", "clock_ms", "late_ms", "silent_ms")
        machine = self._audience.machine_name(str(row["machine"]))
        return {"kind": GATEWAY, "name": name, "process": process, **{key: row[key] for key in kept},
                "machine": machine, "load": "" if row["state"] == "refused" else load}  # fmt: skip

    def restart(self, kind: str, name: str, process: str) -> None:
        """Let a gateway, or the reducer, start again; what is not there any more is no error."""
        audience = self._audience
        if kind == GATEWAY and audience.has_reducer:
            audience.send_order(("restart", f"{name} {process}"))
        elif process == str(audience.pid):
            audience.restart_process()
