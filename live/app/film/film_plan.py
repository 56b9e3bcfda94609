"""Plan of a film in parts: which frames, where each part begins, and from which state it is drawn.

The journal is replayed once without drawing. On the way the state is kept as snapshots, and what pictures remember
(`live/render/film/picture_memory.py`); so each part can be drawn by another process, with the same pictures.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from live.base.errors import PersonError
from live.base.stage_snapshot import Title
from live.clock.ticks import TICK, FrameGrid
from live.render.film.container_formats import FORMATS, segment_length
from live.render.film.picture_memory import PictureMemory, Reach, least_reach
from live.show.journal.journal_reader import Journal
from live.show.journal.replay import (
    Replayer,
    ReplayError,
    ReplayResult,
    ReplayStart,
    first_start,
    start_at,
    start_before,
    start_until,
)
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.state.snapshot import SnapshotError, Snapshotter

SNAPSHOT_TICKS: Final = 128
"""Ticks between two states that are kept while a film is planned."""
USUAL_REACH: Final = 20 * 64
"""Most parts are drawn from a state so many ticks before them, at most."""
LONGEST_REACH: Final = 120 * 64
"""States are kept for so many ticks; a part that remembers more begins with the show."""
PARTS_PER_WORKER: Final = 4
"""A worker that dies costs one part of so many."""
LEAST_SEGMENTS: Final = 2
"""Shortest part, in segments of the film."""
TitleText = tuple[str, str]
"""A title's text and the name of its font."""


@dataclass(frozen=True, slots=True, eq=False)
class FilmPart:
    """Frames `first` to `end` - 1 of the show, and what they are drawn from."""

    number: int
    first: int
    end: int
    reach: Reach
    """First frames that are followed, and drawn, before the part."""
    snapshot: bytes | None = None
    """State from which it starts, at or before the first frame that is followed; None: the beginning of the show."""
    titles: tuple[TitleText, ...] = ()
    """Titles that were shown before the first frame that is followed."""

    @property
    def count(self) -> int:
        """Number of its frames."""
        return self.end - self.first

    def start(self, journal: Journal, loaded: LoadedShow) -> ReplayStart:
        """Return the state from which it starts; PersonError if it cannot be used."""
        try:
            return first_start(journal, loaded) if self.snapshot is None else start_at(journal, loaded, self.snapshot)
        except (ReplayError, SnapshotError) as error:
            raise PersonError(str(error)) from None


def whole_show(end: int) -> FilmPart:
    """Return the part that is the whole show of `end` frames."""
    return FilmPart(0, 0, end, Reach(0, 0))


def film_frames(
    journal: Journal,
    loaded: LoadedShow,
    grid: FrameGrid,
    *,
    measures: tuple[int, int | None] = (1, None),
    frames: tuple[int, int | None] | None = None,
    problems: list[str],
) -> tuple[int, int, int]:
    """Return the first frame of a film and the one after its last, of `measures`, the first and the last one (from 1),
    or `frames` (half-open, from 0; None: to the end), and the number of frames of the show.

    A damaged line ends the show, and is added to `problems`.

    PersonError if the show has no such measure or frame.
    """
    ticks: dict[int, int] = {1: 0}
    damaged = None
    for line in journal.lines_with_damage():
        if line.damaged is not None and damaged is None:
            damaged = line
        if line.measure is not None:
            ticks[line.measure] = line.tick
    last_tick = journal.last_tick if damaged is None else damaged.tick
    end = grid.first_from(last_tick + 1)
    if damaged is not None:
        problems.append(damaged.damaged or "")
    elif (seconds := journal.seconds) is not None:
        end = min(end, grid.count(seconds))
    if frames is not None:
        first, last = frames
        if first >= end:
            raise PersonError(f"{journal.path}: it has no frame {first}; it has {end} frames at {grid.fps:g} a second")
        return first, end if last is None else min(last, end), end

    def frame_of(measure: int) -> int | None:
        if measure not in ticks and max(ticks) > measure:  # its line is lost
            start = start_before(journal, loaded, measure, problems)
            running = Replayer(start.show, journal.lines_with_damage(), tick=start.tick, compare=False)
            running.advance_to(measure)
            ticks[measure] = running.tick
        return grid.first_from(ticks[measure]) if measure in ticks else None

    first_frame = frame_of(measures[0])
    if first_frame is None or first_frame >= end:
        raise PersonError(f"{journal.path}: it has no measure {measures[0]}; it ends in measure {max(ticks)}")
    after = None if measures[1] is None else frame_of(measures[1] + 1)
    return first_frame, end if after is None else min(after, end), end


def part_bounds(first: int, end: int, workers: int, fps: float) -> list[int]:
    """Return where the parts of a film begin [frames], and its end: on the grid of segments, several for each
    worker."""
    segment = max(segment_length(Fraction(fps).limit_denominator(1001), kind) for kind in FORMATS.values())
    wanted = -(-(end - first) // (workers * PARTS_PER_WORKER))
    step = max(-(-wanted // segment), LEAST_SEGMENTS if workers * LEAST_SEGMENTS * segment <= end - first else 1)
    begin = first // segment * segment
    return [first, *range(begin + step * segment, end, step * segment), end]


class FilmPlan:
    """Replays a journal without drawing, and yields the parts of a film. Thread: one."""

    def __init__(
        self,
        journal: Journal,
        loaded: LoadedShow,
        grid: FrameGrid,
        bounds: Sequence[int],
        *,
        problems: list[str],
        to_end: bool,
        on_frame: Callable[[Show, int], None] | None = None,
    ) -> None:
        """`bounds`: where the parts begin, ascending, and the end of the last one; `to_end`: with it the show ends.
        `on_frame` is called for each frame of the film with the show after its last tick."""
        self._journal, self._loaded, self._grid, self._bounds = journal, loaded, grid, bounds
        self._problems, self._to_end, self._on_frame = problems, to_end, on_frame
        self.result: ReplayResult | None = None
        """How the states compare, once all parts were yielded."""

    def parts(self, *, patience: float = 1.0, whole: bool = True) -> Iterator[FilmPart | None]:
        """Yield the parts in order, and None in between, so that a caller can do something else.

        `patience`: parts remember so many times as much as usual. `whole`: replay to the end of the last part.
        """
        begin = self._grid.tick(self._bounds[0]) - USUAL_REACH
        while True:
            try:
                yield from self._parts(begin, patience, whole=whole)
            except _TooLate:
                begin = begin - LONGEST_REACH if begin > LONGEST_REACH else 0
            else:
                return

    def _parts(self, begin: int, patience: float, *, whole: bool) -> Iterator[FilmPart | None]:
        grid, bounds = self._grid, self._bounds
        start = start_until(self._journal, self._loaded, begin, self._problems)
        running = Replayer(start.show, self._journal.lines_with_damage(), tick=start.tick)
        states = _States(start, [grid.tick(max(bound - least_reach(grid.fps), 0)) for bound in bounds[:-1]])
        first = grid.first_from(start.tick)
        memory, titles = PictureMemory(self._loaded.scene(), first), _TitleHistory()
        number, end = 0, bounds[-1] if whole else bounds[-2] + 1
        for frame in range(first, end):
            target = grid.tick(frame)
            while running.tick < target and not running.ended and running.damaged is None:
                running.advance(running.tick + 1)
                if bounds[-2] > frame:
                    states.keep(running.show, running.tick)
            running.advance(target)
            show = running.show
            time = max(grid.time(frame), running.tick * TICK)
            beat = show.timeline.beat_at(time)
            memory.add(show.desk.parameters.picture, time, beat, frozen=show.desk.master.frozen)
            titles.add(frame, show.view_builder.titles_at(beat))
            if number < len(bounds) - 1 and frame == bounds[number]:
                reach = memory.reach(frame, patience=patience) if frame else Reach(0, 0)
                if reach.follow < first and start.tick:
                    raise _TooLate
                state = states.until(grid.tick(reach.follow))
                yield FilmPart(number, frame, bounds[number + 1], reach, state, titles.before(reach.follow))
                number += 1
            if self._on_frame is not None and frame >= bounds[0]:
                self._on_frame(show, frame)
            yield None
        if whole:
            running.advance(math.inf if self._to_end else running.tick)
        self.result = running.result


class _TooLate(Exception):
    """The first part remembers more than the state holds from which the plan began."""


class _States:
    """The states of a show that were kept on the way, with their ticks."""

    def __init__(self, start: ReplayStart, likely: Sequence[int]) -> None:
        """`likely`: ticks at which parts will probably start, ascending; their states are kept besides."""
        self._first = start.snapshot
        self._kept: deque[tuple[int, bytes]] = deque()
        self._taker = Snapshotter(start.show)
        self._due = start.tick + SNAPSHOT_TICKS
        self._likely = deque(tick for tick in likely if tick > start.tick)

    def keep(self, show: Show, tick: int) -> None:
        """Keep the state after `tick` if one is due."""
        if tick < self._due and not (self._likely and tick >= self._likely[0]):
            return
        taken = self._taker.capture(tick)
        if taken is None:  # planning is in progress: some ticks later
            return
        self._due = tick + SNAPSHOT_TICKS
        while self._likely and self._likely[0] <= tick:
            self._likely.popleft()
        self._kept.append((tick, taken.seal()))
        while self._kept[0][0] < tick - LONGEST_REACH:
            self._kept.popleft()

    def until(self, tick: int) -> bytes | None:
        """Return the last state at or before `tick`; None: the beginning of the show."""
        return max(((at, data) for at, data in self._kept if at <= tick), default=(0, self._first))[1]


class _TitleHistory:
    """Texts of titles in the order in which they were first shown."""

    def __init__(self) -> None:
        self._first: dict[TitleText, int] = {}

    def add(self, frame: int, titles: Sequence[Title]) -> None:
        """Add the titles of a frame."""
        for title in titles:
            self._first.setdefault((title.text, title.font), frame)

    def before(self, frame: int) -> tuple[TitleText, ...]:
        """Return those that were shown before a frame."""
        return tuple(text for text, first in self._first.items() if first < frame)
