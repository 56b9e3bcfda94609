"""Changes of a document's blocks: keys that are written, entries that are inserted, removed and reordered."""

from collections.abc import Mapping
from typing import Any

from live.base.toml import KeyPath
from live.document.document import Document, Entry, Names, Splice
from live.document.edit import Applied, Edit
from live.document.place import Place, refuse, value_at
from live.document.toml_blocks import (
    EDIT_ERRORS,
    Block,
    block_text,
    edit_block,
    inserted,
    joined_tail,
    renamed_key,
)


class BlockEditor:
    """One edit at work on a document: it changes blocks, and notes what it did."""

    def __init__(self, document: Document, edit: Edit) -> None:
        self.document, self.edit = document, edit
        self.applied = Applied()

    def restore(self, splices: tuple[Splice, ...]) -> bool:
        """Give back the texts of an inverse; False, with nothing done, if somebody changed them since."""
        done: list[Splice] = []
        try:
            for splice in splices:
                done.append(self.document.apply(splice))
        except (LookupError, StopIteration, *EDIT_ERRORS):
            self.document.undo(done)
            return False
        self.applied.splices = done
        return True

    # Texts

    def replace(self, file: int, block: int, texts: list[Block], count: int = 1) -> None:
        self.applied.splices.append(self.document.splice(file, block, count, texts))

    def _edit_text(self, file: int, block: int, path: KeyPath, value: Any, *, insert: bool = False) -> None:
        there = self.document.files[file].blocks[block]
        try:
            text = edit_block(there, path, value, insert=insert)
            made = there.with_text(text)
            if made.values is None:  # reading it refuses a text that is no TOML
                raise ValueError("nothing")
        except EDIT_ERRORS as error:
            raise refuse(self.edit.at, f"cannot be written there: {error}") from None
        self.replace(file, block, [made])

    def write(self, place: Place, value: Any, *, insert: bool = False) -> None:
        """Set, insert or, for None, remove the value at a key."""
        if value is None and value_at(self.document, place) is None:
            raise refuse(self.edit.at, "there is no such key")
        if place.number is not None:
            self.check_together(place)
            entry = place.entry(self.document)
            self._edit_text(entry.file, entry.block, (*entry.inner, *place.rest), value, insert=insert)
            return
        for number, file in enumerate(self.document.files):
            for index, block in reversed(list(enumerate(file.blocks))):
                if _leads_to(block, place.rest):
                    self._edit_text(number, index, place.rest[len(block.names) :], value, insert=insert)
                    return
        self._write_new(place.rest, value)

    def rename_key(self, place: Place, new: str) -> None:
        """Give a key another name, where it stands if its text is found, else at the end of its table."""
        if place.number is not None:
            self.check_together(place)
            entry = place.entry(self.document)
            file, block, path = entry.file, entry.block, (*entry.inner, *place.rest)
        else:
            file, block = next(
                (number, index)
                for number, each in enumerate(self.document.files)
                for index, one in enumerate(each.blocks)
                if _leads_to(one, place.rest)
            )
            path = place.rest[len(self.document.files[file].blocks[block].names) :]
        there = self.document.files[file].blocks[block]
        made = next(renamed_key(there, path, new), None)
        if made is not None:
            self.replace(file, block, [made])
            return
        value = value_at(self.document, place)
        self._edit_text(file, block, path, None)
        self._edit_text(file, block, (*path[:-1], new), value)

    def _write_new(self, path: KeyPath, value: Any) -> None:
        """Write a key that stands nowhere yet: into its table, or into a new one."""
        for number, file in enumerate(self.document.files):
            for index, block in enumerate(file.blocks):
                if not block.is_entry and block.names and block.names == path[: len(block.names)]:
                    self._edit_text(number, index, path[len(block.names) :], value)
                    return
        root = self.document.files[0].blocks[0]
        if len(path) == 1 or isinstance(root.values.get(str(path[0])), dict):
            self._edit_text(0, 0, path, value)
            return
        names = tuple(str(key) for key in path[:-1])
        last = max(index for index, block in enumerate(self.document.files[0].blocks) if not block.is_entry)
        self._insert_block(0, last, names, {str(path[-1]): value}, is_entry=False)

    def _insert_block(self, file: int, behind: int, names: Names, values: Mapping[str, Any], *, is_entry: bool) -> None:
        try:
            text = block_text(names, values, is_entry=is_entry)
        except EDIT_ERRORS as error:
            raise refuse(self.edit.at, f"cannot be written: {error}") from None
        self._insert_text(file, behind, Block(names, is_entry, text))

    def _insert_text(self, file: int, behind: int, new: Block) -> None:
        blocks = self.document.files[file].blocks
        before = blocks[behind]
        first, second = inserted(before, new.text, is_last=behind == len(blocks) - 1)
        self.replace(file, behind, [before.with_text(first), new.with_text(second)])

    # Entries

    def check_together(self, place: Place) -> None:
        """Refuse an entry whose tables stand apart from it."""
        if self.document.is_apart(place.names, place.entry(self.document)):
            raise refuse(self.edit.at, "a table of this entry stands elsewhere in the file", "move it up to its entry")

    def insert_entry(self, names: Names, index: int, values: Mapping[str, Any], text: str | None = None) -> None:
        """Insert an entry as number `index` of its list; `text` is the block to write, if it exists."""
        entries = self.document.entries(names)
        self.applied.shifts.append((names, -1, index))
        near = entries[max(index - 1, 0)] if entries else self._empty_list(names)
        if near is None:
            file, behind = 0, len(self.document.files[0].blocks) - 1
        elif near.inner:
            row = near.inner[-1]
            assert isinstance(row, int)
            inner = (*near.inner[:-1], row + (1 if index > 0 else 0))
            self._edit_text(near.file, near.block, inner, dict(values), insert=True)
            return
        else:
            file, behind = near.file, near.block if index > 0 else near.block - 1
        if text is not None:
            self._insert_text(file, behind, Block(names, True, text))
        else:
            self._insert_block(file, behind, names, values, is_entry=True)

    def _empty_list(self, names: Names) -> Entry | None:
        """Return the place of the first element of an empty list in brackets, or of a list in a dotted table."""
        for number, file in enumerate(self.document.files):
            for index, block in enumerate(file.blocks):
                if not block.is_entry and block.names == names[: len(block.names)]:
                    path = names[len(block.names) :]
                    values: Any = block.values
                    for key in path:
                        values = values.get(key) if isinstance(values, dict) else None
                    if isinstance(values, list):
                        return Entry(number, index, (*path, 0))
        return None

    def delete_entry(self, place: Place) -> None:
        """Remove an entry."""
        self.check_together(place)
        entry = place.entry(self.document)
        assert place.number is not None
        if entry.inner:
            self._edit_text(entry.file, entry.block, entry.inner, None)
        else:
            blocks = self.document.files[entry.file].blocks
            before, removed = blocks[entry.block - 1], blocks[entry.block]
            text = joined_tail(before, removed)
            self.replace(entry.file, entry.block - 1, [before.with_text(text)], count=2)
        self.applied.shifts.append((place.names, place.number, -1))

    def reorder(self, place: Place, index: int) -> None:
        """Make an entry number `index` of its list. Comments between entries stay where they are."""
        assert place.number is not None
        entries = self.document.entries(place.names)
        self.check_together(place)
        low, high = sorted((place.number, index))
        span = entries[low : high + 1]
        order = list(range(low, high + 1))
        order.insert(index - low, order.pop(place.number - low))
        if any(entry.inner or entry.file != span[0].file for entry in span):
            raise refuse(self.edit.at, "it cannot be moved within a list in brackets, or to another file",
                "delete it and insert it there")  # fmt: skip
        blocks = self.document.files[span[0].file].blocks
        bodies = [blocks[entries[number].block].parts[0] for number in order]
        made = [
            blocks[entry.block].with_text(body + blocks[entry.block].parts[1])
            for entry, body in zip(span, bodies, strict=True)
        ]
        for entry, block in zip(span, made, strict=True):
            self.replace(entry.file, entry.block, [block])
        self.applied.shifts.append((place.names, place.number, index))

    # What an edit leaves behind

    def mark(self, place: Place, *keys: str | int) -> None:
        """Note a key as changed."""
        self.applied.keys.append((*place.key, *keys))

    def take_back_with(self, do: str, at: tuple[str | int, ...], value: Any = None) -> None:
        """Set the inverse."""
        self.applied.inverse = Edit(do, at, value, by=self.edit.by)


def _leads_to(block: Block, path: KeyPath) -> bool:
    """Return whether a block holds the key at `path`, or a part of it that is no table."""
    if block.is_entry or block.names != path[: len(block.names)]:
        return False
    values: Any = block.values
    rest = path[len(block.names) :]
    for depth, key in enumerate(rest):
        last = depth == len(rest) - 1
        if isinstance(values, list) and isinstance(key, int):
            if last:
                return True
            values = values[key] if key < len(values) else None
        elif isinstance(values, dict) and key in values:
            values = values[key]
        else:
            return depth > 0 and isinstance(values, list)
    return bool(rest)
