"""Replay: run a journal again, and compare the state hash of every measure."""

from dataclasses import dataclass
from pathlib import Path

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import StepsAdded, TicksSkipped
from live.show.core import Show
from live.show.journal import Journal
from live.show.load import library_hash, show_of
from live.show.patch import Patch

LONGEST_GAP = 64 * 600
"""Ticks between two lines at most: a measure is noted at least once in ten minutes."""


class ReplayError(Exception):
    """A journal that cannot be run here; the message says what is missing or different."""


def reload(journal: Journal) -> Show:
    """A fresh show of the journal's patch, steps and seed; ReplayError if the steps are not the same any more."""
    header = journal.header
    try:
        patch = Patch.model_validate(header["patch"])
        path = Path(header["patch_path"])
        recordings = None if header["recordings"] is None else Path(header["recordings"])
        seed, tempo, wanted = header["seed"], header["tempo"], header["steps_hash"]
    except (KeyError, TypeError, ValueError) as error:
        raise ReplayError(f"the journal's first line does not hold a whole show: {error}") from None
    try:
        added = (line.event for line in journal.lines if isinstance(line.event, StepsAdded))
        later = frozenset(key for event in added for key in event.clips.split("\n"))
        loaded = show_of(patch, path, recordings=recordings, later=later)
        found = library_hash(loaded.graph.library)
        if found != wanted:
            raise ReplayError(
                f"the steps have changed since (then {wanted}, now {found}): replay needs the same step files"
            )
        return loaded.start(seed=seed, tempo=tempo)
    except PersonError as error:
        raise ReplayError(str(error)) from None


@dataclass(frozen=True, slots=True)
class Replayed:
    """What a replay found: measures compared, and those whose state differs (measure, tick, then, now)."""

    ticks: int
    measures: int
    differences: tuple[tuple[int, int, str, str], ...]


def replay(show: Show, journal: Journal) -> Replayed:
    """Run `show` (fresh, of the journal's patch and seed) through the journal, as fast as the machine can."""
    tick = 0
    now: dict[int, str] = {}
    compared = 0
    differences: list[tuple[int, int, str, str]] = []
    for number, line in enumerate(journal.lines, start=2):
        if line.tick - tick > LONGEST_GAP:
            raise ReplayError(f"line {number} of the journal is damaged: its tick {line.tick} lies far after {tick}")
        while tick < line.tick:
            tick += 1
            if show.tick(tick * TICK):
                now[tick] = show.state_hash()
        if line.event is not None:
            show.apply(line.event)
            if isinstance(line.event, TicksSkipped):
                tick += line.event.count
        elif line.measure is not None and line.state is not None:
            compared += 1
            found = now.get(line.tick, "no measure began here")
            if found != line.state:
                differences.append((line.measure, line.tick, line.state, found))
    return Replayed(tick, compared, tuple(differences))
