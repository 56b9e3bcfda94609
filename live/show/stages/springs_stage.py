"""Springs of characters in a tick: hair, skirts and tails of files."""

from typing import TYPE_CHECKING

from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.character_springs import CharacterSprings


class SpringsStage:
    """Stage SPRINGS of one show."""

    def __init__(self, breakers: CircuitBreakers, springs: "CharacterSprings") -> None:
        self._breakers, self._springs = breakers, springs

    def tick(self, now: Now, fraction: float) -> None:
        """Advance to `fraction` of the measure, after the dancers."""
        if self._breakers.closed(Stage.SPRINGS):
            self._springs.tick(now, fraction)
