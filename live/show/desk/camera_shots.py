"""Kinds of shots and moods of the camera director.

Shot sizes and their names are those of film (Mascelli 1965, *The Five C's of Cinematography*). A mood weights them as
an idiom does (He, Cohen and Salesin 1996, *The Virtual Cinematographer*), with the phrase as the unit of time.
"""

from dataclasses import dataclass
from typing import Final, Literal

Subject = Literal["all", "group", "pair", "soloist"]


@dataclass(frozen=True, slots=True)
class ShotKind:
    """A kind of shot: whom it shows, from which height of their bodies on, and from where."""

    name: str
    subject: Subject
    elevation_deg: tuple[float, float]
    """Least and largest elevation of the camera above the horizon."""
    field_of_view_deg: float
    """Vertical field of view."""
    lowest: float = 0.0
    """Height of the lower edge on the bodies [m]; 0: with their feet."""
    stiffness: float = 1.6
    """How fast it follows its dancers [1/s]."""
    aimed_deg: float | None = None
    """The elevation, where it is not one of those that are compared."""
    above: float = 0.34
    """Share of the free height that lies above the dancers where the width binds."""

    @property
    def whole(self) -> bool:
        """Whether it shows whole bodies."""
        return self.lowest <= 0.0


TOTAL: Final = ShotKind("total", "all", (3.0, 30.0), 34.0)
HIGH: Final = ShotKind("high", "all", (36.0, 50.0), 34.0)
LOW: Final = ShotKind("low", "group", (3.0, 3.0), 42.0, stiffness=2.0, aimed_deg=-4.0, above=0.72)
GROUP: Final = ShotKind("group", "group", (3.0, 16.0), 30.0, stiffness=2.0)
PAIR: Final = ShotKind("pair", "pair", (3.0, 16.0), 27.0, stiffness=2.4)
FULL: Final = ShotKind("full", "soloist", (3.0, 16.0), 27.0, stiffness=2.6)
KNEES: Final = ShotKind("knees", "soloist", (3.0, 9.0), 25.0, 0.45, 3.2)
WAIST: Final = ShotKind("waist", "soloist", (3.0, 9.0), 23.0, 0.95, 3.6)
SHOULDERS: Final = ShotKind("shoulders", "soloist", (3.0, 9.0), 20.0, 1.35, 4.0)
KINDS: Final = (TOTAL, HIGH, LOW, GROUP, PAIR, FULL, KNEES, WAIST, SHOULDERS)
"""All kinds of shots."""


@dataclass(frozen=True, slots=True)
class CameraMood:
    """How the director works: how often it changes, whether it cuts, and which shots it likes."""

    name: str
    measures: int
    """A new shot comes after so many measures, on the line of a phrase."""
    shortest_s: float
    """Least length of a shot [s]."""
    cuts: float
    """Share of the changes that are cuts; the others are moves."""
    move_beats: float
    """Length of a move [beats]."""
    weights: tuple[tuple[ShotKind, float], ...]
    """How likely each kind is where it is possible."""
    drift_deg: float = 0.0
    """Largest turn around the dancers in each measure."""
    push: float = 0.0
    """How much nearer the camera goes in a build-up, as a share of the distance."""
    widest_deg: float = 66.0
    """Largest bearing from the public's side."""


STILL: Final = CameraMood("still", 8, 8.0, 0.0, 8.0, ((TOTAL, 1.0),), widest_deg=0.0)
CALM: Final = CameraMood(
    "calm", 8, 8.0, 0.0, 8.0, ((TOTAL, 1.0), (GROUP, 0.2), (FULL, 0.25), (PAIR, 0.25)), 0.0, 0.06, 44.0
)
LIVELY: Final = CameraMood(
    "lively", 4, 3.0, 0.9, 2.0,
    ((TOTAL, 1.0), (HIGH, 0.25), (LOW, 0.3), (GROUP, 0.4), (PAIR, 0.5), (FULL, 0.4), (KNEES, 0.3)), 0.8, 0.1,
)  # fmt: skip
CINEMATIC: Final = CameraMood(
    "cinematic", 4, 5.0, 0.6, 6.0,
    (
        (TOTAL, 1.0), (HIGH, 0.3), (LOW, 0.4), (GROUP, 0.5), (PAIR, 0.6), (FULL, 0.4), (KNEES, 0.4), (WAIST, 0.35),
        (SHOULDERS, 0.15),
    ),
    2.0, 0.14,
)  # fmt: skip
MOODS: Final = (CALM, STILL, LIVELY, CINEMATIC)
"""All moods, by the number of `/dance/camera/mood`."""
