"""Specification of a sequence: the wanted step of every measure (T063), and the nodes that fit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Bool, Int32
from live.base.errors import PersonError
from live.motion.step_clip import StepClip

if TYPE_CHECKING:
    from live.graph.step_library import StepLibrary


MAX_MEASURES: Final = 100_000
"""Longest dance that is searched: fourteen hours at 120 bpm."""
LEADING_FOOT: Final = {"left": "right", "right": "left"}
"""The leading foot for sideways directions (T134)."""


@dataclass(frozen=True, slots=True)
class SequenceEntry:
    """One entry of a sequence: a step danced once, or one measure of anything."""

    step: int | None
    """Index of the step in the library; None: any step."""
    measures: int = 1
    """Length in measures."""
    direction: str = ""
    """Direction of travel, in words of DIRECTIONS, as "left" or "long left"; "": any."""


@dataclass(frozen=True, slots=True, eq=False)
class SequenceSpec:
    """d(n) of T063 for M measures as sets of nodes (K different sets over N nodes)."""

    entries: tuple[SequenceEntry, ...]
    fits: Bool
    """The nodes in each set, shape (K, N)."""
    set_index: Int32
    """The set of each measure, shape (M,)."""
    entry_index: Int32
    """The entry of `entries` of each measure, shape (M,)."""
    enters: Bool
    """Nodes that begin a step, shape (N,)."""
    leaves: Bool
    """Nodes that end a step, shape (N,)."""
    foot_rule: bool
    """Whether clips that lead with the wrong foot were left out (T134)."""

    @property
    def measures(self) -> int:
        """Length of the dance M."""
        return len(self.set_index)

    def at(self, measure: int) -> Bool:
        """Return the nodes that fit a measure (from 0), (N,)."""
        return np.asarray(self.fits[self.set_index[measure]], np.bool_)


def specify(
    library: "StepLibrary", wanted: Sequence[SequenceEntry], *, foot_rule: bool = False, repeats: bool = False
) -> SequenceSpec:
    """Return the sets of nodes of a sequence, measure by measure.

    A step is danced from its first measure to its last: measures are requested by step and number, so no step is
    entered in its middle. With `foot_rule` a step that travels sideways must lead with the other foot (T134); clips in
    which either is unknown pass. With `repeats` the place of a long step may be filled by repeats of shorter variations
    that were recorded: those that are danced at another tempo. PersonError for an empty or endless sequence.
    """
    total = sum(entry.measures for entry in wanted)
    if not 1 <= total <= MAX_MEASURES:
        raise PersonError(f"a sequence of {total} measures: 1 to {MAX_MEASURES} expected")
    sound = np.ones(library.node_count, np.bool_)
    if foot_rule:
        sound = np.array([leading_foot_fits(clip) for clip in library.clips])[library.node_clip]
    leaves = library.node_measure == library.node_measures - 1
    found: dict[tuple[SequenceEntry, int], int] = {}
    sets: list[Bool] = []
    kind, entries = np.empty(total, np.int32), np.empty(total, np.int32)
    n = 0
    for number, entry in enumerate(wanted):
        for measure in range(entry.measures):
            if (entry, measure) not in found:
                found[entry, measure] = len(sets)
                sets.append(sound & nodes_of(library, entry, measure, repeats=repeats))
            kind[n], entries[n] = found[entry, measure], number
            n += 1
    if wanted[-1].step is None:  # the last step must end with the dance
        kind[-1] = len(sets)
        sets.append(sound & leaves)
    return SequenceSpec(
        entries=tuple(wanted),
        fits=np.stack(sets),
        set_index=kind,
        entry_index=entries,
        enters=np.asarray(library.node_measure == 0),
        leaves=np.asarray(leaves),
        foot_rule=foot_rule,
    )


def nodes_of(library: "StepLibrary", entry: SequenceEntry, measure: int, *, repeats: bool = False) -> Bool:
    """Return the nodes that hold a measure (from 0) of the entry, shape (N,); `repeats`: see `specify`."""
    if entry.step is None:
        return np.ones(library.node_count, np.bool_)
    found = (library.node_step == entry.step) & (library.node_measure == measure)
    found &= library.node_measures == entry.measures
    if repeats:
        found |= (library.node_step == entry.step) & repeated_nodes(library, entry.measures, measure)
    if entry.direction:
        found &= np.array([travels(clip, entry.direction) for clip in library.clips])[library.node_clip]
    return np.asarray(found, np.bool_)


def repeated_nodes(library: "StepLibrary", measures: int, measure: int) -> Bool:
    """Return the nodes of recorded steps that hold a measure (from 0) of `measures` danced by repeats, shape (N,)."""
    short = np.array([clip.recorded and measures % clip.measures == 0 for clip in library.clips])[library.node_clip]
    return np.asarray(short & (library.node_measure == measure % library.node_measures), np.bool_)


def travels(clip: StepClip, direction: str) -> bool:
    """Whether a clip travels in `direction`: "left" includes short and long."""
    return set(direction.split()) <= set(clip.direction.split())


def leading_foot_fits(clip: StepClip) -> bool:
    """Whether the leading foot suits the clip's direction (T134): to the left the right foot leads.

    True if either is unknown, or the clip does not travel sideways.
    """
    side = clip.direction.split()[-1]
    return not clip.leading_foot or LEADING_FOOT.get(side, clip.leading_foot) == clip.leading_foot
