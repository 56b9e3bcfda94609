"""Launch options of a live show: every option once, with its text, form and limits.

`live play` makes its command line from the fields (`live/cli/play.py`). This module imports no NumPy, because
the supervisor uses it.
"""

import base64
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from live.app.bridges import Bridge, installed_bridges
from live.app.option_values import (
    GATEWAYS_PORT,
    OPTION,
    Option,
    check_choice,
    option,
    parse_audience_address,
    parse_audience_link,
    parse_endpoint,
    parse_measures,
    parse_shares,
    parse_size,
    several,
    within,
    writable,
)
from live.base.errors import PersonError
from live.base.field_types import build_dataclass
from live.control.message_codec import decode_packet, encode_packet

if TYPE_CHECKING:
    from live.show.loader import LoadedShow
    from live.show.selection.show_clips import ShowTempo
    from live.show.venue.venue import Venue

MUSIC, PICTURE, RECORDING, RECOVERY = "Music and time", "Picture", "Recording", "Staying alive"
NETWORK, PROGRAMS = "Controls, pages and phones", "Other programs and devices"
"""Panels of the help text. `PROGRAMS` also holds the options of bridges."""
COMMON_OPTIONS: Final = frozenset(
    (
        *("patch", "audio", "venue", "bpm", "link", "midi", "click", "seconds", "measures"),
        *("monitor", "fullscreen", "headless", "size", "record", "journal", "osc", "web", "audience"),
    )
)
"""What `live play --help` shows; the rest is in `live play --help-all` and in `live docs play`."""
LONGEST_KEY: Final = 128
"""Most characters of a key from another machine."""


def _tls(text: str, name: str) -> tuple[Path, Path] | None:
    from live.app.services.audience_tls import parse_tls

    return parse_tls(text)


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchOptions:
    """What a show is started with. What is None here is decided by the venue, then by the patch."""

    patch: str | None = option(
        None, "A patch (TOML file or folder with show.toml). Default: the first show.", argument=True
    )
    audio: str | None = option(
        None, "An input device to listen to (see `live devices`), or a music file.", MUSIC, metavar="DEVICE|FILE"
    )
    audio_channel: str | None = option(
        None, "Which channels of the input: 3, or 5,6, or all. Default: the first two.", MUSIC, metavar="N[,N]|all"
    )
    venue: str | None = option(None, "The hall: its devices and delays (see `live calibrate`).", MUSIC, metavar="NAME")
    bpm: float | None = option(
        None, "The tempo to begin with; without --audio the internal clock keeps it.", MUSIC, parse=within(20, 400)
    )
    link: str | None = option(
        None, "Ableton Link: follow others' tempo and beat, or lead them with the show's. Default: the patch's.",
        MUSIC, metavar="follow|lead|off", parse=lambda text, name: check_choice(text, name, "follow", "lead", "off"),
    )  # fmt: skip
    midi: str | None = option(
        None, "A MIDI port to listen to (see `live devices`): clock, pedals and keys; tcp:HOST:PORT, raw:PATH "
        "and others (`live docs midi`); or off.", MUSIC, metavar="NAME",
    )  # fmt: skip
    midi_file: Path | None = option(
        None, "A MIDI file: its tempo map leads the beat, its notes move the dance and trigger what the map says.",
        MUSIC, metavar="FILE.mid",
    )  # fmt: skip
    midi_out: str | None = option(
        None, "A MIDI port that gets present values, for lights of pads and motor faders; or off.", MUSIC,
        metavar="NAME",
    )  # fmt: skip
    midi_clock_out: str | None = option(
        None, "A MIDI port that gets the show's beat as MIDI clock; or off.", MUSIC, metavar="NAME"
    )
    grid: str | None = option(
        None, "A grid controller (Launchpad, APC) with the pads of the show: its port, or auto for the first one; or "
        "off.", MUSIC, metavar="NAME",
    )  # fmt: skip
    click: str | None = option(
        None, "An output on which the players hear a click (see `live devices`).", MUSIC, metavar="DEVICE"
    )
    click_channels: str | None = option(None, "Which channels of it, from 1: 3, or 5,6.", MUSIC, metavar="N")
    seconds: float | None = option(None, "End after so many seconds.", MUSIC, parse=within(0.1, 7 * 86400))
    measures: tuple[int, int] | None = option(
        None, "Practise these measures of the score, again and again, without the patch's music.", MUSIC,
        metavar="17-24", written=str, parse=lambda text, name: parse_measures(text),
    )  # fmt: skip
    """First and last measure, from 1; None: the whole show."""
    tempo_share: float | None = option(
        None, "Practise at this share of the tempo: 0.8 is slower.", MUSIC, metavar="0.1-2", parse=within(0.1, 2.0)
    )
    """The internal clock keeps the tempo then."""
    steps: Path | None = option(
        None, "Dance the recordings of this folder (BVH files and TOML) instead of the patch's steps.",
        file_okay=False,
    )  # fmt: skip
    seed: int | None = option(None, "Seed of all random choices in the show.", min=0, max=2**31 - 1)

    monitor: str | None = option(
        None, 'Monitor by number, name or place ("right of primary").', PICTURE, metavar="N|NAME"
    )
    fullscreen: bool = option(False, "Full screen.", PICTURE, flags=("--fullscreen",))
    operator: str | None = option(
        None, "A window for the operator on this monitor: the picture with overlay and guides, which no projector "
        "shows then.", PICTURE, metavar="N|NAME",
    )  # fmt: skip
    headless: bool = option(
        False, "No window: run in real time without a picture, or --record or --share it.", PICTURE,
        flags=("--headless",),
    )  # fmt: skip
    size: tuple[int, int] = option(
        (1280, 720), "Size of the window or film.", PICTURE, metavar="WxH", written=str, default_text="1280x720",
        parse=lambda text, name: parse_size(text),
    )  # fmt: skip
    fps: float | None = option(
        None, "Default: the monitor's; 30 without a graphics card.", PICTURE, parse=within(1, 480)
    )
    shaders: Path | None = option(
        None, "For people who work on looks: draw with the shaders of this folder, and again whenever one is edited. "
        "A folder that does not exist is made, with copies of the program's own.", PICTURE, metavar="FOLDER",
        file_okay=False,
    )  # fmt: skip
    quality: int | None = option(
        None, "Hold a step of quality, 0 is the best. Default: as the machine can afford.", PICTURE,
        parse=within(0, 15),
    )  # fmt: skip
    record: Path | None = option(None, "Record the picture as an mp4.", RECORDING, metavar="FILE.mp4", parse=writable)
    share: tuple[str, ...] = option(
        (), "Share the picture with other programs: shm:NAME, or a stream like udp://127.0.0.1:5000.", RECORDING,
        metavar="shm:NAME|URL", written=list[str], parse=lambda texts, name: parse_shares(texts),
    )  # fmt: skip
    journal: Path | None = option(None, "Write the journal here, for `live replay`.", RECORDING, parse=writable)
    no_record: bool = option(
        False, "Keep nothing of people who are seen or captured: --journal and --record are refused, and what the show "
        "learns from them stays in memory.", RECORDING,
    )  # fmt: skip
    status_json: Path | None = option(None, "Write one JSON line of figures a second.", RECORDING, parse=writable)

    osc: tuple[str, int] = option(
        ("127.0.0.1", 9010), "Where OSC is received.", NETWORK, metavar="HOST:PORT", written=str,
        default_text="127.0.0.1:9010", parse=parse_endpoint,
    )  # fmt: skip
    osc_process: bool | None = option(
        None, "Receive OSC in a process of its own, so that floods cost the picture little, or in the show's. Without "
        "either: of its own, unless the whole show is one process.", NETWORK, flags=("--osc-process/--no-osc-process",),
    )  # fmt: skip
    osc_musicians: tuple[str, int] | None = option(
        None, "A separate port for musicians: what only an operator may do is refused there.", NETWORK,
        metavar="HOST:PORT", written=str, parse=parse_endpoint,
    )  # fmt: skip
    osc_out: tuple[tuple[str, int], ...] = option(
        (), "Tell programs there over OSC what happens: beat, tempo, steps, feet, places. May come several times.",
        NETWORK, metavar="HOST:PORT", **several(parse_endpoint),
    )  # fmt: skip
    web: tuple[str, int] | None = option(
        None, "Serve the operator's page for a browser: all controls and present values. Only the printed link lets "
        "in: it has the key.", NETWORK, metavar="[HOST:]PORT", written=str, parse=parse_endpoint,
    )  # fmt: skip
    web_key: str = field(default="", repr=False, metadata={OPTION: Option(
        "A key of your own for that page (16 characters or more), instead of the one that is kept. Others on this "
        "machine can read a command line: the variable is better.", NETWORK,
        written=str, details={"metavar": "KEY", "envvar": "LIVE_WEB_KEY"},
    )})  # fmt: skip
    """The same in all processes of a show."""
    web_hosts: tuple[str, ...] = option(
        (), "A name by which this machine is reached next to its addresses, for that page and OSCQuery. May come "
        "several times.", NETWORK, metavar="NAME[:PORT]", flags=("--web-host",), **several(),
    )  # fmt: skip
    phone_camera: tuple[str, int] | None = option(
        None, "Let phones and tablets be cameras: their browsers see a dancer and send her joints, no picture. Needs "
        "--web; 0.0.0.0:8443 lets in the whole network.", NETWORK, metavar="[HOST:]PORT", written=str,
        parse=parse_endpoint,
    )  # fmt: skip
    audience: tuple[str, int] | None = option(
        None, "Let the audience's phones play along, here: 127.0.0.1:8020 without a value; 0.0.0.0:8020 lets in the "
        "whole network.", NETWORK, metavar="[[HOST:]PORT]", written=str,
        parse=lambda text, name: parse_audience_address(text),
    )  # fmt: skip
    audience_link: str | None = option(
        None, "The address that phones are given, if it is another one.", NETWORK, metavar="http://HOST[:PORT]",
        parse=lambda text, name: parse_audience_link(text),
    )  # fmt: skip
    audience_tls: tuple[Path, Path] | None = option(
        None, "Serve phones over https, with this certificate and its key (PEM files, as Let's Encrypt makes them).",
        NETWORK, metavar="CERT,KEY", written=str, parse=_tls,
    )  # fmt: skip
    gateways: int = option(
        1, "Let so many processes serve the audience's phones, each on a core of its own; 0: other machines alone.",
        NETWORK, min=0, max=64, metavar="N",
    )  # fmt: skip
    gateways_listen: tuple[str, int] | None = option(
        None, f"Let gateways of paired machines join here (live gateway), usually 0.0.0.0:{GATEWAYS_PORT}.", NETWORK,
        metavar="[HOST:]PORT", written=str, parse=parse_endpoint,
    )  # fmt: skip
    audience_secret: bytes = field(default=b"", repr=False)
    """By it phones are recognised; made for each show, the same in all its processes."""

    alone: bool = option(
        False, "One process only: no supervisor, so a crash ends the show.", RECOVERY, flags=("--alone",)
    )
    lead: str | None = option(
        None, "Let machines that stand by follow this show here.", RECOVERY, metavar="[HOST:]PORT"
    )
    standby: str | None = option(
        None, "Follow the show of the machine that leads there, and take over when it falls silent.", RECOVERY,
        metavar="HOST[:PORT]",
    )  # fmt: skip
    nodes: str | None = option(
        None, "Let render nodes (`live node`) draw this show in lockstep; they connect here: the host of --lead, port "
        "9022, without a value. The show runs ahead for them, as the venue says.", RECOVERY, metavar="[[HOST:]PORT]",
    )  # fmt: skip
    service: str | None = option(
        None, "Which service this is (`live service install` writes it): a start resumes what was cut off.",
        RECOVERY, metavar="NAME",
    )  # fmt: skip

    node: str = ""
    """The render node that these options are of; empty: none."""
    bridges: Mapping[str, Any] = field(default_factory=dict)
    """Options of bridges that differ from their defaults: by the bridge's name, a value of its `options`."""

    def check_privacy(self) -> None:
        """Raise PersonError if something is to be recorded in spite of `no_record`."""
        for name, path in (("--journal", self.journal), ("--record", self.record)):
            if self.no_record and path is not None:
                raise PersonError(f"{name} {path}: --no-record keeps nothing of the show", "leave one of them out")

    @property
    def is_practice(self) -> bool:
        """Whether this is practice. The patch's own music does not play then, because it cannot follow."""
        return self.measures is not None or self.tempo_share is not None

    @property
    def film_fps(self) -> float:
        """Frames per second of a film, and of a show without a monitor."""
        return self.fps or 60.0

    def of_bridge(self, bridge: Bridge) -> Any:
        """The options of one bridge."""
        return self.bridges[bridge.name] if bridge.name in self.bridges else bridge.options()

    def read_venue(self) -> "Venue | None":
        """The venue that was named, if one was."""
        from live.show.venue.venue import read_venue

        return None if self.venue is None else read_venue(self.venue, installed_bridges().venue_tables())

    def load(self, *, whole: bool = True) -> "LoadedShow":
        """The patch and its steps, as they are played in the venue. `whole`: see `load_show`."""
        from live.show.loader import load_show
        from live.show.patch.patch_search_path import find_patch

        venue = self.read_venue()
        tables = installed_bridges().patch_tables()
        path, tempo = find_patch(self.patch), self._show_tempo()
        loaded = load_show(path, recordings=self.steps, whole=whole, tables=tables, tempo=tempo)
        return loaded if venue is None else loaded.with_projector(venue.projector)

    def _show_tempo(self) -> "ShowTempo":
        """What these options say about the tempo of the show."""
        from live.control.midi.midi_file import read_song
        from live.show.selection.show_clips import ShowTempo

        bpm = self.bpm
        if bpm is None and self.midi_file is not None and not self.is_practice:
            bpm = read_song(self.midi_file).tempo
        return ShowTempo(bpm, share=self.tempo_share or 1.0, own_music=self.audio is None)

    @property
    def keys(self) -> dict[str, str]:
        """What was made for this show and another machine has to know to serve its page and its phones."""
        return {"web_key": self.web_key, "audience_secret": self.audience_secret.hex()}

    def with_keys(self, keys: Mapping[str, str]) -> "LaunchOptions":
        """Return these options with the keys of the machine that led; ValueError if they are none."""
        if set(keys) != set(self.keys) or not all(len(text) <= LONGEST_KEY for text in keys.values()):
            raise ValueError("keys of a show expected")
        web_key, secret = keys["web_key"] or self.web_key, bytes.fromhex(keys["audience_secret"])
        return replace(self, web_key=web_key, audience_secret=secret or self.audience_secret)

    def encode(self) -> str:
        """As one word, for another process of this program."""
        return base64.b64encode(encode_packet(asdict(self))).decode()

    @classmethod
    def decode(cls, word: str) -> "LaunchOptions":
        """What `encode` made; ValueError for anything else."""
        table = decode_packet(base64.b64decode(word, validate=True))
        if not isinstance(table, dict) or not isinstance(table.get("bridges"), dict):
            raise ValueError("launch options are a table, with one of the bridges")
        kinds = {bridge.name: bridge.options for bridge in installed_bridges().bridges}
        bridges = {}
        for name, values in table.pop("bridges").items():
            kind = kinds.get(name)
            if kind is None or not isinstance(values, dict):
                raise ValueError(f"launch options: there is no bridge {name!r:.80}")
            bridges[name] = build_dataclass(kind, values)
        return replace(build_dataclass(cls, table), bridges=bridges)
