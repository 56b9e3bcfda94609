"""Turns and votes of an audience, as immutable values."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import ControlEvent

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.desk.scenes import Scenes
    from live.show.patch.patch import Patch

VOTE_KINDS: Final = ("step", "scene", "look", "cue", "word")
"""Kinds of votes."""
SOURCE: Final = "audience vote"
NO_BAR: Final = -1.0
"""In a caption: a line without a share."""
_CHANCE: Final = 0xA0D1


@dataclass(frozen=True, slots=True)
class Turn:
    """Only this region (by index) is active from the line of measure `begins` (from 0) to that of `ends`."""

    region: int
    begins: int
    ends: int


@dataclass(frozen=True, slots=True)
class Vote:
    """A vote that is open until the line of measure `closes` (from 0)."""

    number: int
    kind: str
    choices: tuple[str, ...]
    closes: int
    counts: tuple[int, ...] = ()
    """Votes for each choice, in hundredths."""

    def with_counts(self, counts: tuple[int, ...]) -> "Vote":
        """Return the vote with these counts, (number of the vote, hundredths for each choice); unchanged if they
        belong to another vote."""
        good = len(counts) == len(self.choices) + 1 and counts[0] == self.number and min(counts) >= 0
        return replace(self, counts=counts[1:]) if good else self

    def winner(self, seed: int) -> str:
        """Return the choice with most votes, a tie broken by chance; empty if there are no votes."""
        if not any(self.counts):
            return ""
        first = [index for index, count in enumerate(self.counts) if count == max(self.counts)]
        return self.choices[first[int(np.random.default_rng([seed, _CHANCE, self.number]).integers(len(first)))]]

    @property
    def shares(self) -> tuple[tuple[str, float], ...]:
        """Each choice with its share of the votes, from 0 to 1."""
        counts = self.counts or (0,) * len(self.choices)
        total = max(sum(counts), 1)
        return tuple((name, count / total) for name, count in zip(self.choices, counts, strict=True))

    @property
    def tally(self) -> dict[str, dict[str, float]]:
        """Counts for the status."""
        counts = self.counts or (0,) * len(self.choices)
        return {"choices": {name: count / 100 for name, count in zip(self.choices, counts, strict=True)}}


class VoteNames:
    """Names that can be voted for."""

    def __init__(self, patch: "Patch", dancers: "Dancers", scenes: "Scenes") -> None:
        self._patch, self._dancers, self._scenes = patch, dancers, scenes

    def known(self) -> dict[str, tuple[str, ...]]:
        """Return the present names by kind of vote."""
        return {
            "step": tuple(self._dancers.graph.library.steps),
            "scene": tuple(self._scenes.names),
            "look": tuple(look.name for look in self._patch.looks),
            "cue": tuple(cue.name for cue in self._patch.cue),
            "word": self._patch.words.vote,
        }


def resolve_choices(event: events.AskVote, known: dict[str, tuple[str, ...]]) -> tuple[str, ...]:
    """Return the choices with their names in the patch; raises PersonError for unknown ones."""
    what = event.what.strip().casefold()
    if what not in VOTE_KINDS or what != event.what:
        raise PersonError(f"there is no vote on {event.what!r}", f"one of {', '.join(VOTE_KINDS)}")
    names = {name.casefold().strip(): name for name in known[what]}
    found = []
    for asked in event.choices:
        name = names.get(asked.casefold().strip())
        if name is None:
            raise PersonError(f"vote: no {what} is called {asked!r}", f"there are: {', '.join(names.values())[:200]}")
        found.append(name)
    if len(set(found)) < len(found):
        raise PersonError("vote: two choices are the same")
    return tuple(found)


def winner_events(kind: str, winner: str, time: float) -> list[ControlEvent]:
    """Return the events that the winner of a vote triggers."""
    match kind:
        case "step":
            return [events.CallStep(time=time, source=SOURCE, name=winner)]
        case "scene":
            return [events.RecallScene(time=time, source=SOURCE, name=winner)]
        case "look":
            return [events.RecallLook(time=time, source=SOURCE, name=winner)]
        case "word":
            return [events.AddWord(time=time, source=SOURCE, word=winner)]
        case _:
            return [events.GiveCue(time=time, source=SOURCE, name=winner)]
