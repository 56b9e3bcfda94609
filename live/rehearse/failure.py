"""Failure of a run: an exception with its place in the code, comparable between runs."""

import traceback
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Final

PROGRAM_FOLDER: Final = Path(__file__).parents[1]
"""The folder of the program: the deepest place of a traceback in it is reported."""
DIFFERENT_STATE: Final = "different state"
"""The kind of a failure without exception: the same events led to another state."""


@dataclass(frozen=True, slots=True)
class Failure:
    """An exception and where it was raised, or a state that differs."""

    kind: str
    """Class of the exception, or DIFFERENT."""
    message: str
    """The message."""
    place: str = ""
    """File (from the program's folder) and function of the deepest place in the program; unaffected by line numbers."""
    line: int = 0
    tick: int = -1
    """The tick of the failure; -1: none."""
    trace: str = ""
    """The whole traceback, for the report's JSON."""

    @classmethod
    def from_exception(cls, error: BaseException, tick: int = -1) -> "Failure":
        """Return the failure for a caught exception."""
        place, line = deepest_place(error.__traceback__)
        text = "".join(traceback.format_exception(error))
        return cls(type(error).__name__, " ".join(str(error).split()), place, line, tick, text)

    @property
    def key(self) -> tuple[str, str]:
        """Kind and place: equal for the same failure in two runs."""
        return self.kind, self.place

    def __str__(self) -> str:
        at = f"tick {self.tick}: " if self.tick >= 0 else ""
        where = f" in {self.place}, line {self.line}" if self.place else ""
        return f"{at}{self.kind}{where}" + (f": {self.message}" if self.message else "")

    def facts(self) -> dict[str, Any]:
        """Return the fields for a report."""
        return {"kind": self.kind, "words": self.message, "place": self.place, "line": self.line, "tick": self.tick,
                "trace": self.trace}  # fmt: skip


def deepest_place(trace: TracebackType | None) -> tuple[str, int]:
    """Return the deepest place of a traceback in the program, as "show/show.py, tick", and its line."""
    place, line = "", 0
    while trace is not None:
        code = trace.tb_frame.f_code
        path = Path(code.co_filename)
        if path.is_relative_to(PROGRAM_FOLDER):
            place, line = f"{path.relative_to(PROGRAM_FOLDER).as_posix()}, {code.co_name}", trace.tb_lineno
        trace = trace.tb_next
    return place, line
