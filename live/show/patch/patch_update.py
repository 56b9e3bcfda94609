"""Update of a running show from an edited patch.

An edited patch is compared with the running one, since some keys take effect only at the next start. It is validated,
here or in another thread, and waits until the show can switch to it.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from live.base.arrays import Int32
from live.base.compression import decompress_text
from live.base.errors import PersonError
from live.control.events.events import PatchChanged
from live.graph.build.metric import Metric
from live.graph.library_insert import stranded, without_clips
from live.graph.motion_graph import MotionGraph, build_graph
from live.show.desk.refusals import Refusals
from live.show.patch.patch import Patch
from live.show.patch.section_base import Section
from live.show.patch.table_batches import validate_model
from live.show.patch_checks.patch_check import PATCH_CHECKS
from live.show.score.step_names import UnknownStep

START_ONLY_KEYS: Final = (
    "seed", "steps", "takes", "variations", "reserve", "music.file", "music.bpm", "music.one_at_s", "sound", "clock",
    "link", "midi.input", "midi.output", "midi.clock_out", "midi.time_code_bpm", "midi.time_code_offset_s",
    "osc", "background", "scenery", "picture.passes", "character", "texture", "steering.separation", "steering.combine",
)  # fmt: skip
"""Keys that are read only when a show starts."""
GROUP_START_ONLY_KEYS: Final = (
    "dancers", "soloists", "radius", "partners", "arm_length", "hands", "formation", "centre", "size"
)  # fmt: skip
"""The same within a `[[group]]`."""


def split_deferred(new: Patch, current: Patch) -> tuple[Patch, tuple[str, ...]]:
    """Return the patch `new` as far as a show of the patch `current` can apply it, and the keys that need a new start.

    Those keep their running values. If the number of groups changes, all groups wait: `group`.
    """
    waits: list[str] = []
    changes: dict[str, Any] = {}
    for key in START_ONLY_KEYS:
        name, _, inner = key.partition(".")
        old, edited = getattr(current, name), changes.get(name, getattr(new, name))
        if inner:
            kept, wanted = getattr(old, inner), getattr(edited, inner)
            if kept != wanted:
                waits.append(key)
                changes[name] = edited.model_copy(update={inner: kept})
        elif old != edited:
            waits += _differing_keys(name, old, edited)
            changes[name] = old
    if "music.file" in waits:  # the measures are those of the new file
        waits += [key for key in _differing_keys("music", current.music, new.music) if key not in waits]
        changes["music"] = current.music
    if "picture.passes" in waits:  # the sources belong to the names
        changes["picture"] = changes["picture"].model_copy(update={"own": current.picture.own})
    if _example_settings(new) != _example_settings(current):
        waits.append("partner")
        changes["partner"] = current.partner
    if len(new.group) != len(current.group):
        waits.append("group")
        changes["group"] = current.group
    else:
        groups = []
        for number, (group, old_group) in enumerate(zip(new.group, current.group, strict=True), start=1):
            kept = {key: getattr(old_group, key) for key in GROUP_START_ONLY_KEYS}
            kept = {key: value for key, value in kept.items() if value != getattr(group, key)}
            waits += [f"group.{number}.{key}" for key in kept]
            groups.append(group.model_copy(update=kept) if kept else group)
        changes["group"] = tuple(groups)
    return new.model_copy(update=changes), tuple(waits)


def _example_settings(patch: Patch) -> list[tuple[object, ...]]:
    """The settings of each partner's examples, which are read when a show starts."""
    keys = "name", "examples", "steps", "stretch", "unit_beats", "led_by_path", "hold_limits"
    return [tuple(getattr(one, key) for key in keys) for one in patch.partner]


def _differing_keys(name: str, old: Any, new: Any) -> list[str]:
    """Names in the patch of the keys of a section that differ."""
    if not isinstance(old, Section):
        return [name]
    return [f"{name}.{key}" for key in type(old).model_fields if getattr(old, key) != getattr(new, key)]


def changed_fields(old: Patch, new: Patch) -> tuple[str, ...]:
    """Return the names of the fields of a patch that differ."""
    names = dict.fromkeys((*Patch.model_fields, *old.bridge_tables, *new.bridge_tables))
    return tuple(name for name in names if getattr(old, name, None) != getattr(new, name, None))


def patch_version(text: str) -> str:
    """Return a short hash of a patch written as JSON."""
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()


KEPT_COUNT = 4
"""Number of prepared patches kept until an event names them."""


@dataclass(frozen=True, slots=True, eq=False)
class PreparedPatch:
    """A validated patch: a show of it starts."""

    version: str
    new_show: Any
    """That show, in its initial state."""
    changed_fields: tuple[str, ...]
    """Names of the fields that differ from the running patch."""


def rebuilt_graph(graph: MotionGraph, running: Patch, new: Patch) -> MotionGraph:
    """Return the graph of the same library for a show of `new`, rebuilt if `[locomotion]` changes transitions.

    Nodes keep their indices. ValueError if no steps connect any more.
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


ShowFactory = Callable[[Patch, MotionGraph], Any]
"""Builds a new show from a patch and a graph."""


def fresh_show(patch: Patch, make_show: ShowFactory, running: Patch, graph: MotionGraph) -> Any:
    """Return a show of a valid `patch` for one that runs with the patch `running` in `graph`.

    PersonError, with its place, if it would not start, or cannot replace the running one. Slow: do not call it in a
    live frame.
    """
    try:
        if split_deferred(patch, running)[1]:
            raise PersonError("the patch needs a new start")
        return make_show(patch, rebuilt_graph(graph, running, patch))
    except UnknownStep as error:
        raise PersonError(str(error), key_path=error.place) from None
    except ValueError as error:  # of the graph
        raise PersonError(str(error)) from None


def prepare_patch(text: str, make_show: ShowFactory, running: Patch, graph: MotionGraph) -> PreparedPatch:
    """Validate a patch, written as JSON, and prepare a show of it; PersonError as by `fresh_show`. Slow, too."""
    try:
        patch = validate_model(Patch, _parse_json(text), PATCH_CHECKS)
    except ValueError as error:  # of pydantic, or a damaged text
        raise PersonError(str(error)) from None
    fresh = fresh_show(patch, make_show, running, graph)
    return PreparedPatch(patch_version(text), fresh, changed_fields(running, patch))


def _parse_json(text: str) -> dict[str, Any]:
    """Parse a patch written as JSON; ValueError for anything else."""
    try:
        found = json.loads(text)
    except RecursionError:
        raise ValueError("its brackets are nested too deep") from None
    if not isinstance(found, dict):
        raise ValueError("a patch is a table")
    return found


class PatchUpdates:
    """State of a patch reload, from the event that reports the edit until the show applies it."""

    def __init__(self, refusals: Refusals) -> None:
        self._refusals = refusals
        self._prepared: dict[str, PreparedPatch] = {}
        self.waiting: PreparedPatch | None = None
        """The patch that the show applies as soon as it can."""
        self._tried_measure: int | None = None
        self.version = ""
        """Version of the patch in force; empty for the one that the show began with."""
        self.applied_count = 0
        """Number of patches applied."""
        self.last_changed: tuple[str, ...] = ()
        """Fields that the last one changed."""
        self.replaced: list[Patch] = []
        """Replaced patches, for another thread to free."""

    def offer(self, prepared: PreparedPatch) -> None:
        """Keep a patch for the event that names its version. Thread: any."""
        self._prepared[prepared.version] = prepared
        for version in list(self._prepared)[:-KEPT_COUNT]:
            self._prepared.pop(version, None)

    def request(self, event: PatchChanged, make_show: ShowFactory, running: Patch, graph: MotionGraph) -> None:
        """Handle the request to apply a patch; if it was not prepared, as in a replay, prepare it here."""
        prepared = self._prepared.pop(event.version, None)
        if prepared is None:
            try:
                prepared = prepare_patch(decompress_text(event.patch), make_show, running, graph)
            except (PersonError, ValueError) as error:
                self._refusals.add(f"{event.source}: {error}")
                return
        self.waiting, self._tried_measure = prepared, None

    def discard(self) -> None:
        """Discard the waiting edit; its file has to be saved again."""
        self.waiting = None

    def is_due(self, measure: int) -> bool:
        """Return whether a patch waits that was not yet tried in this `measure`; True at most once in each."""
        tried, self._tried_measure = self._tried_measure == measure, measure
        return self.waiting is not None and not tried

    def pop_ready(self, running: Patch, nodes: Int32) -> Any:
        """Return the new show whose patch is to be applied now, or None if there is none.

        It waits, too, while dancers in `nodes` (A,) would have no next step in its graph.
        """
        prepared = self.waiting
        if prepared is None:
            return None
        if stranded(prepared.new_show.graph, nodes).any():
            self._refusals.add("patch: [locomotion] would leave dancers without a next step; it waits")
            return None
        self.waiting = None
        self.version, self.applied_count = prepared.version, self.applied_count + 1
        self.last_changed = prepared.changed_fields
        self.replaced.append(running)
        del self.replaced[:-KEPT_COUNT]
        return prepared.new_show
