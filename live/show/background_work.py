"""Background work that does not delay frames: tasks spread over ticks, and threads that release the GIL often.

A thread that waits for the GIL gets it only after `sys.getswitchinterval()`, 5 ms by default, and a frame has to
reacquire it after every kernel. `short_switch_interval` lowers the interval to 0.1 ms. Long patches
(thousands of entries) are validated, serialized and freed in batches, because pydantic would hold the GIL for the whole
patch.
"""

import json
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Final, TypeVar, get_args, get_origin

from pydantic import BaseModel, TypeAdapter, ValidationError

from live.show.patch.patch import Patch
from live.show.patch.section_base import Section

Task = tuple[float, Callable[[], object]]
"""Weight and function of one piece of work."""

MAX_SHARE: Final = 1.5
"""A tick does a further piece only if its work stays below this multiple of its share."""


class TaskQueue:
    """A queue of pieces of work, done in order, a share of them in each tick."""

    def __init__(self) -> None:
        self._waiting: deque[Task] = deque()
        self.remaining = 0.0
        """Total weight of the waiting pieces."""

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def weights(self) -> list[float]:
        """The weights of the waiting pieces."""
        return [weight for weight, _ in self._waiting]

    def extend(self, pieces: Iterable[Task]) -> None:
        """Append pieces to the queue."""
        self._waiting.extend(pieces)
        self.remaining = sum(weight for weight, _ in self._waiting)

    def run_share(self, ticks: int) -> None:
        """Do this tick's share, with `ticks` left for all pieces, this one included."""
        share, done = self.remaining / max(ticks, 1), 0.0
        while self._waiting and done < share:
            weight = self._waiting[0][0]
            if done and ticks > 1 and done + weight > MAX_SHARE * share:
                return  # a heavy piece gets a tick of its own
            self._do_one()
            done += weight

    def clear(self) -> None:
        """Discard the waiting pieces."""
        self._waiting.clear()
        self.remaining = 0.0

    def run_all(self) -> None:
        """Do all waiting pieces."""
        while self._waiting:
            self._do_one()

    def _do_one(self) -> None:
        weight, piece = self._waiting.popleft()
        self.remaining -= weight
        piece()


SWITCH_INTERVAL_S: Final = 0.0001
"""Switch interval of the interpreter in polite mode [s]. Single calls of compiled code may still take longer."""

_lock = threading.Lock()
_saved_intervals: list[float] = []


@contextmanager
def short_switch_interval() -> Iterator[None]:
    """Lower the interpreter's switch interval within the block; it applies to all threads. Thread: any, several at a
    time."""
    with _lock:
        _saved_intervals.append(sys.getswitchinterval())
        sys.setswitchinterval(min(SWITCH_INTERVAL_S, _saved_intervals[0]))
    try:
        yield
    finally:
        with _lock:
            before = _saved_intervals[0]
            _saved_intervals.pop()
            if not _saved_intervals:
                sys.setswitchinterval(before)


BATCH_SIZE: Final = 100
"""Entries that are validated or freed in one batch."""
BATCH_PAUSE_S: Final = 0.0005
"""Pause between two batches when freeing [s]."""

Model = TypeVar("Model", bound=BaseModel)


def validate_model(model: type[Model], data: dict[str, Any]) -> Model:
    """Return the model of `data`, with long lists of tables validated in batches. Raises the same ValidationError as
    pydantic."""
    pieces = dict(data)
    try:
        for name, field in model.model_fields.items():
            rows, kind = data.get(name), _section_of(field.annotation)
            if kind is not None and isinstance(rows, list) and len(rows) > BATCH_SIZE:
                adapter = TypeAdapter(list[kind])  # type: ignore[valid-type]
                checked: list[Any] = []
                for begin in range(0, len(rows), BATCH_SIZE):
                    checked += adapter.validate_python(rows[begin : begin + BATCH_SIZE])
                pieces[name] = checked
    except ValidationError:  # reported below together with all other errors
        pieces = data
    return model.model_validate(pieces)


def patch_json(patch: Patch) -> str:
    """Return `Patch.written` as JSON, with long lists of tables serialized in batches."""
    long = {name for name in patch.model_fields_set if len(_tables(patch, name)) > BATCH_SIZE}
    head = patch.model_dump(mode="json", exclude_unset=True, exclude=long)
    parts = [f"{json.dumps(key)}:{json.dumps(value, separators=(',', ':'))}" for key, value in head.items()]
    for name in sorted(long):
        rows = (row.model_dump_json(exclude_unset=True) for row in _tables(patch, name))
        parts.append(f'"{name}":[{",".join(rows)}]')
    return "{" + ",".join(parts) + "}"


def free_patches(patches: list[Patch]) -> None:
    """Free unused patches in small batches and empty the list. Thread: not the show's."""
    while patches:
        patch = patches.pop()
        rows = [list(_tables(patch, name)) for name in type(patch).model_fields]
        del patch
        for long in rows:
            while len(long) > BATCH_SIZE:
                del long[-BATCH_SIZE:]
                time.sleep(BATCH_PAUSE_S)


def _tables(patch: Patch, name: str) -> tuple[Section, ...]:
    """Return the tables of a field; empty if the field holds no tables."""
    rows = getattr(patch, name)
    return rows if isinstance(rows, tuple) and rows and isinstance(rows[0], Section) else ()


def _section_of(annotation: Any) -> type[Section] | None:
    """Return the class of the tables in a field's tuple; None for other fields."""
    kinds = get_args(annotation) if get_origin(annotation) is tuple else ()
    return kinds[0] if kinds and isinstance(kinds[0], type) and issubclass(kinds[0], Section) else None
