"""Edit: what an edited patch changes of a running show, and what of it has to wait for the next start.

Reloading: an edited patch, prepared by another thread or here, waits until a running show can take it.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from live.base.compression import unpacked
from live.base.errors import PersonError
from live.control.events.events import PatchChanged
from live.graph.build.metric import Metric
from live.graph.library_insert import Int32, stranded, without_clips
from live.graph.motion_graph import MotionGraph, build_graph
from live.show.background_work import validated
from live.show.desk.refusals import Refusals
from live.show.patch.patch import Patch
from live.show.patch.section_base import Section
from live.show.score.step_names import UnknownStep

AT_THE_START: Final = (
    "seed", "steps", "reserve", "music", "sound", "clock", "link", "midi.input", "midi.output", "midi.clock_out",
    "midi.time_code_bpm", "midi.time_code_offset_s", "osc", "stage", "background", "item",
    "picture.passes", "character", "texture", "steering.separation", "steering.combine",
)  # fmt: skip
"""Keys that count when a show starts, and not again."""
GROUP_AT_THE_START: Final = (
    "dancers", "soloists", "radius", "partners", "arm_length", "hands", "formation", "centre", "size"
)  # fmt: skip
"""The same within a `[[group]]`."""


def fitted(new: Patch, running: Patch) -> tuple[Patch, tuple[str, ...]]:
    """The patch `new` as far as it can act in a show of the patch `running`, and the keys that wait for a new start.

    Those keep the values they run with. Groups that come or go wait all together: `group`.
    """
    waits: list[str] = []
    changes: dict[str, Any] = {}
    for key in AT_THE_START:
        name, _, inner = key.partition(".")
        old, edited = getattr(running, name), changes.get(name, getattr(new, name))
        if inner:
            kept, wanted = getattr(old, inner), getattr(edited, inner)
            if kept != wanted:
                waits.append(key)
                changes[name] = edited.model_copy(update={inner: kept})
        elif old != edited:
            waits += _keys(name, old, edited)
            changes[name] = old
    if "picture.passes" in waits:  # the texts belong to the names
        changes["picture"] = changes["picture"].model_copy(update={"own": running.picture.own})
    if len(new.gate) != len(running.gate):
        waits.append("gate")
        changes["gate"] = running.gate
    if _examples(new) != _examples(running):
        waits.append("partner")
        changes["partner"] = running.partner
    if len(new.group) != len(running.group):
        waits.append("group")
        changes["group"] = running.group
    else:
        groups = []
        for number, (group, old_group) in enumerate(zip(new.group, running.group, strict=True), start=1):
            kept = {key: getattr(old_group, key) for key in GROUP_AT_THE_START}
            kept = {key: value for key, value in kept.items() if value != getattr(group, key)}
            waits += [f"group.{number}.{key}" for key in kept]
            groups.append(group.model_copy(update=kept) if kept else group)
        changes["group"] = tuple(groups)
    return new.model_copy(update=changes), tuple(waits)


def _examples(patch: Patch) -> list[tuple[object, ...]]:
    """What each partner answers from: read when a show starts."""
    keys = "name", "examples", "steps", "stretch", "unit_beats", "by_path", "near"
    return [tuple(getattr(one, key) for key in keys) for one in patch.partner]


def _keys(name: str, old: Any, new: Any) -> list[str]:
    """The keys of a section that differ, by their names in the patch."""
    if not isinstance(old, Section):
        return [name]
    return [f"{name}.{key}" for key in type(old).model_fields if getattr(old, key) != getattr(new, key)]


def changed(old: Patch, new: Patch) -> tuple[str, ...]:
    """Names of the fields of a patch that differ."""
    return tuple(name for name in Patch.model_fields if getattr(old, name) != getattr(new, name))


def version_of(text: str) -> str:
    """A short name for a patch written as JSON."""
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()


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
