"""Where a replay begins: with the show as it began, or with a snapshot; each with the steps that were there by then."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from live.base.errors import PersonError
from live.control.events import StepsAdded
from live.graph.insertion import insert_clips
from live.show.core import Show
from live.show.journal_file import read_snapshots
from live.show.journal_reading import Journal
from live.show.load import LoadedShow, library_hash, show_of
from live.show.patch import Patch
from live.show.snapshot import SnapshotError, facts_of, restore


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
    return loaded_of(journal.header, _added(journal))


def loaded_of(header: dict[str, Any], added: Iterable[list[str]]) -> LoadedShow:
    """The same by a journal's header, and by what each StepsAdded has added; ReplayError as above."""
    try:
        patch = Patch.model_validate(header["patch"])
        path = Path(header["patch_path"])
        recordings = None if header["recordings"] is None else Path(header["recordings"])
        wanted = header["steps_hash"]
        header["seed"], header["tempo"]
    except (KeyError, TypeError, ValueError) as error:
        raise ReplayError(f"the journal's first line does not hold a whole show: {error}") from None
    try:
        later = frozenset(key for keys in added for key in keys)
        loaded = show_of(patch, path, recordings=recordings, later=later)
    except PersonError as error:
        raise ReplayError(str(error)) from None
    found = library_hash(loaded.graph.library)
    if found != wanted:
        raise ReplayError(
            f"the steps have changed since (then {wanted}, now {found}): replay needs the same step files"
        )
    return loaded


def first_start(journal: Journal, loaded: LoadedShow) -> Start:
    """The journal's show as it began."""
    try:
        return Start(loaded.start(seed=journal.header["seed"], tempo=journal.header["tempo"]), 0)
    except PersonError as error:
        raise ReplayError(str(error)) from None


def start_before(journal: Journal, loaded: LoadedShow, measure: int, problems: list[str]) -> Start:
    """The last snapshot from before `measure` (from 1) begins, or the beginning; `problems`: what is damaged."""
    best = None
    for data in read_snapshots(snapshots_of(journal), problems):
        if facts_of(data)["measure"] < measure:
            best = data
    if best is not None:
        try:
            return _restored(journal, loaded, best)
        except SnapshotError as error:
            problems.append(str(error))
    return first_start(journal, loaded)


def starts(journal: Journal, loaded: LoadedShow, tick: float, problems: list[str]) -> Iterator[Start]:
    """The snapshots that were taken after `tick`, in order."""
    for data in read_snapshots(snapshots_of(journal), problems):
        if facts_of(data)["tick"] > tick:
            try:
                yield _restored(journal, loaded, data)
            except SnapshotError as error:
                problems.append(str(error))


def snapshots_of(journal: Journal) -> Path:
    """The file of a journal's snapshots; it need not be there."""
    return journal.path.with_name(journal.path.name + ".snap")


def _restored(journal: Journal, loaded: LoadedShow, data: bytes) -> Start:
    """The show of a snapshot, with the steps that had come by then."""
    facts = facts_of(data)
    if facts["steps_hash"] != library_hash(loaded.graph.library):
        for keys in _added(journal):
            clips = [loaded.reserve[key] for key in keys if key in loaded.reserve]
            loaded = replace(loaded, graph=insert_clips(loaded.graph, clips))
            if facts["steps_hash"] == library_hash(loaded.graph.library):
                break
    return Start(restore(loaded, data), facts["tick"])


def _added(journal: Journal) -> Iterator[list[str]]:
    """What each event that added steps has added."""
    for row in journal.rows_with('"StepsAdded"'):
        if isinstance(row.event, StepsAdded):
            yield row.event.clips.split("\n")
