"""What each edit does to a document's blocks, and the edit that takes it back."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from live.base.errors import PersonError
from live.base.toml import KeyPath
from live.document.block_editor import BlockEditor
from live.document.document import LIST_SECTIONS, Document, Names, Splice
from live.document.edit import MAX_TOGETHER, TOGETHER, Applied, Edit, EditRefused, Fault, shifted_key
from live.document.place import Place, as_written, find_place, folded, path_text, refuse, value_at
from live.document.references import references
from live.document.toml_blocks import EDIT_ERRORS, Block, edit_block, joined_tail
from live.show.patch.section_stage import ItemSection
from live.show.patch.toml_model import InvalidModel, key_text

MOVE_KEYS: Final = ("measure", "beat", "section", "at", "to", "wall_to", "points", "centre", "place")
"""Keys that a `move` may change: where an entry lies in time, or on the stage."""
RESIZE_KEYS: Final = ("measures", "size", "width", "depth", "height", "radius", "dancers")
"""Keys that a `resize` may change."""
SHOWN_FAULTS: Final = 50


def apply_edit(document: Document, edit: Edit) -> Applied:
    """Apply an edit to a document and return what it did; EditRefused with all faults leaves it as it was."""
    return apply_edits(document, [edit])


def apply_edits(document: Document, edits: Sequence[Edit]) -> Applied:
    """Apply edits as one; the document has to be valid after the last of them."""
    former, whole, inverses = document.patch, Applied(), list[Edit | None]()
    try:
        for edit in edits:
            action = BlockEditor(document, edit)
            try:
                _ACTIONS[edit.do](action)
            finally:
                whole.splices += action.applied.splices
            kept = [shifted_key(key, action.applied.shifts) for key in whole.keys]
            whole.keys = [*(key for key in kept if key is not None), *action.applied.keys]
            whole.shifts += action.applied.shifts
            inverses.append(action.applied.inverse)
        whole.inverse = _together(inverses)
        document.patch = document.validate()
        if edits[0].exact:
            whole.splices = _restore(document, edits[0], whole.splices)
    except BaseException as error:
        refusal = _refusal(document, edits, error)
        document.undo(whole.splices)
        document.patch = former
        if refusal is error:
            raise
        raise (as_written(refusal, document, whole.shifts) if isinstance(refusal, EditRefused) else refusal) from None
    return whole


def _together(inverses: Sequence[Edit | None]) -> Edit | None:
    """Return the inverse of edits from their own ones; None if one has none, or if they are too many."""
    known = tuple(one for one in reversed(inverses) if one is not None)
    if len(known) != len(inverses) or len(known) > MAX_TOGETHER:
        return None
    return known[0] if len(known) == 1 else Edit(TOGETHER, (), edits=known)


def _refusal(document: Document, edits: Sequence[Edit], error: BaseException) -> BaseException:
    """Return an error in the form of a refusal, if it is a person's; the document is still as it was edited."""
    if isinstance(error, InvalidModel):
        faults = []
        for problem in error.problems(SHOWN_FAULTS):
            what, remedy = _split_remedy(problem.text)
            measure, dancers = concerned(document, problem.key_path)
            place = problem.file, problem.line, key_text(problem.key_path)
            faults.append(Fault(what, *place, remedy, measure, dancers))
        return EditRefused(*faults)
    if isinstance(error, PersonError):
        return EditRefused(Fault(error.message, field=path_text(edits[-1].at), remedy=error.remedy or ""))
    return error


def _restore(document: Document, edit: Edit, written: list[Splice]) -> list[Splice]:
    """Give back the exact texts of an inverse instead, if they are still known and mean the same; return what was
    done."""
    wanted = document.patch
    document.undo(written)
    action = BlockEditor(document, edit)
    if action.restore(edit.exact):
        with contextlib.suppress(PersonError):
            if document.validate() == wanted:
                return action.applied.splices
        document.undo(action.applied.splices)
    done = [document.apply(splice) for splice in written]
    document.patch = document.validate()
    return done


def _split_remedy(text: str) -> tuple[str, str]:
    what, _, remedy = text.partition("; ")
    return what, remedy


def concerned(document: Document, key_path: KeyPath) -> tuple[float | None, str | None]:
    """Return the measure and the dancers of the entry at a key."""
    names = tuple(key for key in key_path[:1] if isinstance(key, str))
    entries = document.entries(names)
    if len(key_path) < 2 or not isinstance(key_path[1], int) or key_path[1] >= len(entries):
        return None, None
    values = document.values(entries[key_path[1]])
    measure, dancers = values.get("measure"), values.get("dancers" if names == ("regroup",) else "group")
    return (
        float(measure) if isinstance(measure, int | float) else None,
        dancers if isinstance(dancers, str) else None,
    )


def _numbered(at: Place, rest: KeyPath = ()) -> tuple[str | int, ...]:
    """Return the path of an edit with entries by number from 1."""
    return tuple(key + 1 if isinstance(key, int) else key for key in (*at.key, *rest))


def _place(action: BlockEditor) -> Place:
    return find_place(action.document, action.edit.at)


def _table(action: BlockEditor, words: str) -> dict[str, Any]:
    value = action.edit.value
    if not isinstance(value, dict):
        raise refuse(action.edit.at, f"value: {words} expected, found {str(value)[:60]!r}")
    return value


def _set(action: BlockEditor) -> None:
    place, value = _place(action), action.edit.value
    if place.names and place.number is None:
        raise refuse(action.edit.at, "this is a list of tables", "say which, by name or by its number from 1")
    former = value_at(action.document, place)
    if not place.rest:
        if value is None:
            _delete(action)
            return
        wanted = _table(action, "a table")
        assert isinstance(former, dict)
        _change_keys(action, place, {**dict.fromkeys(former), **wanted})
        return
    if value is None and place.number is None and isinstance(former, dict) and _delete_table(action, place, former):
        return
    if isinstance(value, dict) and isinstance(former, dict) and place.number is None:
        _change_keys(action, place, {**dict.fromkeys(former), **value})
        return
    action.write(place, value)
    action.mark(place)
    action.take_back_with("set", _numbered(place), former)


def _delete_table(action: BlockEditor, place: Place, former: dict[str, Any]) -> bool:
    """Remove a whole table with a header of its own; False if there is none."""
    found = [
        (number, index)
        for number, file in enumerate(action.document.files)
        for index, block in enumerate(file.blocks)
        if not block.is_entry and block.names and block.names[: len(place.rest)] == place.rest
    ]
    if not found:
        return False
    for number, index in reversed(found):
        blocks = action.document.files[number].blocks
        before = blocks[index - 1]
        action.replace(number, index - 1, [before.with_text(joined_tail(before, blocks[index]))], count=2)
    action.mark(place)
    action.take_back_with("set", _numbered(place), former)
    return True


def _change(action: BlockEditor) -> None:
    place, value = _place(action), action.edit.value
    former = value_at(action.document, place) if not place.names or place.number is not None else None
    if isinstance(value, dict) and (isinstance(former, dict) or (former is None and not place.names)):
        _change_keys(action, place, value)
    else:
        _set(action)


def _change_keys(action: BlockEditor, place: Place, changes: Mapping[str, Any]) -> None:
    """Set several keys of a table; None removes one."""
    former = value_at(action.document, place) or {}
    undo = {}
    for key, value in changes.items():
        if key in former and former[key] == value and type(former[key]) is type(value):
            continue
        if value is None and key not in former:
            raise refuse((*action.edit.at, key), "there is no such key")
        undo[key] = former.get(key)
        inner = Place(place.names, place.number, (*place.rest, key), place.section)
        action.write(inner, value)
        action.mark(inner)
    action.take_back_with("change", _numbered(place), undo)


def _insert(action: BlockEditor) -> None:
    document, edit = action.document, action.edit
    number: int | None = None
    at = edit.at
    for length in (1, 2, 3):  # a list, perhaps of a section, and the number that the new entry gets
        if len(at) == length + 1 and isinstance(at[-1], int) and (place := find_place(document, at[:-1])).names:
            if place.number is None:
                number = at[-1] - 1
                at = at[:-1]
            break
    place = find_place(document, at)
    if not place.names or place.number is not None:
        _insert_value(action, find_place(document, edit.at))
        return
    values = dict(_table(action, "a table of the entry's keys"))
    members = list(range(len(document.entries(place.names))))
    if place.section is not None:
        values = {"section": place.section, **values}
        members = [
            index
            for index, entry in enumerate(document.entries(place.names))
            if folded(document.values(entry).get("section", "")) == folded(place.section)
        ]
    if number is not None and number > len(members):
        raise refuse(edit.at, f"it cannot be number {number + 1}", f"there are {len(members)}")
    if number is None or number == len(members):
        index = members[-1] + 1 if members and place.section is not None else len(document.entries(place.names))
    else:
        index = members[number]
    action.insert_entry(place.names, index, values)
    action.take_back_with("delete", (*place.names, index + 1))


def _insert_value(action: BlockEditor, place: Place) -> None:
    """Insert an element of a list, or a key that does not exist yet."""
    former = value_at(action.document, place)
    if isinstance(former, list):
        place = Place(place.names, place.number, (*place.rest, len(former)), place.section)
        former = None
    is_element = isinstance(place.rest[-1], int) if place.rest else False
    if former is not None and not is_element:
        raise refuse(action.edit.at, "it is there already", "change it")
    if action.edit.value is None:
        raise refuse(action.edit.at, "value: nothing to insert")
    action.write(place, action.edit.value, insert=is_element)
    action.mark(place)
    action.take_back_with("delete", _numbered(place))


def _delete(action: BlockEditor) -> None:
    place = _place(action)
    if place.number is None or place.rest:
        if place.names and place.number is None:
            raise refuse(action.edit.at, "this is a list of tables", "say which, by name or by its number from 1")
        former = value_at(action.document, place)
        if isinstance(former, dict) and place.number is None and _delete_table(action, place, former):
            return
        action.write(place, None)
        action.mark(place)
        if isinstance(place.rest[-1], int):
            action.take_back_with("insert", _numbered(place), former)
        else:
            action.take_back_with("set", _numbered(place), former)
        return
    values = value_at(action.document, place)
    action.mark(place)
    action.delete_entry(place)
    action.take_back_with("insert", (*place.names, place.number + 1), values)


def _fields(names: Names) -> set[str]:
    section = LIST_SECTIONS.get(names)
    return set() if section is None else set(section.model_fields)


def _move(action: BlockEditor) -> None:
    place, value = _place(action), action.edit.value
    if place.number is None or place.rest:
        raise refuse(action.edit.at, "only an entry of a list can be moved", "say which, by name or number")
    has_measure = "measure" in _fields(place.names)
    if isinstance(value, dict) and set(value) == {"number"}:
        value, has_measure = value["number"], False
    if isinstance(value, int | float) and not isinstance(value, bool):
        if has_measure:
            _change_keys(action, place, {"measure": value})
            return
        count = len(action.document.entries(place.names))
        if not isinstance(value, int) or not 1 <= value <= count:
            raise refuse(action.edit.at, f"value: its new number expected, 1 to {count}")
        action.mark(place)
        action.reorder(place, value - 1)
        action.take_back_with("move", (*place.names, value), {"number": place.number + 1})
        return
    allowed = [key for key in MOVE_KEYS if key in _fields(place.names)]
    if isinstance(value, list) and "at" in allowed:
        _change_keys(action, place, _moved(action, place, value))
        return
    changes = _table(action, "a measure, a number, or a table of keys")
    if not changes or not set(changes) <= set(allowed):
        raise refuse(action.edit.at, "value: a move changes where an entry lies", f"allowed are {', '.join(allowed)}")
    _change_keys(action, place, changes)


def _moved(action: BlockEditor, place: Place, at: list[Any]) -> dict[str, Any]:
    """Return the keys of an entry that moves to `at` (x, z) [m]; the other end of a line or wall goes with it."""
    former = value_at(action.document, place) or {}
    changes: dict[str, Any] = {"at": at}
    for key in ("to", "wall_to"):
        try:
            changes |= {
                key: [round(float(b + c - a), 6) for a, b, c in zip(former["at"], former[key], at, strict=True)]
            }
        except KeyError:
            continue
        except (TypeError, ValueError):
            raise refuse(action.edit.at, "value: a place expected: x and z in metres") from None
    return changes


def _resize(action: BlockEditor) -> None:
    place, value = _place(action), action.edit.value
    if place.names and (place.number is None or place.rest):
        raise refuse(action.edit.at, "only an entry or the stage has a size", "say which, by name or number")
    stage = {"width", "depth"} if place.rest == ("stage",) else set[str]()
    known = (_fields(place.names) or {"size"}) if place.names else stage
    allowed = [key for key in RESIZE_KEYS if key in known]
    if not isinstance(value, dict) and allowed:
        value = _sizes(action, place, allowed, value)
    if not isinstance(value, dict) or not value or not set(value) <= set(allowed):
        raise refuse(action.edit.at, "value: a resize changes how long or large a thing is",
            f"allowed are {', '.join(allowed) or 'none here'}")  # fmt: skip
    _change_keys(action, place, value)


def _sizes(action: BlockEditor, place: Place, allowed: Sequence[str], value: Any) -> dict[str, Any]:
    """Return the keys of a size that is given by a number, or by a list of numbers."""
    if allowed[0] == "size" and isinstance(value, int | float):
        if place.names == ("item",):  # width and depth; the height stays
            height = (value_at(action.document, place) or {}).get("size", ItemSection.model_fields["size"].default)[1]
            return {"size": [value, height, value]}
        return {"size": [value, value]}
    if allowed[:2] == ["width", "depth"] and isinstance(value, list) and len(value) == 2:
        return dict(zip(allowed, value, strict=False))
    return {allowed[0]: value}


def _copy(action: BlockEditor) -> None:
    document, place, value = action.document, _place(action), action.edit.value
    if place.number is None or place.rest:
        raise refuse(action.edit.at, "only an entry of a list can be copied", "say which, by name or number")
    action.check_together(place)
    entry, fields = place.entry(document), _fields(place.names)
    source = document.values(entry)
    changes: dict[str, Any] = {}
    if isinstance(value, dict):
        changes = value
    elif isinstance(value, str):
        changes = {"name": value}
    elif value is not None:
        changes = {"measure": value}
    if "name" in source and "name" not in changes and place.names != ("signal",):
        changes = {"name": _free_name(document, place.names, str(source["name"])), **changes}
    text = None
    if not entry.inner:
        lines = document.files[entry.file].blocks[entry.block].parts[0].split("\n")
        while lines[0].lstrip().startswith("#"):
            lines.pop(0)
        block = Block(place.names, True, "\n".join(lines).replace("\r", ""))
        try:
            for key, changed in changes.items():
                if changed is not None or key in source:
                    block = block.with_text(edit_block(block, (key,), changed))
        except EDIT_ERRORS as error:
            raise refuse(action.edit.at, f"value: cannot be written: {error}") from None
        text = block.text
    kept = {key: item for key, item in {**source, **changes}.items() if item is not None}
    if "measure" in changes and "measure" not in fields:
        raise refuse(action.edit.at, "value: it has no measure", "give the name of the copy, or a table of keys")
    action.insert_entry(place.names, place.number + 1, kept, text)
    action.take_back_with("delete", (*place.names, place.number + 2))


def _free_name(document: Document, names: Names, name: str) -> str:
    """Return a name that no entry of the list has: "bow 2"."""
    known = {folded(document.values(entry).get("name", "")) for entry in document.entries(names)}
    stem = name.rstrip("0123456789").rstrip() or name
    return next(made for number in range(2, len(known) + 3) if folded(made := f"{stem} {number}") not in known)


def _rename(action: BlockEditor) -> None:
    document, place, new = action.document, _place(action), action.edit.value
    if not isinstance(new, str) or not new.strip():
        raise refuse(action.edit.at, f"value: a name expected, found {str(new)[:60]!r}")
    if place.rest[:1] == ("selections",) and len(place.rest) == 2 and not place.names:
        kind, old = "selections", str(place.rest[1])
        words = value_at(document, place)
        if words is None:
            raise refuse(action.edit.at, f"no selection is called {old!r}")
        if value_at(document, Place((), None, ("selections", new))) is not None:
            raise refuse(action.edit.at, f"two selections are called {new!r}", "give each its own name")
        action.rename_key(place, new)
        at: tuple[str | int, ...] = ("selections", new)
    else:
        values = value_at(document, place) if place.number is not None and not place.rest else None
        if not isinstance(values, dict) or "name" not in values:
            raise refuse(action.edit.at, "only an entry with a name can be renamed", "say which, by name or number")
        kind, old = place.names[-1], str(values["name"])
        for number, entry in enumerate(document.entries(place.names)):
            if folded(document.values(entry).get("name", "")) == folded(old):
                one = Place(place.names, number, ("name",))
                action.write(one, new)
                action.mark(one)
        at = _numbered(place)
    for reference in list(references(document, kind, old, new)):
        if reference.key is not None:
            action.rename_key(reference.place, reference.key)
        else:
            action.write(reference.place, reference.value)
        action.mark(reference.place)
    action.take_back_with("rename", at, old)


_ACTIONS: Final[dict[str, Callable[[BlockEditor], None]]] = {
    "insert": _insert, "change": _change, "move": _move, "resize": _resize,
    "copy": _copy, "delete": _delete, "rename": _rename, "set": _set,
}  # fmt: skip
