"""HttpPart: a part of a live show that answers over HTTP, in a process of its own that is told the show's values."""

import importlib.util
import socket
from collections.abc import Callable, Sequence
from typing import Any, Final

from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.clock.time_source import Clock
from live.control.helper_process import Helper
from live.control.registry.values import Changes

AT_ONCE: Final = 64
"""Addresses that are told in one packet."""
BACKLOG: Final = 128
"""Connections that wait until the process accepts them."""


class HttpPart:
    """Between the show and the process that answers. Thread: the one that runs the show."""

    def __init__(
        self, where: tuple[str, int], option: str, module: str, plan: Callable[[], dict[str, Any]], clock: Clock,
        *, needs: Sequence[str] = ("aiohttp",),
    ) -> None:  # fmt: skip
        """`module` is the process, `plan` what it reads first beside its socket (`http`); `needs`: packages."""
        self._where, self._option, self._module, self._plan, self._clock = where, option, module, plan, clock
        self._needs = needs
        self.goes_on = False
        """Whether the show goes on after an engine that may hold the port still."""
        self._socket: socket.socket | None = None
        self._helper: Helper | None = None
        self._all: dict[str, Any] = {}
        self._untold: dict[str, Any] = {}

    def start(self) -> None:
        """Listen, and begin to answer; PersonError if that cannot be."""
        missing = [name for name in self._needs if importlib.util.find_spec(name) is None]
        if missing:
            raise PersonError(f"{self._option} needs the package {' and '.join(missing)}", "make play installs it")
        self._socket = self._listening()
        http = self._socket.fileno()
        self._helper = Helper(self._module, self._clock, self._plan() | {"http": http}, self._anew, http)
        self._helper.start()

    def _listening(self) -> socket.socket:
        try:
            return listening_socket(self._where, BACKLOG, goes_on=self.goes_on)
        except (OSError, OverflowError) as error:
            where = f"{self._where[0]}:{self._where[1]}"
            raise PersonError(f"{self._option} {where}: {error}", "choose another port") from None

    def stop(self) -> None:
        """Answer nobody any more."""
        if self._helper is not None:
            self._helper.stop()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def tell(self, changes: Changes) -> None:
        """These have new values in the show."""
        self._all.update(changes)
        self._untold.update(changes)

    def _anew(self) -> None:
        self._untold = dict(self._all)

    def frame(self) -> None:
        """After each frame: pass on what has changed, a little at a time."""
        if self._helper is None:
            return
        self._helper.frame()
        if self._untold:
            some = {address: self._untold[address] for address in list(self._untold)[:AT_ONCE]}
            if self._helper.send(some):
                for address in some:
                    del self._untold[address]

    @property
    def port(self) -> int:
        """Where it answers."""
        return self._where[1] if self._socket is None else int(self._socket.getsockname()[1])

    @property
    def process(self) -> int | None:
        """The number of the process that answers; None while there is none."""
        return None if self._helper is None else self._helper.process

    def status(self) -> dict[str, Any]:
        """For the status line."""
        return {} if self._helper is None else self._helper.facts()
