"""Played: how a wish is to be seen, and its way from the command line to the process that plays it."""

import base64
import pickle
from dataclasses import dataclass

from live.cli.wish import Wish


@dataclass(frozen=True, slots=True)
class Played:
    """A wish and where its picture is shown."""

    wish: Wish
    monitor: str | None = None
    fullscreen: bool = False
    headless: bool = False

    def packed(self) -> str:
        """As one word, for another process of this program."""
        return base64.b64encode(pickle.dumps(self)).decode()

    @classmethod
    def unpacked(cls, word: str) -> "Played":
        """What `packed` made. Only for what this program's own supervisor hands over."""
        played = pickle.loads(base64.b64decode(word))
        assert isinstance(played, cls)
        return played
