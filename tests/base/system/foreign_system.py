"""Environment of a process that finds no more than Windows has: no descriptors to inherit, no fork, no /proc."""

import os
from pathlib import Path

from tests.base.system.test_portability import LACKING, POSIX_MODULES
from tests.places import ROOT

FOREIGN = Path(__file__).parent / "foreign"


def foreign_environment() -> dict[str, str]:
    """The environment of this process, in which the program takes the ways that work on every system."""
    hidden = [f"{module}.{name}" for module in ("os", "signal", "socket", "select") for name in LACKING[module]]
    path = os.pathsep.join((str(FOREIGN), str(ROOT)))
    return {**os.environ, "PYTHONPATH": path, "LIVE_PORTABLE": "1", "HIDDEN_NAMES": " ".join([*hidden, *POSIX_MODULES])}
