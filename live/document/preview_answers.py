"""Answers of the preview to questions of pages, as frames: those of the stage's stream, and what is doubtful.

A question is an object: {"id", "from", "to"} or {"id", "measure"} or {"id", "segment"} (`live docs preview`). It names
the document by `document`, a revision, or by `with`, edits that are tried and not saved.
"""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.audio.music_file import MusicFileError
from live.control.audio.waveform import PEAKS_PER_SECOND, read_waveform
from live.document.document_store import DocumentStore
from live.document.edit import EditRefused, parse_edit
from live.document.formation_answers import next_values, option_values, places_values
from live.document.preview import (
    Positions,
    PreviewEngine,
    division_values,
    first_change,
    led_patch,
    plan_faults,
    way_values,
)
from live.document.preview_question import Question, parse_question
from live.document.sheets.sheet_answers import SheetRun, sheet_values, sheets_pdf
from live.document.show_check import ShowCheck, needs_loading
from live.document.step_answers import motion_frames, sequence_values, step_values
from live.show.loader import LoadedShow, adapt_edited_patch, load_from_patch
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import find_resource
from live.show.view.stage_frames import document_frame, joints_frame, positions_frame, waveform_frame

MAX_RANGE: Final = 64
"""Maximum number of measures in an answer."""
MAX_FAULTS: Final = 20
"""Maximum number of faults in a refusal."""
MAX_JOINT_MEASURES: Final = 16
"""Maximum number of measures whose joints are told at once."""
MAX_BRANCHES: Final = 3
"""Edited documents whose simulated measures are kept."""
_MEASURE: Final = re.compile(r"\bmeasure (\d+)\b(?! of)")
_RANGE: Final = PersonError('"from" and "to", "measure" or "segment" expected', '{"id": 1, "from": 57, "to": 60}')


class PreviewAnswers:
    """Keeps the preview of one show's files, which it reads again when they have changed. One thread."""

    def __init__(self, loaded: LoadedShow, store: DocumentStore, *, seed: int | None = None) -> None:
        """`store` has the files of `loaded`; nothing is written. PersonError if the show does not start."""
        self._store, self._seed, self._loaded = store, seed, loaded
        store.check = ShowCheck(loaded.path, loaded.recordings, loaded.tempo)
        self._engine = PreviewEngine(self._with(store.document.patch), seed=seed)
        self._revision = store.revision
        self._asked: tuple[str | int | None, PreviewEngine | SheetRun] = (None, self._engine)
        self._sheets: SheetRun | None = None
        self._branches: list[PreviewEngine] = []  # of other documents, the latest last
        self._notes: list[tuple[PreviewEngine, Patch, list[str]]] = []
        self._waveform: tuple[tuple[Path, int, int], bytes] | None = None  # of a file as it was
        self.on_tick: Callable[[], None] = lambda: None
        """Called after each simulated tick; what it raises ends the answer."""

    def _with(self, written: Patch) -> LoadedShow:
        """Return the show of another patch; PersonError if its steps cannot be loaded."""
        loaded = self._loaded
        if needs_loading(loaded.patch, written) and loaded.recordings is None:
            return load_from_patch(written, loaded.path, tempo=loaded.tempo)
        return replace(loaded, patch=self._adapt(written))

    def _adapt(self, written: Patch) -> Patch:
        loaded = self._loaded
        return adapt_edited_patch(written, loaded.graph, loaded.patch, recordings=loaded.recordings is not None)

    def progress(self) -> str:
        """Return a frame that tells how many measures are simulated for the present question."""
        name, engine = self._asked
        return json.dumps({"kind": "progress", "id": name, "measures": engine.measures})

    def answer(self, values: object) -> Iterator[str | bytes]:
        """Yield the frames that answer a question, `done` or `refused` as the last one."""
        name = values.get("id") if isinstance(values, dict) else None
        name = name if isinstance(name, str | int) else None
        try:
            question = parse_question(values)
            yield from self._frames(question)
            done: dict[str, Any] = {"kind": "done", "id": question.id, "document": self._revision}
        except EditRefused as error:
            done = {
                "kind": "refused",
                "id": name,
                "refused": [fault.to_json_values() for fault in error.faults[:MAX_FAULTS]],
            }
        except (PersonError, OSError) as error:
            words = error.message if isinstance(error, PersonError) else str(error)
            remedy = (error.remedy if isinstance(error, PersonError) else None) or ""
            done = {"kind": "refused", "id": name, "refused": [{"what": words, "remedy": remedy}]}
        yield json.dumps(done)

    def _frames(self, question: Question) -> Iterator[str | bytes]:
        if question.planned and question.edits and (found := self._planned(question)) is not None:
            yield from found
            return
        if question.waveform:
            yield self._music_waveform()
            return
        if question.sheets is not None:
            yield self._sheet_frame(question, question.sheets)
            return
        engine, answers = self._find(question)
        engine.on_tick = self.on_tick
        self._asked = question.id, engine
        library = list(self._library(engine, question, answers))
        if library:
            yield from library
            return
        if question.measure is not None:
            yield from self._moment(engine, question, question.measure - 1.0)
            return
        first, last = self._range(engine, question)
        if first and question.positions != "none":
            there = (
                engine.samples(first - 1.0, float(last))
                if question.positions == "samples"
                else [engine.at(measure - 1.0) for measure in range(first, last + 2)]
            )
            yield from _positions(engine, question, there)
            if question.joints:
                yield from _bodies(engine, question, first, last)
        plan = engine.plan(first, last) if first and (question.ways or question.notes) else None
        head = {"id": question.id, "document": self._revision, "from": first, "to": last}
        if plan is not None and question.ways:
            who = np.ones(plan.ways.shape[1], np.bool_)
            if question.segment is not None:
                who = engine.dancers_of(question.segment - 1)
            ways = way_values(plan)
            dancers = np.flatnonzero(who).tolist()
            rows = [ways[dancer] for dancer in dancers]
            yield json.dumps({"kind": "ways", **head, "dancers": [dancer + 1 for dancer in dancers], "ways": rows})
        if first and question.division:
            yield json.dumps({"kind": "division", **head, "division": division_values(engine, first, last)})
        if question.notes or answers:
            faults = {} if plan is None else plan_faults(engine, plan, first)
            doubts = self._doubts(engine, first, last) if question.notes else []
            yield json.dumps({"kind": "notes", **head, **faults, "notes": doubts, "answers": answers})

    def _planned(self, question: Question) -> list[str] | None:
        """Return the frames of planned ways of an edited document from where everybody stands in the present one; None
        if they stand elsewhere then, and have to be simulated."""
        patch, answers = self._patch_of(question)
        patch = self._adapt(patch)
        engine = self._preview_of(led_patch(self._store.document.patch)) if question.led else self._engine
        engine.on_tick = self.on_tick
        self._asked = question.id, engine
        first, last = self._range(engine, question)
        change = first_change(engine.patch, patch)
        if engine.patch != patch and (change is None or change < first or needs_loading(engine.patch, patch)):
            return None
        plan = engine.plan(first, last, patch)
        head = {"id": question.id, "document": self._revision, "from": first, "to": last}
        dancers = list(range(1, plan.ways.shape[1] + 1))
        faults = plan_faults(engine, plan, first)
        return [
            json.dumps({"kind": "ways", **head, "dancers": dancers, "ways": way_values(plan)}),
            json.dumps({"kind": "notes", **head, **faults, "notes": [], "answers": answers}),
        ]

    def _library(
        self, engine: PreviewEngine, question: Question, answers: list[dict[str, Any]]
    ) -> Iterator[str | bytes]:
        """Yield the answer to a question about steps or formations; nothing if it asks for none. PersonError for
        options of an edit that is refused."""
        head = {"id": question.id, "document": self._revision}
        if question.steps:
            yield json.dumps({"kind": "steps", **head, "steps": step_values(engine.graph)})
        if question.step is not None:
            for frame in motion_frames(engine.graph, question.step, question.takes):
                yield frame if isinstance(frame, bytes) else json.dumps(frame | head)
        if question.sequence is not None:
            yield json.dumps(sequence_values(engine.graph, question.sequence) | head)
        if question.places:
            yield json.dumps(places_values(engine, question.places) | head)
        if question.element is not None:
            yield json.dumps(next_values(engine, question.element) | head)
        if question.options:
            if question.segment is None:
                raise PersonError('"options" are those of a segment', '{"id": 1, "segment": 3, "options": [{}]}')
            for fault in (fault for answer in answers for fault in answer.get("refused", ())):
                raise PersonError(fault["what"], fault.get("remedy"))
            yield json.dumps(option_values(engine, question.segment, question.options) | head)

    def _range(self, engine: PreviewEngine, question: Question) -> tuple[int, int]:
        """Return the first and last measure (from 1) that are asked for; zeros for none. PersonError if it is wrong."""
        if question.segment is not None:
            first, last = engine.measures_of(question.segment - 1)
            return first, min(last, first + MAX_RANGE - 1)
        if question.first is None:
            if question.last is None and question.positions == "none" and not question.ways:
                return 0, 0  # the notes of the whole document
            raise _RANGE
        first, last = question.first, question.last or question.first
        if last < first:
            raise PersonError(f"measures {first} to {last}: the first one comes last", '{"from": 5, "to": 8}')
        if last - first >= MAX_RANGE:
            raise PersonError(f"{last - first + 1} measures at once", f"at most {MAX_RANGE}")
        return first, last

    def _find(self, question: Question) -> tuple[PreviewEngine, list[dict[str, Any]]]:
        """Return the preview of the document that is asked for, and the answers of the edits."""
        patch, answers = self._patch_of(question)
        return self._preview_of(patch), answers

    def _patch_of(self, question: Question) -> tuple[Patch, list[dict[str, Any]]]:
        """Return the patch that is asked for, and the answers of the edits."""
        self._store.refresh()
        patch = self._store.document.patch
        if self._store.revision != self._revision:
            self._engine = self._moved_to(patch)
            self._branches = [one for one in self._branches if one is not self._engine]
            self._revision = self._store.revision
        if question.document not in (None, self._revision):
            patch = self._store.patch_at(question.document or 0)
        edits, answers = [], list[dict[str, Any]]()
        for number, values in enumerate(question.edits, start=1):
            try:
                edits.append(parse_edit(values))
            except PersonError as error:
                raise PersonError(f"with, edit {number}: {error.message}", error.remedy) from None
        if edits:
            if question.document not in (None, self._revision):
                edits = [replace(edit, base=edit.base or question.document) for edit in edits]
            patch, answers = self._store.attempt(edits)
        return led_patch(patch) if question.led else patch, answers

    def _known(self, patch: Patch) -> PreviewEngine | None:
        return next((engine for engine in (self._engine, *self._branches) if engine.patch == patch), None)

    def _moved_to(self, written: Patch) -> PreviewEngine:
        """Return the preview of the document as it is written now."""
        patch = self._adapt(written)
        if (known := self._known(patch)) is not None:
            return known
        if needs_loading(self._engine.patch, patch):
            return PreviewEngine(self._with(written), seed=self._seed)
        self._engine.set_patch(patch)
        return self._engine

    def _preview_of(self, written: Patch) -> PreviewEngine:
        """Return the preview of a patch: one that is there, or a new one, which shares what it can."""
        patch = self._adapt(written)
        if (known := self._known(patch)) is not None:
            return known
        if needs_loading(self._engine.patch, patch):
            engine = PreviewEngine(self._with(written), seed=self._seed)
        else:
            engine = self._engine.branch(patch)
        self._branches = [*self._branches, engine][-MAX_BRANCHES:]
        return engine

    def _sheet_frame(self, question: Question, paper: str) -> str | bytes:
        """Return the pages of sheets, or all of them as a PDF. PersonError if the show does not start, or refuses the
        edits."""
        patch, answers = self._patch_of(question)
        for fault in (fault for answer in answers for fault in answer.get("refused", ())):
            raise PersonError(fault["what"], fault.get("remedy"))
        loaded = self._with(patch)
        if self._sheets is None or self._sheets.patch != loaded.patch:
            self._sheets = SheetRun(loaded, seed=self._seed)
        self._asked = question.id, self._sheets
        book = self._sheets.book(self.on_tick)
        if question.pdf:
            return document_frame(sheets_pdf(book, paper, self.on_tick))
        return json.dumps(sheet_values(book, paper, question.dancer) | {"id": question.id, "document": self._revision})

    def _music_waveform(self) -> bytes:
        """Return the frame of the music's waveform; PersonError if there is no music."""
        self._store.refresh()
        music = self._store.document.patch.music
        path = None if music.file is None else find_resource(music.file, self._loaded.path)
        if path is None:
            told = "this show has no music" if music.file is None else f"there is no file {music.file!r}"
            raise PersonError(told, 'name it as `file` of `[music]`, or put the file into the folder "music"')
        facts = path.stat()
        key = path, facts.st_mtime_ns, facts.st_size
        if self._waveform is None or self._waveform[0] != key:
            try:
                peaks = read_waveform(path, self.on_tick)
            except MusicFileError as error:
                raise PersonError(str(error)) from None
            self._waveform = key, waveform_frame(PEAKS_PER_SECOND, peaks)
        return self._waveform[1]

    def _moment(self, engine: PreviewEngine, question: Question, danced: float) -> Iterator[str | bytes]:
        there = engine.at(danced)
        yield from _positions(engine, question, [there])
        if question.joints:
            dancers = question.joints if isinstance(question.joints, list) else None
            yield joints_frame(there.tick, engine.view_at(danced).joint_position[: len(there.place)], dancers)

    def _doubts(self, engine: PreviewEngine, first: int, last: int) -> list[dict[str, Any]]:
        """Return the doubts of `live check`, each with the measure that it names; for a range only those within it, and
        those of no measure."""
        kept = next((words for one, patch, words in self._notes if one is engine and patch is engine.patch), None)
        if kept is None:
            kept = engine.notes()
            self._notes = [*self._notes, (engine, engine.patch, kept)][-MAX_BRANCHES:]
        rows = []
        for words in kept:
            found = _MEASURE.search(words)
            measure = int(found[1]) if found else None
            if not first or measure is None or first <= measure <= last:
                rows.append({"measure": measure, "what": words})
        return rows


def _bodies(engine: PreviewEngine, question: Question, first: int, last: int) -> Iterator[bytes]:
    """Yield the joints of each sample of measures `first` to `last` (from 1); PersonError for too many."""
    if last - first >= MAX_JOINT_MEASURES:
        raise PersonError(f"joints of {last - first + 1} measures at once", f"at most {MAX_JOINT_MEASURES}")
    dancers = question.joints if isinstance(question.joints, list) else None
    for tick, joints in engine.bodies(first - 1.0, float(last)):
        yield joints_frame(tick, joints, dancers)


def _positions(engine: PreviewEngine, question: Question, there: list[Positions]) -> Iterator[str | bytes]:
    """Yield the order of the dancers, what each binary frame shows, and these frames."""
    count = len(there[0].place) if there else 0
    yield json.dumps({"kind": "dancers", "revision": count, "ids": list(range(1, count + 1))})
    moments = []
    for one in there:
        moment: dict[str, Any] = {
            "tick": one.tick,
            "measure": round(one.measure + 1.0, 4),
            "time_s": round(one.tick * TICK, 3),
        }
        if question.positions == "measures":
            moment["steps"] = [engine.describe(node) for node in one.node.tolist()]
        moments.append(moment)
    yield json.dumps({"kind": "moments", "id": question.id, "moments": moments})
    for one in there:
        yield positions_frame(one.tick, one.place, one.heading, one.present)


def open_answers(loaded: LoadedShow, *, seed: int | None = None) -> PreviewAnswers:
    """Return the answers for the files of a show, without writing any. PersonError if they are not valid."""
    return PreviewAnswers(loaded, DocumentStore(loaded.path, tables=loaded.tables, dry=True), seed=seed)
