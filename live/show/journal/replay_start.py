"""Where a replay begins: with the show as it began, or with a snapshot; each with the steps that were there by then."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from live.base.compression import unpacked
from live.base.errors import PersonError
from live.control.events.events import ControlEvent, PatchChanged, StepsAdded, StepsChanged
from live.graph.library_insert import insert_clips
from live.library.clip_text import clips_from_text
from live.motion.step_clip import StepClip
from live.show.core import Show
from live.show.journal.journal_file import read_snapshots
from live.show.journal.journal_reading import Journal
from live.show.journal.skipped_events import left_out
from live.show.load import LoadedShow, show_of
from live.show.patch.patch import Patch
from live.show.patch.reloading import graph_for
from live.show.selection.library_hash import library_hash, steps_hash
from live.show.selection.new_steps import changed_graph, clip_key
from live.show.state.snapshot import SnapshotError, facts_of, patch_hash, restore


class ReplayError(Exception):
    """A journal that cannot be run here; the message says what is missing or different."""


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """A show, and the tick after which it stands."""

    show: Show
    tick: int


def reload(journal: Journal) -> Show:
    """A fresh show of the journal's patch, steps and seed; ReplayError if the steps are not the same any more."""
    return first_start(journal, loaded_by(journal)).show


def loaded_by(journal: Journal) -> LoadedShow:
    """Patch and steps with which the journal's show began, those that came later in reserve; ReplayError as above."""
    changed = (row.event for row in journal.rows_with('"StepsChanged"') if isinstance(row.event, StepsChanged))
    return loaded_of(journal.header, _added(journal), changed)


def loaded_of(header: dict[str, Any], added: Iterable[list[str]], changed: Iterable[StepsChanged] = ()) -> LoadedShow:
    """The same by a journal's header, by what each StepsAdded has added, and by every StepsChanged; ReplayError as
    above."""
    try:
        patch = Patch.model_validate(header["patch"])
        path = Path(header["patch_path"])
        recordings = None if header["recordings"] is None else Path(header["recordings"])
        wanted = header["steps_hash"]
        seed, tempo = header["seed"], header["tempo"]
        if not isinstance(seed, int) or not isinstance(tempo, int | float | None):
            raise TypeError("'seed' is a whole number, 'tempo' a number or null")
    except (KeyError, TypeError, ValueError) as error:
        raise ReplayError(f"the journal's first line does not hold a whole show: {error}") from None
    try:
        later = frozenset(key for keys in added for key in keys)
        names, was = [str(name) for name in header.get("steps", ())], _as_they_were(changed)
        loaded = show_of(patch, path, recordings=recordings, later=later, names=names, was=was)
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


def first_start(journal: Journal, loaded: LoadedShow) -> Start:
    """The journal's show as it began."""
    try:
        return Start(loaded.start(seed=journal.header["seed"], tempo=journal.header["tempo"]), 0)
    except PersonError as error:
        raise ReplayError(str(error)) from None


def start_before(journal: Journal, loaded: LoadedShow, measure: int, problems: list[str]) -> Start:
    """The last snapshot from before `measure` (from 1) begins, or the beginning; `problems`: what is damaged."""
    best, gaps = None, left_out(journal.path)
    for data in read_snapshots(snapshots_of(journal), problems):
        facts = facts_of(data)
        if facts["measure"] < measure and not any(gap.holds(facts["tick"]) for gap in gaps):
            best = data
    if best is not None:
        try:
            return _restored(journal, loaded, best)
        except SnapshotError as error:
            problems.append(str(error))
    return first_start(journal, loaded)


def starts(journal: Journal, loaded: LoadedShow, tick: float, problems: list[str]) -> Iterator[Start]:
    """The snapshots that were taken after `tick`, in order."""
    gaps = left_out(journal.path)
    for data in read_snapshots(snapshots_of(journal), problems):
        now = facts_of(data)["tick"]
        if now > tick and not any(gap.holds(now) for gap in gaps):
            try:
                yield _restored(journal, loaded, data)
            except SnapshotError as error:
                problems.append(str(error))


def snapshots_of(journal: Journal) -> Path:
    """The file of a journal's snapshots; it need not be there."""
    return journal.path.with_name(journal.path.name + ".snap")


def _restored(journal: Journal, loaded: LoadedShow, data: bytes) -> Start:
    """The show of a snapshot, with the patch and the steps that it had by then."""
    facts = facts_of(data)
    for event in _changes(journal):
        if (facts["steps_hash"], facts["patch_hash"]) == (steps_hash(loaded.graph), patch_hash(loaded.patch)):
            break
        try:
            loaded = _changed(loaded, event)
        except ValueError as error:
            raise SnapshotError(f"the journal is damaged: {error}") from None
    return Start(restore(loaded, data), facts["tick"])


def _changed(loaded: LoadedShow, event: ControlEvent) -> LoadedShow:
    """The show as it goes on after an event that changed its patch or steps; ValueError for a damaged one."""
    match event:
        case StepsAdded():
            clips = [loaded.reserve[key] for key in event.clips.split("\n") if key in loaded.reserve]
            return replace(loaded, graph=insert_clips(loaded.graph, clips))
        case StepsChanged():
            graph = changed_graph(loaded.graph, event.gone.split("\n"), clips_from_text(event.now))
            return replace(loaded, graph=graph)
        case PatchChanged():
            patch = Patch.model_validate_json(unpacked(event.patch))
            return replace(loaded, patch=patch, graph=graph_for(loaded.graph, loaded.patch, patch))
        case _:
            return loaded


def _changes(journal: Journal) -> Iterator[ControlEvent]:
    """The events that changed patch or steps, in order."""
    for row in journal.rows_with('"StepsAdded"', '"StepsChanged"', '"PatchChanged"'):
        if isinstance(row.event, StepsAdded | StepsChanged | PatchChanged):
            yield row.event


def _as_they_were(changed: Iterable[StepsChanged]) -> dict[str, StepClip]:
    """Clips whose files were changed or taken away during the show, as they were before."""
    was: dict[str, StepClip] = {}
    came: set[str] = set()
    for event in changed:
        for clip in clips_from_text(event.was):
            if clip_key(clip) not in came:
                was.setdefault(clip_key(clip), clip)
        came.update(clip_key(clip) for clip in clips_from_text(event.now))
    return was


def _added(journal: Journal) -> Iterator[list[str]]:
    """What each event that added steps has added."""
    for row in journal.rows_with('"StepsAdded"'):
        if isinstance(row.event, StepsAdded):
            yield row.event.clips.split("\n")
