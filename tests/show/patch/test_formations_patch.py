"""The `formations` patch: each formation is reached at its measure line, and a mirrored canon is one."""

import numpy as np
import pytest

from live.show.loader import load_show
from live.show.patch.patch_search_path import find_patch
from tests.fixtures.hips import hips
from tests.fixtures.mostly_long import mostly_long

STANDING = {4: "letters", 12: "star", 20: "spiral", 25: "scattered", 31: "halves"}
MEASURES = 38


class DancedLines:
    """One run of the patch, only as far as a test asks for its measure lines."""

    def __init__(self):
        self._show, self._tick, self._found = load_show(find_patch("formations")).start(), 0, {}

    def until(self, measures):
        """By measure line: hips (A, 2), positions wanted by segments (A, 2), smallest distance of agents [m]."""
        show = self._show
        while show.span.number < measures:
            self._tick += 1
            if show.tick(self._tick / 64):
                on = show.motion.present
                under, wanted, _ = show.motion.evolutions.target(show.span.number * show.timeline.beats_per_measure)
                assert under[on].all()
                apart = np.hypot(*(show.state.position[on][:, None] - show.state.position[on][None]).transpose(2, 0, 1))
                np.fill_diagonal(apart, np.inf)
                self._found[show.span.number] = hips(show.dancers, 0.0)[on], wanted[on], apart.min()
        return self._found


@pytest.fixture(scope="module")
def danced_lines():
    return DancedLines()


@mostly_long("line", STANDING, quick=[0])
def test_each_formation_is_reached_on_its_measure_line(danced_lines, line):
    hips, wanted, _ = danced_lines.until(line)[line]
    off = np.hypot(*(hips - wanted).T)
    assert off.mean() < 0.1
    assert off.max() < 0.35


@pytest.mark.long
def test_dancers_stay_half_a_meter_apart(danced_lines):
    assert min(nearest for _, _, nearest in danced_lines.until(MEASURES).values()) > 0.5


@pytest.mark.long
def test_right_half_mirrors_left_half_two_measures_later(danced_lines):
    """Segments in measures 33 and 34: the left half's path, reflected, is the right half's in 35 and 36 (T147)."""
    measure_lines = danced_lines.until(MEASURES)
    left = measure_lines[31][1][:, 0] < 0.0
    way = {line: measure_lines[line][1] - measure_lines[31][1] for line in (34, 36)}
    assert np.abs(way[34][~left]).max() < 1e-3
    assert np.allclose(way[34][left], way[34][left][0], atol=1e-3)
    assert np.hypot(*way[34][left][0]) > 0.5
    assert np.allclose(way[36][~left], way[34][left][0] * (-1.0, 1.0), atol=1e-3)
