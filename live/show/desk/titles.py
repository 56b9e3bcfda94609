"""Titles: letters over the picture or in the stage, shown by name or with any text, with entrances on the beat."""

import math
import unicodedata
from dataclasses import dataclass, replace
from typing import Final

from live.base.errors import PersonError
from live.base.stage_snapshot import Title
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.patch.patch import Patch
from live.show.patch.section_picture import TitleSection
from live.show.stages.now import Now

TITLE_EVENTS: Final = (events.ShowTitle, events.HideTitle)
"""Events that `handle` handles."""
MAX_SHOWN: Final = 8
"""Maximum number of titles at a time; the oldest goes."""
EXIT_BEATS: Final = 2.0
"""Length of a title's fade out [beats]."""
NEVER: Final = -1.0
"""End of a title that stays until it is hidden."""
_GRACE: Final = 0.1
"""A call this late after a beat [beats] still begins on it."""
_BEHIND, _FRONT = 1.0, 0.6
"""Default distance of titles behind the stage's back edge, and before its front edge [m]."""
_MIDDLE: Final = (0.5, 0.5)
_USUAL_HEIGHT: Final = 2.2
"""Default height of the middle of a title in the stage [m]."""


@dataclass(frozen=True, slots=True)
class ShownTitle:
    """A title that is seen or about to be."""

    key: str
    """Case-folded name of its style; a new title of a style replaces the one before."""
    title: Title
    begin: float
    """The beat on which its entrance begins."""
    entrance: float
    """Length of the entrance [beats]."""
    end: float
    """The beat on which it begins to fade out, or `NEVER`."""

    def at(self, beat: float) -> Title | None:
        """Return it as it is seen at a beat; None if it is not."""
        age = beat - self.begin
        level = 1.0 if self.end == NEVER else min(max(1.0 - (beat - self.end) / EXIT_BEATS, 0.0), 1.0)
        if age < 0.0 or level <= 0.0:
            return None
        progress = 1.0 if self.entrance <= 0.0 else min(age / self.entrance, 1.0)
        return replace(self.title, progress=progress, level=level)


class Titles:
    """The titles of one show. Thread: the show's."""

    def __init__(self, patch: Patch) -> None:
        self._patch = patch
        self.shown: list[ShownTitle] = []
        """Titles that are seen, about to be, or fading out, the oldest first."""

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `TITLE_EVENTS`; raises PersonError if it names no title."""
        beat = now.beat
        match event:
            case events.ShowTitle():
                self._show(event, beat, float(now.timeline.beats_per_measure))
            case events.HideTitle():
                self._hide(event.name, beat)

    def clear(self, beat: float) -> None:
        """Let all titles fade out."""
        self._end(self.shown, beat)

    def _show(self, event: events.ShowTitle, beat: float, measure: float) -> None:
        known = {_folded(section.name): section for section in self._patch.title}
        style = _folded(event.style).strip("*")
        if style and style not in known:
            there = ", ".join(section.name for section in self._patch.title) or "no [[title]] in the patch"
            raise PersonError(f"no title is called {event.style!r}", f"there are: {there}")
        own = known.get(_folded(event.text))
        section = known[style] if style else own or next(iter(known.values()), TitleSection(name="title"))
        text = own.text if own is not None and own.text else event.text
        text = clean_text(text)
        if not text.strip(" |"):
            return
        begin = math.ceil(beat - _GRACE)
        key = _folded(section.name)
        entrance = section.measures * measure
        end = NEVER if section.hold <= 0.0 else begin + entrance + section.hold * measure
        self._end([one for one in self.shown if one.key == key], begin)
        self.tick(beat)
        self.shown.append(ShownTitle(key, title_of(section, text, self._patch), float(begin), entrance, float(end)))
        del self.shown[:-MAX_SHOWN]

    def _hide(self, name: str, beat: float) -> None:
        wanted = _folded(name)
        chosen = [one for one in self.shown if wanted in ("", "*") or wanted in (one.key, _folded(one.title.text))]
        if not chosen and wanted not in ("", "*"):
            raise PersonError(f"no title {name!r} is shown", "`*` hides all of them")
        self._end(chosen, math.ceil(beat - _GRACE))

    def _end(self, chosen: list[ShownTitle], beat: float) -> None:
        self.shown = [
            replace(one, end=beat) if one in chosen and (one.end == NEVER or one.end > beat) else one
            for one in self.shown
        ]

    def tick(self, beat: float) -> None:
        """Forget titles that have gone."""
        if self.shown:
            self.shown = [one for one in self.shown if one.end == NEVER or beat < one.end + EXIT_BEATS]

    def seen_at(self, beat: float) -> tuple[Title, ...]:
        """Return the titles seen at a beat, in drawing order."""
        return tuple(seen for one in self.shown if (seen := one.at(beat)) is not None)

    def facts(self) -> list[str]:
        """Return the texts that are shown, for the status."""
        return [one.title.text for one in self.shown]


def title_of(section: TitleSection, text: str, patch: Patch) -> Title:
    """Return a text as a title of this style, complete and opaque."""
    first, second = section.at or (_MIDDLE if section.place == "picture" else (0.0, _USUAL_HEIGHT))
    half = 0.5 * patch.stage.depth
    usual = half + _FRONT if section.place == "front" else -half - _BEHIND
    z = 0.0 if section.place == "picture" else usual if section.z is None else section.z
    size = section.size if section.size is not None else 0.09 if section.place == "picture" else 1.0
    r, g, b = (part * section.brightness for part in section.colour)
    return Title(
        text,
        place="picture" if section.place == "picture" else "stage",
        at=(first, second, z),
        size=size,
        tracking=section.tracking,
        colour=(r, g, b),
        entrance=section.entrance,
        font=section.font or "",
    )


def clean_text(text: str) -> str:
    """Return a text in composed letters, with single spaces and without what cannot be printed."""
    composed = unicodedata.normalize("NFC", text)
    return " ".join("".join(letter if letter.isprintable() else " " for letter in composed).split())


def _folded(name: str) -> str:
    return name.casefold().strip()
