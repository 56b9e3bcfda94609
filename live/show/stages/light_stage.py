"""Brightness of the picture: the blackout fades."""

from typing import Final

from live.base.scalar_kernels import damper
from live.clock.ticks import TICK
from live.control.events.events import Blackout
from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

FADE_HALFLIFE: Final = 0.06
"""Half-life of a blackout's fade [s]: dark within 0.2 s, without a flash."""


class LightStage:
    """Stage LIGHT of one show."""

    EVENTS = (Blackout,)

    def __init__(self, breakers: CircuitBreakers) -> None:
        self.blackout = False
        """Whether the picture is or becomes black."""
        self.brightness = 1.0
        """Present brightness, 0 to 1."""
        self._breakers = breakers

    def handle(self, event: Blackout, now: Now) -> None:
        """Begin or end the blackout."""
        self.blackout = event.on

    def tick(self) -> None:
        """Fade by one tick."""
        level = self._breakers.enter(Stage.LIGHT)
        goal = 0.0 if self.blackout else 1.0
        self.brightness = goal if level else damper(self.brightness, goal, FADE_HALFLIFE, TICK)
