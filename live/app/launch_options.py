"""Wish: what was asked for on the command line of a show. It is light to import: a supervisor needs no array.

Played: how a wish is to be seen, and its way from the command line to the process that plays it.
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
    """What was asked for on the command line."""

    patch: str | None = None
    audio: str | None = None
    audio_channel: str | None = None
    venue: str | None = None
    bpm: float | None = None
    link: str | None = None
    """follow, lead or off; None: what the patch says."""
    click: str | None = None
    click_channels: str | None = None
    midi: str | None = None
    midi_file: Path | None = None
    """A MIDI file that leads the beat, and whose notes work what the map says."""
    midi_out: str | None = None
    midi_clock_out: str | None = None
    """Ports by name, or off; None: what the venue says, or the patch."""
    steps: Path | None = None
    seed: int | None = None
    measures: tuple[int, int] | None = None
    """First and last measure of the written score, from 1, that are practised; None: the whole show."""
    tempo_share: float | None = None
    """The tempo as a share of what it would be; the internal clock keeps it then."""
    osc: tuple[str, int] = ("127.0.0.1", 9010)
    osc_process: bool = False
    """Whether OSC is received in a process of its own."""
    osc_musicians: tuple[str, int] | None = None
    """A second port, where only what musicians may is taken."""
    osc_out: tuple[tuple[str, int], ...] = ()
    """Whom the show tells what happens; none: whom venue or patch name."""
    dmx: tuple[str, ...] = ()
    """Universes of lamps that follow the show, as `parse_universe` reads them."""
    vmc_out: tuple[str, ...] = ()
    """Where dancers are sent as avatars, as `parse_avatars` reads it."""
    psn: str | None = None
    """Where trackers come in by PosiStageNet, as `parse_psn` reads it; None: where the venue says."""
    vmc: tuple[tuple[str, int], ...] = ()
    """Where real dancers' bodies come in by the VMC protocol; none: where the venue says."""
    oscquery: tuple[str, int] | None = None
    """Where other programs can find out what there is to control."""
    web: tuple[str, int] | None = None
    """Where the operator's page is served."""
    web_key: str = field(default="", repr=False)
    """What whoever wants in by that page has to bring; the same in all processes of a show."""
    web_hosts: tuple[str, ...] = ()
    """Names by which this machine is reached beside its addresses, for the page and OSCQuery."""
    audience: tuple[str, int] | None = None
    """Where the audience's phones play along."""
    audience_link: str | None = None
    """How phones are told to find that, if not by its own address."""
    audience_tls: tuple[Path, Path] | None = None
    """Certificate and key by which phones are met over https."""
    audience_secret: bytes = b""
    """What only this show knows, in all its processes: by it phones are known again."""
    journal: Path | None = None
    status_json: Path | None = None
    seconds: float | None = None
    record: Path | None = None
    share: tuple[str, ...] = ()
    """Where the picture is shared: shm:NAME, or addresses of streams."""
    operator: str | None = None
    """The monitor of the operator's own window; None: as the venue says."""
    size: tuple[int, int] = (1280, 720)
    fps: float | None = None
    shaders: Path | None = None
    """A folder of shaders that are drawn with instead of the program's own, and taken anew when they are edited."""
    quality: int | None = None
    """The step of the picture's quality that is held, 0 for the best; None: as the machine can afford."""

    @property
    def practises(self) -> bool:
        """Whether this is practice: the patch's own music cannot follow then, so that it does not play."""
        return self.measures is not None or self.tempo_share is not None

    @property
    def film_fps(self) -> float:
        """Frames per second of a film, and of a show without a monitor."""
        return self.fps or 60.0

    def read_venue(self) -> "Venue | None":
        """The venue that was named, if one was."""
        from live.show.venue.venue import read_venue

        return None if self.venue is None else read_venue(self.venue)

    def load(self, *, whole: bool = True) -> "LoadedShow":
        """The patch and its steps, as they are played in the venue. `whole`: see `load_show`."""
        from live.show.loader import load_show
        from live.show.patch.patch_search_path import find_patch

        venue = self.read_venue()
        loaded = load_show(find_patch(self.patch), recordings=self.steps, whole=whole)
        return loaded if venue is None else loaded.played_in(venue.projector)


@dataclass(frozen=True, slots=True)
class Played:
    """A wish and where its picture is shown."""

    wish: Wish
    monitor: str | None = None
    fullscreen: bool = False
    headless: bool = False

    def packed(self) -> str:
        """As one word, for another process of this program."""
        return base64.b64encode(packet_of(asdict(self))).decode()

    @classmethod
    def unpacked(cls, word: str) -> "Played":
        """What `packed` made; ValueError for anything else."""
        told = read_packet(base64.b64decode(word, validate=True))
        if not isinstance(told, dict):
            raise ValueError("what is to be played is no table")
        return made_of(cls, told)
