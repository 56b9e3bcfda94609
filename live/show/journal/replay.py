"""Replay of a journal from its beginning or from a snapshot, with a comparison of every measure's state hash."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from live.base.compression import decompress_text
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events.events import (
    ControlEvent,
    ExamplesChanged,
    PatchChanged,
    StepsAdded,
    StepsChanged,
    TicksSkipped,
)
from live.graph.library_insert import insert_clips
from live.library.clip_text import clips_from_text
from live.motion.step_clip import StepClip
from live.show.journal.journal_reader import Journal, JournalLine
from live.show.journal.journal_writer import read_snapshots
from live.show.journal.skipped_events import skipped_gaps
from live.show.loader import LoadedShow, load_from_patch
from live.show.patch.patch import Patch
from live.show.patch.patch_update import rebuilt_graph
from live.show.patch_checks.patch_check import PATCH_CHECKS
from live.show.selection.graph_update import clip_key, gone_clips, library_hash, updated_graph
from live.show.show import Show, apply_safely
from live.show.state.snapshot import SnapshotError, origin_hashes, restore, snapshot_header


class ReplayError(Exception):
    """A journal that cannot be replayed here; the message names the missing or different part."""


@dataclass(frozen=True, slots=True, eq=False)
class ReplayStart:
    """Start of a replay: a show in its state after `tick`."""

    show: Show
    tick: int
    snapshot: bytes | None = None
    """The snapshot that it is; None: the beginning."""


def load_journal(journal: Journal) -> LoadedShow:
    """Load the initial patch and steps of a journal, with later steps in reserve; ReplayError as above."""
    changed = (row.event for row in journal.lines_containing('"StepsChanged"') if isinstance(row.event, StepsChanged))
    pairs = (row.event for row in journal.lines_containing('"ExamplesChanged"'))
    examples = [event for event in pairs if isinstance(event, ExamplesChanged)]
    return load_from_header(journal.header, _added(journal), changed, examples)


def load_from_header(
    header: dict[str, Any],
    added: Iterable[list[str]],
    changed: Iterable[StepsChanged] = (),
    examples: Sequence[ExamplesChanged] = (),
) -> LoadedShow:
    """Load a show from a journal's header, the clip keys of each StepsAdded, and all StepsChanged and ExamplesChanged
    events; ReplayError as above."""
    try:
        patch = Patch.model_validate(header["patch"], context=PATCH_CHECKS)
        path = Path(header["patch_path"])
        recordings = None if header["recordings"] is None else Path(header["recordings"])
        wanted = header["steps_hash"]
        seed, tempo = header["seed"], header["tempo"]
        if not isinstance(seed, int) or not isinstance(tempo, int | float | None):
            raise TypeError("'seed' is a whole number, 'tempo' a number or null")
    except (KeyError, TypeError, ValueError) as error:
        raise ReplayError(f"the journal's first line does not hold a complete show: {error}") from None
    try:
        later = frozenset(key for keys in added for key in keys)
        names, was = [str(name) for name in header.get("steps", ())], _original_clips(changed)
        loaded = load_from_patch(
            patch, path, recordings=recordings, reserved=later, names=names, former=was, changed_pairs=examples
        )
    except (PersonError, ValueError, TypeError, OSError) as error:
        raise ReplayError(str(error)) from None
    found = library_hash(loaded.graph.library)
    if found != wanted:
        raise ReplayError(
            f"the steps have changed since (then {wanted}, now {found}): replay needs the same step files"
        )
    texture = None if loaded.bank is None else loaded.bank.digest()
    if header.get("texture") != texture:
        raise ReplayError("the recordings in [texture] have changed since: replay needs the same files")
    answers = None if loaded.answers is None else loaded.answers.digest()
    if header.get("partner") != answers:
        raise ReplayError("the examples of [[partner]] have changed since: replay needs the same files")
    return loaded


def first_start(journal: Journal, loaded: LoadedShow) -> ReplayStart:
    """Return the start at tick 0."""
    try:
        return ReplayStart(loaded.start(seed=journal.header["seed"], tempo=journal.header["tempo"]), 0)
    except PersonError as error:
        raise ReplayError(str(error)) from None


def start_before(journal: Journal, loaded: LoadedShow, measure: int, problems: list[str]) -> ReplayStart:
    """Return the last start before `measure` (from 1): a snapshot, or tick 0. Damage is added to `problems`."""
    return _last_start(journal, loaded, lambda facts: facts["measure"] < measure, problems)


def start_until(journal: Journal, loaded: LoadedShow, tick: int, problems: list[str]) -> ReplayStart:
    """Return the last start at or before `tick`: a snapshot, or tick 0. Damage is added to `problems`."""
    return _last_start(journal, loaded, lambda facts: facts["tick"] <= tick, problems)


def _last_start(
    journal: Journal, loaded: LoadedShow, fits: Callable[[dict[str, Any]], bool], problems: list[str]
) -> ReplayStart:
    best, gaps = None, skipped_gaps(journal.path)
    for data in read_snapshots(snapshots_of(journal), problems):
        facts = snapshot_header(data)
        if fits(facts) and not any(gap.invalidates(facts["tick"]) for gap in gaps):
            best = data
    if best is not None:
        try:
            return start_at(journal, loaded, best)
        except SnapshotError as error:
            problems.append(str(error))
    return first_start(journal, loaded)


def later_starts(journal: Journal, loaded: LoadedShow, tick: float, problems: list[str]) -> Iterator[ReplayStart]:
    """Yield the snapshots taken after `tick`, in order."""
    gaps = skipped_gaps(journal.path)
    for data in read_snapshots(snapshots_of(journal), problems):
        now = snapshot_header(data)["tick"]
        if now > tick and not any(gap.invalidates(now) for gap in gaps):
            try:
                yield start_at(journal, loaded, data)
            except SnapshotError as error:
                problems.append(str(error))


def snapshots_of(journal: Journal) -> Path:
    """Return the path of a journal's snapshot file; the file need not exist."""
    return journal.path.with_name(journal.path.name + ".snap")


def start_at(journal: Journal, loaded: LoadedShow, data: bytes) -> ReplayStart:
    """Return the start at a snapshot, with the patch and steps of that time; SnapshotError if it cannot be used."""
    facts = snapshot_header(data)
    for event in _changes(journal):
        if all(facts.get(key) == found for key, found, _ in origin_hashes(loaded)):
            break
        try:
            loaded = _apply_change(loaded, event)
        except ValueError as error:
            raise SnapshotError(f"the journal is damaged: {error}") from None
    return ReplayStart(restore(loaded, data), facts["tick"], data)


def _apply_change(loaded: LoadedShow, event: ControlEvent) -> LoadedShow:
    """Return the loaded show after an event that changed its patch, steps or examples; ValueError for a damaged one."""
    match event:
        case StepsAdded():
            clips = [loaded.reserve[key] for key in event.clips.split("\n") if key in loaded.reserve]
            return replace(loaded, graph=insert_clips(loaded.graph, clips))
        case StepsChanged():
            graph = updated_graph(loaded.graph, gone_clips(event), clips_from_text(event.now))
            return replace(loaded, graph=graph)
        case PatchChanged():
            patch = Patch.model_validate_json(decompress_text(event.patch), context=PATCH_CHECKS)
            return replace(loaded, patch=patch, graph=rebuilt_graph(loaded.graph, loaded.patch, patch))
        case ExamplesChanged() if event.bank in loaded.later_answers:
            return replace(loaded, answers=loaded.later_answers[event.bank])
        case _:
            return loaded


def _changes(journal: Journal) -> Iterator[ControlEvent]:
    """Yield the events that changed patch, steps or examples, in order."""
    for row in journal.lines_containing('"StepsAdded"', '"StepsChanged"', '"PatchChanged"', '"ExamplesChanged"'):
        if isinstance(row.event, StepsAdded | StepsChanged | PatchChanged | ExamplesChanged):
            yield row.event


def _original_clips(changed: Iterable[StepsChanged]) -> dict[str, StepClip]:
    """Return the original clips whose files were changed or removed during the show."""
    was: dict[str, StepClip] = {}
    came: set[str] = set()
    for event in changed:
        for clip in clips_from_text(event.was):
            if clip_key(clip) not in came:
                was.setdefault(clip_key(clip), clip)
        came.update(clip_key(clip) for clip in clips_from_text(event.now))
    return was


def _added(journal: Journal) -> Iterator[list[str]]:
    """Yield the clip keys of each event that added steps."""
    for row in journal.lines_containing('"StepsAdded"'):
        if isinstance(row.event, StepsAdded):
            yield row.event.clips.split("\n")


MAX_DIFFERENCES: Final = 1000
"""Maximum number of differences kept; after the first one usually all measures differ."""


@dataclass(slots=True)
class ReplayResult:
    """Result of a replay."""

    ticks: int = 0
    """The last tick."""
    first_tick: int = 0
    """The first tick."""
    measures: int = 0
    """Number of measures compared."""
    different: int = 0
    """Number of measures whose state differs."""
    differences: tuple[tuple[int, int, str, str], ...] = ()
    """The first of them: measure, tick, recorded hash, hash of the replay."""
    not_compared: list[tuple[int, int]] = field(default_factory=list)
    """Ranges of measures (first, last) that could not be compared: their lines could not be written or read, or the
    show skipped their ticks."""
    last: int | None = None
    """The measure compared last."""
    failed: int = 0
    """Events that raised an error of the program and were refused, in the show as in the replay."""
    problems: list[str] = field(default_factory=list)
    """Unusable parts of the journal, in words."""

    def record(self, measures: Iterable[int], *, compared: bool = True) -> None:
        """Record that `measures` were compared, or (`compared` false) that all up to the last of them never will be."""
        latest = max(measures, default=0)
        lacks = latest - 1 if compared else latest
        if self.last is not None and lacks > self.last:
            self.not_compared.append((self.last + 1, lacks))
        self.last = max(latest, self.last or 0)


class Replayer:
    """Runs a show through the lines of a journal, step by step."""

    def __init__(
        self, show: Show, lines: Iterator[JournalLine], *, tick: int = 0, compare: bool = True, to: int | None = None
    ) -> None:
        """`show` is in its state after `tick`. `compare`: whether state hashes are compared; `to`: the last measure."""
        self.show = show
        self.tick = tick
        self.ended = False
        """Whether the replay has ended."""
        self.damaged: float | None = None
        """If the replay has stopped before a damaged line: the tick up to which lines may be lost."""
        self.result = ReplayResult(ticks=tick, first_tick=tick)
        self._lines = lines
        self._line: JournalLine | None = None
        self._compare, self._to = compare, to
        self._begun = tick
        self._hash: tuple[int, str] | None = None
        self._next_line()

    def _next_line(self) -> None:
        """Read the next line that is relevant."""
        for line in self._lines:
            if line.tick < self._begun or (line.tick == self._begun and line.measure is not None):
                continue  # lines before the snapshot, and its own measure line
            self._line = line
            return
        self._line, self.ended = None, True

    def advance(self, until: float) -> None:
        """Run up to the tick `until` or the end of the journal; events at that tick wait for the next call."""
        while not self.ended and self.damaged is None:
            line = self._line
            assert line is not None
            if line.tick > self.tick:
                if self.tick >= until:
                    break
                self._run_tick()
            elif line.measure is None and self.tick >= until:
                break
            else:
                self._apply_line(line)
        self.result.ticks = self.tick

    def advance_to(self, measure: int) -> None:
        """Run until `measure` (from 1) begins, or to the end of the journal."""
        while not self.ended and self.damaged is None and self.show.span.number + 1 < measure:
            self.advance(self.tick + 1)

    def _run_tick(self) -> None:
        self.tick += 1
        if not self.show.tick(self.tick * TICK):
            return
        if self._to is not None and self.show.span.number >= self._to:
            self.ended = True
        if self._compare:
            self._hash = self.tick, self.show.state_hash()

    def _apply_line(self, line: JournalLine) -> None:
        if line.damaged is not None:
            self._stop(line)
            return
        if line.event is not None and not line.skipped:
            self.result.failed += apply_safely(self.show, line.event) is None
            if isinstance(line.event, TicksSkipped):
                self.tick += line.event.count
        elif line.measure is not None and line.state is not None and self._compare:
            self._compare_with(line)
        self._next_line()

    def _stop(self, line: JournalLine | None) -> None:
        """Stop before a damaged line. Its events acted no later than the tick of the next undamaged line."""
        while line is not None and line.damaged is not None:
            self.result.problems.append(line.damaged)
            line = next(self._lines, None)
        self.damaged = math.inf if line is None else line.tick

    def _compare_with(self, line: JournalLine) -> None:
        found, measure = self.result, line.measure or 0
        found.record([measure])
        found.measures += 1
        now = "no measure began here" if self._hash is None or self._hash[0] != line.tick else self._hash[1]
        if now == line.state:
            return
        found.different += 1
        if len(found.differences) < MAX_DIFFERENCES:
            found.differences += ((measure, line.tick, line.state or "", now),)


def replay(show: Show, journal: Journal) -> ReplayResult:
    """Run `show` (fresh, of the journal's patch and seed) through the journal, as fast as possible."""
    return run_from(ReplayStart(show, 0), journal)


def run_from(
    start: ReplayStart, journal: Journal, *, loaded: LoadedShow | None = None, to: int | None = None
) -> ReplayResult:
    """Replay from any start; `to`: the last measure (from 1).

    After a damaged line the replay resumes at the next snapshot, if `loaded` is given and there is one.
    """
    running = Replayer(start.show, journal.lines_with_damage(), tick=start.tick, to=to)
    found = running.result
    while True:
        running.advance(math.inf)
        if running.damaged is None:
            return found
        after = None if loaded is None else next(later_starts(journal, loaded, running.damaged, found.problems), None)
        if after is None:
            found.record((line.measure for line in journal.lines_with_damage() if line.measure), compared=False)
            return found
        found.problems.append(f"the replay resumes at the snapshot in measure {after.show.span.number + 1}")
        running = Replayer(after.show, journal.lines_with_damage(), tick=after.tick, to=to)
        running.result = found
