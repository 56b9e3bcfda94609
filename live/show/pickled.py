"""Pickled: a tree of objects as bytes, without what can be found elsewhere and what is worth nothing.

Arrays that are parts of one another stay so: kernels and their owners look at the same memory.
"""

import io
import pickle
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from operator import attrgetter
from types import MethodType
from typing import Any, Final

import numpy as np

from live.show.state_reading import Array, Path, array_of, bound, dotted, empty, found, made, part_of, resolve, whole

Reduced = tuple[Any, ...]

PLAIN: Final = (type(None), bool, int, float, complex, str, bytes, type)
LONG: Final = 512
"""A constant with more entries than this is not looked through: they are written should anybody hold them."""


class Walked:
    """All objects that one constant holds, by their path."""

    def __init__(self, value: object, path: Path, met: Iterable[Mapping[int, Path]] = ()) -> None:
        """Objects in `met` have a path already."""
        self.value = value
        self.path: dict[int, Path] = {}
        self.kinds: set[type] = set()
        self._met = tuple(met)
        self._held: list[object] = []  # so that no other object gets their identity
        self._walk(value, path)

    def _walk(self, value: Any, path: Path) -> None:
        name = id(value)
        if isinstance(value, PLAIN) or name in self.path or any(name in met for met in self._met):
            return
        self.path[name] = path
        self._held.append(value)
        if isinstance(value, np.ndarray):
            if isinstance(value.base, np.ndarray):
                self._walk(value.base, (*path, "base"))
            return
        if isinstance(value, Mapping | list | tuple) and len(value) > LONG:
            return
        if isinstance(value, Mapping):
            for key, each in value.items():
                self._walk(each, (*path, ("key", key)))
            return
        if isinstance(value, list | tuple):
            for number, each in enumerate(value):
                self._walk(each, (*path, number))
            return
        self.kinds.add(type(value))
        for attribute in _attributes(value):
            self._walk(getattr(value, attribute, None), (*path, attribute))


_ahead: dict[str, Walked] = {}


def walk_ahead(value: object, constant: str) -> None:
    """Walk through what will soon be a show's `constant`, so that no frame has to; it must share nothing with those
    before it. Thread: any one."""
    _ahead[constant] = Walked(value, dotted(constant))


class Known:
    """Which objects of a tree are not written: constants, by their path, and scratch arrays."""

    def __init__(
        self, root: object, constant: Iterable[str], scratch: Iterable[str] = (), before: "Known | None" = None
    ) -> None:
        """`constant` and `scratch`: paths from `root`; all that a constant holds is constant, too.

        What was the same `before`, or was walked through ahead, is not walked through again.
        """
        self.path: dict[int, Path] = {}
        self.kinds: set[type] = set()
        self.parts: dict[str, Walked] = {}
        for words in constant:
            value = resolve(root, dotted(words))
            known = (None if before is None else before.parts.get(words), _ahead.get(words))
            part = next((each for each in known if each is not None and each.value is value), None)
            part = part or Walked(value, dotted(words), [self.path])
            self.parts[words] = part
            self.path |= part.path
            self.kinds |= part.kinds
        arrays = [array for words in scratch for array in _arrays(resolve(root, dotted(words)))]
        self.scratch = {id(array) for array in arrays}
        self._held = arrays
        self.reducers = _Reducers(self)


def _arrays(found: Any) -> tuple[object, ...]:
    return found if isinstance(found, tuple) else (found,)


def _attributes(value: object) -> Iterable[str]:
    yield from getattr(value, "__dict__", ())
    for cls in type(value).__mro__:
        slots = cls.__dict__.get("__slots__", ())
        yield from (slots,) if isinstance(slots, str) else slots


class _Reducers(dict[type, Callable[[Any], Reduced]]):
    """How objects of each kind are taken apart; those of new kinds are looked at when the first one comes."""

    def __init__(self, known: "Known") -> None:
        super().__init__(dict.fromkeys(known.kinds, self._constant))
        self._path, self._scratch = known.path, known.scratch
        self._parts: dict[int, tuple[Array, Reduced]] = {}
        self[np.ndarray] = self._array
        self[MethodType] = _method

    def __missing__(self, kind: type) -> Callable[[Any], Reduced]:
        if issubclass(kind, type):
            raise KeyError(kind)
        self[kind] = _fields_of(kind) if getattr(kind, "__getstate__", None) is _FROZEN else _as_usual
        return self[kind]

    def _constant(self, value: Any) -> Reduced:
        path = self._path.get(id(value))
        return (found, (path,)) if path is not None else _as_usual(value)

    def _array(self, value: Array) -> Reduced:
        name = id(value)
        if name in self._path:
            return found, (self._path[name],)
        base = value.base
        if base is None:
            if name in self._scratch:
                return empty, (value.shape, value.dtype.char)
        elif isinstance(base, np.ndarray) and base.flags.c_contiguous:
            return self._part(value, base)
        if value.flags.c_contiguous and value.flags.writeable:
            return whole, (value.tobytes(), value.shape, value.dtype.char)
        axes = tuple(sorted(range(value.ndim), key=lambda axis: -abs(value.strides[axis])))
        laid = value.transpose(axes)
        return array_of, (laid.tobytes(), laid.shape, value.dtype.char, axes, value.flags.writeable)

    def _part(self, value: Array, base: Array) -> Reduced:
        kept = self._parts.get(id(value))
        if kept is None or kept[0] is not value:
            offset = value.__array_interface__["data"][0] - base.__array_interface__["data"][0]
            kept = value, (part_of, (base, offset, value.shape, value.strides, value.dtype.char))
            if len(self._parts) > LONG:
                self._parts.clear()
            self._parts[id(value)] = kept
        return kept[1]


def _method(value: MethodType) -> Reduced:
    return bound, (value.__self__, value.__func__.__name__)


def _as_usual(value: Any) -> Reduced:
    usual: Reduced = value.__reduce_ex__(5)
    return usual


@dataclass(frozen=True, slots=True)
class _Frozen:
    """What the standard library does for values like this is slow, and is known by its function."""


_FROZEN: Final = _Frozen.__getstate__


def _fields_of(kind: type) -> Callable[[Any], Reduced]:
    """Takes apart a frozen value with slots."""
    names = [field.name for field in fields(kind)]
    if len(names) < 2:
        return _as_usual
    values = attrgetter(*names)
    return lambda value: (made, (kind, *values(value)))


def write_state(value: object, known: Known) -> bytes:
    """The bytes of `value`; raises whatever pickle raises for what is no plain value (a file, a lambda)."""
    out = io.BytesIO()
    pickler = pickle.Pickler(out, protocol=5)
    pickler.dispatch_table = known.reducers
    pickler.dump(value)
    return out.getvalue()
