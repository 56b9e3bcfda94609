"""The audience's words: they wait for the operator, then gather behind the dancers or fall as rain.

A word comes from a stranger: it is short, has letters only, and none of the patch's blocked words in it. What comes
over the network is refused or waits; nothing is drawn before the operator has approved it, unless the patch says so.
"""

import math
import unicodedata
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.base.stage_snapshot import Title
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.desk.titles import clean_text
from live.show.patch.patch import Patch
from live.show.stages.now import Now

WORD_EVENTS: Final = (
    events.AddWord, events.OfferWord, events.ApproveWord, events.RejectWord, events.ClearWords,
)  # fmt: skip
"""Events that `handle` handles."""
MAX_LENGTH: Final = 24
"""Maximum length of a word [letters]."""
MAX_WAITING: Final = 64
"""Maximum number of words that wait for the operator; the oldest is forgotten."""
RAIN_BEATS: Final = 32.0
"""How long a word falls that stays where it lands [beats]."""
GATHER_BEATS: Final = 4.0
"""A word reaches its place within so many beats."""
FADE_BEATS: Final = 4.0
"""Length of a word's fade out [beats]."""
_LETTER_WIDTH: Final = 0.95
"""Usual width of a letter, in heights of a capital letter."""
_LINE: Final = 1.5
"""Height that a word takes, in heights of a capital letter."""
_TRIES: Final = 1200
_RAIN_TRIES: Final = 24
"""Places that are tried for a word of the cloud, and of the rain."""
_ANGLES: Final = 2.39996323 * np.arange(_TRIES)
_DISC: Final = np.sqrt(np.arange(_TRIES) / _TRIES)[:, None] * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
"""Places evenly spread over a disc of radius 1, from its middle on (golden angle, Vogel 1979), shape (1200, 2)."""
_MARKS: Final = "-'’ "
"""What a word may have besides letters."""
_SEED: Final = 0x3012D


@dataclass(frozen=True, slots=True)
class ShownWord:
    """A word that is seen."""

    title: Title
    """At its place."""
    began: float
    """The beat on which it came."""
    start: tuple[float, float, float]
    """Where it comes from."""
    end: float
    """The beat on which it begins to fade; -1: none yet."""


class Words:
    """The words of one show. Thread: the show's."""

    def __init__(self, patch: Patch, *, seed: int) -> None:
        self._patch, self._seed = patch, seed
        self.waiting: list[str] = []
        """Words that wait for the operator, the oldest first."""
        self.shown: list[ShownWord] = []
        """Words that are seen, the oldest first."""
        self._count = 0
        self.refused = 0
        """How many words were refused."""

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `WORD_EVENTS`; raises PersonError for a word that is refused or does not wait."""
        match event:
            case events.AddWord():
                self._show(self._checked(event.word), now.beat)
            case events.OfferWord():
                self._offer(self._checked(event.word), now.beat)
            case events.ApproveWord():
                for word in self._take(event.word):
                    self._show(word, now.beat)
            case events.RejectWord():
                self._take(event.word)
            case events.ClearWords():
                self.waiting = []
                self.clear(now.beat)

    def clear(self, beat: float) -> None:
        """Let all words fade."""
        self.shown = [replace(one, end=beat) if one.end < 0.0 else one for one in self.shown]

    def _checked(self, word: str) -> str:
        """Return a word as it is shown; PersonError if it is refused."""
        try:
            return check_word(word, self._patch.words.blocked)
        except PersonError:
            self.refused += 1
            raise

    def _offer(self, word: str, beat: float) -> None:
        if self._patch.words.accept == "all":
            self._show(word, beat)
        elif word.casefold() not in [each.casefold() for each in self.waiting]:
            self.waiting = [*self.waiting, word][-MAX_WAITING:]

    def _take(self, word: str) -> list[str]:
        """Remove a waiting word, or with `*` all of them, and return what was removed."""
        wanted = word.casefold().strip()
        taken = [each for each in self.waiting if wanted == "*" or each.casefold() == wanted]
        if not taken and wanted != "*":
            raise PersonError(f"no word {word!r} waits", f"there are: {', '.join(self.waiting)[:200] or 'none'}")
        self.waiting = [each for each in self.waiting if each not in taken]
        return taken

    def _show(self, word: str, beat: float) -> None:
        said = self._patch.words
        self.shown = [one for one in self.shown if beat < self._end(one) + FADE_BEATS]
        chance = np.random.default_rng([self._seed, _SEED, self._count])
        self._count += 1
        size = said.size * (0.75 + 0.6 * float(chance.random()))
        half_depth = 0.5 * self._patch.stage.depth
        z = -half_depth - 1.4 + 0.6 * float(chance.random())
        width = said.width or 1.1 * self._patch.stage.width
        half = 0.5 * size * _LETTER_WIDTH * len(word)
        if said.form == "rain":
            reach, height = max(0.5 * width - half, 0.0), said.top + size
            places = np.stack([reach * (2.0 * chance.random(_RAIN_TRIES) - 1.0), np.full(_RAIN_TRIES, height)], axis=1)
            x, _ = self._freest(places, half, 0.5 * size * _LINE, beat)
            place, start = (x, said.bottom + 0.5 * size, z), (x, height, z)
        else:
            middle, rise = 0.5 * (said.bottom + said.top), 0.5 * (said.top - said.bottom) - 0.5 * size * _LINE
            places = np.array((0.0, middle)) + _DISC * (max(0.5 * width - half, 0.0), max(rise, 0.05))
            x, y = self._freest(places, half, 0.5 * size * _LINE, None)
            place = (x, y, z)
            angle = math.tau * float(chance.random())
            start = (x + 3.0 * math.cos(angle), max(y + 2.0 * math.sin(angle), 0.3), z)
        r, g, b = said.colour
        title = Title(word, "stage", place, size, 0.02, (r, g, b), "fade", said.font or "")
        self.shown.append(ShownWord(title, beat, start, -1.0))
        there = [one for one in self.shown if one.end < 0.0]
        for one in there[: max(len(there) - said.most, 0)]:
            self.shown[self.shown.index(one)] = replace(one, end=beat)

    def _freest(
        self, places: Float64, half_width: float, half_height: float, beat: float | None
    ) -> tuple[float, float]:
        """Return the first of the places (N, 2) [m] where a word covers no other one, else one where it covers least.

        Others are at their places, or where they are at a beat.
        """
        boxes = np.zeros((len(self.shown), 4))
        for row, one in zip(boxes, self.shown, strict=True):
            x, y, _ = one.title.at if beat is None else self._seen(one, beat).at
            size = one.title.size
            row[:] = x, y, 0.5 * size * _LETTER_WIDTH * len(one.title.text), 0.5 * size * _LINE
        apart = np.abs(places[:, None] - boxes[:, :2])
        over = np.maximum((half_width, half_height) + boxes[:, 2:] - apart, 0.0)
        x, y = places[int(over.prod(axis=2).sum(axis=1).argmin())].tolist()
        return x, y

    def _end(self, one: ShownWord) -> float:
        """Return the beat on which a word begins to fade, infinity if it stays."""
        life = self._patch.words.beats or math.inf
        return one.end if one.end >= 0.0 else one.began + life

    def seen_at(self, beat: float) -> tuple[Title, ...]:
        """Return the words as they are seen at a beat."""
        return tuple(self._seen(one, beat) for one in self.shown if beat < self._end(one) + FADE_BEATS)

    def _seen(self, one: ShownWord, beat: float) -> Title:
        said, age = self._patch.words, max(beat - one.began, 0.0)
        rain = said.form == "rain"
        share = min(age / (said.beats or RAIN_BEATS if rain else GATHER_BEATS), 1.0)
        eased = share if rain else 1.0 - (1.0 - share) ** 3
        x, y, z = (a + (b - a) * eased for a, b in zip(one.start, one.title.at, strict=True))
        level = min(max(1.0 - (beat - self._end(one)) / FADE_BEATS, 0.0), 1.0)
        return replace(one.title, at=(x, y, z), progress=min(age / 2.0, 1.0), level=level)

    def facts(self) -> dict[str, Any]:
        """Return values for the status."""
        return {
            "waiting": list(self.waiting), "shown": [one.title.text for one in self.shown if one.end < 0.0],
            "refused": self.refused,
        }  # fmt: skip


def check_word(word: str, blocked: tuple[str, ...]) -> str:
    """Return a word without surplus spaces; PersonError if it is too long, has other signs than letters, or a blocked
    word in it (whatever its case and accents)."""
    text = clean_text(word)
    if not 1 <= len(text) <= MAX_LENGTH:
        raise PersonError(f"a word of {len(text)} letters", f"1 to {MAX_LENGTH} letters")
    if not all(letter in _MARKS or unicodedata.category(letter)[0] in "LM" for letter in text) or not any(
        letter.isalpha() for letter in text
    ):
        raise PersonError(f"{text!r} is no word", "letters, hyphens, apostrophes and spaces")
    plain = _plain(text)
    for each in blocked:
        if _plain(each) and _plain(each) in plain:
            raise PersonError("a word that the patch blocks")
    return text


def _plain(text: str) -> str:
    """Return a text's letters only, without case and accents."""
    return "".join(letter for letter in unicodedata.normalize("NFKD", text.casefold()) if letter.isalpha())
