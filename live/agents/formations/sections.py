"""Sections kept together: dancers of one section get neighbouring places (T090, T104)."""

import numpy as np
import numpy.typing as npt

from live.agents.formations.along import share

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]


def section_sizes(wished: tuple[int, ...], count: int) -> list[int]:
    """Sizes of sections that together are `count`: as wished, or in the same proportions."""
    if sum(wished) == count:
        return list(wished)
    sizes = np.array(wished, np.float64)
    return [int(each) for each in share(count, sizes, np.zeros(len(sizes)), np.zeros(len(sizes), np.int64))]


def sections_along(sizes: list[int]) -> Int64:
    """Section (from 0) of each place, in the order along the lines, shape (sum of sizes,)."""
    return np.repeat(np.arange(len(sizes), dtype=np.int64), sizes)


def sections_in_area(places: Float64, sizes: list[int]) -> Int64:
    """Section (from 0) of each of the places (S, 2): the area is halved across its longer side again and again.

    Sections come from left to right, then from front to back, in their order.
    """
    section = np.zeros(len(places), np.int64)
    _halve(places, np.arange(len(places)), sizes, 0, section)
    return section


def _halve(places: Float64, members: Int64, sizes: list[int], first: int, section: Int64) -> None:
    if len(sizes) == 1:
        section[members] = first
        return
    cut = min(range(1, len(sizes)), key=lambda n: abs(2 * sum(sizes[:n]) - sum(sizes)))
    x, z = np.round(places[members], 9).T
    wide = len(members) > 0 and np.ptp(x) >= np.ptp(z)
    ordered = members[np.lexsort((-z, x) if wide else (x, -z))]
    taken = sum(sizes[:cut])
    _halve(places, ordered[:taken], sizes[:cut], first, section)
    _halve(places, ordered[taken:], sizes[cut:], first + cut, section)
