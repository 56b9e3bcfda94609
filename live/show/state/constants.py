"""Constants of a show: objects that a snapshot refers to by name, because patch, steps and seed determine them.

Every object inside a constant has a name, too. A snapshot can only name entries of the table that its reader has built
from a fresh show; no path from the bytes is ever evaluated.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

from live.show.state.kind import PLAIN

MAX_WALKED: Final = 512
"""The entries of containers longer than this get no names; they are written if something else refers to them."""


def attribute_at(root: object, path: str) -> Any:
    """Return the nested attribute of `root` at the dotted `path`; paths are literals of this program."""
    here: Any = root
    for word in path.split("."):
        here = getattr(here, word)
    return here


class NamedObjects:
    """All objects inside one constant, by name."""

    def __init__(self, value: object, name: str, known: Iterable[Mapping[int, str]] = ()) -> None:
        """`known`: objects that have a name already."""
        self.value = value
        self.names: dict[int, str] = {}
        self.objects: dict[str, object] = {}
        self.classes: set[type] = set()
        self._known = tuple(known)
        self._walk(value, name)

    def _walk(self, value: Any, name: str) -> None:
        key, cls = id(value), type(value)
        if cls in PLAIN or isinstance(value, type) or key in self.names or any(key in met for met in self._known):
            return
        self.names[key] = name
        self.objects[name] = value
        if isinstance(value, np.ndarray):
            if isinstance(value.base, np.ndarray):
                self._walk(value.base, f"{name}.base")
            return
        if isinstance(value, Mapping | list | tuple) and len(value) > MAX_WALKED:
            return
        if isinstance(value, Mapping):
            for word, each in value.items():
                self._walk(each, f"{name}[{word!r}]")
            return
        if isinstance(value, list | tuple):
            for number, each in enumerate(value):
                self._walk(each, f"{name}[{number}]")
            return
        self.classes.add(cls)
        for attribute in attributes(value):
            self._walk(getattr(value, attribute, None), f"{name}.{attribute}")


_ahead: dict[str, NamedObjects] = {}


def walk_ahead(value: object, name: str) -> None:
    """Walk in advance through an object that will become a show's constant of this name, to save time in the frame. It
    must share nothing with the constants before it. Thread: any one."""
    _ahead[name] = NamedObjects(value, name)


class Constants:
    """The constants of a show, and its scratch arrays, whose content is computed before it is read."""

    def __init__(
        self, root: object, constant: Mapping[str, str], scratch: Iterable[str], before: "Constants | None" = None
    ) -> None:
        """`constant`: paths from `root` by name; everything inside a constant is constant, too. `scratch`: paths.

        Objects unchanged since `before`, or walked through ahead, are not walked through again.
        """
        self.name_of: dict[int, str] = {}
        self.named: dict[str, object] = {}
        self.classes: set[type] = set()
        self.parts: dict[str, NamedObjects] = {}
        for name, path in constant.items():
            value = attribute_at(root, path)
            known = (None if before is None else before.parts.get(name), _ahead.get(name))
            part = next((each for each in known if each is not None and each.value is value), None)
            part = part or NamedObjects(value, name, [self.name_of])
            self.parts[name] = part
            self.name_of |= part.names
            self.named |= part.objects
            self.classes |= part.classes
        self.scratch: dict[str, Any] = {}
        for path in scratch:
            found = attribute_at(root, path)
            rows = enumerate(found) if isinstance(found, tuple) else [("", found)]
            self.scratch |= {f"{path}{number}": array for number, array in rows}
        self.scratch_of = {id(array): name for name, array in self.scratch.items()}


def attributes(value: object) -> Iterable[str]:
    """Yield the names of all instance attributes and slots of an object."""
    yield from getattr(value, "__dict__", ())
    for cls in type(value).__mro__:
        slots = cls.__dict__.get("__slots__", ())
        yield from (slots,) if isinstance(slots, str) else slots
