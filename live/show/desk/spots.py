"""Spots: the follow spots of a show; whom each follows. How bright, how wide and of what colour are parameters."""

from typing import Any

from live.base.errors import PersonError
from live.base.lights import SPOTS
from live.base.picture import BY_ADDRESS
from live.base.stage_snapshot import StageView
from live.show.desk.chase import Chase, Float64
from live.show.desk.parameters import Parameters
from live.show.group.group_motion import GroupMotion


class Spots:
    """All follow spots. Call `tick` for every tick, `place` for every picture. Thread: the show's."""

    def __init__(self, parameters: Parameters, motion: GroupMotion) -> None:
        self._parameters = parameters
        self._chases = tuple(Chase(motion) for _ in range(SPOTS))
        self._levels = [BY_ADDRESS[f"/dance/spot/{number}"].first for number in range(1, SPOTS + 1)]

    def follow(self, number: float, whom: str, level: float, *, beats: float) -> None:
        """Spot `number`, from 1, follows whom these words mean and goes to `level` in so many beats; PersonError if
        they mean nobody."""
        if number != int(number):
            raise PersonError(f"spot {number:g}: 1 to {SPOTS} expected")
        place = int(number) - 1
        self._chases[place].follow(whom, cut=beats <= 0.0)
        self._parameters.fade({self._levels[place]: level}, beats=beats)

    def begin_measure(self) -> None:
        """Who is meant may have changed."""
        for chase in self._chases:
            chase.begin_measure()

    def tick(self, seconds: float) -> None:
        """So much time has passed."""
        row = self._parameters.picture
        for chase, level in zip(self._chases, self._levels, strict=True):
            if row[level] > 0.0:
                chase.tick(seconds)
            else:
                chase.stop()

    def place(self, view: StageView, seconds: float) -> None:
        """Say in a view where the spots are so long after the last tick."""
        for number, chase in enumerate(self._chases):
            if chase.running:
                view.spot[number] = chase.at(seconds)

    def hashed(self) -> tuple[Float64, ...]:
        """What belongs to the state of the show; nothing while all spots are dark."""
        return tuple(part for chase in self._chases for part in chase.hashed())

    def facts(self) -> dict[str, Any]:
        """For the status: whom each spot that is lit follows."""
        return {"spots": {str(n): chase.whom for n, chase in enumerate(self._chases, start=1) if chase.running}}
