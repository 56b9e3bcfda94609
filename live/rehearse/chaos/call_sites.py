"""Call sites of a show's tick, found by looking at shows that run, and exceptions raised at them.

A site is a place from which the tick, or one of the show's own methods below it, calls something. The exception comes
as the callee begins, so that nothing of it is done: an error of the program at that place looks like this. All of
it happens by a profile function (`sys.setprofile`) while a tick runs; the program has no hook for it.
"""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType, FunctionType
from typing import Any, Final

from live.rehearse.failure import OURS
from live.show.show import Show

MECHANISM: Final = "show/breakers.py"
"""Callees of this file are what a failing stage is put out of service by."""

Tick = Callable[[Show, float], bool]


class Injected(RuntimeError):
    """An exception that was raised on purpose."""


@dataclass(frozen=True, slots=True, order=True)
class Site:
    """A place in the program that calls something, by what stays when the file around it is edited a little."""

    caller: str
    """File and function, as "show/core.py, Show._move"."""
    line: int
    callee: str
    """File and function of ours, or the name of what is not ours."""

    def __str__(self) -> str:
        return f"{self.caller}, line {self.line} -> {self.callee}"

    @property
    def of_the_mechanism(self) -> bool:
        """Whether it asks the breakers: what is broken for ever there cannot be put out of service."""
        return self.callee.startswith(MECHANISM)


def _own_codes() -> set[CodeType]:
    """The code of every method of a show itself, however many classes it is made of."""
    found = (value for kind in Show.__mro__ if kind is not object for value in vars(kind).values())
    return {value.__code__ for value in found if isinstance(value, FunctionType)}


def _name(code: CodeType) -> str:
    path = Path(code.co_filename)
    file = path.relative_to(OURS).as_posix() if path.is_relative_to(OURS) else path.name
    return f"{file}, {code.co_qualname}"


class Looker:
    """Notes all sites that ticks pass. Thread: the one that runs the show."""

    def __init__(self, *, deep: bool = False) -> None:
        """`deep`: the calls that the callees make, too."""
        self._callers = _own_codes()
        self._deep = deep
        self.sites: dict[Site, int] = {}
        """All that were found, with how often they were passed."""
        self._names: dict[CodeType, str] = {}

    def run(self, tick: Tick, show: Show, time: float) -> bool:
        """Run a tick, and look."""
        sys.setprofile(self._look)
        try:
            return tick(show, time)
        finally:
            sys.setprofile(None)

    def _look(self, frame: FrameType, event: str, arg: Any) -> None:
        site = self._site(frame, event, arg)
        if site is not None:
            self.sites[site] = self.sites.get(site, 0) + 1

    def _site(self, frame: FrameType, event: str, arg: Any) -> Site | None:
        if event == "call":
            caller = frame.f_back
            if caller is None or caller.f_code not in self._callers:
                return None
            if self._deep and caller.f_code in _own_codes() and frame.f_code.co_filename.startswith(str(OURS)):
                self._callers.add(frame.f_code)
            return Site(self._named(caller.f_code), caller.f_lineno, self._named(frame.f_code))
        if event == "c_call" and frame.f_code in self._callers:
            return Site(self._named(frame.f_code), frame.f_lineno, str(getattr(arg, "__qualname__", arg)))
        return None

    def _named(self, code: CodeType) -> str:
        name = self._names.get(code)
        if name is None:
            name = self._names[code] = _name(code)
        return name


class Injector:
    """Raises an exception at a site, so many times, in ticks from a time of the show on. Thread: the show's."""

    def __init__(self) -> None:
        self.site: Site | None = None
        self.left = 0
        """So often it is still to be raised."""
        self.since = 0.0
        """In ticks from that time of the show on [s]."""
        self.raised = 0
        """How often it was, since it was armed."""

    def arm(self, site: Site, times: int, since: float) -> None:
        """From now on."""
        self.site, self.left, self.since, self.raised = site, times, since, 0

    def disarm(self) -> None:
        """No more."""
        self.site, self.left = None, 0

    def run(self, tick: Tick, show: Show, time: float) -> bool:
        """Run a tick, with the exception if it is time for it."""
        if self.site is None or self.left <= 0 or time < self.since:
            return tick(show, time)
        sys.setprofile(self._raise)
        try:
            return tick(show, time)
        finally:
            sys.setprofile(None)

    def _raise(self, frame: FrameType, event: str, arg: Any) -> None:
        site = self.site
        if site is None or self.left <= 0:
            return
        if event == "call":
            caller = frame.f_back
            here = caller is not None and caller.f_lineno == site.line and _name(frame.f_code) == site.callee
            here = here and caller is not None and _name(caller.f_code) == site.caller
        elif event == "c_call" and frame.f_lineno == site.line:
            here = getattr(arg, "__qualname__", str(arg)) == site.callee and _name(frame.f_code) == site.caller
        else:
            here = False
        if here:
            self.left -= 1
            self.raised += 1
            self.note()
            raise Injected(f"injected at {site}")

    def note(self) -> None:
        """It is raised now."""


@contextmanager
def instead_of_tick(run: Callable[[Tick, Show, float], bool]) -> Iterator[None]:
    """Every tick of every show goes through `run` meanwhile."""
    was: Tick = Show.tick

    def tick(show: Show, time: float) -> bool:
        return run(was, show, time)

    replace_method(Show, "tick", tick)
    try:
        yield
    finally:
        replace_method(Show, "tick", was)


def replace_method(owner: type, name: str, made: Callable[..., Any]) -> None:
    """Another method in the place of one, for this process."""
    setattr(owner, name, made)
