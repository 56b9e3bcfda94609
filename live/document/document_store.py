"""A document on disk: edits are checked, saved atomically and kept in a history.

Changes that another program makes to the files are taken in.
One store at a time writes a show; it decides the order of all edits.
"""

import contextlib
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import IO, Any, Final

from live.base.errors import PersonError
from live.base.system.file_lock import lock_file
from live.document.document import Document, DocumentFile, Splice
from live.document.edit import Edit, EditRefused, Fault
from live.document.edit_actions import apply_edits, concerned
from live.document.history import (
    Revision,
    What,
    check_conflict,
    check_order,
    differences,
    history_line,
    in_force,
    read_history,
    rebased,
    texts_at,
    texts_hash,
)
from live.document.place import as_written, refuse
from live.library.disk_cache import read_regular_file
from live.library.whole_file import write_atomically
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import patch_files
from live.show.patch.patch_search_path import PatchError
from live.show.patch.toml_model import MAX_BYTES, BridgeTables, key_text, read_text

HISTORY_FOLDER: Final = ".history"
_BOM: Final = b"\xef\xbb\xbf"
Check = Callable[[Patch, Patch | None], Sequence[PersonError]]
"""Returns why a show of a valid patch would not start, or would strand dancers that the patch before did not (None:
it goes back to an earlier text), with keys where the errors have a place."""
MakeEdits = Callable[[Patch], Sequence[Edit]]
"""Makes edits for the patch as it is written now."""


@dataclass(frozen=True, slots=True)
class Accepted:
    """The answer to an edit that was accepted."""

    revision: Revision
    notes: tuple[Fault, ...] = ()
    """What no longer fits, though it is valid."""

    def to_json_values(self, edit_id: str | int | None) -> dict[str, Any]:
        """Return it as values for JSON: the answer to an edit."""
        inverse = self.revision.inverse
        exact = tuple(splice.reverse() for splice in reversed(self.revision.splices))
        kept = None if inverse is None else replace(inverse, base=self.revision.number, exact=exact).to_json_values()
        answer = {"id": edit_id, "revision": self.revision.number, "inverse": kept}
        return answer | ({"notes": [note.to_json_values() for note in self.notes]} if self.notes else {})


def refused_json_values(edit_id: str | int | None, error: EditRefused) -> dict[str, Any]:
    """Return the answer to a refused edit as values for JSON."""
    return {"id": edit_id, "refused": [fault.to_json_values() for fault in error.faults]}


class DocumentStore:
    """The document of one patch, its files and its history."""

    def __init__(
        self, path: Path, *, tables: BridgeTables = (), check: Check | None = None,
        date: Callable[[], str] = lambda: "", dry: bool = False,
    ) -> None:  # fmt: skip
        """Open the patch in `path`; PatchError if it is not valid.

        `date` gives the date of a revision, for people. With `dry` nothing is written.
        """
        self.path, self._tables, self._date, self._dry = path, tables, date, dry
        self.check = check
        """What a patch has to pass besides its own checks."""
        self._stamps: dict[str, tuple[int, ...]] = {}
        self._marks: set[str] = set()  # files that begin with a byte order mark
        self.problem = ""
        """Why the files cannot be edited now: another program made them invalid; empty if they can."""
        self.document = self._read()
        folder = path.parent / HISTORY_FOLDER
        self._log, self._copies = folder / f"{path.stem}.jsonl", folder / path.stem
        self._unwritten: list[Revision] = []  # they are not in the history's file yet
        self._known_log_size = 0
        self.revisions = self._open_history()
        """All revisions that are known, the oldest first; its texts are those after it."""

    @property
    def revision(self) -> int:
        """The present revision."""
        return self.revisions[-1].number

    # Files

    def _read(self) -> Document:
        files, marks, stamps = [], set(), {}
        for file in patch_files(self.path):
            name = file.relative_to(self.path.parent).as_posix()
            stamps[name] = _stamp(file)
            files.append((name, read_text(file, "patch")))
            if read_regular_file(file, MAX_BYTES).startswith(_BOM):
                marks.add(name)
        try:
            document = Document(files, path=self.path, tables=self._tables)
        except PersonError as error:
            raise PatchError(error.message, error.remedy, error.key_path, error.faults) from None
        self._stamps, self._marks = stamps, marks
        return document

    def has_changed(self) -> bool:
        """Return whether another program changed the files since they were read or written."""
        try:
            names = {file.relative_to(self.path.parent).as_posix(): _stamp(file) for file in patch_files(self.path)}
        except (OSError, PersonError):
            return True
        return names != self._stamps

    def refresh(self) -> bool:
        """Take in what another program changed in the files; return whether they are another revision now.

        An invalid file is told in `problem`, and the document stays as it was.
        """
        if self._log_size() != self._known_log_size:  # another program edited this document
            self.document, self.problem = self._read(), ""
            self.revisions = self._open_history()
            return True
        if not self.has_changed():
            return False
        former = _block_texts(self.document)
        try:
            document = self._read()
        except (PersonError, OSError) as error:
            self.problem = f"another program changed the files, and they are not valid now: {error}"
            return False
        self.problem = ""
        splices = differences(former, _block_texts(document))
        self.document = document
        if not splices:
            return False
        self.revisions.append(self._revision("files", splices=tuple(splices)))
        self._unwritten.append(self.revisions[-1])
        return True

    # History

    def _log_size(self) -> int:
        with contextlib.suppress(OSError):
            return self._log.stat().st_size
        return 0

    def _open_history(self) -> list[Revision]:
        self._unwritten, self._known_log_size = [], self._log_size()
        texts = {file.name: file.text for file in self.document.files}
        revisions = read_history(self._log)
        copies = {name: text for name in self._copy_names() if (text := self._read_copy(name)) is not None}
        if revisions and revisions[-1].texts != texts_hash(texts):
            last = revisions[-1]
            try:
                if last.texts != texts_hash(copies):
                    raise LookupError
                former = {name: DocumentFile(name, text, self.path).texts for name, text in copies.items()}
            except (LookupError, PersonError):  # nobody knows any more what the last revision looked like
                revisions = [Revision(last.number + 1, "files", date=self._date(), texts=texts_hash(texts))]
                self._unwritten = revisions[:]
                return revisions
            splices = tuple(differences(former, _block_texts(self.document)))
            change = Revision(last.number + 1, "files", date=self._date(), splices=splices, texts=texts_hash(texts))
            revisions.append(change)
            self._unwritten = [change]
        if not revisions:
            revisions = [Revision(0, "files", date=self._date(), texts=texts_hash(texts))]
            self._unwritten = revisions[:]
        return revisions

    def _copy_names(self) -> list[str]:
        with contextlib.suppress(OSError):
            found = (file for file in sorted(self._copies.rglob("*.toml")) if file.is_file())
            return [file.relative_to(self._copies).as_posix() for file in found][:1000]
        return []

    def _read_copy(self, name: str) -> str | None:
        with contextlib.suppress(OSError, ValueError):
            return (self._copies / name).read_bytes().decode()
        return None

    def _revision(self, what: What, **values: Any) -> Revision:
        texts = {file.name: file.text for file in self.document.files}
        return Revision(self.revision + 1, what, date=self._date(), texts=texts_hash(texts), **values)

    @contextlib.contextmanager
    def _opened_log(self) -> Iterator[IO[bytes]]:
        """Open the history for one writer at a time; what was appended is removed again if the block fails."""
        self._log.parent.mkdir(exist_ok=True)
        with self._log.open("ab+") as log:
            lock_file(log, within=None)
            size = log.seek(0, os.SEEK_END)
            if size != self._known_log_size or self.has_changed():
                raise refuse((), "another program changed the files in this moment", "look again, and repeat it")
            try:
                yield log
                log.flush()
            except BaseException:
                log.truncate(size)
                raise
            self._known_log_size = log.seek(0, os.SEEK_END)

    def _copy_texts(self, changed: set[str]) -> None:
        """Keep a copy of the changed files, from which a later change by another program is known."""
        files = {file.name: file for file in self.document.files}
        missing = {*files} - {*self._copy_names()}
        with contextlib.suppress(OSError, PersonError):  # without it, that change has no earlier state
            for name in missing | changed:
                copy = self._copies / name
                copy.parent.mkdir(parents=True, exist_ok=True)
                if name in files:
                    write_atomically(files[name].text.encode(), copy, "history")
                else:
                    copy.unlink(missing_ok=True)

    # Edits

    def edit(self, edit: Edit) -> Accepted:
        """Apply, check and save an edit; EditRefused with all faults leaves document and files as they were."""
        self._take_in()
        return self._commit(self._rebased(edit), "edit", by=edit.by)

    def _rebased(self, edit: Edit) -> list[Edit]:
        """Return the parts of an edit as they are written now; EditRefused if nobody can say what they mean now."""
        later = self._since(edit.base)
        if len(edit.parts) > 1 and later:
            check_order(edit.parts, later)
        return [rebased(one, later) for one in edit.parts]

    def edit_together(self, make: MakeEdits, what: What, by: str) -> Accepted:
        """Apply edits as one revision, which is undone as one; EditRefused with all faults changes nothing."""
        self._take_in()
        return self._commit(make(self.document.patch), what, by=by)

    def attempt(self, edits: Sequence[Edit]) -> tuple[Patch, list[dict[str, Any]]]:
        """Return the patch that edits would give, one after the other, and their answers as values for JSON; those that
        are refused are left out. Document, files and history stay as they are."""
        dry, former, count = self._dry, self.document.patch, len(self.revisions)
        self._dry, answers = True, list[dict[str, Any]]()
        try:
            for edit in edits:
                try:
                    answers.append(self._commit(self._rebased(edit), "edit", by=edit.by).to_json_values(edit.id))
                except EditRefused as error:
                    answers.append(refused_json_values(edit.id, error))
            return self.document.patch, answers
        finally:
            tried = [splice for one in self.revisions[count:] for splice in one.splices]
            del self.revisions[count:]
            self._take_back(tried, former)
            self._dry = dry

    def patch_at(self, number: int) -> Patch:
        """Return the patch of an earlier revision; EditRefused if it is not known or not valid."""
        if number == self.revision:
            return self.document.patch
        texts = list(self._texts_at(number).items())
        try:
            return Document(texts, path=self.path, tables=self._tables).patch
        except PersonError as error:
            raise EditRefused(Fault(error.message, remedy=error.remedy or "")) from None

    def _texts_at(self, number: int) -> dict[str, str]:
        try:
            return texts_at(self.document, self.revisions, number)
        except LookupError:
            known = f"the history reaches from {self.revisions[0].number} to {self.revision}"
            raise refuse((), f"there is no revision {number}", known) from None

    def _take_in(self) -> None:
        self.refresh()
        if self.problem:
            raise EditRefused(Fault(self.problem, str(self.path), remedy="mend them there first"))

    def _since(self, base: int | None) -> list[Revision]:
        """Return the revisions after `base`."""
        if base is None:
            return []
        if not self.revisions[0].number <= base <= self.revision:
            known = f"known are {self.revisions[0].number} to {self.revision}"
            raise EditRefused(Fault(f"base: there is no revision {base}", field="base", remedy=known))
        return in_force(self.revisions[base - self.revisions[0].number + 1 :])

    def _commit(self, edits: Sequence[Edit], what: What, *, by: str, of: int | None = None) -> Accepted:
        former, first = self.document.patch, edits[0]
        applied = apply_edits(self.document, edits)
        try:
            check_conflict(first, applied.keys, self._since(first.base))
            self._try_patch(former if what in ("edit", "keep", "music") and not first.exact else None)
            revision = self._revision(
                what, by=by, of=of, edit=replace(first, exact=()),
                inverse=applied.inverse if len(edits) == 1 or what not in ("keep", "music") else None,
                splices=tuple(applied.splices), keys=tuple(applied.keys), shifts=tuple(applied.shifts),
            )  # fmt: skip
            if not applied.splices:  # nothing changed
                return Accepted(replace(revision, number=self.revision))
            self._save(applied.splices, revision)
        except EditRefused as refused:
            self._take_back(applied.splices, former)
            raise as_written(refused, self.document, applied.shifts) from None
        except BaseException:
            self._take_back(applied.splices, former)
            raise
        return Accepted(revision)

    def _take_back(self, splices: Sequence[Splice], former: Patch) -> None:
        self.document.undo(splices)
        self.document.patch = former

    def _try_patch(self, former: Patch | None) -> None:
        faults = [] if self.check is None else self.check(self.document.patch, former)
        if faults:
            raise EditRefused(*map(self._fault, faults))

    def _fault(self, error: PersonError) -> Fault:
        """Return an error of a show with its place in the document."""
        key = error.key_path
        file, line = self.document.location(key) if key else (str(self.path), None)
        measure, dancers = concerned(self.document, key)
        return Fault(error.message, file, line, key_text(key), error.remedy or "", measure, dancers)

    def _save(self, splices: Sequence[Splice], revision: Revision) -> None:
        """Write the changed files and the history, all or nothing."""
        if self._dry:
            self.revisions.append(revision)
            return
        folder = self.path.parent
        texts = {file.name: file.text for file in self.document.files}
        take_back: list[Callable[[], object]] = []
        try:
            with self._opened_log() as log:
                size = log.seek(0, os.SEEK_END)
                log.seek(max(size - 1, 0))
                is_cut_off = log.read(1) not in (b"", b"\n")
                lines = (history_line(one) for one in (*self._unwritten, revision))
                log.write(b"\n" * is_cut_off + b"".join(lines))
                log.flush()
                for name in dict.fromkeys(splice.file for splice in splices):
                    path = folder / name
                    before = path.read_bytes() if path.exists() else None
                    take_back.append(partial(_write, path, before))
                    mark = _BOM if name in self._marks else b""
                    _write(path, None if name not in texts else mark + texts[name].encode())
        except (OSError, PersonError) as error:
            for step in reversed(take_back):
                with contextlib.suppress(OSError, PersonError):
                    step()
            words = error.message if isinstance(error, PersonError) else str(error)
            raise refuse((), f"it cannot be saved: {words}", "make room, or make the folder writable") from None
        written = (*self._unwritten, revision)
        self.revisions.append(revision)
        self._unwritten = []
        self._stamps = {name: _stamp(folder / name) for name in texts}
        self._copy_texts({splice.file for one in written for splice in one.splices})

    # Back

    def undo(self, by: str | None = None, *, redo: bool = False) -> Accepted:
        """Take back a person's last edit that is in force; with `redo` their last undo, if no edit of theirs followed.

        None is everybody. EditRefused if there is none, or if others built on it since.
        """
        self._take_in()
        target = self._last_undo(by) if redo else self.last_in_force(by)
        what: What = "redo" if redo else "undo"
        if target is None:
            raise refuse(
                (), f"{'nobody' if by is None else repr(by)} has nothing to {what}", "see the log of revisions"
            )
        exact = tuple(splice.reverse() for splice in reversed(target.splices))
        if target.inverse is None:
            return self._commit_texts(exact, what, by or "", target.number, target.reversed())
        inverse = replace(target.inverse, by=by or "", base=target.number, exact=exact)
        return self._commit(self._rebased(inverse), what, by=inverse.by, of=target.number)

    def last_in_force(self, by: str | None) -> Revision | None:
        """Return a person's last revision that was not undone."""
        undone = {revision.of for revision in self.revisions if revision.what == "undo"}
        for revision in reversed(self.revisions):
            is_edit = revision.what in ("edit", "keep", "music", "restore", "redo") and revision.number not in undone
            if is_edit and by in (None, revision.by):
                return revision
        return None

    def _last_undo(self, by: str | None) -> Revision | None:
        """Return a person's last undo that was not redone, unless they edited since."""
        redone = {revision.of for revision in self.revisions if revision.what == "redo"}
        for revision in reversed(self.revisions):
            if by not in (None, revision.by) or revision.number in redone:
                continue
            if revision.what == "undo":
                return revision
            if revision.what in ("edit", "keep", "music", "restore"):
                return None
        return None

    def restore(self, number: int, by: str = "") -> Accepted:
        """Return to the texts of an earlier revision, as a new revision; EditRefused if they are not known or valid."""
        self._take_in()
        texts = self._texts_at(number)
        blocks = {name: DocumentFile(name, text, self.path).texts for name, text in texts.items()}
        return self._commit_texts(differences(_block_texts(self.document), blocks), "restore", by, number)

    def _commit_texts(
        self, splices: Sequence[Splice], what: What, by: str, of: int, known: Revision | None = None
    ) -> Accepted:
        """Apply splices of texts, check and save them; `known`: which keys and entries they change."""
        former, done = self.document.patch, list[Splice]()
        try:
            try:
                for splice in splices:
                    done.append(self.document.apply(splice))
                self.document.patch = self.document.validate()
            except LookupError:
                raise refuse((), "the same lines were changed since", "see the log of revisions") from None
            except PersonError as error:
                raise EditRefused(Fault(error.message, remedy=error.remedy or "")) from None
            self._try_patch(None)
            entries = {} if known is None else {"shifts": known.shifts, "keys": known.keys}
            revision = self._revision(what, by=by, of=of, splices=tuple(done), **entries)
            if done:
                self._save(done, revision)
        except BaseException:
            self._take_back(done, former)
            raise
        return Accepted(revision)


def _write(path: Path, data: bytes | None) -> None:
    """Write a file, or for None remove it."""
    if data is None:
        path.unlink(missing_ok=True)
    else:
        write_atomically(data, path, "file", synced=True)


def _stamp(file: Path) -> tuple[int, ...]:
    facts = file.stat()
    return facts.st_mtime_ns, facts.st_size, facts.st_ino


def _block_texts(document: Document) -> dict[str, tuple[str, ...]]:
    return {file.name: file.texts for file in document.files}
