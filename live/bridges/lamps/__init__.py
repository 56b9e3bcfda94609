"""Bridge to the hall's lamps: DMX over sACN or Art-Net, by `--dmx` and `[[dmx]]`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from live.app.bridges import Bridge, ServiceContext
from live.app.option_values import option, several
from live.app.services.service import Service

if TYPE_CHECKING:
    from live.bridges.lamps.dmx_section import DmxTables


@dataclass(frozen=True, slots=True, kw_only=True)
class LampOptions:
    """Launch options of the lamps."""

    dmx: tuple[str, ...] = option(
        (), "Let the hall's lamps follow the show: channels as [[dmx]] says. May come several times.",
        metavar="sacn:UNIVERSE[@HOST]|artnet:UNIVERSE@HOST", **several(),
    )  # fmt: skip


def patch_tables() -> "type[DmxTables]":
    """`[[dmx]]`."""
    from live.bridges.lamps.dmx_section import DmxTables

    return DmxTables


def services(context: ServiceContext[LampOptions]) -> Mapping[str, Service]:
    """The output for `--dmx`."""
    from live.bridges.lamps.dmx_service import DmxService, parse_universe

    universes = tuple(map(parse_universe, context.options.dmx))
    return {"dmx": DmxService(context.engine, universes, context.clock)} if universes else {}


BRIDGE = Bridge(name="lamps", options=LampOptions, patch_tables=patch_tables, services=services)
