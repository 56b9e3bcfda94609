"""Skirts, sleeves, ribbons and long hair in a tick: they follow the dancers' joints."""

from typing import TYPE_CHECKING

from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.dancers.garments import Garments
    from live.show.group.group_motion import GroupMotion


class GarmentsStage:
    """Stage CLOTH of one show."""

    def __init__(
        self, breakers: CircuitBreakers, garments: "Garments", dancers: "Dancers", motion: "GroupMotion"
    ) -> None:
        self._breakers, self._garments, self._dancers, self._motion = breakers, garments, dancers, motion

    def tick(self, now: Now, fraction: float) -> None:
        """Advance the garments to `fraction` of the measure."""
        garments = self._garments
        if self._breakers.enter(Stage.CLOTH):
            garments.restart()  # and so they are drawn fixed to the body
            return
        garments.assign(now.span.number)
        if not garments.any:
            return
        self._dancers.pose(fraction, now.time, out=garments.joints, visible=self._motion.present)
        garments.tick(self._motion.present)
