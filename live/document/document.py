"""A patch as a document: its files as blocks, the patch that they give together, and where each entry stands.

Only changed blocks are parsed and validated again, so that an edit of a long score is fast.
"""

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from live.base.toml import KeyPath, line_of, toml_line_numbers
from live.document.toml_blocks import Block, split_blocks
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import FOLDERS, add_custom_passes
from live.show.patch.patch_search_path import learned_path
from live.show.patch.section_base import Section
from live.show.patch.table_batches import section_of
from live.show.patch.toml_model import BridgeTables, TomlSources, parse_text, validate_sources
from live.show.patch_checks.patch_check import PATCH_CHECKS

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


LIST_SECTIONS: Final = _list_sections()
"""The lists of tables of a patch: their keys, and the section of an entry (None: checked as plain values)."""
_ADAPTERS: Final[dict[Names, TypeAdapter[Section]]] = {
    names: TypeAdapter(kind) for names, kind in LIST_SECTIONS.items() if kind is not None and len(names) == 1
}
_CHECKS_OF_WHOLE: Final = {name: check for name, check in PATCH_CHECKS.items() if name in ("patch", "formation")}
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

    @property
    def text(self) -> str:
        """The whole text."""
        return "".join(block.text for block in self.blocks)

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

    def replace(self, begin: int, count: int, blocks: Sequence[Block]) -> None:
        """Replace `count` blocks from `begin` on."""
        self.blocks[begin : begin + count] = blocks
        self._data = None

    def _merged(self) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for block in self.blocks:
            table: Any = data
            for name in block.names[:-1]:
                table = _last_table(table, name)
            if block.is_entry:
                table.setdefault(block.names[-1], []).append(block.section or block.values)
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
        self._entries: dict[Names, list[Entry]] | None = None
        self.patch = self.validate()
        """The patch that the texts give."""

    def validate(self) -> Patch:
        """Return the patch that the texts give now; PersonError with all errors."""
        all_valid = True
        for file in self.files:
            for block in file.blocks:
                if block.section is None and block.is_entry and (adapter := _ADAPTERS.get(block.names)) is not None:
                    try:
                        block.section = adapter.validate_python(block.values, context=PATCH_CHECKS)
                    except ValidationError:  # reported below together with all other errors
                        all_valid = False
        sources = TomlSources(self.files)
        add_custom_passes(sources.data, self.path)
        checks = _CHECKS_OF_WHOLE if all_valid else PATCH_CHECKS
        return validate_sources(sources, Patch, "patch", checks, self._tables)

    def location(self, path: KeyPath) -> tuple[str, int]:
        """Return file and line of a key, as ("element", 57, "measure"), or of the nearest table around it."""
        return TomlSources(self.files).location(path)

    def entries(self, names: Names) -> list[Entry]:
        """Return where the entries of a list of tables stand, in the order of the patch."""
        return self._all_entries().get(names, [])

    def is_list(self, names: Names) -> bool:
        """Return whether a list of tables has these keys."""
        return names in LIST_SECTIONS or names in self._all_entries()

    def _all_entries(self) -> dict[Names, list[Entry]]:
        if self._entries is None:
            self._entries = {}
            for number, file in enumerate(self.files):
                for index, block in enumerate(file.blocks):
                    if block.is_entry:
                        self._entries.setdefault(block.names, []).append(Entry(number, index))
                        continue
                    for key, value in block.values.items():
                        names = (*block.names, key)
                        if isinstance(value, list) and (names in LIST_SECTIONS or _is_tables(value)):
                            places = [Entry(number, index, (key, row)) for row in range(len(value))]
                            self._entries.setdefault(names, []).extend(places)
        return self._entries

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
        if len(blocks) != count or not all(one.is_entry for one in blocks):
            self._entries = None
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
        self._entries = None
        if number is None and not splice.old:
            self.files.append(DocumentFile(splice.file, "".join(splice.new), self.path))
            self.files.sort(key=lambda file: file_order(file.name, self.path))
        elif (
            number is not None and not splice.new and tuple(one.text for one in self.files[number].blocks) == splice.old
        ):
            del self.files[number]
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


def _is_tables(value: list[Any]) -> bool:
    return bool(value) and all(isinstance(row, dict) for row in value)
