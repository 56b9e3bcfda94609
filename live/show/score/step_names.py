"""Steps by name for programmes: what is not there, or connects to nothing, is told with what there is."""

import difflib
from collections.abc import Iterable
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence_spec import Wanted

IN_PLACE: Final = 0.15
"""A measure that goes no farther than this [m] is danced in place."""


class UnknownStep(ValueError):
    """A step name that the library does not have; the message lists what there is."""

    place: tuple[str | int, ...] = ()
    """The key of the patch that names it."""


def find_step(graph: MotionGraph, name: str) -> int:
    """Index of a step that can be danced; UnknownStep with the known names otherwise."""
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


def length_of(graph: MotionGraph, step: int) -> int:
    """Measures of a step; the longest of its variations."""
    library = graph.library
    return int(library.node_measures[library.node_step == step].max())


def refuse_alone(graph: MotionGraph, entries: Iterable[Wanted]) -> None:
    """PersonError for a step among `entries` that connects to no other."""
    for step in {entry.step for entry in entries if entry.step is not None}:
        if not len(graph.entries(step)):
            raise PersonError(
                f"step {graph.library.steps[step]!r} connects to no other step",
                "raise locomotion.threshold_m or change its beginning and end",
            )


def in_place(graph: MotionGraph, step: int) -> bool:
    """Whether some measure of the step goes nowhere: whoever stands does not drift away and come back."""
    library = graph.library
    return bool(np.hypot(*library.node_travel[(library.node_step == step) & graph.alive].T).min() < IN_PLACE)
