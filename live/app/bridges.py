"""Bridges: optional inputs and outputs of a show, each a package of its own that the program finds when it starts.

A bridge is found by an entry point of the group `live.bridges`, or as a package in `live/bridges`. Nothing imports a
bridge by name. This module imports no NumPy, because the supervisor uses it.
"""

import importlib
import importlib.metadata
import importlib.util
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Generic, TypeAlias, TypeVar

from live.app.services.service import Service

if TYPE_CHECKING:
    from typer import Typer

    from live.base.event_queue import PriorityQueue
    from live.clock.midi.midi_clock import MessageClock
    from live.clock.time_source import Clock
    from live.control.camera.phone_landmarks import PhoneCameras
    from live.control.events.events import ControlEvent
    from live.control.midi.midi_streams import Opener
    from live.show.engine import Engine
    from live.show.loader import LoadedShow
    from live.show.patch.patch import Patch
    from live.show.patch.section_base import Section
    from live.show.venue.venue import Venue

GROUP: Final = "live.bridges"
"""Group of the entry points, and the package of the program's own bridges."""
ATTRIBUTE: Final = "BRIDGE"
"""Name of a bridge's value in its package."""

UNREAD: Final = "no installed bridge reads this table; the show plays without it"
GONE: Final = "its package is gone"
"""Why a bridge is left out that the metadata still names."""

Options = TypeVar("Options")
Command: TypeAlias = "Callable[..., None] | Typer"
"""A command of the command line, as typer takes it, or a group of them."""


@dataclass(frozen=True, slots=True, eq=False)
class ServiceContext(Generic[Options]):
    """What the services of a bridge are made from."""

    options: Options
    """The bridge's own launch options."""
    engine: "Engine"
    """The frame loop, with the show and its latest view."""
    venue: "Venue | None"
    clock: "Clock"
    add_queue: Callable[[], "PriorityQueue[ControlEvent]"]
    """Makes a lane of the event queue for one sender."""
    osc: tuple[str, int]
    """Host and port where the show receives OSC."""
    host_names: tuple[str, ...]
    """Host names of this machine besides its addresses."""
    resumes: bool
    """Whether the show is resumed after an engine that may still hold ports."""
    notices: "list[Callable[[], str]]" = field(default_factory=list)
    """Lines of the operator's overlay: each returns one, or an empty string."""
    phones: "PhoneCameras | None" = None
    """The phones that are cameras of this show; None if there is no page for them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NoOptions:
    """Launch options of a bridge that has none."""


def no_services(context: ServiceContext[Any]) -> Mapping[str, Service]:
    """Services of a bridge that has none."""
    return {}


def no_clocks(patch: "Patch", beats_per_measure: int) -> "Mapping[str, MessageClock]":
    """Clocks of a bridge that makes none."""
    return {}


@dataclass(frozen=True, slots=True, kw_only=True)
class Bridge:
    """An optional input or output. Its functions import what is heavy themselves."""

    name: str
    options: type[Any] = NoOptions
    """A frozen dataclass whose fields are made by `option_values.option`; without arguments it has the defaults."""
    patch_tables: "Callable[[], type[Section]] | None" = None
    """Returns a section whose fields are the tables that the bridge adds to a patch; each has a default."""
    venue_tables: "Callable[[], type[Section]] | None" = None
    """The same for a venue."""
    services: Callable[[ServiceContext[Any]], Mapping[str, Service]] = no_services
    """Makes its services, not started, by their names in the status; PersonError if that is not possible."""
    midi_schemes: "Callable[[], Mapping[str, Opener]]" = dict
    """Returns the openers of MIDI ports that it adds, by the scheme of their names."""
    midi_clocks: "Callable[[Patch, int], Mapping[str, MessageClock]]" = no_clocks
    """Makes the clocks of one MIDI input for a patch and its beats per measure, by the clock source that each is."""
    commands: "Callable[[], Mapping[str, Command]]" = dict
    """Returns the commands that it adds to the command line."""
    calibrations: "Callable[[], Mapping[str, Command]]" = dict
    """Returns the commands that it adds below `live calibrate`."""


@dataclass(frozen=True, slots=True)
class InstalledBridges:
    """The bridges of this program, in the order of their names, and why others were left out."""

    bridges: tuple[Bridge, ...]
    left_out: Mapping[str, str]
    """By name, the reason in words."""

    def patch_tables(self) -> tuple["type[Section]", ...]:
        """Return the sections whose fields are the tables that bridges add to a patch."""
        return tuple(bridge.patch_tables() for bridge in self.bridges if bridge.patch_tables is not None)

    def venue_tables(self) -> tuple["type[Section]", ...]:
        """Return the sections whose fields are the tables that bridges add to a venue."""
        return tuple(bridge.venue_tables() for bridge in self.bridges if bridge.venue_tables is not None)

    def midi_schemes(self) -> "Mapping[str, Opener]":
        """Return the openers of MIDI ports that bridges add, by the scheme of the ports' names."""
        return {scheme: opener for bridge in self.bridges for scheme, opener in bridge.midi_schemes().items()}

    def midi_clocks(self, patch: "Patch", beats_per_measure: int) -> "Mapping[str, MessageClock]":
        """Make the clocks that bridges make of one MIDI input's messages, by the clock source that each is."""
        made = (bridge.midi_clocks(patch, beats_per_measure) for bridge in self.bridges)
        return {source: clock for clocks in made for source, clock in clocks.items()}

    def notes(self, loaded: "LoadedShow", venue: "Venue | None") -> list[str]:
        """Return a line for each bridge that fails, and for each table of patch or venue that no bridge reads."""
        failed = [f"bridge {name} is left out: {why}" for name, why in self.left_out.items() if why != GONE]
        unread = [loaded.place_text((name,)) for name in loaded.patch.unread_tables(self.patch_tables())]
        if venue is not None:
            unread += [f"venue {venue.name}: {name}" for name in venue.unread_tables(self.venue_tables())]
        return failed + [f"{place}: {UNREAD}" for place in unread]

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        return {"installed": [bridge.name for bridge in self.bridges], "left_out": dict(self.left_out)}


@cache
def installed_bridges() -> InstalledBridges:
    """Find and import the bridges: those of entry points, and those in `live/bridges` if the metadata is older.

    A bridge whose package is gone, or fails, is left out: a show plays without it.
    """
    found: dict[str, Bridge] = {}
    left_out: dict[str, str] = {}
    taken: dict[str, str] = {}
    for name, module in sorted(_modules().items()):
        try:
            bridge = getattr(importlib.import_module(module), ATTRIBUTE)
            if not isinstance(bridge, Bridge):
                raise TypeError(f"{module}.{ATTRIBUTE} is no bridge")
            for option in fields(bridge.options):
                if option.name in taken:
                    raise ValueError(f"bridge {taken[option.name]} has an option {option.name}, too")
        except Exception as error:  # the package may be another author's
            gone = isinstance(error, ModuleNotFoundError) and error.name is not None and module.startswith(error.name)
            left_out[name] = GONE if gone else f"{type(error).__name__}: {error}"
        else:
            found[name] = bridge
            taken |= {option.name: name for option in fields(bridge.options)}
    return InstalledBridges(tuple(found.values()), left_out)


def _modules() -> dict[str, str]:
    """Return the packages of all bridges by their names."""
    spec = importlib.util.find_spec(GROUP)
    paths = None if spec is None else spec.submodule_search_locations
    found = {each.name: f"{GROUP}.{each.name}" for each in pkgutil.iter_modules(paths or []) if each.ispkg}
    entries = importlib.metadata.entry_points(group=GROUP)
    return {each.name: each.module for each in entries} | found
