"""Wish: what was asked for on the command line of a show. It is light to import: a supervisor needs no array."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from live.show.load import LoadedShow
    from live.show.venue import Venue


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
    midi_clock_out: str | None = None
    """Ports by name, or off; None: what the venue says, or the patch."""
    steps: Path | None = None
    seed: int | None = None
    measures: tuple[int, int] | None = None
    """First and last measure of the written score, from 1, that are practised; None: the whole show."""
    tempo_share: float | None = None
    """The tempo as a share of what it would be; the internal clock keeps it then."""
    osc: tuple[str, int] = ("127.0.0.1", 9010)
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
        from live.show.venue import read_venue

        return None if self.venue is None else read_venue(self.venue)

    def load(self) -> "LoadedShow":
        """The patch and its steps."""
        from live.show.load import load_show
        from live.show.patch_file import find_patch

        return load_show(find_patch(self.patch), recordings=self.steps)
