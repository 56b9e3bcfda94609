"""The part of a live show that other programs find by themselves: OSCQuery over HTTP, and zeroconf."""

from collections.abc import Sequence

from live.app.services.http_part import HttpPart
from live.clock.time_source import Clock


class OscQueryPart(HttpPart):
    """Between the show and the process that answers OSCQuery."""

    def __init__(
        self, where: tuple[str, int], osc: tuple[str, int], name: str, clock: Clock, *, hosts: Sequence[str] = ()
    ) -> None:
        """`osc`: where the show listens; `hosts`: see `accepted_hosts`."""
        super().__init__(
            where, "--oscquery", "live.control.osc.oscquery_server",
            lambda: {"osc": osc, "name": name, "hosts": list(hosts)}, clock, needs=("aiohttp", "zeroconf"),
        )  # fmt: skip
