"""Comparison of directions: from where a formation is read best.

For each of 91 directions the dancers are framed, and the picture is measured (`camera_kernels.view_legibility`):
how much of each dancer is visible, how evenly the picture is shared (viewpoint entropy, Vázquez et al. 2001), how far
faces look to the camera, and how much of the soloist is visible. So a line is seen across, a column or a diagonal from
where it spreads, a circle from higher, a pair from where both are seen. The public's side is preferred.

Related: Assa, Wolf and Cohen-Or 2010 (*The Virtual Director*) choose cameras for human motion by what they show of it.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.show.desk.camera_framing import Framing
from live.show.desk.camera_kernels import view_legibility
from live.show.desk.camera_shots import GROUP, TOTAL, ShotKind, Subject

BEARINGS_DEG: Final = (0.0, 11.0, -11.0, 22.0, -22.0, 33.0, -33.0, 44.0, -44.0, 55.0, -55.0, 66.0, -66.0)
ELEVATIONS_DEG: Final = (9.0, 15.0, 21.0, 28.0, 3.0, 36.0, 50.0)
DIRECTIONS: Final = np.array(
    [[math.radians(b), math.radians(e)] for b in BEARINGS_DEG for e in ELEVATIONS_DEG], np.float64
)
"""Bearing and elevation of each direction [rad], shape (D, 2)."""
VISIBLE, LEAST_VISIBLE, ENTROPY, FACES, SOLOIST = 0.5, 0.2, 0.2, 0.12, 0.35
"""Weights of the parts of legibility."""
FOREGROUND: Final = 1.2
"""What a picture costs that is full of others before the chosen."""
HIDDEN: Final = 10.0
"""What a direction costs from which the chosen are hidden: visible by less than `LEAST_SEEN`."""
LEAST_SEEN: Final = 0.65
PUBLIC: Final = 0.16
"""What 60 degrees away from the public's side cost."""
EASY_ELEVATION: Final = math.radians(12.0)
"""From higher above, bodies are foreshortened."""
ABOVE_COST: Final = 0.24
"""What 25 degrees above `EASY_ELEVATION` cost."""
NOT_COMPARED: Final = -1e6
"""Score of a direction that has not been compared, or is out of the question."""
SUBJECTS: Final[tuple[Subject, ...]] = ("all", "soloist", "group", "pair")


@dataclass(eq=False)
class Stand:
    """Where the dancers stand for a comparison, and who the subjects are."""

    place: Float64
    """[m], shape (A, 2)."""
    heading: Float64
    """[rad], shape (A,)."""
    there: Bool
    """Who is seen, shape (A,)."""
    chosen: Bool
    """The dancers of each of `SUBJECTS`, shape (4, A)."""

    def of(self, subject: Subject) -> Bool:
        """Return the dancers of a subject, (A,)."""
        return np.asarray(self.chosen[SUBJECTS.index(subject)])

    def has(self, subject: Subject) -> bool:
        """Whether there is such a subject."""
        return bool(self.of(subject).any())


class ViewComparison:
    """Scores of all directions for one stand, computed in pieces. Thread: the show's."""

    def __init__(self, framing: Framing, stand: Stand) -> None:
        self._framing, self.stand = framing, stand
        self.score: Float64 = np.full((len(SUBJECTS), len(DIRECTIONS)), NOT_COMPARED)
        """Legibility of each subject from each direction, shape (4, D)."""
        self.done = 0
        """Directions that are compared."""

    def is_seen(self, subject: Subject) -> bool:
        """Whether a subject is there and not hidden from all directions that were compared."""
        return bool(self.score[SUBJECTS.index(subject)].max() > -0.5 * HIDDEN)

    @property
    def finished(self) -> bool:
        """Whether all directions are compared."""
        return self.done >= len(DIRECTIONS)

    def work(self, directions: int) -> None:
        """Compare so many more directions."""
        for index in range(self.done, min(self.done + directions, len(DIRECTIONS))):
            for row, subject in enumerate(SUBJECTS):
                if self.stand.has(subject):
                    self.score[row, index] = self._legibility(row, TOTAL if subject == "all" else GROUP, index)
        self.done += directions

    def _legibility(self, row: int, kind: ShotKind, index: int) -> float:
        stand, (bearing, elevation) = self.stand, DIRECTIONS[index].tolist()
        chosen = stand.chosen[row]
        frame = self._framing.fit(kind, stand.place, chosen, bearing, elevation)
        view = self._framing.view(kind, bearing, elevation, frame.field_of_view)
        camera, found = np.array([*frame.target, frame.distance], np.float64), np.empty(5)
        view_legibility(stand.place, stand.there, chosen, stand.heading, view, camera, found)
        seen, least, entropy, faces, before = found.tolist()
        score = VISIBLE * seen + LEAST_VISIBLE * least + ENTROPY * entropy + FACES * faces
        score -= FOREGROUND * before + (HIDDEN if row > 0 and seen < LEAST_SEEN else 0.0)
        if row == 0 and stand.has("soloist"):
            view_legibility(stand.place, stand.there, stand.chosen[1], stand.heading, view, camera, found)
            score += SOLOIST * float(found[1])
        aside, above = bearing / math.radians(60.0), max(elevation - EASY_ELEVATION, 0.0) / math.radians(25.0)
        return float(score - PUBLIC * aside * aside - ABOVE_COST * above)
