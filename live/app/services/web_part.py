"""The part of a live show that its operator opens in a browser."""

from collections.abc import Sequence
from typing import Any

from rich.console import Console

from live.app.services.http_part import HttpPart
from live.app.services.own_address import own_address
from live.clock.time_source import Clock
from live.show.core import Show
from live.show.desk.completions import names_in


class WebPart(HttpPart):
    """Between the show and the process that serves the operator's page."""

    def __init__(
        self, where: tuple[str, int], key: str, osc: tuple[str, int], show: Show, clock: Clock, *,
        hosts: Sequence[str] = (),
    ) -> None:  # fmt: skip
        """`key`: without it nobody gets in; `osc`: where the show itself listens; `hosts`: see `accepted_hosts`."""
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(osc[0], osc[0])

        def plan() -> dict[str, Any]:
            stage = show.patch.stage
            return {
                "key": key, "osc": (host, osc[1]), "name": show.patch.name, "names": names_in(show),
                "half": (0.5 * stage.width, 0.5 * stage.depth), "hosts": list(hosts),
            }  # fmt: skip

        super().__init__(where, "--web", "live.control.web.web_server", plan, clock)
        self._key = key

    def start(self) -> None:
        """Listen, begin to answer, and say where; PersonError if that cannot be."""
        super().start()
        link = f"http://{_reached_at(self._where[0])}:{self.port}/#key={self._key}"
        Console(stderr=True, highlight=False).print(f"operator's page: {link}", soft_wrap=True, markup=False)


def _reached_at(host: str) -> str:
    """The address that somebody else would write for a host that means all of this machine's."""
    if host not in ("0.0.0.0", "::"):
        return f"[{host}]" if ":" in host else host
    return own_address()
