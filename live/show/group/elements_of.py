"""Elements as patches and controls say them, as values for the field (T105-T110, T132)."""

import math
from dataclasses import dataclass
from typing import Final

from live.agents.elements.element import Element, Points
from live.agents.elements.element_kinds import FLOW_NAMES, KIND_NAMES
from live.base.errors import PersonError
from live.control.events import events
from live.show.patch.section_elements import ElementSection

ElementEvent = events.Attract | events.Repel | events.Spread | events.Voice | events.PlaceElement
VOICE_MEASURES: Final = 2.0
"""How long a voice of the audience is heard if it is not raised again."""


@dataclass(frozen=True, slots=True)
class Placing:
    """One element as it was asked for: what, for whom (in words), how long; not yet when."""

    kind: str
    points: Points = ((0.0, 0.0),)
    strength: float = 1.0
    measures: float = 4.0
    group: str = "*"
    radius: float = 0.0
    closed: bool = False
    flow: str = ""
    whom: str = ""
    fair: bool = False

    def element(self, *, groups: int, target_group: int, source: str, start: float, beats_per_measure: int) -> Element:
        """The element from the beat `start` on; PersonError if it has no meaning.

        `groups`: the mask of those it addresses; `target_group`: the bit of the group `whom`, -1 if that is a number.
        """
        return Element(
            kind=KIND_NAMES[self.kind],
            points=self.points,
            strength=self.strength,
            start_beat=start,
            end_beat=start + self.measures * beats_per_measure,
            groups=groups,
            source=source,
            closed=self.closed,
            radius=self.radius,
            fair=self.fair,
            flow=FLOW_NAMES[self.flow or "uniform"],
            target=self.dancer,
            target_group=target_group,
        )

    @property
    def dancer(self) -> int:
        """Index of the dancer that `whom` numbers, -1 if it numbers none."""
        return int(self.whom) - 1 if self.whom.isdecimal() and len(self.whom) < 7 else -1


def placing_of_section(section: ElementSection) -> Placing:
    """What an element of the score asks for."""
    points = section.points or ((section.at,) if section.to is None else (section.at, section.to))
    return Placing(
        section.kind,
        points,
        section.strength,
        section.measures,
        section.group,
        section.radius,
        section.closed,
        section.flow,
        section.whom,
    )


def placing_of_event(event: ElementEvent) -> Placing:
    """What a control asks for; PersonError for points that are none."""
    match event:
        case events.Attract() | events.Repel():
            kind = "attract" if isinstance(event, events.Attract) else "repel"
            return Placing(kind, ((event.x, event.z),), event.strength, event.measures, event.group)
        case events.Spread():
            return Placing("spread", measures=event.measures, group=event.group)
        case events.Voice():
            return Placing("attract", ((event.x, event.z),), event.strength, VOICE_MEASURES, fair=True)
        case events.PlaceElement():
            if event.kind not in KIND_NAMES or (event.flow and event.flow not in FLOW_NAMES):
                raise PersonError(f"no element is called {event.kind or event.flow!r}")
            points = points_of(event.points) if event.points else ((0.0, 0.0),)
            return Placing(
                event.kind,
                points,
                event.strength,
                event.measures,
                event.group,
                event.radius,
                event.closed,
                event.flow,
                event.whom,
            )


def points_of(text: str) -> Points:
    """Points written as "x z, x z" [m]; PersonError for anything else."""
    try:
        numbers = [[float(word) for word in pair.split()] for pair in text.replace(";", ",").split(",")]
    except ValueError:
        numbers = [[]]
    if any(len(pair) != 2 or not all(map(math.isfinite, pair)) for pair in numbers):
        raise PersonError(f"points {text[:60]!r} are none", "write x z of each in metres, as in -3 0, 0 -2.5, 3 0")
    return tuple((pair[0], pair[1]) for pair in numbers)
