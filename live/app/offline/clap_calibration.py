"""Clap test of `live calibrate --claps`: the screen flashes, people clap with it, and a microphone records them."""

import time
from collections.abc import Callable
from types import TracebackType
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.clock.time_source import Clock, SystemClock
from live.control.audio.channel_mixer import Channels
from live.control.audio.devices import SoundDevice
from live.control.audio.latency_claps import ClapOffset, clap_offset, find_claps
from live.control.audio.latency_sweep import Microphone

FLASH_PERIOD: Final = 0.75
"""Seconds between flashes: 80 bpm, slow enough to be safe for photosensitive eyes and to measure up to 370 ms."""

START_DELAY: Final = 2.0
FLASH_DURATION: Final = 0.12
END_DELAY: Final = 1.5


class Screen(Protocol):
    """Screen that can be light or dark."""

    def show(self, light: bool) -> bool:
        """Draw one picture, which takes about a frame; return False if the screen was closed."""
        ...


class WindowScreen:
    """Full-screen window on a monitor."""

    def __init__(self, monitor: str | None) -> None:
        """Raise PersonError if there is no screen."""
        from live.render.window.monitors import UnknownMonitor, find_monitor
        from live.render.window.window import NoWindow, Window

        try:
            chosen = None if monitor is None else find_monitor(monitor)
            self._window = Window("Clap with the light", monitor=chosen, fullscreen=True)
        except (NoWindow, UnknownMonitor) as error:
            raise PersonError(f"--claps: {error}") from None

    def show(self, light: bool) -> bool:
        """Draw one picture; return False after Esc or when the window was closed."""
        from live.render.window.window_input import CloseRequested, KeyPressed

        for value in self._window.poll():
            if isinstance(value, CloseRequested) or (isinstance(value, KeyPressed) and value.name == "escape"):
                return False
        level = 1.0 if light else 0.0
        target = self._window.target
        target.use()
        target.clear(level, level, level)
        self._window.swap()
        return True

    def __enter__(self) -> "WindowScreen":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._window.close()


def flash(
    screen: Screen, count: int, clock: Clock, wait: Callable[[float], None] = time.sleep
) -> npt.NDArray[np.float64]:
    """Flash `count` times; return the start of the first light picture of each flash [s], shape (count,).

    A show also decides at that moment what it draws. Raise PersonError if the screen is closed.
    """
    begin = clock.now() + START_DELAY
    flashes: list[float] = []
    while (now := clock.now()) < begin + count * FLASH_PERIOD + END_DELAY:
        into = (now - begin) % FLASH_PERIOD
        light = 0.0 <= now - begin < count * FLASH_PERIOD and into < FLASH_DURATION
        number = int((now - begin) // FLASH_PERIOD)
        if light and number >= len(flashes):
            flashes.append(now)
        if not screen.show(light):
            raise PersonError("the clap test was broken off", "let it run to its end")
        wait(0.002)
    return np.array(flashes)


def clap_test(screen: Screen, device: SoundDevice, channels: Channels, count: int) -> ClapOffset:
    """Flash and record; return the delay of the claps at the input."""
    clock = SystemClock()
    microphone = Microphone(device, channels, START_DELAY + count * FLASH_PERIOD + END_DELAY + 10.0, clock)
    try:
        flashes = flash(screen, count, clock)
    finally:
        microphone.close()
    claps = find_claps(microphone.sound(), microphone.sample_rate)
    return clap_offset(microphone.time_of(claps), flashes)
