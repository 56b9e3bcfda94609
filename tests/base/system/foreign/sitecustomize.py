"""Hides from the program what Windows lacks: put this folder on PYTHONPATH, and every process of a show is so.

The standard library and other packages, which have their own ways for each system, still see all of it.
"""

import builtins
import os
import select
import signal
import socket
import sys
import types
from typing import Any

HIDDEN = os.environ.get("HIDDEN_NAMES", "").split()
"""`module.name` for each name, and `module` for each module."""
SYSTEM_FOLDER = "live.base.system."


def is_hidden_from(frame: types.FrameType) -> bool:
    caller = str(frame.f_globals.get("__name__", ""))
    if caller == "__main__":  # a process that was started with -m
        caller = getattr(frame.f_globals.get("__spec__"), "name", "")
    return caller.startswith("live.") and not caller.startswith(SYSTEM_FOLDER)


class ForeignModule(types.ModuleType):
    def __getattribute__(self, name: str) -> Any:
        module = types.ModuleType.__getattribute__(self, "__name__")
        if f"{module}.{name}" in HIDDEN and is_hidden_from(sys._getframe(1)):
            raise AttributeError(f"this system has no {name}")
        return types.ModuleType.__getattribute__(self, name)


def import_unless_hidden(name: str, *others: Any, **more: Any) -> Any:
    if name in HIDDEN and is_hidden_from(sys._getframe(1)):
        raise ModuleNotFoundError(f"this system has no module {name}", name=name)
    return import_any(name, *others, **more)


import_any, builtins.__import__ = builtins.__import__, import_unless_hidden
for module in (os, signal, socket, select):
    module.__class__ = ForeignModule
