"""Constants: what a state names instead of writing it, because patch, steps and seed alone decide it.

Each object that they hold has a name. A snapshot can only name a row of the table that its reader has made of a fresh
show; nothing is looked up by a path that comes from bytes.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

from live.show.state.kind import PLAIN

LONG: Final = 512
"""A constant with more entries than this is not looked through: they are written should anybody hold them."""


def at(root: object, path: str) -> Any:
    """The attribute of an attribute ... of `root` at `path`, words of this program with dots between them."""
    here: Any = root
    for word in path.split("."):
        here = getattr(here, word)
    return here


class Walked:
    """All objects that one constant holds, by name."""

    def __init__(self, value: object, name: str, met: Iterable[Mapping[int, str]] = ()) -> None:
        """Objects in `met` have a name already."""
        self.value = value
        self.names: dict[int, str] = {}
        self.objects: dict[str, object] = {}
        self.classes: set[type] = set()
        self._met = tuple(met)
        self._walk(value, name)

    def _walk(self, value: Any, name: str) -> None:
        key, cls = id(value), type(value)
        if cls in PLAIN or isinstance(value, type) or key in self.names or any(key in met for met in self._met):
            return
        self.names[key] = name
        self.objects[name] = value
        if isinstance(value, np.ndarray):
            if isinstance(value.base, np.ndarray):
                self._walk(value.base, f"{name}.base")
            return
        if isinstance(value, Mapping | list | tuple) and len(value) > LONG:
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


_ahead: dict[str, Walked] = {}


def walk_ahead(value: object, name: str) -> None:
    """Walk through what will soon be a show's constant of this name, so that no frame has to; it must share nothing
    with those before it. Thread: any one."""
    _ahead[name] = Walked(value, name)


class Constants:
    """The constants of a show, and its scratch arrays, whose content is worked out before it is read."""

    def __init__(
        self, root: object, constant: Mapping[str, str], scratch: Iterable[str], before: "Constants | None" = None
    ) -> None:
        """`constant`: paths from `root` by name; all that a constant holds is constant, too. `scratch`: paths.

        What was the same `before`, or was walked through ahead, is not walked through again.
        """
        self.name_of: dict[int, str] = {}
        self.named: dict[str, object] = {}
        self.classes: set[type] = set()
        self.parts: dict[str, Walked] = {}
        for name, path in constant.items():
            value = at(root, path)
            known = (None if before is None else before.parts.get(name), _ahead.get(name))
            part = next((each for each in known if each is not None and each.value is value), None)
            part = part or Walked(value, name, [self.name_of])
            self.parts[name] = part
            self.name_of |= part.names
            self.named |= part.objects
            self.classes |= part.classes
        self.scratch: dict[str, Any] = {}
        for path in scratch:
            found = at(root, path)
            rows = enumerate(found) if isinstance(found, tuple) else [("", found)]
            self.scratch |= {f"{path}{number}": array for number, array in rows}
        self.scratch_of = {id(array): name for name, array in self.scratch.items()}


def attributes(value: object) -> Iterable[str]:
    """The names of all attributes that an object can hold itself."""
    yield from getattr(value, "__dict__", ())
    for cls in type(value).__mro__:
        slots = cls.__dict__.get("__slots__", ())
        yield from (slots,) if isinstance(slots, str) else slots
