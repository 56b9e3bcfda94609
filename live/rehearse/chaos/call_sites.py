"""Tracer for the call sites of a show's tick, and injector of exceptions at them.

A site is a place from which the frame of a show, or one of its stages, calls a function. The exception is raised
at the beginning of the callee, before it has any effect, like an error of the program at that place. Both use a profile
function (`sys.setprofile`) while a tick runs; the program has no hook for them.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, Final

from live.rehearse.failure import PROGRAM_FOLDER
from live.show import circuit_breakers
from live.show import frame as show_frame
from live.show.show import Show
from live.show.stages import tripped_stages

BREAKERS_FILE: Final = Path(circuit_breakers.__file__).relative_to(PROGRAM_FOLDER).as_posix()
"""Callees in this file are the circuit breakers."""

Tick = Callable[[Show, float], bool]


class InjectedError(RuntimeError):
    """An injected exception."""


@dataclass(frozen=True, slots=True, order=True)
class CallSite:
    """A place in the program that calls a function."""

    caller: str
    """File and function, as "show/show.py, Show.tick"."""
    line: int
    callee: str
    """File and function in the program, or the qualified name of an external function."""

    def __str__(self) -> str:
        return f"{self.caller}, line {self.line} -> {self.callee}"

    @property
    def is_breaker(self) -> bool:
        """Whether the callee is a circuit breaker: a permanent failure there cannot be isolated."""
        return self.callee.startswith(BREAKERS_FILE)


_VALUES: Final = ("now.py", "measure_span.py")
"""Files of the stages that only hold values."""
_STAGES: Final = Path(str(tripped_stages.__file__)).parent
_TICK_FILES: Final = frozenset(
    [
        str(show_frame.__file__),
        *(str(path) for path in _STAGES.glob("*.py") if path.name not in _VALUES),
    ]
)
"""Files with the code of a tick: the frame and its stages."""


def _code_name(code: CodeType) -> str:
    path = Path(code.co_filename)
    file = path.relative_to(PROGRAM_FOLDER).as_posix() if path.is_relative_to(PROGRAM_FOLDER) else path.name
    return f"{file}, {code.co_qualname}"


class CallSiteTracer:
    """Records all call sites that ticks pass. Thread: the one that runs the show."""

    def __init__(self) -> None:
        self.sites: dict[CallSite, int] = {}
        """The found sites, with the number of calls."""
        self._names: dict[CodeType, str] = {}

    def run(self, tick: Tick, show: Show, time: float) -> bool:
        """Run a tick and record its call sites."""
        sys.setprofile(self._trace)
        try:
            return tick(show, time)
        finally:
            sys.setprofile(None)

    def _trace(self, frame: FrameType, event: str, arg: Any) -> None:
        site = self._site(frame, event, arg)
        if site is not None:
            self.sites[site] = self.sites.get(site, 0) + 1

    def _site(self, frame: FrameType, event: str, arg: Any) -> CallSite | None:
        if event == "call":
            caller = frame.f_back
            if caller is None or caller.f_code.co_filename not in _TICK_FILES:
                return None
            return CallSite(self._cached_name(caller.f_code), caller.f_lineno, self._cached_name(frame.f_code))
        if event == "c_call" and frame.f_code.co_filename in _TICK_FILES:
            return CallSite(self._cached_name(frame.f_code), frame.f_lineno, str(getattr(arg, "__qualname__", arg)))
        return None

    def _cached_name(self, code: CodeType) -> str:
        name = self._names.get(code)
        if name is None:
            name = self._names[code] = _code_name(code)
        return name


class ExceptionInjector:
    """Raises an exception at a site, a number of times, from a show time on. Thread: the show's."""

    def __init__(self) -> None:
        self.site: CallSite | None = None
        self.remaining = 0
        """Remaining number of exceptions."""
        self.since = 0.0
        """Show time from which on they are raised [s]."""
        self.raised_count = 0
        """Number of exceptions since it was armed."""

    def arm(self, site: CallSite, times: int, since: float) -> None:
        """Start raising at `site`."""
        self.site, self.remaining, self.since, self.raised_count = site, times, since, 0

    def disarm(self) -> None:
        """Stop raising."""
        self.site, self.remaining = None, 0

    def run(self, tick: Tick, show: Show, time: float) -> bool:
        """Run a tick, with the exception if it is due."""
        if self.site is None or self.remaining <= 0 or time < self.since:
            return tick(show, time)
        sys.setprofile(self._raise)
        try:
            return tick(show, time)
        finally:
            sys.setprofile(None)

    def _raise(self, frame: FrameType, event: str, arg: Any) -> None:
        site = self.site
        if site is None or self.remaining <= 0:
            return
        if event == "call":
            caller = frame.f_back
            here = caller is not None and caller.f_lineno == site.line and _code_name(frame.f_code) == site.callee
            here = here and caller is not None and _code_name(caller.f_code) == site.caller
        elif event == "c_call" and frame.f_lineno == site.line:
            here = getattr(arg, "__qualname__", str(arg)) == site.callee and _code_name(frame.f_code) == site.caller
        else:
            here = False
        if here:
            self.remaining -= 1
            self.raised_count += 1
            self.on_raise()
            raise InjectedError(f"injected at {site}")

    def on_raise(self) -> None:
        """Called before the exception is raised; for subclasses."""


@contextmanager
def replaced_tick(run: Callable[[Tick, Show, float], bool]) -> Iterator[None]:
    """Replace `Show.tick` of all shows by `run`, within the context."""
    was: Tick = Show.tick

    def tick(show: Show, time: float) -> bool:
        return run(was, show, time)

    replace_method(Show, "tick", tick)
    try:
        yield
    finally:
        replace_method(Show, "tick", was)


def replace_method(owner: type, name: str, replacement: Callable[..., Any]) -> None:
    """Replace a method of a class, in this process."""
    setattr(owner, name, replacement)
