"""Reloading: an edited patch, prepared by another thread or here, waits until a running show can take it."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from live.base.compression import unpacked
from live.base.errors import PersonError
from live.control.events.events import PatchChanged
from live.graph.build.weights import Metric
from live.graph.library_insert import Int32, stranded, without_clips
from live.graph.motion_graph import MotionGraph, build_graph
from live.show.desk.refusals import Refusals
from live.show.long_patches import validated
from live.show.patch.edit import changed, fitted, version_of
from live.show.patch.patch import Patch
from live.show.score.step_names import UnknownStep

KEPT = 4
"""Prepared patches that are kept for an event to name them."""


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """A patch that was proved: a show of it starts."""

    version: str
    fresh: Any
    """That show, at its first moment."""
    different: tuple[str, ...]
    """What is different in the patch."""


def graph_for(graph: MotionGraph, running: Patch, new: Patch) -> MotionGraph:
    """The graph of the same library for a show of `new`: another one if `[locomotion]` joins steps otherwise.

    Nodes keep their indices. ValueError if nothing connects any more.
    """
    keys = ("transition_beats", "threshold_m", "weights", "emphasis")
    if all(getattr(running.locomotion, key) == getattr(new.locomotion, key) for key in keys):
        return graph
    limits = new.locomotion
    window = min(1.0, limits.transition_beats / new.clock.beats_per_measure)
    metric = Metric.of(limits.weights, limits.emphasis)
    made = build_graph(graph.library, window=window, threshold=limits.threshold_m, metric=metric)
    leaving = np.unique(graph.library.node_clip[graph.leaving]).tolist()
    return without_clips(made, leaving) if leaving else made


Start = Callable[[Patch, MotionGraph], Any]
"""Makes a fresh show of a patch in a graph."""


def prepare(text: str, start: Start, running: Patch, graph: MotionGraph) -> Prepared:
    """Prove a patch, written as JSON, for a show that runs with the patch `running` in `graph`.

    PersonError if it would not start, or cannot take the place of the other one. Takes a while: not in a live frame.
    """
    try:
        patch = validated(Patch, _values(text))
        if fitted(patch, running)[1]:
            raise PersonError("the patch needs a new start")
        fresh = start(patch, graph_for(graph, running, patch))
        return Prepared(version_of(text), fresh, changed(running, patch))
    except UnknownStep as error:
        raise PersonError(str(error), place=error.place) from None
    except ValueError as error:  # of pydantic or the graph, or a damaged text
        raise PersonError(str(error)) from None


def _values(text: str) -> dict[str, Any]:
    """A patch written as JSON; ValueError for anything else."""
    try:
        found = json.loads(text)
    except RecursionError:
        raise ValueError("its brackets are nested too deep") from None
    if not isinstance(found, dict):
        raise ValueError("a patch is a table")
    return found


class Reloading:
    """Between the event that says a patch was edited and the moment when the show takes it."""

    def __init__(self, refusals: Refusals) -> None:
        self._refusals = refusals
        self._offered: dict[str, Prepared] = {}
        self.waiting: Prepared | None = None
        """What the show takes as soon as it can."""
        self._tried: int | None = None
        self.version = ""
        """The patch in force; empty: the one that the show began with."""
        self.taken = 0
        """How often a patch was taken."""
        self.last: tuple[str, ...] = ()
        """What was different in the last one."""
        self.spent: list[Patch] = []
        """Patches that were taken out of force, for another thread to free."""

    def offer(self, prepared: Prepared) -> None:
        """Hold a patch ready for the event that names its version. Thread: any."""
        self._offered[prepared.version] = prepared
        for version in list(self._offered)[:-KEPT]:
            self._offered.pop(version, None)

    def ask(self, event: PatchChanged, start: Start, running: Patch, graph: MotionGraph) -> None:
        """A patch shall be taken: the one that was prepared, or else it is prepared here, as in a replay."""
        prepared = self._offered.pop(event.version, None)
        if prepared is None:
            try:
                prepared = prepare(unpacked(event.patch), start, running, graph)
            except (PersonError, ValueError) as error:
                self._refusals.add(f"{event.source}: {error}")
                return
        self.waiting, self._tried = prepared, None

    def drop(self) -> None:
        """The edit that waits is given up: its file has to be saved again."""
        self.waiting = None

    def due(self, measure: int) -> bool:
        """Whether a patch waits that was not tried yet in this `measure`; once in each."""
        tried, self._tried = self._tried == measure, measure
        return self.waiting is not None and not tried

    def take(self, running: Patch, nodes: Int32) -> Any:
        """The fresh show whose patch is to be taken now; None if there is none, or if dancers in `nodes` (A,) would
        have no way on in its graph: then it waits."""
        prepared = self.waiting
        if prepared is None:
            return None
        if stranded(prepared.fresh.graph, nodes).any():
            self._refusals.add("patch: [locomotion] would leave dancers without a next step; it waits")
            return None
        self.waiting = None
        self.version, self.taken = prepared.version, self.taken + 1
        self.last = prepared.different
        self.spent.append(running)
        del self.spent[:-KEPT]
        return prepared.fresh
