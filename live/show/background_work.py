"""Pieces: work that is spread over ticks, so much in each that it is done in time.

Polite: long work in a thread that leaves the interpreter to the frame loop.

Python's interpreter is one for all threads: who waits for it while another computes is let in only after
`sys.getswitchinterval()`, 5 ms, and a frame asks for it anew after every kernel. While somebody works politely
it is let in after a tenth of a millisecond.

Long patches: what thousands of entries cost is paid in pieces, so that no frame waits for all of them.

Checking, writing and freeing an entry is a matter of microseconds, but pydantic and Python do it for a whole patch at
once, and meanwhile the interpreter is nobody else's.
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

Piece = tuple[float, Callable[[], object]]
"""A piece of the work, after what it weighs."""

MORE: Final = 1.5
"""A tick takes a further piece only if it does not come to more than so many times its share."""


class Pieces:
    """A row of pieces, done in their order."""

    def __init__(self) -> None:
        self._waiting: deque[Piece] = deque()
        self.left = 0.0
        """What those that wait weigh together."""

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def weights(self) -> list[float]:
        """What each that waits weighs."""
        return [weight for weight, _ in self._waiting]

    def begin(self, pieces: Iterable[Piece]) -> None:
        """These are to be done, after those that wait."""
        self._waiting.extend(pieces)
        self.left = sum(weight for weight, _ in self._waiting)

    def work(self, ticks: int) -> None:
        """Do this tick's share, if so many `ticks` are left for all, this one included."""
        share, done = self.left / max(ticks, 1), 0.0
        while self._waiting and done < share:
            weight = self._waiting[0][0]
            if done and ticks > 1 and done + weight > MORE * share:
                return  # rather in the next tick than together with others in this one
            self._do_one()
            done += weight

    def clear(self) -> None:
        """Forget all that is left."""
        self._waiting.clear()
        self.left = 0.0

    def finish(self) -> None:
        """Do all that is left."""
        while self._waiting:
            self._do_one()

    def _do_one(self) -> None:
        weight, piece = self._waiting.popleft()
        self.left -= weight
        piece()


LETS_IN_S: Final = 0.0001
"""Seconds after which a thread that waits is let in meanwhile, but for single calls of compiled code."""

_lock = threading.Lock()
_working: list[float] = []


@contextmanager
def polite() -> Iterator[None]:
    """What the calling thread does within is done politely; all threads share that. Thread: any, several at a time."""
    with _lock:
        _working.append(sys.getswitchinterval())
        sys.setswitchinterval(min(LETS_IN_S, _working[0]))
    try:
        yield
    finally:
        with _lock:
            before = _working[0]
            _working.pop()
            if not _working:
                sys.setswitchinterval(before)


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
