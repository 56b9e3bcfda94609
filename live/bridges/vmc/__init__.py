"""Bridge to motion capture and avatars by VMC: `--vmc`, `--vmc-out`, `[vmc]` of the venue, `live mocap send`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from live.app.bridges import Bridge, Command, ServiceContext
from live.app.option_values import add_default_port, option, parse_endpoint, several
from live.app.services.service import Service

if TYPE_CHECKING:
    from live.bridges.vmc.vmc_service import VmcTables

VMC_PORT: Final = 39539


def parse_port(text: str, name: str) -> tuple[str, int]:
    """Parse [HOST:]PORT or HOST; raise PersonError for anything else."""
    return parse_endpoint(add_default_port(text, VMC_PORT), name)


@dataclass(frozen=True, slots=True, kw_only=True)
class VmcOptions:
    """Launch options of input and output."""

    vmc_out: tuple[str, ...] = option(
        (), "Send dancers to other programs as avatars by the VMC protocol: the first, or those that WHO names, each "
        "to the next port. May come several times.", metavar="HOST:PORT[=WHO][@RATE]", **several(),
    )  # fmt: skip
    vmc: tuple[tuple[str, int], ...] = option(
        (), "Listen there for a real dancer's body by the VMC protocol (usually 39539). May come several times.",
        metavar="[HOST:]PORT|HOST", **several(parse_port),
    )  # fmt: skip


def venue_tables() -> "type[VmcTables]":
    """`[vmc]` of a venue."""
    from live.bridges.vmc.vmc_service import VmcTables

    return VmcTables


def services(context: ServiceContext[VmcOptions]) -> Mapping[str, Service]:
    """The input for `--vmc` or the venue's ports, and the output for `--vmc-out`."""
    from live.bridges.vmc.vmc_output_service import VmcOutputService, parse_avatars
    from live.bridges.vmc.vmc_service import VmcService, VmcTables

    found: dict[str, Service] = {}
    named = () if context.venue is None else context.venue.read_tables(VmcTables).vmc.at
    endpoints = context.options.vmc or tuple(parse_port(each, "[vmc] at") for each in named)
    if endpoints:
        found["vmc"] = VmcService(endpoints, context.engine.show, context.add_queue(), context.clock)
    avatars = tuple(map(parse_avatars, context.options.vmc_out))
    if avatars:
        found["vmc_out"] = VmcOutputService(context.engine, avatars, context.clock)
    return found


def commands() -> Mapping[str, Command]:
    """`live mocap send`."""
    from live.bridges.vmc.mocap_command import app

    return {"mocap": app}


BRIDGE = Bridge(name="vmc", options=VmcOptions, venue_tables=venue_tables, services=services, commands=commands)
