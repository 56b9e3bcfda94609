"""Linked timeline: each dancer has one segment at every beat, with auxiliary ones in gaps (T089, Fig 4.3)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

AUXILIARY = -1
"""Source of generated segments: pauses in gaps, and junctions (of no length) where groups divide or join."""


@dataclass(frozen=True, slots=True, eq=False)
class Span:
    """Time span and dancers of a written segment."""

    begin: float
    """Beat."""
    end: float
    """Beat."""
    dancers: Mask
    """The dancers, shape (A,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A piece of the linked timeline, in beats."""

    begin: float
    end: float
    dancers: Mask
    """The dancers, shape (A,)."""
    source: int
    """Index of the span it comes from, or `AUXILIARY`."""
    before: tuple[int, ...] = ()
    """Indices of the links that it continues: one, or several for a junction; none at the beginning."""
    after: tuple[int, ...] = ()
    """The links that continue it."""


def link_timeline(spans: Sequence[Span], dancers: int, length: float) -> tuple[Link, ...]:
    """Return one linked sequence from beat 0 to beat `length` in which each dancer has exactly one segment at a time.

    A span that begins later permanently replaces what its dancers had; of two that begin together the one written later
    counts. A group changes only through a junction: a link of no length with the dancers who come together there.
    """
    pieces: dict[tuple[float, float, int], Mask] = {}
    for dancer in range(dancers):
        for piece in _pieces_of_dancer(spans, dancer, length):
            pieces.setdefault(piece, np.zeros(dancers, np.bool_))[dancer] = True
    links = [Link(begin, end, mask, source) for (begin, end, source), mask in sorted(pieces.items(), key=_sort_key)]
    return _connect(links)


def _pieces_of_dancer(spans: Sequence[Span], dancer: int, length: float) -> list[tuple[float, float, int]]:
    latest: dict[float, int] = {}
    for index, span in enumerate(spans):
        begin = max(span.begin, 0.0)
        if span.dancers[dancer] and begin < length and span.end > begin:
            latest[begin] = index
    begins = sorted(latest)
    pieces: list[tuple[float, float, int]] = []
    at = 0.0
    for begin, following in zip(begins, [*begins, length][1:], strict=True):
        if begin > at:
            pieces.append((at, begin, AUXILIARY))
        at = min(spans[latest[begin]].end, following)
        pieces.append((begin, at, latest[begin]))
    if at < length:
        pieces.append((at, length, AUXILIARY))
    return pieces


def _sort_key(item: tuple[tuple[float, float, int], Mask]) -> tuple[float, float, int, int]:
    (begin, end, source), mask = item
    return begin, end, source, int(np.argmax(mask))


def _connect(links: list[Link]) -> tuple[Link, ...]:
    """Insert junctions, sort, and connect."""
    everything = list(links)
    edges: list[tuple[Link, Link]] = []
    for beat in sorted({link.begin for link in links} - {0.0}):
        ending = [link for link in links if link.end == beat]
        starting = [link for link in links if link.begin == beat]
        for before, after in _connected_sets(ending, starting):
            if len(before) == len(after) == 1:
                edges.append((before[0], after[0]))
                continue
            together = np.logical_or.reduce([link.dancers for link in before])
            junction = Link(beat, beat, together, AUXILIARY)
            everything.append(junction)
            edges += [(link, junction) for link in before] + [(junction, link) for link in after]
    everything.sort(key=lambda link: (link.begin, link.end, int(np.argmax(link.dancers))))
    index = {id(link): number for number, link in enumerate(everything)}
    into: list[list[int]] = [[] for _ in everything]
    out: list[list[int]] = [[] for _ in everything]
    for one, other in edges:
        out[index[id(one)]].append(index[id(other)])
        into[index[id(other)]].append(index[id(one)])
    return tuple(
        Link(link.begin, link.end, link.dancers, link.source, tuple(sorted(before)), tuple(sorted(after)))
        for link, before, after in zip(everything, into, out, strict=True)
    )


def _connected_sets(ending: list[Link], starting: list[Link]) -> list[tuple[list[Link], list[Link]]]:
    """Return the connected sets of ending and starting links that share dancers."""
    parties: list[tuple[list[Link], list[Link], Mask]] = []
    for link in ending:
        parties.append(([link], [], link.dancers))
    for link in starting:
        touched = [party for party in parties if (party[2] & link.dancers).any()]
        rest = [party for party in parties if not (party[2] & link.dancers).any()]
        before = [each for party in touched for each in party[0]]
        after = [each for party in touched for each in party[1]] + [link]
        mask = np.logical_or.reduce([party[2] for party in touched] + [link.dancers])
        parties = [*rest, (before, after, mask)]
    return [(before, after) for before, after, _ in parties if before and after]
