"""A patch as a document: its files as blocks, the patch that they give together, and where each entry stands.

Only changed blocks are parsed and validated again, so that an edit of a long score is fast.
"""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from live.base.toml import KeyPath, line_of, toml_line_numbers
from live.document.toml_blocks import Block, split_blocks
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import FOLDERS, add_custom_passes, add_gesture_files
from live.show.patch.patch_search_path import learned_path
from live.show.patch.section_base import InvalidEntry, Section
from live.show.patch.table_batches import section_of
from live.show.patch.toml_model import BridgeTables, TomlSources, parse_text, validate_sources
from live.show.patch_checks.patch_check import PATCH_CHECKS, check_patch

Names = tuple[str, ...]
"""Keys of a table: ("stage",), ("midi", "map")."""


def _list_sections() -> dict[Names, type[Section] | None]:
    found: dict[Names, type[Section] | None] = {("formation",): None}
    for name, field in Patch.model_fields.items():
        kind = section_of(field.annotation)
        if kind is not None:
            found[name,] = kind
        elif isinstance(field.annotation, type) and issubclass(field.annotation, Section):
            for inner, below in field.annotation.model_fields.items():
                if (kind := section_of(below.annotation)) is not None:
                    found[name, inner] = kind
    return found


def _length_limits(metadata: Sequence[Any]) -> tuple[int, int]:
    low = max((each.min_length for each in metadata if hasattr(each, "min_length")), default=0)
    return low, min((each.max_length for each in metadata if hasattr(each, "max_length")), default=1 << 30)


LIST_SECTIONS: Final = _list_sections()
"""The lists of tables of a patch: their keys, and the section of an entry (None: checked as plain values)."""
_ADAPTERS: Final[dict[Names, TypeAdapter[Section]]] = {
    names: TypeAdapter(kind) for names, kind in LIST_SECTIONS.items() if kind is not None and len(names) == 1
}
LIST_LENGTHS: Final[dict[Names, tuple[int, int]]] = {
    names: _length_limits(Patch.model_fields[names[0]].metadata) for names in _ADAPTERS
}
"""Smallest and largest number of entries of each list of sections."""
_REMAINING_PATCH_CHECKS: Final = {name: check for name, check in PATCH_CHECKS.items() if (name,) not in _ADAPTERS}
"""The checks that are left once each entry's section is valid."""


@dataclass(frozen=True, slots=True)
class Splice:
    """A change of a file's text: some blocks in a row are replaced by others; a file without blocks does not exist."""

    file: str
    """Its name within the show's folder."""
    block: int
    """Index of the first one."""
    old: tuple[str, ...]
    """Their texts."""
    new: tuple[str, ...]
    """The texts in their place."""

    def reverse(self) -> "Splice":
        """Return the splice that takes this one back."""
        return Splice(self.file, self.block, self.new, self.old)


@dataclass(frozen=True, slots=True)
class Entry:
    """Where an entry of a list of tables stands."""

    file: int
    block: int
    inner: KeyPath = ()
    """Keys below the block's header that lead to an entry written as an inline table."""


class DocumentFile:
    """One file: its blocks, and its values as far as messages and merging need them."""

    def __init__(self, name: str, text: str, path: Path) -> None:
        """`name` is its name within the folder of the show in `path`. PersonError, with the line, if it is no TOML."""
        self.name, self.file = name, str(path.parent / name)
        parse_text(text, self.file, "patch")
        self.blocks = split_blocks(text)
        self._data: dict[str, Any] | None = None
        self._changed_lists: set[Names] = set()  # lists with blocks that were replaced or not valid then
        self.has_apart = False
        """Whether tables of an entry stand apart from it, as far as `data` was read."""
        self._text: str | None = None

    @property
    def text(self) -> str:
        """The whole text."""
        if self._text is None:
            self._text = "".join([block.text for block in self.blocks])
        return self._text

    @property
    def texts(self) -> tuple[str, ...]:
        """The texts of its blocks."""
        return tuple(block.text for block in self.blocks)

    @property
    def data(self) -> dict[str, Any]:
        """Its values; entries that were validated are sections."""
        if self._data is None:
            self._data = self._merged()
            return self._data
        for names in list(self._changed_lists):
            blocks = [block for block in self.blocks if block.names == names and block.is_entry]
            if blocks:
                self._data[names[0]] = [block.section or block.values for block in blocks]
            else:
                self._data.pop(names[0], None)
            if all(block.section is not None for block in blocks):
                self._changed_lists.remove(names)
        return self._data

    def replace(self, begin: int, count: int, blocks: Sequence[Block]) -> None:
        """Replace `count` blocks from `begin` on."""
        touched = (*self.blocks[begin : begin + count], *blocks)
        self.blocks[begin : begin + count] = blocks
        self._text = None
        if all(block.is_entry and len(block.names) == 1 for block in touched) and not self.has_apart:
            self._changed_lists.update(block.names for block in touched)
        else:
            self._data = None

    def _merged(self) -> dict[str, Any]:
        data: dict[str, Any] = {}
        lists: dict[Names, list[Any]] = {}
        self._changed_lists.clear()
        self.has_apart = False
        for block in self.blocks:
            rows = lists.get(block.names)
            if block.is_entry and block.section is None and block.names in _ADAPTERS:
                self._changed_lists.add(block.names)
            if rows is not None and block.is_entry:
                rows.append(block.section or block.values)
                continue
            table: Any = data
            for name in block.names[:-1]:
                self.has_apart |= isinstance(table.get(name), list)
                table = _last_table(table, name)
            if block.is_entry:
                rows = table.setdefault(block.names[-1], [])
                rows.append(block.section or block.values)
                if len(block.names) == 1:
                    lists[block.names] = rows
            elif block.names:
                _last_table(table, block.names[-1]).update(block.values)
            else:
                data.update(block.values)
        return data

    def line(self, path: KeyPath) -> int:
        """Return the line of a key of this file, or of the nearest table around it."""
        line, best, best_depth = 1, 1, 0
        counts: dict[Names, int] = {}
        for block in self.blocks:
            if block.is_entry:
                counts[block.names] = counts.get(block.names, 0) + 1
            below = _below(path, block, counts)
            if below is not None and len(block.names) >= best_depth:
                lines = toml_line_numbers(block.text)
                prefix: KeyPath = (*block.names, 0) if block.is_entry else block.names
                inside = any((*prefix, *below[:length]) in lines for length in range(1, len(below) + 1))
                if inside or len(block.names) > best_depth:
                    best, best_depth = line + line_of(lines, (*prefix, *below)) - 1, len(block.names)
            line += block.line_count
        return best


def _below(path: KeyPath, block: Block, counts: dict[Names, int]) -> KeyPath | None:
    """Return the keys of a path below a block's header; None if the path does not lead through it. `counts`: the
    entries of each list so far."""
    at = 0
    for depth, name in enumerate(block.names, start=1):
        if at >= len(path) or path[at] != name:
            return None
        at += 1
        if depth < len(block.names) or block.is_entry:
            number = path[at] if at < len(path) else None
            if isinstance(number, int):
                if number != counts.get(block.names[:depth], 0) - 1:
                    return None
                at += 1
            elif block.is_entry and depth == len(block.names):
                return None
    return path[at:]


def _last_table(table: dict[str, Any], name: str) -> dict[str, Any]:
    """Return the table under a key, of a list its last one, made if it is missing; it can be changed."""
    found = table.setdefault(name, {})
    if isinstance(found, list):
        if isinstance(found[-1], Section):
            found[-1] = found[-1].model_dump(mode="json", exclude_unset=True)
        found[-1] = found = dict(found[-1])
    return found  # type: ignore[no-any-return]


class Document:
    """A patch that can be edited: several files with their texts, block by block."""

    def __init__(self, files: Sequence[tuple[str, str]], *, path: Path, tables: BridgeTables = ()) -> None:
        """`files` are names within the show's folder and texts, the main file first, which lies in `path`.

        PersonError with all errors if they are no valid patch.
        """
        self.files = [DocumentFile(name, text, path) for name, text in files]
        self.path, self._tables = path, tables
        self._entries: dict[Names, list[Entry]] = {}
        self._changed: set[Names] = {()}  # tables whose values may differ from those of the last valid patch
        self._unchecked = [block for file in self.files for block in file.blocks]  # new since the last valid patch
        self.patch = self.validate()
        """The patch that the texts give."""

    def validate(self) -> Patch:
        """Return the patch that the texts give now; PersonError with all errors."""
        all_valid = True
        for block in self._unchecked:
            if block.section is None and block.is_entry and (adapter := _ADAPTERS.get(block.names)) is not None:
                try:
                    block.section = adapter.validate_python(block.values, context=PATCH_CHECKS)
                except ValidationError:  # reported below together with all other errors
                    all_valid = False
        if all_valid and (patch := self._with_changed_lists()) is not None:
            self._unchecked.clear()
            self._changed.clear()
            return patch
        sources = TomlSources(self.files)
        add_custom_passes(sources.data, self.path)
        add_gesture_files(sources, self.path)
        checks = _REMAINING_PATCH_CHECKS if all_valid else PATCH_CHECKS
        made = validate_sources(sources, Patch, "patch", checks, self._tables)
        self._unchecked.clear()
        self._changed.clear()
        return made

    def _with_changed_lists(self) -> Patch | None:
        """Return the patch if it is the last valid one but for entries of some lists, and has no error; else None."""
        names = self._changed
        if not all(each in LIST_LENGTHS for each in names) or any(file.has_apart for file in self.files):
            return None
        rows: dict[str, tuple[Section, ...]] = {
            name: tuple(row for file in self.files for row in file.data.get(name, ())) for (name,) in names
        }
        if not all(LIST_LENGTHS[name,][0] <= len(found) <= LIST_LENGTHS[name,][1] for name, found in rows.items()):
            return None
        patch = self.patch.model_copy(update=rows)
        patch.model_fields_set.difference_update(name for name, found in rows.items() if not found)
        try:
            check_patch(patch)
        except InvalidEntry:  # the whole validation has the words for it
            return None
        return patch

    def location(self, path: KeyPath) -> tuple[str, int]:
        """Return file and line of a key, as ("element", 57, "measure"), or of the nearest table around it."""
        return TomlSources(self.files).location(path)

    def entries(self, names: Names) -> list[Entry]:
        """Return where the entries of a list of tables stand, in the order of the patch."""
        found = self._entries.get(names)
        if found is None:
            found = self._entries[names] = list(self._find_entries(names))
        return found

    def _find_entries(self, names: Names) -> Iterator[Entry]:
        table, key = names[:-1], names[-1]
        for number, file in enumerate(self.files):
            for index, block in enumerate(file.blocks):
                if block.is_entry:
                    if block.names == names:
                        yield Entry(number, index)
                elif block.names == table:
                    value = block.values.get(key)
                    if isinstance(value, list) and (names in LIST_SECTIONS or _is_tables(value)):
                        yield from (Entry(number, index, (key, row)) for row in range(len(value)))

    def is_list(self, names: Names) -> bool:
        """Return whether a list of tables has these keys."""
        return names in LIST_SECTIONS or bool(self.entries(names))

    def values(self, entry: Entry) -> dict[str, Any]:
        """Return the values of an entry. Do not change them."""
        values: Any = self.files[entry.file].blocks[entry.block].values
        for key in entry.inner:
            values = values[key]
        return values  # type: ignore[no-any-return]

    def is_apart(self, names: Names, entry: Entry) -> bool:
        """Return whether tables of an entry stand elsewhere in its file, behind other tables."""
        blocks = self.files[entry.file].blocks
        for block in blocks[entry.block + 1 :]:
            if block.names == names:
                break
            if block.names[: len(names)] == names:
                return True
        return False

    def splice(self, file: int, block: int, count: int, blocks: Sequence[Block]) -> Splice:
        """Replace blocks of a file; return what was done. The patch is validated later."""
        there = self.files[file]
        old = there.blocks[block : block + count]
        there.replace(block, count, blocks)
        self._unchecked += blocks
        if len(blocks) != count or any(map(_differ, old, blocks)):
            self._changed.update(one.names for one in (*old, *blocks))
        if len(blocks) != count or not all(one.is_entry for one in blocks):
            self._entries.clear()
        return Splice(there.name, block, tuple(one.text for one in old), tuple(one.text for one in blocks))

    def apply(self, splice: Splice) -> Splice:
        """Repeat a splice where its old texts stand, next to their former place; return what was done.

        LookupError if they stand nowhere any more.
        """
        number = next((index for index, file in enumerate(self.files) if file.name == splice.file), None)
        if number is None or not splice.old or not splice.new:
            return self._apply_file(splice, number)
        texts, count = self.files[number].texts, len(splice.old)
        places = [at for at in range(len(texts) - count + 1) if texts[at : at + count] == splice.old]
        if not places:
            raise LookupError(splice.file)
        at = min(places, key=lambda place: abs(place - splice.block))
        made = [_parse_block(text, is_first=at + index == 0) for index, text in enumerate(splice.new)]
        return self.splice(number, at, count, made)

    def _apply_file(self, splice: Splice, number: int | None) -> Splice:
        """Add or remove a whole file."""
        self._entries.clear()
        if number is None and not splice.old:
            self.files.append(DocumentFile(splice.file, "".join(splice.new), self.path))
            self._unchecked += self.files[-1].blocks
            self._changed.add(())
            self.files.sort(key=lambda file: file_order(file.name, self.path))
        elif (
            number is not None and not splice.new and tuple(one.text for one in self.files[number].blocks) == splice.old
        ):
            del self.files[number]
            self._changed.add(())
        else:
            raise LookupError(splice.file)
        return splice

    def undo(self, splices: Sequence[Splice]) -> None:
        """Take back splices that were the last ones."""
        for splice in reversed(splices):
            with contextlib.suppress(LookupError):
                self.apply(splice.reverse())


def file_order(name: str, path: Path) -> tuple[int, str]:
    """Return the sort key of a file of the patch in `path`: the main one, learned MIDI, the folders."""
    first = [path.name, learned_path(path).name]
    folder = name.partition("/")[0]
    return (first.index(name) if name in first else 2 + FOLDERS.index(folder) if folder in FOLDERS else 9), name


def _parse_block(text: str, *, is_first: bool) -> Block:
    """Return the block of a text; `is_first`: it stands before the first header. LookupError if it is none."""
    blocks = split_blocks(text)
    if is_first and len(blocks) == 1:
        return blocks[0]
    if is_first or len(blocks) != 2 or blocks[0].text:
        raise LookupError("text")
    return blocks[1]


def _differ(old: Block, new: Block) -> bool:
    """Return whether two blocks differ by more than what follows their last key."""
    return old.names != new.names or old.is_entry != new.is_entry or old.parts[0] != new.parts[0]


def _is_tables(value: list[Any]) -> bool:
    return bool(value) and all(isinstance(row, dict) for row in value)
