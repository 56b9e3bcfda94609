"""Bridge to programs that look for a show: OSCQuery over HTTP and zeroconf, by `--oscquery`."""

from collections.abc import Mapping
from dataclasses import dataclass

from live.app.bridges import Bridge, ServiceContext
from live.app.option_values import option, parse_endpoint
from live.app.services.service import Service


@dataclass(frozen=True, slots=True, kw_only=True)
class OscQueryOptions:
    """Launch options of OSCQuery."""

    oscquery: tuple[str, int] | None = option(
        None, "Be found by ossia score, Chataigne, TouchOSC and others: OSCQuery over HTTP, and zeroconf.",
        metavar="HOST:PORT", written=str, parse=parse_endpoint,
    )  # fmt: skip


def services(context: ServiceContext[OscQueryOptions]) -> Mapping[str, Service]:
    """The server for `--oscquery`."""
    if context.options.oscquery is None:
        return {}
    from live.bridges.oscquery.oscquery_service import OscQueryService

    name = f"Live {context.engine.show.patch.name}"
    service = OscQueryService(context.options.oscquery, context.osc, name, context.clock, hosts=context.host_names)
    service.resumes = context.resumes
    return {"oscquery": service}


BRIDGE = Bridge(name="oscquery", options=OscQueryOptions, services=services)
