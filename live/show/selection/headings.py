"""Headings: where each dancer should face at the end of her next measure, by what her group looks at (T126, T127)."""

import numpy as np
import numpy.typing as npt

from live.graph.select.placing import wrapped
from live.show.group.group_motion import GroupMotion
from live.show.patch.facing import ATTRACTOR, CENTRE, DANCER, DEGREES, GROUP, PATH, PUBLIC, Facing, parse_facing
from live.show.patch.patch import Patch

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

MOVES = 0.25
"""A way shorter than this [m] in a measure has no direction: whoever stands faces where she came to (T126)."""
CLOSE = 0.3
"""Nobody turns after what is nearer than this [m]."""


class Headings:
    """The headings of A dancers, measure after measure.

    A heading that is wanted becomes one that is danced by T127: a quarter of the turn in one measure, half of it in
    the next, a quarter in the third. A show does not know what will be wanted a measure later, so the turn begins with
    the measure in which it is wanted, not before.
    """

    def __init__(self, patch: Patch, motion: GroupMotion) -> None:
        """PersonError for words that mean nothing."""
        self._patch = patch
        self._motion = motion
        count = len(motion.casting.group)
        self._facing = [self.parse(section.facing) for section in patch.group]
        self._raw = np.zeros((2, count))
        """What was wanted in the last two measures, unwrapped, the newest first."""
        self._before = self._raw.copy()

    def parse(self, words: str) -> Facing:
        """What `words` mean in this show; PersonError if nothing."""
        casting = self._motion.casting
        return parse_facing(words, dancers=len(casting.group), groups=casting.names)

    def take_patch(self, fresh: "Headings") -> None:
        """Take over where groups look whose patch says something else now; others keep what they were told."""
        for index, (old, new) in enumerate(zip(self._patch.group, fresh._patch.group, strict=True)):
            if old.facing != new.facing:
                self._facing[index] = fresh._facing[index]

    @property
    def facings(self) -> tuple[Facing, ...]:
        """Where each group looks."""
        return tuple(self._facing)

    def set(self, group: int, facing: Facing) -> None:
        """The dancers of that group look there from their next decided measure on."""
        self._facing[group] = facing

    def begin(self, heading: Float64) -> None:
        """Everybody faces `heading` (A,) [rad] and wants to."""
        self._raw[:] = heading

    def take_back(self) -> None:
        """The last `next` shall not have been."""
        self._raw[:] = self._before

    def next(self, start: Float64, wish: Float64, planned: Float64, known: Bool) -> Float64:
        """Headings (A,) [rad] at the end of the next measure of dancers who go from `start` to `wish` (A, 2) [m].

        `planned` (A,) are the headings of those who are in an evolution (`known`): they are smoothed already. To be
        called once for each measure.
        """
        self._before[:] = self._raw
        wanted = self._raw[0].copy()
        for index, facing in enumerate(self._facing):
            members = np.flatnonzero(self._motion.casting.group == index)
            if len(members):
                wanted[members] = self._wanted(facing, members, start, wish, wanted)
        passing = self._motion.entrances.passing  # whoever comes or goes looks where she goes
        wanted[passing] = _towards(wish - start, MOVES, wanted)[passing]
        wanted[known] = planned[known]
        newest = self._raw[0] + wrapped(wanted - self._raw[0])
        smooth = 0.25 * newest + 0.5 * self._raw[0] + 0.25 * self._raw[1]
        smooth[known | passing] = newest[known | passing]
        self._raw[1], self._raw[0] = self._raw[0], newest
        self._raw[1, passing] = newest[passing]
        return np.asarray(smooth)

    def _wanted(
        self, facing: Facing, members: npt.NDArray[np.intp], start: Float64, wish: Float64, last: Float64
    ) -> Float64:
        """Headings of `members` (n,), (n,)."""
        match facing.kind:
            case k if k == PUBLIC:
                return np.zeros(len(members))
            case k if k == DEGREES:
                return np.full(len(members), facing.heading)
            case k if k == PATH:
                return _towards((wish - start)[members], MOVES, last[members])
        place = self._place(facing, members)
        if place is None:
            return last[members]
        return _towards(place - wish[members], CLOSE, last[members])

    def _place(self, facing: Facing, members: npt.NDArray[np.intp]) -> Float64 | None:
        """What the members look at [m], (2,) or (n, 2); None if it is not there."""
        group, position = self._motion.casting.group, self._motion.state.position.astype(np.float64)
        index = int(group[members[0]])
        match facing.kind:
            case k if k == CENTRE:
                return np.array(self._patch.group[index].centre)
            case k if k == DANCER:
                return position[facing.dancer] if self._motion.present[facing.dancer] else None
            case k if k == GROUP:
                whom = (group == self._motion.casting.names.index(facing.name)) & self._motion.present
                return position[whom].mean(axis=0) if whom.any() else None
            case k if k == ATTRACTOR:
                return self._motion.elements.attractor_of(int(members[0]))
        return None


def _towards(way: Float64, least: float, last: Float64) -> Float64:
    """Headings (n,) along `way` (n, 2); `last` (n,) where it is shorter than `least` [m]."""
    return np.where(np.hypot(*way.T) > least, np.arctan2(way[:, 0], way[:, 1]), last)
