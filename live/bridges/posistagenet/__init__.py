"""Bridge to tracking systems: positions by PosiStageNet, by `--psn` and `[psn]` of the venue."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from live.app.bridges import Bridge, ServiceContext
from live.app.option_values import option
from live.app.services.service import Service

if TYPE_CHECKING:
    from live.bridges.posistagenet.psn_service import PsnTables


@dataclass(frozen=True, slots=True, kw_only=True)
class PsnOptions:
    """Launch options of the trackers."""

    psn: str | None = option(
        None, "Listen there for trackers by PosiStageNet, usually 236.10.10.10:56565; ADDRESS: of the network card.",
        metavar="[GROUP:]PORT[@ADDRESS]",
    )  # fmt: skip


def venue_tables() -> "type[PsnTables]":
    """`[psn]` of a venue."""
    from live.bridges.posistagenet.psn_service import PsnTables

    return PsnTables


def services(context: ServiceContext[PsnOptions]) -> Mapping[str, Service]:
    """The input for `--psn` or the venue's trackers."""
    from live.bridges.posistagenet.psn_service import PsnService, PsnTables, parse_psn

    named = None if context.venue is None else context.venue.read_tables(PsnTables).psn.at
    if context.options.psn is not None:
        wanted = parse_psn(context.options.psn)
    elif named is not None:
        wanted = parse_psn(named, "[psn] at")
    else:
        return {}
    return {"psn": PsnService(*wanted, context.add_queue(), context.clock)}


BRIDGE = Bridge(name="posistagenet", options=PsnOptions, venue_tables=venue_tables, services=services)
