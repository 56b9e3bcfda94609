"""Random edits of a document, valid and invalid ones, from a seed."""

import random
from typing import Any

from live.document.document import LIST_SECTIONS, Document
from live.document.edit import ACTIONS, Edit

TABLE_KEYS = (("seed",), ("stage", "width"), ("motion", "larger"), ("clock", "bpm"), ("look", "haze"))


def random_edit(rng: random.Random, document: Document, by: str = "") -> Edit:
    """Return an edit of an entry or a key that exists."""
    names = rng.choice([names for names in LIST_SECTIONS if document.entries(names)])
    entries = document.entries(names)
    number = rng.randrange(len(entries))
    values = document.values(entries[number])
    at: tuple[str | int, ...] = (*names, number + 1)
    do = rng.choice(ACTIONS)
    measure = rng.randrange(1, 200)
    match do:
        case "insert":
            fresh = values | ({"name": f"n{rng.randrange(10**6)}"} if "name" in values else {})
            fresh |= {"measure": measure} if "measure" in values else {}
            return Edit(do, rng.choice((names, at)), fresh, by=by)
        case "delete":
            return Edit(do, at, by=by)
        case "rename":
            return Edit(do, at, f"r{rng.randrange(10**6)}", by=by)
        case "copy":
            return Edit(do, at, {"measure": measure} if "measure" in values and rng.random() < 0.5 else None, by=by)
        case "move":
            return Edit(do, at, rng.choice((measure // 4 + 1, {"number": rng.randrange(len(entries)) + 1})), by=by)
        case "resize":
            return Edit(do, at, rng.randrange(1, 12), by=by)
    if rng.random() < 0.2:
        return Edit("set", rng.choice(TABLE_KEYS), rng.choice((None, 5, 100, 0.3)), by=by)
    key = rng.choice(list(values))
    value = _changed(rng, values[key])
    if isinstance(values[key], list) and values[key] and rng.random() < 0.3:
        return Edit("set", (*at, key, rng.randrange(len(values[key])) + 1), values[key][-1], by=by)
    return Edit(do, at, {key: value}, by=by) if do == "change" else Edit(do, (*at, key), value, by=by)


def _changed(rng: random.Random, value: Any) -> Any:
    if rng.random() < 0.15:
        return None
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return rng.choice((round(value * 1.1, 3), value + 1, rng.randrange(1, 9)))
    return value[1:] + value[:1] if isinstance(value, list) else value
