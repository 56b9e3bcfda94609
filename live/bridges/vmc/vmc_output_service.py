"""Service that sends dancers to other programs as avatars by the VMC protocol."""

import re
from typing import Any, Final

import numpy as np

from live.app.option_values import parse_endpoint
from live.base.errors import PersonError, error_context
from live.bridges.vmc.vmc_output import MOST_AVATARS, AvatarTarget, VmcOutput, pack_dancers
from live.clock.time_source import Clock
from live.control.helper_process import HelperProcess
from live.show.engine import Engine
from live.show.show import Show

SELECTION_INTERVAL: Final = 1.0
"""Interval [s] at which selections of dancers are resolved again: groups change, dancers enter and leave."""


def parse_avatars(text: str) -> AvatarTarget:
    """Parse HOST:PORT[=WHO][@RATE]; the default is the first dancer, 60 times a second."""
    match = re.fullmatch(r"\s*([^=@\s]+)(?:=([^@]+))?(?:@(\d{1,3}(?:\.\d+)?))?\s*", text)
    rate = 60.0 if match is None else float(match[3] or 60.0)
    if match is None or not 1.0 <= rate <= 120.0:
        raise PersonError(
            f"--vmc-out {text!r}: HOST:PORT, HOST:PORT=WHO or HOST:PORT=WHO@RATE expected, 1 to 120 times a second",
            '--vmc-out "127.0.0.1:39539=ember & 1"',
        )
    host, port = parse_endpoint(match[1], "--vmc-out")
    return AvatarTarget(host, port, (match[2] or "1").strip(), rate)


class VmcOutputService:
    """Feeds the process that sends avatars. Thread: the show's."""

    def __init__(self, engine: Engine, avatars: tuple[AvatarTarget, ...], clock: Clock) -> None:
        self._engine, self._avatars, self._clock = engine, avatars, clock
        self._rows = [self._select_rows(each) for each in avatars]
        self._due = [0.0] * len(avatars)
        self._next_selection = 0.0
        targets = [(each.host, each.port) for each in avatars]
        self._helper = HelperProcess("live.bridges.vmc.vmc_output", clock, {"targets": targets}, lambda: None)

    def _select_rows(self, avatars: AvatarTarget) -> np.ndarray[Any, np.dtype[np.intp]]:
        """Return the rows of the selected dancers on stage; raise PersonError for an invalid selection."""
        show: Show = self._engine.show
        with error_context("--vmc-out"):
            who = show.casting.select(avatars.who, show.state.position)
        return np.flatnonzero(who & show.motion.present)[:MOST_AVATARS]

    def start(self) -> None:
        """Start to send; raise PersonError for an unknown host."""
        for each in self._avatars:
            try:
                VmcOutput(each.host, each.port).close()
            except OSError as error:
                where = f"{each.host}:{each.port}"
                words = f"--vmc-out {where}: {error.strerror or error}"
                raise PersonError(words, "use IP addresses") from None
        self._engine.view.detailed = True
        self._helper.start()

    def stop(self) -> None:
        """Stop sending."""
        self._helper.stop()

    def frame(self) -> None:
        """Send the dancers that are due, after each frame."""
        self._helper.frame()
        view, now = self._engine.view, self._clock.now()
        if now >= self._next_selection:
            self._next_selection = now + SELECTION_INTERVAL
            for index, each in enumerate(self._avatars):
                try:
                    self._rows[index] = self._select_rows(each)
                except PersonError:  # an edit has removed the name: send no dancer
                    self._rows[index] = self._rows[index][:0]
        if not view.filled:
            return
        for index, each in enumerate(self._avatars):
            if view.time < self._due[index] or not len(self._rows[index]):
                continue
            self._due[index] = max(self._due[index] + 1.0 / each.rate, view.time)
            data = pack_dancers(self._rows[index], view.joint_position, view.joint_rotation)
            self._helper.send((index, view.time, data))

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        to = {
            f"{each.host}:{each.port}": (rows + 1).tolist()
            for each, rows in zip(self._avatars, self._rows, strict=True)
        }
        return {"to": to, **self._helper.status()}
