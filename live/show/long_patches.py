"""Long patches: what thousands of entries cost is paid in pieces, so that no frame waits for all of them.

Checking, writing and freeing an entry is a matter of microseconds, but pydantic and Python do it for a whole patch at
once, and meanwhile the interpreter is nobody else's.
"""

import json
import time
from typing import Any, Final, TypeVar, get_args, get_origin

from pydantic import BaseModel, TypeAdapter, ValidationError

from live.show.patch.patch import Patch
from live.show.patch.section_base import Section

AT_A_TIME: Final = 100
"""Entries that are checked or freed in one go."""
RESTS_S: Final = 0.0005
"""Seconds between two goes of freeing."""

Model = TypeVar("Model", bound=BaseModel)


def validated(model: type[Model], data: dict[str, Any]) -> Model:
    """The model of `data`, its long lists of tables checked piece by piece; pydantic's ValidationError as it would be
    otherwise."""
    pieces = dict(data)
    try:
        for name, field in model.model_fields.items():
            rows, kind = data.get(name), _section_of(field.annotation)
            if kind is not None and isinstance(rows, list) and len(rows) > AT_A_TIME:
                adapter = TypeAdapter(list[kind])  # type: ignore[valid-type]
                checked: list[Any] = []
                for begin in range(0, len(rows), AT_A_TIME):
                    checked += adapter.validate_python(rows[begin : begin + AT_A_TIME])
                pieces[name] = checked
    except ValidationError:  # told with everything else that is wrong
        pieces = data
    return model.model_validate(pieces)


def written_text(patch: Patch) -> str:
    """`Patch.written` as JSON, its long lists of tables piece by piece."""
    long = {name for name in patch.model_fields_set if len(_rows(patch, name)) > AT_A_TIME}
    head = patch.model_dump(mode="json", exclude_unset=True, exclude=long)
    parts = [f"{json.dumps(key)}:{json.dumps(value, separators=(',', ':'))}" for key, value in head.items()]
    for name in sorted(long):
        rows = (row.model_dump_json(exclude_unset=True) for row in _rows(patch, name))
        parts.append(f'"{name}":[{",".join(rows)}]')
    return "{" + ",".join(parts) + "}"


def freed(patches: list[Patch]) -> None:
    """Free patches that nobody needs any more, taken from the list, without haste. Thread: not the show's."""
    while patches:
        patch = patches.pop()
        rows = [list(_rows(patch, name)) for name in type(patch).model_fields]
        del patch
        for long in rows:
            while len(long) > AT_A_TIME:
                del long[-AT_A_TIME:]
                time.sleep(RESTS_S)


def _rows(patch: Patch, name: str) -> tuple[Section, ...]:
    """The tables of one kind; none for anything else."""
    rows = getattr(patch, name)
    return rows if isinstance(rows, tuple) and rows and isinstance(rows[0], Section) else ()


def _section_of(annotation: Any) -> type[Section] | None:
    """The kind of table of which a field holds many; None if it does not."""
    kinds = get_args(annotation) if get_origin(annotation) is tuple else ()
    return kinds[0] if kinds and isinstance(kinds[0], type) and issubclass(kinds[0], Section) else None
