"""AgentsAhead: where the agents of a show will be when the next measure ends, looked ahead a few steps at a time."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.crowd.agent_state import AgentState
from live.agents.entrances.entrances import ON, Entrances
from live.agents.prediction import LookAhead
from live.show.group.elements import Elements
from live.show.group.evolutions import Evolutions
from live.show.group.floor import Floor
from live.show.measure_span import MeasureSpan

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

TAKEN: Final = 0.5
"""An element whose influence has come this far takes a dancer out of her evolution for good."""


class AgentsAhead:
    """Call `begin`, `work` until all is done, and `ends`."""

    def __init__(
        self, look: LookAhead, evolutions: Evolutions, elements: Elements, entrances: Entrances, floor: Floor,
        count: int, beats: int,
    ) -> None:  # fmt: skip
        """`look` runs the copy of `count` agents; `beats` of a danced measure."""
        self._look, self._evolutions, self._elements = look, evolutions, elements
        self._entrances, self._floor = entrances, floor
        self._count, self._beats = count, beats
        self._late: Float64 = np.zeros(count)

    def begin(self, state: AgentState, time: float, seconds: float, late: Float64, tempo: float) -> None:
        """Begin to look `seconds` [s] ahead of `time` [s] at `tempo` [bpm], for dancers who are `late` (A,) [beats] on
        purpose."""
        self._late = late
        self._look.begin(state, time=time, seconds=[seconds + beats * 60.0 / tempo for beats in np.unique(late)])

    def work(self, steps: int) -> None:
        """Do at most so many coarse steps of looking ahead."""
        self._look.work(steps)

    def ends(self, span: MeasureSpan | None) -> tuple[Float64, Bool, Float64]:
        """Where everybody will be when the measure after `span` ends, (A, 2) [m]; who is in an evolution then, (A,),
        and with which heading, (A,) [rad]. Measures of those who are late end later."""
        place, heading = np.zeros((self._count, 2)), np.zeros(self._count)
        held = np.zeros(self._count, np.bool_)
        for beats, position in zip(np.unique(self._late), self._look.positions, strict=True):
            rows = self._late == beats
            place[rows] = position[rows]
            if span is None:
                continue
            known, planned, facing = self._evolutions.target((span.number + 2) * self._beats + beats)
            rows &= known & (self._elements.influence < TAKEN) & ~self._entrances.passing
            place[rows], heading[rows], held[rows] = planned[rows], facing[rows], True
        if self._floor.fitting is not None:  # plans may have been made for a larger stage
            on = self._entrances.state == ON
            place[on] = np.clip(place[on], -self._floor.half, self._floor.half)
        return place, held, heading
