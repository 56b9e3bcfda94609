"""Specification: which step a dance shall have in every measure (T063), and which nodes would do there."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.graph.step_library import StepLibrary
from live.motion.step_clip import StepClip

Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

MOST_MEASURES: Final = 100_000
"""Longest dance that is searched: fourteen hours at 120 bpm."""
LEADING: Final = {"left": "right", "right": "left"}
"""Which foot leads where a step travels (T134)."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """One entry of a sequence: a step danced once, or one measure of anything."""

    step: int | None
    """Index of the step in the library; None: any step will do."""
    measures: int = 1
    """Its length."""
    way: str = ""
    """Where it must travel, in words of DIRECTIONS, as "left" or "long left"; "": anywhere."""


@dataclass(frozen=True, slots=True, eq=False)
class Specification:
    """d(n) of T063 for M measures as sets of nodes (K different sets over N nodes)."""

    wanted: tuple[Wanted, ...]
    fits: Bool
    """Which nodes would do, set by set, shape (K, N)."""
    kind: Int32
    """The set that each measure asks for, shape (M,)."""
    entry: Int32
    """The entry of `wanted` that each measure belongs to, shape (M,)."""
    enters: Bool
    """Nodes with which a step begins, shape (N,)."""
    leaves: Bool
    """Nodes with which a step ends, shape (N,)."""
    foot_rule: bool
    """Whether clips that lead with the wrong foot were left out (T134)."""

    @property
    def measures(self) -> int:
        """Length of the dance M."""
        return len(self.kind)

    def at(self, measure: int) -> Bool:
        """The nodes that would do in a measure, from 0, (N,)."""
        return np.asarray(self.fits[self.kind[measure]], np.bool_)


def specify(library: StepLibrary, wanted: Sequence[Wanted], *, foot_rule: bool = False) -> Specification:
    """The sets of nodes that a sequence asks for, measure by measure.

    A step is danced from its first measure to its last: its nth measure is asked for by name and number, so that no
    step is entered in its middle. With `foot_rule` a step that travels sideways must lead with the other foot (T134);
    clips of which either is not known are not judged. PersonError for an empty or endless sequence.
    """
    total = sum(entry.measures for entry in wanted)
    if not 1 <= total <= MOST_MEASURES:
        raise PersonError(f"a sequence of {total} measures: 1 to {MOST_MEASURES} expected")
    sound = np.ones(library.node_count, np.bool_)
    if foot_rule:
        sound = np.array([leads_rightly(clip) for clip in library.clips])[library.node_clip]
    leaves = library.node_measure == library.node_measures - 1
    found: dict[tuple[Wanted, int], int] = {}
    sets: list[Bool] = []
    kind, entries = np.empty(total, np.int32), np.empty(total, np.int32)
    n = 0
    for number, entry in enumerate(wanted):
        for measure in range(entry.measures):
            if (entry, measure) not in found:
                found[entry, measure] = len(sets)
                sets.append(sound & nodes_of(library, entry, measure))
            kind[n], entries[n] = found[entry, measure], number
            n += 1
    if wanted[-1].step is None:  # whatever is danced last must end with the dance
        kind[-1] = len(sets)
        sets.append(sound & leaves)
    return Specification(
        wanted=tuple(wanted),
        fits=np.stack(sets),
        kind=kind,
        entry=entries,
        enters=np.asarray(library.node_measure == 0),
        leaves=np.asarray(leaves),
        foot_rule=foot_rule,
    )


def nodes_of(library: StepLibrary, entry: Wanted, measure: int) -> Bool:
    """The nodes that hold a measure, from 0, of what is wanted, shape (N,)."""
    if entry.step is None:
        return np.ones(library.node_count, np.bool_)
    found = (library.node_step == entry.step) & (library.node_measure == measure)
    found &= library.node_measures == entry.measures
    if entry.way:
        found &= np.array([travels(clip, entry.way) for clip in library.clips])[library.node_clip]
    return np.asarray(found, np.bool_)


def travels(clip: StepClip, way: str) -> bool:
    """Whether a clip goes where the words of `way` say: "left" is both short and long."""
    return set(way.split()) <= set(clip.direction.split())


def leads_rightly(clip: StepClip) -> bool:
    """Whether the foot that leads lets the clip travel as it does (T134): to the left the right foot leads.

    True where either is not known, or the clip does not travel sideways.
    """
    side = clip.direction.split()[-1]
    return not clip.leading_foot or LEADING.get(side, clip.leading_foot) == clip.leading_foot
