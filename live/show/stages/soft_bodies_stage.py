"""What moves by itself on the dancers' bodies in a tick: the springs of characters."""

from typing import TYPE_CHECKING

from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.character_springs import CharacterSprings


class SoftBodiesStage:
    """Stage SOFT_BODIES of one show."""

    def __init__(self, breakers: CircuitBreakers, springs: "CharacterSprings") -> None:
        self._breakers, self._springs = breakers, springs

    def tick(self, now: Now, fraction: float) -> None:
        """Advance to `fraction` of the measure, after the dancers."""
        if self._breakers.closed(Stage.SOFT_BODIES):
            self._springs.tick(now, fraction)
