"""Division of the groups over the measures of a show, as a tree: what is shown as rows that split and join (T026).

Schulz 2011, 2.4.3 and Figs 2.8, 4.3 and 4.13: a group divides, by attribute or by place, and joins again where that
ends; steps and group motion may be divided differently. Who belongs to a selection by place follows from the dance, so
a tree is of measures that were danced, live or aside.
"""

from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from live.base.arrays import Int32
from live.show.group.division import dancer_words

if TYPE_CHECKING:
    from live.show.show import Show

Kind = Literal["steps", "motion", "values"]
KINDS: Final[tuple[Kind, ...]] = ("steps", "motion", "values")
KEPT_MEASURES: Final = 4096
"""Number of past measures that are remembered."""


@dataclass(frozen=True, slots=True)
class Part:
    """Dancers of one group who did something of their own in one measure."""

    kind: Kind
    group: int
    words: str
    """The selection, as written or requested; their numbers for values."""
    dancers: frozenset[int]
    """From 1."""


@dataclass(slots=True)
class Branch:
    """A part over some measures, and the parts within it."""

    part: Part
    first: int
    """From 0."""
    last: int
    branches: list["Branch"] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Return plain values for programs; measures count from 1."""
        return {
            "words": self.part.words,
            "dancers": sorted(self.part.dancers),
            "from": self.first + 1,
            "to": self.last + 1,
            "parts": [branch.as_json() for branch in self.branches],
        }


def _members(show: "Show") -> Int32:
    """Return the group of each dancer (A,); -1 for those of the reserve who are not on the stage."""
    group, present = show.casting.group, show.motion.present[: len(show.casting.group)]
    is_reserve = np.arange(len(group)) >= show.patch.dancer_count
    return np.where(is_reserve & ~present, -1, group).astype(np.int32)


def present_parts(show: "Show") -> list[Part]:
    """Return the parts of a show's groups now: with steps, with motion, and with values of their own."""
    group = _members(show)
    subgroups, division = show.scheduler.subgroups, show.variation.division
    found: list[tuple[Kind, str, np.ndarray]] = []
    for each in subgroups.active:
        found.append(("steps", each.words, each.chosen & (group == each.group)))
    for words, who in show.motion.evolutions.moved():
        found.append(("motion", words, who))
    for part, _, words in show.desk.parameters.parts():
        found.append(("values", words, division.part == part))
    return [
        Part(kind, index, words, frozenset((np.flatnonzero(who & (group == index)) + 1).tolist()))
        for kind, words, who in found
        for index in np.unique(group[who]).tolist()
        if index >= 0 and not who[group == index].all()  # a whole group is not divided
    ]


def part_facts(show: "Show") -> list[dict[str, Any]]:
    """Return which dancers have something of their own now, for the status."""
    names = [group.name for group in show.patch.group]
    return [
        {"kind": one.kind, "group": names[one.group], "words": one.words, "dancers": sorted(one.dancers)}
        for one in present_parts(show)
    ]


class DivisionTree:
    """The parts of one show's groups in its last measures."""

    def __init__(self) -> None:
        self._measures: deque[tuple[int, list[Part], tuple[frozenset[int], ...]]] = deque(maxlen=KEPT_MEASURES)

    def observe(self, show: "Show") -> None:
        """Note the division in the measure that is danced; the first call in each measure counts."""
        number = show.span.number
        if number < 0 or (self._measures and self._measures[-1][0] >= number):
            return
        group = _members(show)
        members = (np.flatnonzero(group == index) + 1 for index in range(len(show.patch.group)))
        self._measures.append((number, present_parts(show), tuple(frozenset(one.tolist()) for one in members)))

    def until(self, measure: int) -> "DivisionTree":
        """Return another one with the measures up to `measure` (from 0), after which something else is danced."""
        other = DivisionTree()
        other._measures.extend(one for one in self._measures if one[0] <= measure)
        return other

    def trees(self, names: tuple[str, ...], first: int, last: int) -> dict[Kind, list[Branch]]:
        """Return for each kind the groups with their parts in measures `first` to `last` (from 0)."""
        return {kind: self._of_kind(kind, names, first, last) for kind in KINDS}

    def _of_kind(self, kind: Kind, names: tuple[str, ...], first: int, last: int) -> list[Branch]:
        roots: list[Branch] = []
        found: dict[Part, Branch] = {}
        branches: list[Branch] = []
        for number, parts, members in self._measures:
            if not first <= number <= last:
                continue
            for index, dancers in enumerate(members):
                root = next((one for one in reversed(roots) if one.part.group == index), None)
                if root is not None and root.part.dancers == dancers:
                    root.last = number
                elif dancers:
                    roots.append(Branch(Part(kind, index, names[index], dancers), number, number))
            for part in (part for part in parts if part.kind == kind):
                branch = found.get(part)
                if branch is not None and branch.last >= number - 1:
                    branch.last = number
                else:
                    found[part] = Branch(part, number, number)
                    branches.append(found[part])
        for branch in sorted(branches, key=lambda one: (-len(one.part.dancers), one.first - one.last)):
            own = [root for root in roots if root.part.group == branch.part.group]
            home = _home(own, branch) or next(iter(own), None)  # its group changed meanwhile: the first row of it
            if home is not None:
                home.branches.append(branch)
        return roots


def _home(branches: list[Branch], branch: Branch) -> Branch | None:
    """Return the smallest of `branches` and those below that holds a branch's dancers in all its measures."""
    for each in branches:
        holds = each.part.dancers >= branch.part.dancers and each.first <= branch.first and branch.last <= each.last
        if holds:
            return _home(each.branches, branch) or each
    return None


def tree_lines(trees: dict[Kind, list[Branch]]) -> list[str]:
    """Return trees as lines of text: a part under what it is a part of, with its measures and dancers."""
    lines: list[str] = []

    def add(branch: Branch, depth: int) -> None:
        words, numbers = branch.part.words, dancer_words(sorted(branch.part.dancers))
        who = words if words == numbers else f"{words} ({numbers})"
        lines.append(f"{'  ' * depth}{who}: measures {branch.first + 1}-{branch.last + 1}")
        for each in sorted(branch.branches, key=lambda one: one.first):
            add(each, depth + 1)

    for kind, roots in trees.items():
        if any(root.branches for root in roots):
            lines.append(kind)
            for root in roots:
                add(root, 1)
    return lines
