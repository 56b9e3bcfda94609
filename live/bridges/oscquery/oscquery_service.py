"""Service for OSCQuery: runs the process that answers other programs."""

from collections.abc import Sequence

from live.app.services.http_services import HttpService
from live.clock.time_source import Clock


class OscQueryService(HttpService):
    """Runs the process that answers OSCQuery."""

    def __init__(
        self, where: tuple[str, int], osc: tuple[str, int], name: str, clock: Clock, *, hosts: Sequence[str] = ()
    ) -> None:
        """`osc`: the show's OSC address; `hosts`: see `http_protection.accepted_hosts`."""
        super().__init__(
            where, "--oscquery", "live.bridges.oscquery.oscquery_server",
            lambda: {"osc": osc, "name": name, "hosts": list(hosts)}, clock, needs=("aiohttp", "zeroconf"),
        )  # fmt: skip
