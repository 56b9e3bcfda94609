"""Programme: which step each group should dance in which measure: by sequence, by seeded chance, or as called."""

from dataclasses import dataclass

import numpy as np

from live.graph.motion_graph import NEVER, MotionGraph
from live.show.patch import GroupSection, parse_entry

HOLD_MEASURES = 2
"""Measures for which a step drawn by chance is danced at least."""


class UnknownStep(ValueError):
    """A step name that the library does not have; the message lists what there is."""


def find_step(graph: MotionGraph, name: str) -> int:
    """Index of a step that can be danced; UnknownStep with the known names otherwise."""
    import difflib

    library = graph.library
    index = library.step_index(name)
    if index is None:
        near = difflib.get_close_matches(name.casefold(), [s.casefold() for s in library.steps], n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise UnknownStep(f"no step is called {name!r}: {hint}the steps are {', '.join(library.steps)}")
    if not len(graph.entries(index)):
        raise UnknownStep(
            f"step {name!r} connects to no other step: raise locomotion.threshold_m or change its beginning and end"
        )
    return index


@dataclass(slots=True)
class _Call:
    """A step called from outside, and the first measure in which it is over."""

    step: int
    until: int


class GroupProgramme:
    """The wishes of one group, measure after measure. Seeded: the same seed and calls give the same dance."""

    def __init__(self, graph: MotionGraph, group: GroupSection, *, seed: int, index: int) -> None:
        """Raises UnknownStep if the group names a step that is not there."""
        self._graph = graph
        self._seed = (seed, index)
        self._random = group.choose == "random"
        entries = [parse_entry(entry) for entry in group.steps]
        self._steps = [find_step(graph, name) for name, _ in entries]
        library = graph.library
        self._measures: list[int] = []
        for step, (_, times) in zip(self._steps, entries, strict=True):
            length = int(library.node_measures[library.node_step == step].max())
            self._measures += [step] * (length * times)
        self.travel_step = None if group.travel_step is None else find_step(graph, group.travel_step)
        """The step for ways too far for the step in turn, or None."""
        self._drawn = self._steps[0]
        self._drawn_until = 0
        self._call: _Call | None = None

    def call(self, step: int, *, measure: int, measures: float) -> None:
        """Dance `step` from `measure` on for a number of measures (rounded up to whole ones)."""
        self._call = _Call(step, measure + max(1, int(np.ceil(measures))))

    def release(self) -> None:
        """Forget a called step."""
        self._call = None

    def wanted(self, measure: int, nodes: np.ndarray[tuple[int], np.dtype[np.int32]]) -> int:
        """The step to dance in `measure` by dancers who are in `nodes` now; to be asked once per measure."""
        if self._call is not None:
            if measure < self._call.until:
                return self._call.step
            self._call = None
        if not self._random:
            return self._measures[measure % len(self._measures)]
        if measure >= self._drawn_until:
            self._drawn = self._draw(measure, nodes)
            library = self._graph.library
            length = int(library.node_measures[library.node_step == self._drawn].max())
            self._drawn_until = measure + length * -(-HOLD_MEASURES // length)
        return self._drawn

    def _draw(self, measure: int, nodes: np.ndarray[tuple[int], np.dtype[np.int32]]) -> int:
        """Draw among the group's steps, evenly; not the last one again, and reachable at once if any is."""
        chance = np.random.default_rng([*self._seed, measure])
        hops = self._graph.hops[self._steps][:, nodes]
        near = [s for s, h in zip(self._steps, hops, strict=True) if (h <= 1).all()]
        far = [s for s, h in zip(self._steps, hops, strict=True) if (h < NEVER).all()]
        for choice in (near, far, self._steps):
            fresh = [step for step in choice if step != self._drawn]
            if fresh:
                return int(fresh[int(chance.integers(len(fresh)))])
        return self._drawn
