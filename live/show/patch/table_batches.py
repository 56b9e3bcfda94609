"""Long patches (thousands of entries), validated, serialized and freed in batches.

pydantic would hold the GIL for the whole patch, and the frames of a running show would wait.
"""

import json
import time
from typing import Any, Final, TypeVar, get_args, get_origin

from pydantic import BaseModel, TypeAdapter, ValidationError

from live.show.patch.section_base import Checks, Section

BATCH_SIZE: Final = 100
"""Entries that are validated or freed in one batch."""
BATCH_PAUSE_S: Final = 0.0005
"""Pause between two batches when freeing [s]."""

Model = TypeVar("Model", bound=BaseModel)


def validate_model(model: type[Model], data: dict[str, Any], checks: Checks | None = None) -> Model:
    """Return the model of `data`, checked by `checks`, with long lists of tables validated in batches. Raises the same
    ValidationError as pydantic."""
    pieces = dict(data)
    try:
        for name, field in model.model_fields.items():
            rows, kind = data.get(name), section_of(field.annotation)
            if kind is not None and isinstance(rows, list) and len(rows) > BATCH_SIZE:
                if all(type(row) is kind for row in rows):  # they were validated before
                    continue
                adapter = TypeAdapter(list[kind])  # type: ignore[valid-type]
                checked: list[Any] = []
                for begin in range(0, len(rows), BATCH_SIZE):
                    checked += adapter.validate_python(rows[begin : begin + BATCH_SIZE], context=checks)
                pieces[name] = checked
    except ValidationError:  # reported below together with all other errors
        pieces = data
    return model.model_validate(pieces, context=checks)


def patch_json(patch: Section) -> str:
    """Return the written keys of a patch as JSON, with long lists of tables serialized in batches."""
    long = {name for name in patch.model_fields_set if len(_tables(patch, name)) > BATCH_SIZE}
    head = patch.model_dump(mode="json", exclude_unset=True, exclude=long)
    parts = [f"{json.dumps(key)}:{json.dumps(value, separators=(',', ':'))}" for key, value in head.items()]
    for name in sorted(long):
        rows = (row.model_dump_json(exclude_unset=True) for row in _tables(patch, name))
        parts.append(f'"{name}":[{",".join(rows)}]')
    return "{" + ",".join(parts) + "}"


def free_patches(patches: list[Model]) -> None:
    """Free unused patches in small batches and empty the list. Thread: not the show's."""
    while patches:
        patch = patches.pop()
        rows = [list(_tables(patch, name)) for name in type(patch).model_fields]
        del patch
        for long in rows:
            while len(long) > BATCH_SIZE:
                del long[-BATCH_SIZE:]
                time.sleep(BATCH_PAUSE_S)


def _tables(patch: BaseModel, name: str) -> tuple[Section, ...]:
    """Return the tables of a field; empty if the field holds no tables."""
    rows = getattr(patch, name)
    return rows if isinstance(rows, tuple) and rows and isinstance(rows[0], Section) else ()


def section_of(annotation: Any) -> type[Section] | None:
    """Return the class of the tables in a field's tuple; None for other fields."""
    kinds = get_args(annotation) if get_origin(annotation) is tuple else ()
    return kinds[0] if kinds and isinstance(kinds[0], type) and issubclass(kinds[0], Section) else None
