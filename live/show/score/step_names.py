"""Step lookup by name, with error messages that list the known steps."""

import difflib
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.graph.search.sequence_spec import SequenceEntry
from live.graph.select.selector import recorded_seconds, tempo_excess

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph

IN_PLACE: Final = 0.15
"""A measure that travels less than this [m] counts as in place."""


class UnknownStep(ValueError):
    """A step name that the library does not have; the message lists the known steps."""

    place: tuple[str | int, ...] = ()
    """Patch key that contains the name."""


def find_step(graph: "MotionGraph", name: str) -> int:
    """Return the index of a danceable step; otherwise raise UnknownStep with the known names."""
    library = graph.library
    index = library.step_index(name)
    if index is None:
        if why := library.refusal(name):
            raise UnknownStep(why)
        near = difflib.get_close_matches(name.casefold(), [s.casefold() for s in library.steps], n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise UnknownStep(f"no step is called {name!r}: {hint}the steps are {', '.join(library.steps)}")
    if all(clip.mood for clip in library.clips if clip.step == library.steps[index]):
        raise UnknownStep(f"step {name!r} has only examples of moods: it needs a clip without a mood")
    if not len(graph.entries(index)):
        raise UnknownStep(
            f"step {name!r} connects to no other step: raise locomotion.threshold_m or change its beginning and end"
        )
    return index


def step_measures(graph: "MotionGraph", step: int) -> int:
    """Return the measures of a step: the longest of its variations."""
    library = graph.library
    return int(library.node_measures[library.node_step == step].max())


def check_connected(graph: "MotionGraph", entries: Iterable[SequenceEntry]) -> None:
    """Raise PersonError for a step among `entries` that connects to no other."""
    for step in {entry.step for entry in entries if entry.step is not None}:
        if not len(graph.entries(step)):
            raise PersonError(
                f"step {graph.library.steps[step]!r} connects to no other step",
                "raise locomotion.threshold_m or change its beginning and end",
            )


def is_in_place(graph: "MotionGraph", step: int) -> bool:
    """Whether a variation of the step has a measure in place, so that a standing group does not drift away."""
    library = graph.library
    return bool(np.hypot(*library.node_travel[(library.node_step == step) & graph.alive].T).min() < IN_PLACE)


def near_tempo(graph: "MotionGraph", steps: Sequence[int], seconds: float) -> npt.NDArray[np.bool_]:
    """Whether a variation of each of `steps` (n,) can be danced in measures of `seconds` within the limits of its
    tempo; of 0 seconds: any."""
    library = graph.library
    if seconds <= 0.0 or not any(clip.recorded for clip in library.clips):
        return np.ones(len(steps), np.bool_)
    fits = graph.alive & (np.abs(tempo_excess(recorded_seconds(library), seconds)) < 1e-9)
    return np.isin(steps, library.node_step[fits])
