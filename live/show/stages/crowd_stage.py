"""Motion of the agents in a tick: what each group wants, and the crowd that moves accordingly."""

from typing import TYPE_CHECKING

from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion
    from live.show.selection.scheduler import Scheduler


class GroupStage:
    """Evolutions, elements and entrances write a command for each agent; stage STEERING."""

    def __init__(self, breakers: CircuitBreakers, motion: "GroupMotion", scheduler: "Scheduler") -> None:
        self._breakers, self._motion, self._scheduler = breakers, motion, scheduler

    def tick(self, now: Now) -> None:
        """Write the commands of this tick."""
        if self._breakers.closed(Stage.STEERING):
            self._motion.command(now.time, now.timeline, now.span, speed=self._scheduler.speed)


class CrowdStage:
    """Agents follow their commands and avoid each other; stages STEERING and PARTNERS."""

    def __init__(
        self, breakers: CircuitBreakers, motion: "GroupMotion", scheduler: "Scheduler", dancers: "Dancers"
    ) -> None:
        self._breakers, self._motion, self._dancers = breakers, motion, dancers
        self._correction = scheduler.root_correction

    def tick(self, now: Now) -> None:
        """Advance the agents by one tick."""
        if self._breakers.closed(Stage.STEERING):
            self._motion.advance(
                now.time,
                reference=self._correction.reference,
                reference_velocity=self._correction.reference_velocity,
            )
        if self._breakers.closed(Stage.PARTNERS):
            self._motion.follow_partner_response(self._dancers.partner_response, self._dancers.drawn_hips)
