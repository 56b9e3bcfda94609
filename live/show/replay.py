"""Replay: run a journal again, and compare the state hash of every measure."""

from collections.abc import Callable
from dataclasses import dataclass

from live.clock.ticks import TICK
from live.control.events import TicksSkipped
from live.show.core import Show
from live.show.journal import Journal


@dataclass(frozen=True, slots=True)
class Replayed:
    """What a replay found: measures compared, and those whose state differs (measure, tick, then, now)."""

    ticks: int
    measures: int
    differences: tuple[tuple[int, int, str, str], ...]


def replay(show: Show, journal: Journal, *, on_tick: Callable[[int], None] | None = None) -> Replayed:
    """Run `show` (fresh, of the journal's patch and seed) through the journal, as fast as the machine can."""
    tick = 0
    now: dict[int, str] = {}
    compared = 0
    differences: list[tuple[int, int, str, str]] = []
    for line in journal.lines:
        while tick < line.tick:
            tick += 1
            if show.tick(tick * TICK):
                now[tick] = show.state_hash()
            if on_tick is not None:
                on_tick(tick)
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
