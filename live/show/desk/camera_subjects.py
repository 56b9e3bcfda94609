"""Whom the camera shows: who can be seen, the soloists, one of the groups, one of the pairs."""

from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64
from live.show.desk.camera_kernels import HEIGHT
from live.show.desk.camera_shots import Subject

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.desk.camera_rig import Spots
    from live.show.group.group_motion import GroupMotion

MOST_SOLOISTS: Final = 3
"""More dancers than that are no soloists."""
SAME_STEP: Final = 0.7
"""A dancer is alone with a step if at least this share of the others dance one other step."""
ABOVE_HEAD: Final = 0.20
"""From the joint of the head to the hair [m]."""
TOPS: Final = (1.2, 1.85)
"""Nobody is framed as if they were smaller or taller [m]."""
FEWEST: Final = 3
"""Among fewer dancers nobody stands out by a step."""


class Subjects:
    """The dancers of one show as a camera or a lamp sees them. It has no state. Thread: the show's."""

    def __init__(self, motion: "GroupMotion", dancers: "Dancers", spots: "Spots") -> None:
        self._motion, self._dancers, self._spots = motion, dancers, spots

    def present(self) -> Bool:
        """Return who is seen and stands somewhere, (A,): a copy."""
        return np.asarray(self._motion.present & np.isfinite(self._dancers.drawn_hips).all(axis=1))

    def soloists(self, present: Bool, *, spots: bool = True) -> Bool:
        """Return the soloists among the dancers `present` (A,), at most `MOST_SOLOISTS`: (A,), nobody if there is none.

        In this order: whoever is alone on the stage; with `spots` whom follow spots follow; the patch's soloists; who
        alone dances another step than all others.
        """
        count = int(np.count_nonzero(present))
        if count == 1:
            return present
        followed = self._spots.followed() if spots else np.zeros(len(present), np.bool_)
        for found in (followed, self._motion.casting.soloists, self._alone_with_a_step(present)):
            found = found & present
            number = int(np.count_nonzero(found))
            if 0 < number <= MOST_SOLOISTS and number < count:
                return found
        return np.zeros(len(present), np.bool_)

    def _alone_with_a_step(self, present: Bool) -> Bool:
        """Return who dances a step that nobody else dances while most others are together in one, (A,)."""
        found = np.zeros(len(present), np.bool_)
        rows = np.flatnonzero(present)
        node = self._dancers.present.node[rows]
        if len(rows) < FEWEST or (node < 0).any():
            return found
        steps, which, sizes = np.unique(
            self._dancers.graph.library.node_step[node], return_inverse=True, return_counts=True
        )
        if len(steps) >= 2 and sizes.max() >= SAME_STEP * (len(rows) - 1):
            found[rows[sizes[which] == 1]] = True
        return found

    def dances_alone(self, dancer: int, present: Bool) -> bool:
        """Whether a dancer is alone on the stage, or dances another step than most of their group among those
        `present`."""
        node, step = self._dancers.present.node, self._dancers.graph.library.node_step
        group = self._motion.casting.group
        others = present & (group == group[dancer]) & (node >= 0)
        others[dancer] = False
        return not others.any() or bool((step[node[others]] != step[node[dancer]]).mean() > 0.5)

    def activity(self, present: Bool) -> Float64:
        """Return how much each of the dancers `present` (A,) moves in this measure, limbs and travel, (A,); 0 for the
        others."""
        found = np.zeros(len(present))
        rows = np.flatnonzero(present & (self._dancers.present.node >= 0))
        if not len(rows):
            return found
        nodes, which = np.unique(self._dancers.present.node[rows], return_inverse=True)
        moments = self._dancers.graph.moments
        limbs = np.linalg.norm(np.diff(moments.feature[nodes].astype(np.float64), axis=1), axis=2).mean(axis=1)
        travel = np.linalg.norm(np.diff(moments.hips[nodes], axis=1), axis=2).mean(axis=1)
        found[rows] = (limbs + travel)[which]
        return found

    def groups(self, present: Bool) -> list[Bool]:
        """Return the groups of at least two dancers among those `present`, if there are several groups: those nearer to
        the public first."""
        group, depth = self._motion.casting.group, self.places()[:, 1]
        found = [present & (group == index) for index in np.unique(group[present]).tolist()]
        several = [one for one in found if np.count_nonzero(one) >= 2] if len(found) > 1 else []
        return sorted(several, key=lambda one: -float(depth[one].mean()))

    def pairs(self, present: Bool) -> list[tuple[int, int]]:
        """Return the pairs on the stage, leader and follower: those nearer to the public first."""
        partners, depth = self._motion.partners, self.places()[:, 1]
        both = zip(partners.leader.tolist(), partners.follower.tolist(), strict=True)
        found = [(leader, follower) for leader, follower in both if present[leader] and present[follower]]
        return sorted(found, key=lambda pair: -float(depth[list(pair)].mean()))

    def begins_step(self, present: Bool) -> float:
        """Return which share of the dancers `present` begins a step with this measure."""
        node = self._dancers.present.node[present]
        node = node[node >= 0]
        return float((self._dancers.graph.library.node_measure[node] == 0).mean()) if len(node) else 1.0

    def places(self) -> Float64:
        """Return where the dancers' hips are, (A, 2) [m]; the middle of the stage for what is not finite."""
        found = self._dancers.drawn_hips.astype(np.float64)
        if self._dancers.captured:  # their own steps go on unseen
            captured = self._dancers.captured_dancers()
            found[captured] = self._motion.state.position[captured]
        found[~np.isfinite(found)] = 0.0
        return found

    def top(self, chosen: Bool) -> float:
        """Return how far up those who are `chosen` (A,) reach in this measure without their arms, between the two
        `TOPS` [m]: who dances low is less tall in the picture, who springs is taller."""
        node = self._dancers.present.node[chosen]
        if not len(node) or (node < 0).any():
            return HEIGHT
        highest = float(self._dancers.graph.moments.head_height(np.unique(node)).max())
        return min(max(highest + ABOVE_HEAD, TOPS[0]), TOPS[1])

    def headings(self) -> Float64:
        """Return the headings of the dancers at the end of this measure [rad], (A,)."""
        return np.nan_to_num(np.asarray(self._dancers.present.ends()[1], np.float64))

    def coming_places(self, beat: float, seconds: float, *, planned: bool) -> Float64:
        """Return where the dancers will be in so many seconds, at the danced `beat`, (A, 2) [m].

        Whom a segment leads is at its place then; the others go on at their present speeds, or stay if only what is
        `planned` counts.
        """
        found = self.places()
        if not planned:
            found += np.nan_to_num(self._motion.state.velocity.astype(np.float64)) * seconds
        if self._motion.evolutions.running:
            led, place, _ = self._motion.evolutions.target(beat)
            found[led] = np.nan_to_num(place[led].astype(np.float64))
        return found


def choose(subject: Subject, subjects: Subjects, present: Bool, draw: npt.NDArray[np.float64]) -> Bool:
    """Return the dancers of a subject among those `present`, (A,), with two numbers drawn from 0 to 1; nobody if there
    is no such subject. Those in front are drawn more often."""
    match subject:
        case "all":
            return present
        case "soloist":
            return subjects.soloists(present)
        case "group":
            found = subjects.groups(present)
            return found[int(draw[0] ** 2 * len(found))] if found else np.zeros(len(present), np.bool_)
        case "pair":
            who = np.zeros(len(present), np.bool_)
            pairs = subjects.pairs(present)
            if pairs:
                who[list(pairs[int(draw[1] ** 2 * len(pairs))])] = True
            return who
