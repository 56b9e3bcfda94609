"""Venue files: the devices and delays of a hall, independent of a show; also their update with measured values."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

import tomlkit
from pydantic import Field, field_validator
from tomlkit.exceptions import TOMLKitError

from live.base.errors import PersonError
from live.base.field_types import HOST_NAME_PATTERN
from live.clock.ticks import TICK
from live.render.outputs.output import MAX_PICTURE_SIDE
from live.show.patch.patch_search_path import PATCHES, is_file, user_settings_folder
from live.show.patch.section_base import Name, Section, WholeFile
from live.show.patch.section_io import Targets
from live.show.patch.toml_model import BridgeTables, parse_model, read_text
from live.show.venue.venue_audience import VenueAudience
from live.show.venue.venue_output import MAX_OUTPUTS, VenueOutput, VenueProjector, check_outputs

SignedDelay = Annotated[float, Field(ge=-500, le=500, allow_inf_nan=False)]
Delay = Annotated[float, Field(ge=0, le=500, allow_inf_nan=False)]
Numbers = Annotated[list[Annotated[int, Field(ge=1, le=128)]], Field(min_length=1, max_length=128)]
Spread = Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)]


class VenueAudio(Section):
    """`[audio]`: default audio devices, if the command line names none."""

    device: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The input device, by its name or a part of it."""
    channels: Numbers | None = None
    """Its channels, from 1; default: the first two."""
    output: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The output device for music."""
    click: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The output device for the musicians' click track."""
    click_channels: Numbers | None = None
    """Its channels, from 1; default: the first two."""


class VenueLatency(Section):
    """`[latency]`: delays in the hall; `live calibrate` measures them."""

    input_ms: SignedDelay = 0.0
    """From a sound in the hall to its samples in the program."""
    output_ms: SignedDelay | None = None
    """From samples in the program to the sound in the hall; default: the value reported by the device."""
    display_ms: Delay = TICK * 1000.0
    """From drawing to the display; default: one frame at 60 Hz."""
    projector_ms: Delay = 0.0
    """Additional delay of the projector and the devices before it."""
    click_ms: SignedDelay = 0.0
    """Additional delay of the click, beyond the value reported by its device."""
    round_trip_ms: SignedDelay | None = None
    """The last measured delay from output to input; for information."""
    round_trip_spread_ms: Spread | None = None
    """Spread of the single measurements."""
    claps_spread_ms: Spread | None = None
    """Spread of the single claps when the picture was measured."""


class VenueMidi(Section):
    """`[midi]`: default MIDI ports, if the command line names none."""

    input: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The input port, by its name or a part of it."""
    output: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The port for feedback of current values: pad lights, motor faders."""
    clock_out: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The port for MIDI clock, sent at the show's beat."""
    grid: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The port of a grid controller with the show's pads, or `auto` for the first one that is connected."""


class VenueOsc(Section):
    """`[osc]`: default receivers of outgoing OSC, if the command line names none."""

    out: Targets = ()
    """Addresses like `192.168.1.20:57120`."""


class VenueNodes(Section):
    """`[nodes]`: render nodes, which draw the outputs that name them (`live node`)."""

    ahead_ms: Annotated[float, Field(ge=10, le=500, allow_inf_nan=False)] = 80.0
    """How far the show runs ahead of its pictures, so that its lines reach every node in time; it adds to what a press
    of a key takes to be seen. Wired networks need 40, those that lose packets 80 or more."""


PictureSide = Annotated[int, Field(ge=16, le=MAX_PICTURE_SIDE)]
Host = Annotated[str, Field(pattern=HOST_NAME_PATTERN)]


class VenueWeb(Section):
    """`[web]`: settings of the operator's page and of OSCQuery."""

    hosts: Annotated[tuple[Host, ...], Field(max_length=16)] = ()
    """Host names of this machine in addition to its addresses, such as `show.example` or `show.example:443`."""


class Venue(WholeFile):
    """Settings of a hall."""

    name: Name = "venue"
    """Name of the venue."""
    audio: VenueAudio = VenueAudio()
    midi: VenueMidi = VenueMidi()
    osc: VenueOsc = VenueOsc()
    web: VenueWeb = VenueWeb()
    audience: VenueAudience = VenueAudience()
    latency: VenueLatency = VenueLatency()
    nodes: VenueNodes = VenueNodes()
    projector: VenueProjector | None = None
    """Position of the projector, and the floor's corners in its picture."""
    output: Annotated[tuple[VenueOutput, ...], Field(max_length=MAX_OUTPUTS)] = ()
    """Its projectors; without any the picture fills one window."""
    picture_size: tuple[PictureSide, PictureSide] | None = None
    """Width and height of the whole picture [pixels], which may be larger than a graphics card can draw at once: each
    machine draws the part that its outputs show. Left out: so that no output has to enlarge its part."""
    operator: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The monitor of the operator's window, in the form of `--operator`."""

    @field_validator("output")
    @classmethod
    def _by_name(cls, output: tuple[VenueOutput, ...]) -> tuple[VenueOutput, ...]:
        check_outputs(output)
        return output

    @field_validator("name")
    @classmethod
    def _printable(cls, name: str) -> str:
        if not name.isprintable():
            raise ValueError("printable characters expected")
        return name


def user_venue_folder() -> Path:
    """Return the user's folder of venues."""
    return user_settings_folder() / "venues"


VENUES: Final = PATCHES / "venues"
"""The project's folder of venues."""


def venue_path(name: str) -> Path:
    """Return the file of a venue: the user's, else the project's, else the path for a new one of the user's.

    PersonError for an invalid name: venues are never looked up outside these folders, least of all in a show.
    """
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", name):
        raise PersonError(
            f"--venue {name[:80]!r}: a name of letters, digits, - and _ expected, not a file", "--venue hall"
        )
    own = user_venue_folder() / f"{name}.toml"
    return own if is_file(own) or not is_file(VENUES / own.name) else VENUES / own.name


def known_venues() -> list[str]:
    """Return the names of all venues."""
    return sorted({path.stem for folder in (user_venue_folder(), VENUES) for path in folder.glob("*.toml")})


def read_venue(name: str, tables: BridgeTables = ()) -> Venue:
    """Read a venue by name, with the bridges' tables; PersonError if it does not exist or its file is invalid."""
    path = venue_path(name)
    if not is_file(path):
        known = ", ".join(known_venues()) or "none yet"
        raise PersonError(
            f"there is no venue {name!r}", f"create it with live calibrate --venue {name}; there are: {known}"
        )
    return parse_model(read_text(path, "venue"), str(path), Venue, "venue", tables=tables)


FILE_HEADER = "# A venue: what is true of the hall and not of the show.\n\n"


def update_toml(text: str, name: str, values: Mapping[str, Mapping[str, object]], comment: str) -> str:
    """Return the TOML `text` (empty for a new file) with `values` by table and key; all else is kept, with comments.

    `comment` is appended to each new or changed line.
    """
    document = tomlkit.parse(text or f"{FILE_HEADER}name = {tomlkit.item(name).as_string()}\n")
    for table, keys in values.items():
        if table not in document:
            document[table] = tomlkit.table()
        section = document[table]
        for key, value in keys.items():
            if section.get(key) == value:
                continue
            section[key] = value
            section[key].comment(comment)
    return tomlkit.dumps(document)


def updated_venue_text(path: Path, name: str, values: Mapping[str, Mapping[str, object]], comment: str) -> str:
    """Return the new text of a venue's file; PersonError if the present text is invalid."""
    before = read_text(path, "venue") if is_file(path) else ""
    parse_model(before, str(path), Venue, "venue")
    try:
        text = update_toml(before, name, values, comment)
    except TOMLKitError as error:
        raise PersonError(f"{path}: {error}", "write the measured values into it yourself") from None
    parse_model(text, str(path), Venue, "venue")
    return text


@dataclass(slots=True)
class Latencies:
    """Current delays [s], adjustable during the show. Thread: the show's; single values may be read from any."""

    input: float = 0.0
    """From a sound in the hall to its samples in the program."""
    output: float | None = None
    """From samples in the program to the sound in the hall; None: the value reported by the device."""
    display: float = TICK
    """From drawing to the display."""
    projector: float = 0.0
    nodes: float = 0.0
    """How far the show runs ahead for its render nodes."""

    @classmethod
    def of(cls, venue: Venue | None, *, nodes: bool = False) -> "Latencies":
        """Return the delays of a venue; the defaults without one. `nodes`: the show has render nodes."""
        one = VenueLatency() if venue is None else venue.latency
        ahead = VenueNodes() if venue is None else venue.nodes
        return cls(
            one.input_ms / 1000.0,
            None if one.output_ms is None else one.output_ms / 1000.0,
            one.display_ms / 1000.0,
            one.projector_ms / 1000.0,
            ahead.ahead_ms / 1000.0 if nodes else 0.0,
        )

    @property
    def lead(self) -> float:
        """Total picture delay [s]: a frame must be drawn for this much later than the clock."""
        return self.display + self.projector + self.nodes

    def set(self, what: str, seconds: float) -> None:
        """Change one delay by name; unknown names are ignored (replays of other versions)."""
        if what in ("input", "output", "display", "projector"):
            setattr(self, what, seconds)

    def facts(self) -> dict[str, float | None]:
        """Return the delays in milliseconds, for the status."""
        names = ("input", "output", "display", "projector", "lead")
        values = {name: getattr(self, name) for name in names}
        return {f"{name}_ms": None if value is None else round(1000.0 * value, 2) for name, value in values.items()}
