"""Lossless TOML: a text as blocks, one for each table, and edits of a block that keep what a person wrote.

A block is the text from one table header to the next, with the comments right above its header; all blocks joined are
the text. A sub-table of an entry of `[[ ]]` (`[group.motion]`) belongs to the entry's block where it follows it.
"""

import contextlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Self

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, Item, StringType
from tomlkit.items import String as TomlString

from live.base.toml import KeyPath, TableHeader, parse_toml, toml_headers
from live.show.patch.section_base import Section


@dataclass(eq=False)
class Block:
    """One table of a file, or the keys before its first header. Its text never changes."""

    names: tuple[str, ...]
    """Keys of its header; empty: the keys before the first header."""
    is_entry: bool
    """Whether it is an entry of `[[ ]]`."""
    text: str
    section: Section | None = None
    """Its values as its section, once they were found valid."""

    @cached_property
    def values(self) -> dict[str, Any]:
        """The values below its header."""
        values: Any = parse_toml(self.text)
        for name in self.names:
            values = values[name]
            if isinstance(values, list):
                values = values[0]
        return values  # type: ignore[no-any-return]

    @cached_property
    def line_count(self) -> int:
        """Number of line ends in it."""
        return self.text.count("\n")

    @cached_property
    def parts(self) -> tuple[str, str]:
        """Its text up to its last key, without the line end, and the rest: blank lines and comments."""
        last = toml_headers(self.text)[1]
        lines = _lines(self.text)
        body = "".join(lines[:last])
        end = "\r\n" if body.endswith("\r\n") else "\n" if body.endswith("\n") else ""
        return body.removesuffix(end), end + "".join(lines[last:])

    def with_text(self, text: str) -> Self:
        """Return the same table with another text."""
        return type(self)(self.names, self.is_entry, text)


def split_blocks(text: str) -> list[Block]:
    """Return the blocks of a valid TOML text, the keys before the first header first (perhaps none)."""
    lines = _lines(text)
    blocks: list[Block] = []
    begin = 0
    path: KeyPath = ()
    for header in toml_headers(text)[0]:
        if _is_entry(path) and header.path[: len(path)] == path and header.path != path:
            continue  # a table of this entry
        start = _first_comment(lines, header)
        blocks.append(_block(path, lines[begin:start]))
        begin, path = start, header.path
    blocks.append(_block(path, lines[begin:]))
    return blocks


def _block(path: KeyPath, lines: Sequence[str]) -> Block:
    return Block(tuple(key for key in path if isinstance(key, str)), _is_entry(path), "".join(lines))


def _is_entry(path: KeyPath) -> bool:
    return bool(path) and isinstance(path[-1], int)


def _lines(text: str) -> list[str]:
    """Split at line feeds only; str.splitlines knows line ends that TOML does not."""
    first, last = text.split("\n")[:-1], text.rpartition("\n")[2]
    return [f"{line}\n" for line in first] + ([last] if last else [])


def _first_comment(lines: list[str], header: TableHeader) -> int:
    """Return the index of the first comment line right above a header, or of the header itself."""
    start = header.line - 1
    while start > header.last_line and lines[start - 1].lstrip(" \t").startswith("#"):
        start -= 1
    return start


def block_text(names: Iterable[str], values: Mapping[str, Any], *, is_entry: bool) -> str:
    """Return the text of a new table, without a line end behind it."""
    header = ".".join(tomlkit.key(name).as_string() for name in names)
    lines = [f"[[{header}]]" if is_entry else f"[{header}]"]
    lines += [f"{tomlkit.key(key).as_string()} = {toml_item(value).as_string()}" for key, value in values.items()]
    return "\n".join(lines)


def inserted(before: Block, new: str, *, is_last: bool) -> tuple[str, str]:
    """Return the texts of a block and of a `new` one behind it, which gets the comments that follow the first."""
    body, tail = before.parts
    end = "\r\n" if "\r\n" in before.text else "\n"
    new = new.replace("\n", end)
    if not body:  # only comments stand before the first header
        first = before.text.rstrip("\r\n") + end * 2 if before.text.strip() else before.text
        return first, new + (end if is_last else end * 2)
    gap = end if tail == end and not is_last else end * 2
    return body + gap, new + tail


def joined_tail(before: Block, removed: Block) -> str:
    """Return the text of the block `before` once the one behind it is removed."""
    body, tail = before.parts
    rest = removed.parts[1]
    if not body and not tail.strip():
        return rest.lstrip("\r\n")
    if not tail.strip():
        return body + rest
    return before.text if not rest.strip() else before.text + rest.lstrip("\r\n")


def edit_block(block: Block, path: Sequence[str | int], value: Any, *, insert: bool = False) -> str:
    """Return a block's text with the key at `path`, below its header, set to `value`; None removes it.

    With `insert`, the value becomes a further element of a list, before the one at `path`. Comments, order and the
    quotes of a text stay. Tables on the way that do not exist are made. Raises one of `EDIT_ERRORS` for a path or a
    value that a text cannot take.
    """
    body, tail = block.parts
    document = tomlkit.parse(body + "\n")
    container: Any = document
    for name in block.names:
        container = container[name]
    if block.is_entry:
        container = container[0]
    for key in path[:-1]:
        if isinstance(key, str) and key not in container and value is not None:
            container[key] = tomlkit.inline_table()
        container = container[key]
        if not hasattr(container, "append") and not hasattr(container, "add"):
            raise ValueError(f"{key} is no table")
    last = path[-1]
    if isinstance(container, AoT) and isinstance(value, Mapping) and isinstance(last, int):
        table = tomlkit.table()
        for key, inner in value.items():
            table.append(key, toml_item(inner))
        container.insert(last, table)
        if not insert:
            del container[last + 1]
    elif value is None:
        del container[last]
    elif isinstance(last, int) and (insert or last == len(container)):
        container.insert(last, toml_item(value))
    else:
        there = container[last] if isinstance(last, int) or last in container else None
        container[last] = toml_item(value, there)
    text = tomlkit.dumps(document).removesuffix("\n")
    if "\r\n" in block.text:
        text = text.replace("\r\n", "\n").replace("\n", "\r\n")
    return text + tail


def renamed_key(block: Block, path: Sequence[str | int], new: str) -> Iterator[Block]:
    """Yield the block with the last key of `path` renamed where it stands; nothing if its text is not found."""
    old = path[-1]
    wanted: Any = json.loads(json.dumps(block.values))
    table = wanted
    for key in path[:-1]:
        table = table[key]
    renamed = {new if key == old else key: value for key, value in table.items()}
    table.clear()
    table.update(renamed)
    forms = (re.escape(tomlkit.key(str(old)).as_string()), re.escape(f'"{old}"'), re.escape(f"'{old}'"))
    for form in forms:
        for found in re.finditer(rf"(?<![\w-]){form}(?=\s*=)", block.text):
            key = tomlkit.key(new).as_string()
            made = block.with_text(block.text[: found.start()] + key + block.text[found.end() :])
            with contextlib.suppress(*EDIT_ERRORS):
                if json.dumps(made.values) == json.dumps(wanted):
                    yield made


def toml_item(value: Any, former: object = None) -> Item:
    """Return a value as TOML writes it on one line; a text keeps the quotes of the `former` one if it can."""
    if isinstance(value, Mapping):
        table = tomlkit.inline_table()
        for key, inner in value.items():
            table.append(key, toml_item(inner))
        return table
    if isinstance(value, list | tuple):
        array = tomlkit.array()
        for inner in value:
            array.append(toml_item(inner))
        return array
    if isinstance(value, str):
        literal = isinstance(former, TomlString) and former._t is StringType.SLL
        if literal and "'" not in value and value.isprintable():
            return tomlkit.string(value, literal=True)
    item: Item = tomlkit.item(value)
    return item


EDIT_ERRORS: Final = (TOMLKitError, KeyError, IndexError, TypeError, ValueError, AttributeError)
"""Errors of `edit_block`."""
