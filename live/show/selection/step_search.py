"""Search of the motion graph for each dancer's next measure, some dancers at a time (T068-T070)."""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import Choosing, with_direction
from live.show.dancers.dancers import Dancers
from live.show.dancers.partners import choose_following, place_followers
from live.show.dancers.root_correction_control import FAITHFUL
from live.show.group.group_motion import GroupMotion
from live.show.patch.patch import Patch
from live.show.selection.choices import Choices
from live.show.selection.step_targets import Aims

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

AT_A_TIME: Final = 48
"""Most dancers whose measures are chosen in one piece."""


class Searching:
    """Search for A dancers; the results are written to `choices`.

    Call `limit`, then `choose` for all dancers, `lead`, and `follow` for all pairs; `catch_up` at any time after that.
    """

    def __init__(self, patch: Patch, dancers: Dancers, motion: GroupMotion, aims: Aims, choices: Choices) -> None:
        """`take_graph` must be called before anything else."""
        self._patch, self._dancers, self._motion = patch, dancers, motion
        self._aims, self._choices = aims, choices
        self._asked_from = np.full(len(aims.step), -1, np.int32)
        self._arguments: tuple[Any, ...] = ()
        self._following: tuple[Int32, Int32] = np.zeros(0, np.int32), np.zeros(0, np.int32)
        self.seconds = 2.0
        """Duration of a measure [s]."""

    def take_graph(self, graph: MotionGraph, choosing: Choosing) -> None:
        """Switch to this graph. Called while no next measure is decided."""
        self._choosing = choosing
        self._give = np.minimum(graph.node_give, self._patch.locomotion.correction_m)
        self._usual_give = float(np.median(self._give))

    def take_patch(self, fresh: "Searching") -> None:
        """Apply the correction limits of another patch."""
        self._give, self._usual_give = fresh._give, fresh._usual_give

    @property
    def asked(self) -> bool:
        """Whether the arguments of the search are set."""
        return bool(self._arguments)

    def forget(self) -> None:
        """Clear the arguments of the search."""
        self._arguments = ()

    @property
    def axes(self) -> Float64:
        """End axes of the present measures, as used by the search: x, z, angle, its cosine and sine, (A, 5)."""
        return np.asarray(self._arguments[1])

    @property
    def on_support(self) -> Float64:
        """`Variation.on_support` as used by the search, (A,)."""
        return np.asarray(self._arguments[6][:, 0])

    def limit(self) -> None:
        """Limit the targets to the dancers' reach, and set the arguments of the search."""
        variation, limits = self._dancers.variation, self._patch.locomotion
        share = FAITHFUL + (1.0 - FAITHFUL) * variation.obedience
        self._choosing.allow(seconds=self.seconds, turn=math.radians(limits.turn_deg), give=self._give)
        self._aims.limit(self._choices, share * self._usual_give)
        self._asked_from[:] = self._dancers.node
        self._arguments = (
            self._asked_from,
            with_direction(self._dancers.present.end_placement()),
            with_direction(np.column_stack([self._choices.target, self._aims.heading])),
            self._aims.row,
            self._aims.ahead,
            self._motion.partners.own_sides(variation.sides, self._dancers.graph.library.node_side[self._asked_from]),
            np.column_stack([variation.on_support, variation.face_average, share]),
            self._choices.out,
        )

    def choose(self, rows: slice) -> None:
        """Choose the next measures of these dancers."""
        self._choosing.choose(rows, *self._arguments)

    def lead(self) -> None:
        """Set the followers' targets from the ends of their leaders' measures, which are chosen already."""
        partners = self._motion.partners
        self._following = partners.follower, partners.follower
        if len(partners.leader):
            self._following = place_followers(
                partners, self._choosing, self._choices, self._aims.heading, self._arguments
            )

    def follow(self, pairs: slice) -> None:
        """Choose the next measures of the followers of these pairs."""
        rows, sides = (array[pairs] for array in self._following)
        if len(rows):
            choose_following(rows, sides, self._choosing, self._choices, self._arguments)

    def catch_up(self) -> bool:
        """Choose again for dancers whose present measure was replaced since the search. Returns whether there are
        any."""
        node = self._dancers.node
        changed = np.flatnonzero(self._asked_from != node)
        if not len(changed):
            return False
        self._asked_from[changed] = node[changed]
        self._arguments[1][changed] = with_direction(self._dancers.present.end_placement())[changed]
        for row in changed.tolist():
            self.choose(slice(row, row + 1))
        return True
