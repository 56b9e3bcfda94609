"""Parsed command line of a show, and its encoding for other processes.

The module imports no NumPy, because the supervisor uses it.
"""

import base64
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from live.base.field_types import made_of
from live.control.message_codec import packet_of, read_packet

if TYPE_CHECKING:
    from live.show.loader import LoadedShow
    from live.show.venue.venue import Venue


@dataclass(frozen=True, slots=True)
class Wish:
    """Parsed command line of a show."""

    patch: str | None = None
    audio: str | None = None
    audio_channel: str | None = None
    venue: str | None = None
    bpm: float | None = None
    link: str | None = None
    """follow, lead or off; None: as in the patch."""
    click: str | None = None
    click_channels: str | None = None
    midi: str | None = None
    midi_file: Path | None = None
    """A MIDI file whose tempo map leads the beat and whose notes act through the patch's MIDI map."""
    midi_out: str | None = None
    midi_clock_out: str | None = None
    """Ports by name, or off; None: as in the venue or the patch."""
    steps: Path | None = None
    seed: int | None = None
    measures: tuple[int, int] | None = None
    """First and last measure of the score to practise, from 1; None: the whole show."""
    tempo_share: float | None = None
    """Factor on the tempo; the internal clock then leads."""
    osc: tuple[str, int] = ("127.0.0.1", 9010)
    osc_process: bool = False
    """Whether OSC is received in a separate process."""
    osc_musicians: tuple[str, int] | None = None
    """A second OSC port, which accepts only commands that musicians may use."""
    osc_out: tuple[tuple[str, int], ...] = ()
    """Receivers of the show's OSC output; empty: those of the venue or the patch."""
    dmx: tuple[str, ...] = ()
    """DMX universes that the show controls, in the syntax of `parse_universe`."""
    vmc_out: tuple[str, ...] = ()
    """Receivers of dancers as VMC avatars, in the syntax of `parse_avatars`."""
    psn: str | None = None
    """PosiStageNet input for trackers, in the syntax of `parse_psn`; None: as in the venue."""
    vmc: tuple[tuple[str, int], ...] = ()
    """Ports for motion capture of real dancers by the VMC protocol; empty: as in the venue."""
    oscquery: tuple[str, int] | None = None
    """Address of the OSCQuery server."""
    web: tuple[str, int] | None = None
    """Address of the operator's web page."""
    web_key: str = field(default="", repr=False)
    """Access key of the web page; the same in all processes of a show."""
    web_hosts: tuple[str, ...] = ()
    """Host names of this machine besides its addresses, accepted by the web page and OSCQuery."""
    audience: tuple[str, int] | None = None
    """Address of the server for the audience's phones."""
    audience_link: str | None = None
    """Web address given to phones, if it differs from the server's own."""
    audience_tls: tuple[Path, Path] | None = None
    """Certificate and key for https to phones."""
    audience_secret: bytes = b""
    """Secret of this show, shared by its processes, by which returning phones are recognised."""
    journal: Path | None = None
    status_json: Path | None = None
    seconds: float | None = None
    record: Path | None = None
    share: tuple[str, ...] = ()
    """Where the picture is shared: shm:NAME, or stream addresses."""
    operator: str | None = None
    """The monitor of the operator's own window; None: as in the venue."""
    size: tuple[int, int] = (1280, 720)
    fps: float | None = None
    shaders: Path | None = None
    """A folder of shaders used instead of the built-in ones, and reloaded when edited."""
    quality: int | None = None
    """Fixed quality level of the picture, 0 is best; None: adaptive."""

    @property
    def practises(self) -> bool:
        """Whether this is practice; the patch's own music is then silent, as it cannot follow."""
        return self.measures is not None or self.tempo_share is not None

    @property
    def film_fps(self) -> float:
        """Frames per second of a film, and of a show without a monitor."""
        return self.fps or 60.0

    def read_venue(self) -> "Venue | None":
        """Read the venue; None if none is named."""
        from live.show.venue.venue import read_venue

        return None if self.venue is None else read_venue(self.venue)

    def load(self, *, whole: bool = True) -> "LoadedShow":
        """Load the patch and its steps, adapted to the venue. `whole`: see `load_show`."""
        from live.show.loader import load_show
        from live.show.patch.patch_search_path import find_patch

        venue = self.read_venue()
        loaded = load_show(find_patch(self.patch), recordings=self.steps, whole=whole)
        return loaded if venue is None else loaded.played_in(venue.projector)


@dataclass(frozen=True, slots=True)
class Played:
    """Launch options with display options, and their encoding for another process."""

    wish: Wish
    monitor: str | None = None
    fullscreen: bool = False
    headless: bool = False

    def packed(self) -> str:
        """Encode as one word, for the command line of another process."""
        return base64.b64encode(packet_of(asdict(self))).decode()

    @classmethod
    def unpacked(cls, word: str) -> "Played":
        """Decode the result of `packed`; raise ValueError for anything else."""
        told = read_packet(base64.b64decode(word, validate=True))
        if not isinstance(told, dict):
            raise ValueError("the launch options are not a table")
        return made_of(cls, told)
