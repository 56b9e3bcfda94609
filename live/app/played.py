"""Played: how a wish is to be seen, and its way from the command line to the process that plays it."""

import base64
from dataclasses import asdict, dataclass

from live.app.wish import Wish
from live.base.field_types import made_of
from live.control.message_codec import packet_of, read_packet


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
