"""Edits of a running show's files: each is checked with the show, saved, and danced from the next free measure line."""

import json
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any, Final

from live.app.offline.music_map import measures_of_resource
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS, run_once
from live.control.events.document import (
    EditDocument,
    KeepCue,
    KeepFormation,
    KeepMeasures,
    KeepScene,
    KeepWays,
    RedoDocument,
    ReplaceMusic,
    RestoreDocument,
    UndoDocument,
)
from live.control.events.event import ControlEvent
from live.document.document_store import Accepted, DocumentStore, MakeEdits, refused_json_values
from live.document.edit import Edit, EditRefused, parse_edits
from live.document.history import Revision
from live.document.music_edits import replace_music
from live.document.place import refuse
from live.document.show_check import show_faults
from live.document.take import TakeRecorder, formation_table, keep_edits
from live.document.taken_ways import WayRecorder, evolution_table
from live.show.background_work import short_switch_interval
from live.show.group.stage_check import stage_faults
from live.show.patch.hot_reload import Candidate, PatchWatch
from live.show.patch.patch import Patch
from live.show.patch.section_score import formation_names
from live.show.patch.toml_model import TomlSources, key_text
from live.show.show import Show
from live.show.stages.now import Now

Keep = KeepMeasures | KeepWays | KeepFormation | KeepScene | KeepCue
Request = EditDocument | UndoDocument | RedoDocument | RestoreDocument | ReplaceMusic | Keep
Make = Callable[[DocumentStore], Accepted]
"""Makes one revision of what was prepared."""
Change = tuple[str | int | None, Callable[[], Accepted]]
"""The sender's name for a change, and what makes it."""
WORDS: Final[dict[type, str]] = {
    EditDocument: "edit", UndoDocument: "undo", RedoDocument: "redo", RestoreDocument: "restore",
    ReplaceMusic: "music", KeepMeasures: "keep", KeepWays: "keep", KeepFormation: "keep",
    KeepScene: "keep", KeepCue: "keep",
}  # fmt: skip
MAX_ANSWERS_LENGTH: Final = 6000
"""Maximum length of the published answers [characters]; it has to fit into one OSC packet."""
MAX_WAITING: Final = 1000
"""Maximum number of edits that wait; more are refused."""
SHOWN_FAULTS: Final = 4
LOGGED: Final = 20
"""Number of revisions that are published."""


class DocumentService:
    """The document of a running show. Its edits are applied one after the other in the thread of the patch watch."""

    def __init__(self, watch: PatchWatch, show: Show, path: Path, open_store: Callable[[], DocumentStore]) -> None:
        """`path` is the patch's file; `open_store` reads the show's files, for the first edit."""
        self._watch, self._show, self._path, self._open_store = watch, show, path, open_store
        self._store: DocumentStore | None = None
        self._recorder, self._way_recorder = TakeRecorder(show), WayRecorder(show)
        show.frame.router.observers.append(self._observe)
        self._candidate: Candidate | None = None  # the patch that was checked last
        self._waiting = 0
        self._answers: deque[dict[str, Any]] = deque(maxlen=64)
        self._accepted_in: dict[int, int] = {}  # measure of the show in which a revision was accepted
        self._danced_in: dict[tuple[int, int], int] = {}  # last measure of the show at a place of the score
        self._last_measure = -1
        self._accepted = self._refused = 0
        self._log: str | None = None
        self.change_listeners: list[Callable[[Revision, Patch], None]] = []
        """Called with each accepted revision and its patch. Thread: the watching one."""
        self.answer_listeners: list[Callable[[Request, dict[str, Any]], None]] = []
        """Called with each answer and the request that it belongs to. Thread: any."""
        self.published = ""
        """The latest answers as JSON."""

    # -- thread: the show's ------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Do nothing; the patch watch has the thread."""

    def stop(self) -> None:
        """Do nothing: edits that wait when the show ends are not saved, and were not answered."""

    def frame(self) -> None:
        """Note what is being danced."""
        self._recorder.frame()
        self._way_recorder.frame()
        measure = self._show.span.number
        if measure != self._last_measure and measure >= 0:
            self._last_measure = measure
            place = self._show.score_runner.score.place(measure)
            self._danced_in[place.section, place.measure] = measure

    def _observe(self, event: ControlEvent, now: Now) -> None:
        try:
            self._recorder.observe(event, now)
        except Exception as error:  # a fault of the program: the show goes on without this note
            FAULTS.record("the recorder of takes", error)

    def handle(self, event: ControlEvent) -> None:
        """Pass an edit on to the watching thread."""
        if not isinstance(event, Request):
            return
        if self._waiting >= MAX_WAITING:
            self._refused += 1
            self._tell(refused_json_values(None, refuse((), "too many edits wait", "send it again later")), event)
            return
        self._waiting += 1
        if isinstance(event, ReplaceMusic):  # it is heard first, which takes seconds
            task = "the measures of other music", partial(self._prepare, event, partial(self._music, event))
            threading.Thread(target=run_once, args=task, name="music", daemon=True).start()
            return
        self._prepare(event, partial(self._keep, event) if isinstance(event, Keep) else None)

    def _prepare(self, event: Request, prepare: Callable[[], Make] | None) -> None:
        """Prepare a request, and pass it on to the watching thread. Thread: any."""
        try:
            make = None if prepare is None else prepare()
        except PersonError as error:
            answer = refused_json_values(None, refuse((), error.message, error.remedy or ""))
            self._watch.do(lambda: self._refuse(event, answer))
            return
        self._watch.do(lambda: self._serve(event, make))

    def _music(self, event: ReplaceMusic) -> Make:
        """Return what replaces the music; PersonError if a file is missing or no measures are found."""
        measures = measures_of_resource(self._path, event.file, event.lines)
        return lambda store: replace_music(store, event.file, measures, event.by)

    def _keep(self, event: Keep) -> Make:
        """Return what keeps what an event names; PersonError if there is no such thing."""
        make = self._keep_edits(event)
        return lambda store: store.edit_together(make, "keep", event.by)

    def _keep_edits(self, event: Keep) -> MakeEdits:
        """Return what makes the edits that keep what an event names, as it is now; PersonError if there is no such
        thing."""
        match event:
            case KeepMeasures():
                take = self._recorder.last(event.measures)
                if not take:
                    raise PersonError("no whole measure was danced yet", "wait for the next measure line")
                return lambda patch: keep_edits(take, patch, event.name)
            case KeepWays():
                walked = self._way_recorder.last(event.measures, event.group)
                return lambda patch: [
                    _put("evolution", evolution_table(event.name, walked), [one.name for one in patch.evolution])
                ]
            case KeepFormation():
                made = self._show.motion.evolutions.formations.get(event.name.casefold().strip())
                if made is None:
                    known = ", ".join(one.name for one in self._show.motion.evolutions.formations.values())
                    raise PersonError(f"no formation is called {event.name!r}", f"there are: {known or 'none'}")
                table = formation_table(made.name, made.spec)
                return lambda patch: [_put("formation", table, formation_names(patch.formation))]
            case KeepScene():
                table = {"name": event.name, "set": self._show.desk.scenes.written(event.name)}
                return lambda patch: [_put("scene", table, [scene.name for scene in patch.scene])]
            case KeepCue():
                table = {"name": event.name, "set": self._show.desk.scenes.written()}
                cue = {"name": event.name, "scene": event.name}
                return lambda patch: [
                    _put("scene", table, [scene.name for scene in patch.scene]),
                    _put("cue", cue, [one.name for one in patch.cue]),
                ]

    def do(self, task: Callable[[], None]) -> None:
        """Run a task soon in the watching thread."""
        self._watch.do(task)

    def status(self) -> dict[str, Any]:
        """Return revision, and the number of accepted and refused edits."""
        return {"revision": self.revision, "accepted": self._accepted, "refused": self._refused}

    @property
    def revision(self) -> int | None:
        """The present revision; None before the first edit."""
        return None if self._store is None else self._store.revision

    @property
    def log(self) -> str | None:
        """The latest revisions as JSON; None before the first edit."""
        return self._log

    # -- thread: the watching one ------------------------------------------------------------------------------------

    def present(self) -> tuple[int, Patch]:
        """Return the present revision and its patch; those that the show dances if the files are not valid."""
        try:
            store = self._opened()
            store.refresh()
        except (PersonError, OSError):
            return self.revision or 0, self._show.patch
        return store.revision, store.document.patch

    def _refuse(self, event: Request, answer: dict[str, Any]) -> None:
        self._waiting -= 1
        self._refused += 1
        self._publish(answer, event)

    def _serve(self, event: Request, make: Make | None) -> None:
        self._waiting -= 1
        try:
            with short_switch_interval():
                for answer in self._answer(event, make):
                    self._publish(answer, event)
        except Exception as error:  # a fault of the program: the show and the next edits go on
            FAULTS.record("an edit of the document", error)
            self._publish({"id": None, "refused": [{"what": f"{type(error).__name__}: {error}"}]}, event)

    def _answer(self, event: Request, make: Make | None) -> Iterator[dict[str, Any]]:
        """Serve a request and yield its answers."""
        try:
            store = self._opened()
            changes = self._changes(store, event, make)
        except (PersonError, OSError) as error:
            self._refused += 1
            yield refused_json_values(None, refuse((), str(error)))
            return
        for edit_id, change in changes:
            try:
                accepted, waits = self._take(store, change)
                answer = accepted.to_json_values(edit_id) | ({"waits": list(waits)} if waits else {})
                self._accepted += 1
            except EditRefused as error:
                answer = refused_json_values(edit_id, error)
                self._refused += 1
            yield answer

    def _changes(self, store: DocumentStore, event: Request, make: Make | None) -> list[Change]:
        """Return the changes that an event asks for; PersonError if it cannot be read."""
        if make is not None:
            return [(None, partial(make, store))]
        match event:
            case EditDocument():
                text = event.edit if event.edit.lstrip().startswith("[") else f"[{event.edit}]"
                return [(edit.id, partial(store.edit, edit)) for edit in parse_edits(text, "edit")]
            case UndoDocument():
                return [(None, partial(self._undo, store, event.by or None))]
            case RedoDocument():
                return [(None, partial(store.undo, event.by or None, redo=True))]
            case RestoreDocument():
                return [(None, partial(store.restore, event.revision, event.by))]
        raise PersonError("nothing to do")

    def _undo(self, store: DocumentStore, by: str | None) -> Accepted:
        self._refuse_danced(store, store.last_in_force(by))
        return store.undo(by)

    def _opened(self) -> DocumentStore:
        if self._store is None:
            self._store = self._open_store()
            self._store.check = self._check
        return self._store

    def _check(self, patch: Patch, former: Patch | None) -> list[PersonError]:
        """Return why the running show cannot take a patch in place of `former`; keep what it would take."""

        def build(one: Patch) -> None:
            self._candidate = self._watch.candidate(one)

        self._candidate = None
        return show_faults(build, patch) or self._stage_faults(former)

    def _stage_faults(self, former: Patch | None) -> list[PersonError]:
        """Return whom the stage of the checked patch strands."""
        made = None if self._candidate is None else self._candidate.new_show
        return [] if made is None or former is None else stage_faults(made, former)

    def _take(self, store: DocumentStore, change: Callable[[], Accepted]) -> tuple[Accepted, tuple[str, ...]]:
        """Save a change, and have the show take it; return also the keys that it changed for the next start alone."""
        before = store.revision
        waits: tuple[str, ...] = ()
        accepted = change()
        if store.revision != before and self._candidate is not None:
            self._accepted_in[store.revision] = self._show.span.number
            waits = _among(self._candidate.deferred_keys, accepted.revision.keys)
            try:
                self._watch.offer(self._candidate, TomlSources(store.document.files))
            except PersonError as error:  # it is saved, and acts from the next start on
                self._watch.problem = str(error)
            if not store.has_changed():
                self._watch.skip_present_files()
        self._candidate = None
        if store.revision != before:
            for listen in self.change_listeners:
                listen(accepted.revision, store.document.patch)
        return accepted, waits

    def _refuse_danced(self, store: DocumentStore, target: Revision | None) -> None:
        """Raise EditRefused for the undo of a revision whose measures have been danced since."""
        since = None if target is None else self._accepted_in.get(target.number)
        if target is None or since is None:
            return
        for key in {key[:2] for key in target.keys}:
            rows = getattr(store.document.patch, str(key[0]), None)
            if not isinstance(rows, tuple) or len(key) < 2 or not isinstance(key[1], int) or key[1] >= len(rows):
                continue
            entry = rows[key[1]]
            measure = getattr(entry, "measure", None)
            place = None if measure is None else self._show.score_runner.score.place_of(entry.section, measure)
            if place is not None and self._danced_in.get(place, -1) > since:
                where = f" of {entry.section}" if entry.section else ""
                words = f"measure {measure:g}{where} has been danced with it"
                raise refuse(key, words, "change it by a new edit, which acts when that measure comes again")

    def _tell(self, answer: dict[str, Any], event: Request) -> None:
        for listen in self.answer_listeners:
            listen(event, answer)

    def _publish(self, answer: dict[str, Any], event: Request) -> None:
        """Add an answer to those that everybody can read, in a short form."""
        self._tell(answer, event)
        answer = {**answer, "what": WORDS[type(event)]}
        if "refused" in answer:
            faults = answer["refused"]
            short = {**answer, "refused": faults[:SHOWN_FAULTS], "faults": len(faults)}
        else:
            inverse = answer["inverse"]
            short = {**answer, "inverse": None if inverse is None else {**inverse, "exact": None}}
            if "notes" in answer:
                short |= {"notes": answer["notes"][:SHOWN_FAULTS], "note_count": len(answer["notes"])}
        self._answers.append(short)
        text = json.dumps(list(self._answers))
        while len(text) > MAX_ANSWERS_LENGTH and len(self._answers) > 1:
            self._answers.popleft()
            text = json.dumps(list(self._answers))
        if len(text) > MAX_ANSWERS_LENGTH:  # one long answer: without its values
            self._answers[0] = {key: short[key] for key in ("id", "what", "revision", "faults") if key in short}
            text = json.dumps(list(self._answers))
        self.published = text
        if self._store is not None:
            latest = self._store.revisions[-LOGGED:]
            rows = [{"revision": one.number, "date": one.date, "by": one.by, "text": one.text} for one in latest]
            self._log = json.dumps(rows)


def _among(waiting: tuple[str, ...], keys: Iterable[tuple[Any, ...]]) -> tuple[str, ...]:
    """Return those of the `waiting` keys that a change of `keys` concerns."""
    changed = [(*key_text(key).split("."),) for key in keys]
    parts = {one: (*one.split("."),) for one in waiting}
    return tuple(
        one for one, own in parts.items() if any(own[: len(key)] == key or key[: len(own)] == own for key in changed)
    )


def _put(kind: str, table: dict[str, Any], known: Iterable[str]) -> Edit:
    """Return the edit that writes an entry: over the one of the same name, or a new one."""
    named = str(table["name"]).casefold().strip() in {name.casefold().strip() for name in known}
    return Edit("set", (kind, table["name"]), table) if named else Edit("insert", (kind,), table)


def edit_date() -> str:
    """Return the present date and time, for people who read a history."""
    return datetime.now().astimezone().isoformat(timespec="seconds")
