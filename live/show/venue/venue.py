"""Venue: what is true of a hall and not of a show: its sound devices and how long sound and pictures take there.

What was measured, brought into the text of a venue's file so that all that a person wrote in it stays as it is.

Latencies: the delays of a venue as the running show uses them, changed by hand while it runs.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final

import tomlkit
from pydantic import Field, field_validator
from tomlkit.exceptions import TOMLKitError

from live.base.errors import PersonError
from live.base.host_name import HOST_NAME
from live.clock.ticks import TICK
from live.show.patch.patch_reader import parse_model, read_text
from live.show.patch.patch_search_path import PATCHES, is_file, user_settings
from live.show.patch.section_base import Name, Section
from live.show.patch.section_io import Endpoints, Targets
from live.show.venue.venue_audience import VenueAudience
from live.show.venue.venue_output import MOST_OUTPUTS, VenueOutput, VenueProjector, check_outputs

Sooner = Annotated[float, Field(ge=-500, le=500, allow_inf_nan=False)]
Later = Annotated[float, Field(ge=0, le=500, allow_inf_nan=False)]
Numbers = Annotated[list[Annotated[int, Field(ge=1, le=128)]], Field(min_length=1, max_length=128)]
Spread = Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)]


class VenueAudio(Section):
    """`[audio]`: which devices are used where the command line names none."""

    device: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The input that is listened to, by its name or a part of it."""
    channels: Numbers | None = None
    """Which of its channels, from 1; the first two if left out."""
    output: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The output that music is played to."""
    click: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The output on which the players hear a click."""
    click_channels: Numbers | None = None
    """Which of its channels, from 1; the first two if left out."""


class VenueLatency(Section):
    """`[latency]`: how long things take; `live calibrate` measures them."""

    input_ms: Sooner = 0.0
    """From the sound that is heard to its samples here."""
    output_ms: Sooner | None = None
    """From samples handed over here to the sound that is heard; what the device says if left out."""
    display_ms: Later = TICK * 1000.0
    """From a picture drawn here to the display; a frame of 60 Hz if left out."""
    projector_ms: Later = 0.0
    """What the projector, and all that lies between, takes longer."""
    click_ms: Sooner = 0.0
    """How much later the click is heard than its device says."""
    round_trip_ms: Sooner | None = None
    """What was measured last from output to input; for the record."""
    round_trip_spread_ms: Spread | None = None
    """How far single measurements differed."""
    claps_spread_ms: Spread | None = None
    """How far single claps differed, when the picture was measured."""


class VenueMidi(Section):
    """`[midi]`: which ports are used where the command line names none."""

    input: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The port that is listened to, by its name or a part of it."""
    output: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The port that is told present values: the lights of pads, motor faders."""
    clock_out: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The port that the show's beat is sent to as MIDI clock."""


class VenueOsc(Section):
    """`[osc]`: whom the show tells what happens, where the command line names nobody."""

    out: Targets = ()
    """Addresses like `192.168.1.20:57120`."""


class VenueVmc(Section):
    """`[vmc]`: where real dancers' bodies are listened for, where the command line says nothing."""

    at: Endpoints = ()
    """Ports like `39539`, or with the address of this machine as in `0.0.0.0:39539`."""


class VenuePsn(Section):
    """`[psn]`: where trackers are listened for, where the command line says nothing."""

    at: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """As in `236.10.10.10:56565`, or with the address of the network card, `236.10.10.10:56565@192.168.1.5`."""


Host = Annotated[str, Field(pattern=HOST_NAME)]


class VenueWeb(Section):
    """`[web]`: of the operator's page and of OSCQuery."""

    hosts: Annotated[tuple[Host, ...], Field(max_length=16)] = ()
    """Names by which this machine is reached beside its addresses, as in `show.example` or `show.example:443`."""


class Venue(Section):
    """A hall."""

    name: Name = "venue"
    """What it is called."""
    audio: VenueAudio = VenueAudio()
    midi: VenueMidi = VenueMidi()
    osc: VenueOsc = VenueOsc()
    vmc: VenueVmc = VenueVmc()
    psn: VenuePsn = VenuePsn()
    web: VenueWeb = VenueWeb()
    audience: VenueAudience = VenueAudience()
    latency: VenueLatency = VenueLatency()
    projector: VenueProjector | None = None
    """Where its projector stands, and where its picture has the corners of the floor."""
    output: Annotated[tuple[VenueOutput, ...], Field(max_length=MOST_OUTPUTS)] = ()
    """Its projectors; without any the picture fills one window."""
    operator: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """The monitor of the operator's own window, as `--operator` names it."""

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


def user_venues() -> Path:
    """The user's own folder of venues."""
    return user_settings() / "venues"


VENUES: Final = PATCHES / "venues"
"""The project's own venues."""


def venue_path(name: str) -> Path:
    """The file of a venue: the user's own, else the project's, else where the user's own would be.

    PersonError for a name that no venue can have: venues are never looked up elsewhere, least of all in a show.
    """
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", name):
        raise PersonError(
            f"--venue {name[:80]!r}: a name of letters, digits, - and _ expected, not a file", "--venue hall"
        )
    own = user_venues() / f"{name}.toml"
    return own if is_file(own) or not is_file(VENUES / own.name) else VENUES / own.name


def known_venues() -> list[str]:
    """The names of all venues there are."""
    return sorted({path.stem for folder in (user_venues(), VENUES) for path in folder.glob("*.toml")})


def read_venue(name: str) -> Venue:
    """The venue of that name; PersonError if there is none, or for what is wrong in its file."""
    path = venue_path(name)
    if not is_file(path):
        known = ", ".join(known_venues()) or "none yet"
        raise PersonError(f"there is no venue {name!r}", f"live calibrate --venue {name} makes it; there are: {known}")
    return parse_model(read_text(path, "venue"), str(path), Venue, "venue")


HEAD = "# A venue: what is true of the hall and not of the show.\n\n"


def with_values(text: str, name: str, values: Mapping[str, Mapping[str, object]], comment: str) -> str:
    """The TOML `text` (empty for a new file) with `values` by table and key; comments and all else are kept.

    `comment` stands behind each of the lines that are new or changed.
    """
    document = tomlkit.parse(text or f"{HEAD}name = {tomlkit.item(name).as_string()}\n")
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


def changed_venue(path: Path, name: str, values: Mapping[str, Mapping[str, object]], comment: str) -> str:
    """The text that the venue's file gets; PersonError if what is there is wrong."""
    before = read_text(path, "venue") if is_file(path) else ""
    parse_model(before, str(path), Venue, "venue")
    try:
        text = with_values(before, name, values, comment)
    except TOMLKitError as error:
        raise PersonError(f"{path}: {error}", "write the measured values into it yourself") from None
    parse_model(text, str(path), Venue, "venue")
    return text


@dataclass(slots=True)
class Latencies:
    """Delays [s]. Thread: the show's; single values may be read from any."""

    input: float = 0.0
    """From the sound that is heard to its samples here."""
    output: float | None = None
    """From samples handed over to the sound that is heard; None: as the device says."""
    display: float = TICK
    """From a picture drawn to the display."""
    projector: float = 0.0

    @classmethod
    def of(cls, venue: Venue | None) -> "Latencies":
        """Those of a venue; the usual ones without."""
        if venue is None:
            return cls()
        one = venue.latency
        return cls(
            one.input_ms / 1000.0,
            None if one.output_ms is None else one.output_ms / 1000.0,
            one.display_ms / 1000.0,
            one.projector_ms / 1000.0,
        )

    @property
    def lead(self) -> float:
        """How far ahead of the clock a picture must be when it is drawn [s]: it is seen so much later."""
        return self.display + self.projector

    def set(self, what: str, seconds: float) -> None:
        """Change one by its name; names there are not are left alone (replays of other versions)."""
        if what in ("input", "output", "display", "projector"):
            setattr(self, what, seconds)

    def facts(self) -> dict[str, float | None]:
        """In milliseconds, for the status."""
        names = ("input", "output", "display", "projector", "lead")
        values = {name: getattr(self, name) for name in names}
        return {f"{name}_ms": None if value is None else round(1000.0 * value, 2) for name, value in values.items()}
