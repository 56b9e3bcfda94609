"""The show's files as pages see them: the whole structure, and after it each change."""

import json
from collections import deque
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from pydantic import BaseModel

from live.document.edit import shifted_number
from live.document.show_check import GRAPH_KEYS
from live.show.patch.patch import Patch
from live.show.patch.table_batches import patch_json

if TYPE_CHECKING:
    from live.app.services.document_service import DocumentService
    from live.document.history import Revision
    from live.show.show import Show

MAX_ENTRIES: Final = 200
"""Maximum number of entries in a change; after a larger one pages get the whole structure."""


class PageText(NamedTuple):
    """A text for the pages."""

    name: str
    """"structure", "change", or "replacement": a change after which the structure comes."""
    number: int
    """The revision that it tells."""
    text: str


class ScoreStream:
    """Texts about the show's files. Thread: the watching one writes them, the show's takes them."""

    def __init__(self, show: "Show", document: "DocumentService") -> None:
        self._show, self._document = show, document
        self._texts: deque[PageText] = deque()
        self._is_watched = False
        self._told: int | None = None  # the revision that was told last
        document.change_listeners.append(self._add_change)

    # -- thread: the show's ------------------------------------------------------------------------------------------

    def want_structure(self) -> None:
        """Write the whole structure, and from now on each change."""
        self._is_watched = True
        self._document.do(self._write_structure)

    def rest(self) -> None:
        """Write nothing until the structure is wanted again."""
        self._is_watched = False
        self._texts.clear()

    def update_patch(self) -> None:
        """Write the structure if another program has changed the show's files."""
        if self._is_watched:
            self._document.do(self._write_untold)

    def take(self) -> Iterator[PageText]:
        """Return the texts that are ready, and forget them."""
        while self._texts:
            yield self._texts.popleft()

    # -- thread: the watching one ------------------------------------------------------------------------------------

    def _write_structure(self) -> None:
        self._write(*self._document.present())

    def _write_untold(self) -> None:
        revision, patch = self._document.present()
        if revision != self._told:
            self._write(revision, patch)

    def _write(self, revision: int, patch: Patch) -> None:
        library = self._show.graph.library
        steps = [
            {"name": name, "measures": int(library.node_measures[library.node_step == step].max(initial=1))}
            for step, name in enumerate(library.steps)
        ]
        head = {"kind": "structure", "revision": revision, "groups": _groups(patch), "library": steps}
        text = f'{json.dumps(head)[:-1]}, "score": {patch_json(patch)}}}'
        self._texts.append(PageText("structure", revision, text))
        self._told = revision

    def _add_change(self, revision: "Revision", patch: Patch) -> None:
        if not self._is_watched:
            return
        follows = self._told is not None and revision.number == self._told + 1
        values = change_values(revision, patch)
        says_all = follows and values["entries"] is not None
        name = "change" if says_all else "replacement"
        self._texts.append(PageText(name, revision.number, json.dumps(values)))
        self._told = revision.number
        if not says_all:
            self._write(revision.number, patch)


def change_values(revision: "Revision", patch: Patch) -> dict[str, Any]:
    """Return what a revision changed, as values for JSON.

    On the score of the structure of before, `shifts` and then `entries` give that of now. Entries are None if they are
    too many, or if they do not say all: then the whole structure is needed.
    """
    edit = revision.edit
    values: dict[str, Any] = {
        "kind": "change", "revision": revision.number, "what": revision.what, "by": revision.by, "of": revision.of,
        "edit": None if edit is None else {"do": edit.do, "at": list(edit.at), "value": edit.value},
        "shifts": [], "entries": None,
    }  # fmt: skip
    if not revision.keys and not revision.shifts:
        return values
    whole = {names[0] for names, _, _ in revision.shifts if not _is_list(patch, names)}
    values["shifts"] = [
        {"list": names[0], "from": _number(begin), "to": _number(end)}
        for names, begin, end in revision.shifts
        if names[0] not in whole
    ]
    rows = dict.fromkeys(_inserted(revision))
    for key in revision.keys:
        name = str(key[0])
        if name in whole or len(key) < 2 or not isinstance(key[1], int) or not _is_list(patch, (name,)):
            whole.add(name)
        else:
            rows[name, key[1]] = None
    if whole & {*GRAPH_KEYS} or len(whole) + len(rows) > MAX_ENTRIES:
        return values  # the steps may be others
    values["entries"] = [
        {"at": [name, index + 1], "value": _values(getattr(patch, name)[index])}
        for name, index in rows
        if name not in whole and index < len(getattr(patch, name))
    ] + [
        {"at": [name], "value": _values(getattr(patch, name)) if name in patch.model_fields_set else None}
        for name in sorted(whole)
    ]
    if "group" in whole | {name for name, _ in rows}:
        values["groups"] = _groups(patch)
    return values


def _inserted(revision: "Revision") -> Iterator[tuple[str, int]]:
    """Yield list and final index of each entry that a revision inserted and that is still there."""
    for number, (names, begin, end) in enumerate(revision.shifts):
        index = shifted_number(names, end, revision.shifts[number + 1 :]) if begin < 0 else None
        if index is not None:
            yield names[0], index


def _groups(patch: Patch) -> list[dict[str, Any]]:
    return [{"name": group.name, "dancers": group.dancers, "colour": group.colour} for group in patch.group]


def _is_list(patch: Patch, names: Sequence[str]) -> bool:
    rows = getattr(patch, names[0], None)
    return len(names) == 1 and isinstance(rows, tuple) and all(isinstance(row, BaseModel) for row in rows)


def _number(index: int) -> int | None:
    """Return a number from 1 of an index; None for -1, nowhere."""
    return None if index < 0 else index + 1


def _values(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json", exclude_unset=True)
    return [_values(one) for one in value] if isinstance(value, tuple) else value
