"""Type checker for a decoded state: every field must match its kind, so that no kernel reads beyond an array.

Types are checked from the root on. Arrays must have the same shape as in a fresh show of the same patch, and indices
must be in range.
"""

from collections import Counter, OrderedDict, deque
from collections.abc import Iterable, Mapping
from types import MethodType
from typing import Any, Final

import numpy as np

from live.control.events.event import ControlEvent
from live.show.state.byte_format import StateDecodeError
from live.show.state.kind import MAX_MAGNITUDE, NUMBERS, Kind, Type
from live.show.state.kinds import BY_CLASS, BY_NAME, CONSTANT_KINDS

_CLASSES: Final[dict[str, tuple[type, ...]]] = {
    "int": (int, bool), "float": (float, int, np.float64), "bool": (bool,), "str": (str,), "none": (type(None),),
    "bytes": (bytes,), "complex": (complex,), "array": (np.ndarray,), "method": (MethodType,), "event": (),
    "list": (list,), "row": (tuple,), "tuple": (tuple,), "set": (set,), "frozenset": (frozenset,), "deque": (deque,),
    "dict": (dict,), "ordered": (OrderedDict,), "counter": (Counter,),
}  # fmt: skip
"""The classes of each type word other than kinds."""


def check_state(root: Any, found: str, fresh: object, index_limits: Mapping[str, int]) -> None:
    """Raise Unreadable, naming the field, unless `root` is a valid object of the kind `found`.

    `fresh`: the root of an unused show; `index_limits`: the number of items of each index type.
    """
    types = _TypeChecker(index_limits)
    try:
        types.check(root, Type(found))
        _check_shapes(root, fresh)
        types.finish()
    except StateDecodeError:
        raise
    except Exception as error:  # crafted objects may lack attributes
        raise StateDecodeError(f"{type(error).__name__}: {error}"[:400]) from None


class _TypeChecker:
    """Traversal of a value and all it holds."""

    def __init__(self, many: Mapping[str, int]) -> None:
        self._index_limits = many
        self._known: set[tuple[int, Type]] = set()
        self._objects: list[tuple[Any, Kind]] = []
        self._waiting: list[tuple[Any, Type, str]] = []

    def check(self, root: Any, wanted: Type) -> None:
        """Raise Unreadable for a value of another type."""
        self._waiting.append((root, wanted, ""))
        while self._waiting:
            value, wanted, where = self._waiting.pop()
            found = next((each for each in wanted.alternatives if _fits(value, each)), None)
            if found is None:
                raise StateDecodeError(f"{where} is {type(value).__name__}, {wanted} expected"[:300])
            if found.index_of:
                self._within(value, found, where)
            if isinstance(value, np.ndarray) and value.dtype.kind in "fc" and not found.any_number:
                most = np.abs(value).max(initial=0.0)
                if not most <= MAX_MAGNITUDE:
                    raise StateDecodeError(f"{where} holds {most}, more than {MAX_MAGNITUDE:g}")
            if (id(value), found) not in self._known:
                self._visit(value, found, where)
        for value, kind in self._objects:
            if kind.is_consistent is not None and not kind.is_consistent(value):
                raise StateDecodeError(f"the fields of a {kind.name!r} are inconsistent")

    def finish(self) -> None:
        """Let objects compute their unwritten attributes."""
        for value, kind in self._objects:
            if kind.after_read is not None:
                kind.after_read(value)

    def _within(self, value: Any, wanted: Type, where: str) -> None:
        """Check that indices are in range; -1 means none."""
        many = self._index_limits[wanted.index_of]
        low, high = (value, value) if type(value) is int else (value.min(initial=0), value.max(initial=-1))
        if low < -1 or high >= many:
            raise StateDecodeError(f"{where} holds {wanted.index_of} indices {low} to {high}, there are {many}")

    def _visit(self, value: Any, found: Type, where: str) -> None:
        kind = BY_CLASS.get(type(value))
        if kind is not None:
            self._known.add((id(value), found))
            self._objects.append((value, kind))
            for name, wanted in types_of(kind).items():
                self._waiting.append((getattr(value, name), wanted, f"{kind.name}.{name}"))
        elif found.word in _INSIDE:
            self._known.add((id(value), found))
            self._waiting += [(each, wanted, where) for each, wanted in _items(value, found, where)]


_INSIDE: Final = frozenset({"list", "row", "tuple", "set", "frozenset", "deque", "dict", "ordered", "counter"})


def _items(value: Any, found: Type, where: str) -> Iterable[tuple[Any, Type]]:
    """Return the items of a container with their types."""
    if found.word == "tuple":
        return zip(value, found.items, strict=True)
    if found.word in ("dict", "ordered"):
        keys, values = found.items
        return [*((each, keys) for each in value), *((each, values) for each in value.values())]
    if found.word == "counter":
        return [*((each, found.items[0]) for each in value), *((each, Type("int")) for each in value.values())]
    return ((each, found.items[0]) for each in value)


def _fits(value: Any, found: Type) -> bool:
    word, cls = found.word, type(value)
    if word in NUMBERS:
        return cls is np.ndarray and value.dtype.str == NUMBERS[word]
    if word == "any":
        return True
    if word == "event":
        return isinstance(value, ControlEvent)
    if word in _CLASSES:
        return cls in _CLASSES[word] and (word != "tuple" or len(value) == len(found.items))
    kind = BY_NAME.get(word)
    return cls is (CONSTANT_KINDS[word] if kind is None else kind.cls)


_types: dict[str, dict[str, Type]] = {}


def types_of(kind: Kind) -> dict[str, Type]:
    """Return the fields of a kind and their types, parsed once."""
    if kind.name not in _types:
        _types[kind.name] = kind.types()
    return _types[kind.name]


def _check_shapes(root: Any, fresh: Any) -> None:
    """Check that arrays have the same shape as in `fresh`, wherever both exist."""
    known: set[int] = set()
    waiting = [(root, fresh, "")]
    while waiting:
        value, like, where = waiting.pop()
        if type(value) is not type(like) or value is like or id(value) in known:
            continue
        kind = BY_CLASS.get(type(value))
        if kind is not None:
            known.add(id(value))
            for name, wanted in types_of(kind).items():
                if not wanted.any_shape_inside:
                    waiting.append((getattr(value, name), getattr(like, name), f"{kind.name}.{name}"))
        elif isinstance(value, np.ndarray):
            if value.shape != like.shape or (value.size and value.strides != like.strides):
                raise StateDecodeError(f"{where} has the shape {value.shape}, {like.shape} expected")
        elif isinstance(value, dict):
            waiting += [(each, like[key], where) for key, each in value.items() if key in like]
        elif isinstance(value, list | tuple) and len(value) == len(like):
            waiting += [(each, other, where) for each, other in zip(value, like, strict=True)]
