"""Tables of improvisation: one `[[improvise]]` for one group, its names looked up in the library."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError, named
from live.graph.motion_graph import MotionGraph
from live.show.patch.improvise import ImproviseSection
from live.show.score.places import END
from live.show.score.score import Score
from live.show.score.sequence_lookup import where_of
from live.show.score.step_names import UnknownStep, find_step

NOBODY: Final = -1


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """One `[[improvise]]` for one group: names are looked up, and where it holds."""

    section: int
    begin: int
    """Its first measure within the section, from 0."""
    end: int | None
    """The measure after its last; None: it has none."""
    asked: ImproviseSection
    steps: tuple[int, ...]
    weights: npt.NDArray[np.float64]
    factors: tuple[npt.NDArray[np.float64], ...]
    """What each rule multiplies the weights with."""
    caller: int
    """Group that is answered, NOBODY for none."""
    listening: int | None


def table_of(
    section: ImproviseSection,
    score: Score,
    graph: MotionGraph,
    own: list[int],
    groups: list[str],
    group: int,
    where: tuple[str | int, ...] = (),
) -> Table | None:
    """One `[[improvise]]` for the group `group`, whose own steps are `own`; None if its place never comes.

    PersonError for names that are not there, or limits that cannot be kept.
    """
    place = score.place_of(section.section, section.measure)
    if place is None:
        return None
    with named(where_of(section.section, section.measure, f"improvise of group {groups[group]!r}"), where):
        try:
            given = {find_step(graph, name): weight for name, weight in section.steps.items()}
            weights = given or dict.fromkeys(own, 1.0)
            steps = tuple(weights)
            factors = []
            for rule in section.rule:
                favours = {find_step(graph, name): factor for name, factor in rule.favours.items()}
                factors.append(np.array([favours.get(step, 1.0) for step in steps]))
            listening = None if section.listening is None else find_step(graph, section.listening)
        except UnknownStep as error:
            raise PersonError(str(error)) from None
        if sum(weight > 0.0 for weight in weights.values()) < 2 and section.most < 1000:
            raise PersonError(
                f"with one step alone it would come more than {section.most} times in a row",
                "give it more steps, or most = 1000",
            )
        caller = NOBODY
        if section.answers is not None:
            caller = [name.casefold() for name in groups].index(section.answers.casefold())
    size = score.playhead.stretches[place[0]].measures if place[0] != END else None
    end = size if section.measures is None else place[1] + section.measures
    return Table(place[0], place[1], end, section, steps, np.array(list(weights.values())), tuple(factors), caller,
                 listening)  # fmt: skip
