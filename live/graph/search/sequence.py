"""Sequences: parsing of wanted steps ("couru left, échappé x2, *"), and the search for a matching path (T063-T066)."""

import difflib
import re
import unicodedata
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32
from live.base.errors import PersonError
from live.graph.search.depth_first_reference import NODE_BUDGET, depth_first
from live.graph.search.sequence_spec import MAX_MEASURES, SequenceEntry, SequenceSpec, travels
from live.graph.search.viterbi import CostToGo, Edges, cheapest_path
from live.graph.step_library import StepLibrary
from live.motion.step_clip import DIRECTIONS

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph


Method = Literal["layered", "depth first"]


class NoPath(ValueError):
    """There is no dance of the requested number of measures, even with other steps."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundPath:
    """A dance of M measures, and its differences from the request."""

    node: Int32
    """Shape (M,)."""
    wrong: Bool
    """Measures that differ from the request, shape (M,)."""
    edge_cost: Float64
    """Distance of the poses at the beginning of each measure [m] (K002), 0 for a first measure, shape (M,)."""

    @property
    def cost(self) -> int:
        """Number of measures that differ from the request (T063)."""
        return int(self.wrong.sum())


def find_sequence(
    graph: "MotionGraph",
    specification: SequenceSpec,
    *,
    start: int | None = None,
    method: Method = "layered",
    budget: int = NODE_BUDGET,
) -> FoundPath:
    """Return the dance with the fewest wrong measures (T063), and of those the smoothest.

    `start` is the node danced before the first measure; without it the dance begins with any step. Method "depth first"
    is the thesis' search (T064): the first dance without a wrong measure, not the smoothest. It raises SearchTooLong
    after `budget` nodes; if it finds none, the layered search finds the nearest (T065). NoPath if there is no dance of
    that many measures.
    """
    edges = edges_of(graph)
    node = depth_first(edges, specification, start=start, budget=budget) if method == "depth first" else None
    if node is None and method == "layered":
        node = cheapest_path(CostToGo(edges, specification, wrong=False), start)
    if node is None:
        node = cheapest_path(CostToGo(edges, specification, wrong=True), start)
    if node is None:
        raise NoPath(f"no steps that follow each other fill {specification.measures} measures")
    return _found_path(edges, specification, node, start)


def best_start(graph: "MotionGraph", specification: SequenceSpec, nodes: npt.ArrayLike) -> int:
    """Return the node after which the dance has the fewest wrong measures, of those the smoothest.

    One search covers all `nodes`; the first node is returned if no dance follows any.
    """
    edges = edges_of(graph)
    value = CostToGo(edges, specification, wrong=True).layer(0)
    after = np.full(len(value), np.inf)
    np.minimum.at(after, np.repeat(np.arange(len(value)), np.diff(edges.start)), edges.cost + value[edges.target])
    choice = np.asarray(nodes)
    return int(choice[np.argmin(after[choice])])


def edges_of(graph: "MotionGraph") -> Edges:
    """Return the graph's edges in the format of the searches."""
    return Edges(graph.edge_start, graph.edge_target, graph.edge_cost)


def _found_path(edges: Edges, specification: SequenceSpec, node: Int32, start: int | None) -> FoundPath:
    wrong = ~specification.fits[specification.set_index, node]
    cost = np.zeros(len(node))
    before = -1 if start is None else start
    for measure, after in enumerate(node.tolist()):
        if before >= 0:
            row = slice(edges.start[before], edges.start[before + 1])
            cost[measure] = edges.cost[row][edges.target[row] == after].min()
        before = after
    return FoundPath(node, np.asarray(wrong), cost)


ANY: Final = "*"
_TIMES: Final = re.compile(r"(?P<what>.+?)\s+[x×]\s*(?P<times>[0-9]{1,200})")
_LENGTH: Final = re.compile(r"(?P<what>.+?)\s*:\s*(?P<measures>[0-9]{1,3})")
_WAYS: Final = tuple(dict.fromkeys([*DIRECTIONS, *(way.split()[-1] for way in DIRECTIONS[1:])]))
"""Directions that may follow a step's name: the nine directions, or only their last word."""


def parse_sequence(text: str, library: StepLibrary) -> list[SequenceEntry]:
    """Parse a sequence: names of steps with commas between them.

    "*" is a measure of anything, "x3" after an entry repeats it, a direction after a name selects it, and ":2" selects
    the variation of two measures if a step has several lengths. Capitals, accents, blanks and underscores do not
    matter. PersonError names the entry, the text read, and the nearest names.
    """
    wanted: list[SequenceEntry] = []
    parts = text.split(",")
    for number, part in enumerate(parts, start=1):
        where = f"entry {number} of the sequence"
        if not part.strip():
            raise PersonError(f"{where} is empty: the name of a step or {ANY} expected", list_steps(library))
        what, times = _repeats(part.strip(), library)
        measures = len(wanted) + times  # lower bound: no entry is shorter than a measure
        if times < 1 or measures > MAX_MEASURES:
            raise PersonError(
                f"{where}, {_short(part)}: 1 to {MAX_MEASURES} measures in all expected",
                "fewer repeats" if times else "leave the entry out",
            )
        wanted += [_entry(what, library, where)] * times
    return wanted


def find_name(library: StepLibrary, name: str) -> int | None:
    """Return the index of the step called `name`; accents are ignored unless they distinguish two steps."""
    index = library.step_index(name)
    if index is None:
        plain = [_unaccented(step) for step in library.steps]
        if plain.count(_unaccented(name)) == 1:
            index = plain.index(_unaccented(name))
    return index


def list_steps(library: StepLibrary, count: int = 12) -> str:
    """Return a text with the names of the first few steps."""
    return "the steps are " + ", ".join(library.steps[:count]) + (", ..." if len(library.steps) > count else "")


def _repeats(part: str, library: StepLibrary) -> tuple[str, int]:
    """Return an entry without its repeats, and their number; a step may itself be called "wave x2"."""
    match = _TIMES.fullmatch(part)
    if match is None or find_name(library, part) is not None:
        return part, 1
    return match["what"], int(match["times"])


def _entry(what: str, library: StepLibrary, where: str) -> SequenceEntry:
    if what == ANY:
        return SequenceEntry(None)
    step, way, measures = find_name(library, what), "", None
    if step is None and (match := _LENGTH.fullmatch(what)) is not None:
        what, measures = match["what"], int(match["measures"])
        step = find_name(library, what)
    if step is None:
        what, way = _split_direction(what)
        step = find_name(library, what)
    if step is None:
        raise _unknown(what, library, where)
    lengths = sorted({clip.measures for clip in library.clips if clip.step == library.steps[step]})
    if way:
        lengths = sorted({c.measures for c in library.clips if c.step == library.steps[step] and travels(c, way)}) or (
            lengths
        )
    if measures is not None and measures not in lengths:
        unit = "measure" if lengths == [1] else "measures"
        raise PersonError(
            f"{where}: {library.steps[step]!r} is {_listed(lengths)} {unit} long, not {measures}",
            f"{library.steps[step]}:{lengths[0]}",
        )
    if measures is None and len(lengths) > 1:
        raise PersonError(
            f"{where}: variations of {library.steps[step]!r} are {_listed(lengths)} measures long: say which",
            f"{library.steps[step]}:{lengths[0]}",
        )
    return SequenceEntry(step, measures or lengths[0], way)


def _split_direction(what: str) -> tuple[str, str]:
    """Return name and direction of "walk long left"; no direction if there is none at the end."""
    plain = " ".join(what.casefold().replace("_", " ").split())
    for way in _WAYS:
        if plain.endswith(" " + way):
            return plain[: -len(way)].strip(), way
    return what, ""


def _unknown(name: str, library: StepLibrary, where: str) -> PersonError:
    plain = {_unaccented(step): step for step in library.steps}
    near = [plain[found] for found in difflib.get_close_matches(_unaccented(name), plain, n=3)]
    return PersonError(f"{where}: there is no step {_short(name)}", " or ".join(near) if near else list_steps(library))


def _short(text: str) -> str:
    text = " ".join(text.split())
    return repr(text if len(text) <= 60 else text[:60] + "…")


def _listed(lengths: list[int]) -> str:
    return " or ".join(map(str, lengths))


def _unaccented(name: str) -> str:
    letters = unicodedata.normalize("NFKD", name.replace("_", " ").replace("-", " ").casefold())
    return " ".join("".join(letter for letter in letters if not unicodedata.combining(letter)).split())
