"""State reading: the bytes that `live/show/pickled.py` wrote as a tree of objects again, constants from another tree.

Reading knows only the classes of the core, numbers and plain containers, so that bytes from outside can make nothing
else.
"""

import io
import pickle
import sys
from dataclasses import fields
from typing import Any, Final

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
Path = tuple[Any, ...]

CORE: Final = ("live.agents.", "live.base.", "live.clock.", "live.graph.", "live.motion.", "live.show.")
DEVICES: Final = frozenset(
    f"live.show.{name}"
    for name in (
        "engine",
        "journal",
        "library_watch",
        "line_writer",
        "load",
        "patch_file",
        "patch_watch",
        "polite",
        "replay",
        "status",
    )
)
"""Modules of the show's package that touch files or run threads: a state holds nothing of them."""
OTHERS: Final = {
    "builtins": {"bytearray", "complex", "frozenset", "range", "set", "slice"},
    "collections": {"Counter", "OrderedDict", "defaultdict", "deque"},
    "numpy": {"dtype"},
    "numpy.core.multiarray": {"scalar"},
    "numpy._core.multiarray": {"scalar"},
}
HELPERS: Final = {"array_of", "bound", "empty", "found", "made", "part_of", "whole"}


class Unreadable(Exception):
    """Bytes that are no state of a show; the message says why."""


def resolve(root: object, path: Path) -> Any:
    """What lies at `path` of `root`: names of attributes, numbers in sequences, ("key", k) in mappings."""
    here: Any = root
    for part in path:
        if isinstance(part, str):
            here = getattr(here, part)
        elif isinstance(part, tuple):
            here = here[part[1]]
        else:
            here = here[part]
    return here


def dotted(words: str) -> Path:
    """The path that is written with dots."""
    return tuple(words.split("."))


class _Reader(pickle.Unpickler):
    """Knows the classes of the core alone, and where constants are found."""

    def __init__(self, data: bytes, root: object) -> None:
        super().__init__(io.BytesIO(data))
        self._root = root

    def find_class(self, module: str, name: str) -> Any:
        """A class that a state may hold; Unreadable for any other."""
        if module == __name__ and name in HELPERS:
            return (lambda path: resolve(self._root, path)) if name == "found" else getattr(sys.modules[module], name)
        if name in OTHERS.get(module, ()):
            return super().find_class(module, name)
        event = module.startswith("live.control.") and module.endswith(("event", "events"))
        if event or (module.startswith(CORE) and module not in DEVICES):
            kind = super().find_class(module, name)
            if isinstance(kind, type):
                return kind
        raise Unreadable(f"{module}.{name} is nothing that a state of a show holds")


def read_state(data: bytes, root: object) -> Any:
    """What `write_state` wrote, with constants taken from `root`; Unreadable for anything else."""
    try:
        return _Reader(data, root).load()
    except Unreadable:
        raise
    except Exception as error:  # damaged bytes can raise anything
        raise Unreadable(f"{type(error).__name__}: {error}") from None


# -- what is called while reading -------------------------------------------------------------------------------------


def found(path: Path) -> Any:
    """A constant: `_Reader` puts the one of its own root in the place of this."""
    raise Unreadable(f"there is no {path} here")


def made(kind: type, *values: object) -> object:
    """A frozen value with slots, of its fields in their order."""
    value: object = object.__new__(kind)
    for field, each in zip(fields(kind), values, strict=True):
        object.__setattr__(value, field.name, each)
    return value


def empty(shape: tuple[int, ...], kind: str) -> Array:
    """An array that is worked out before it is read."""
    return np.zeros(shape, np.dtype(kind))


def whole(data: bytes, shape: tuple[int, ...], kind: str) -> Array:
    """An array of its own, row after row."""
    return np.frombuffer(data, np.dtype(kind)).reshape(shape).copy()


def array_of(data: bytes, shape: tuple[int, ...], kind: str, axes: tuple[int, ...], writeable: bool) -> Array:
    """An array of its own, laid out in memory as it was."""
    out = np.frombuffer(data, np.dtype(kind)).reshape(shape).copy()
    if axes != tuple(range(len(axes))):
        out = out.transpose(np.argsort(axes))
    if not writeable:
        out.flags.writeable = False
    return out


def part_of(base: Array, offset: int, shape: tuple[int, ...], strides: tuple[int, ...], kind: str) -> Array:
    """A part of another array, in the same memory."""
    out: Array = np.ndarray(shape, np.dtype(kind), base, offset, strides)
    return out


def bound(owner: object, name: str) -> Any:
    """A method of an object of the core."""
    if not type(owner).__module__.startswith(CORE) or name.startswith("__"):
        raise Unreadable(f"{type(owner).__name__} has no method {name!r} that a state may hold")
    return getattr(owner, name)
