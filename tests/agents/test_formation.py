"""Formations: the right number of places, inside the wished rectangle, apart from each other."""

import numpy as np
import pytest

from live.agents.formation import FORMATIONS


@pytest.mark.parametrize("shape", sorted(FORMATIONS))
@pytest.mark.parametrize("count", [0, 1, 2, 7, 24, 50])
def test_places(shape, count):
    places = FORMATIONS[shape](count, centre=(1.0, -0.5), size=(40.0, 30.0))
    assert places.shape == (count, 2)
    assert (np.abs(places - [1.0, -0.5]) <= np.array([20.0, 15.0]) + 1e-9).all()
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))[np.triu_indices(count, 1)]
    assert count < 2 or apart.min() > 0.6


def test_a_deep_and_narrow_grid_is_filled_and_centred():
    places = FORMATIONS["grid"](2, centre=(0.0, 0.0), size=(1.0, 4.0))
    assert places[:, 1].tolist() == [2.0, -2.0]
    places = FORMATIONS["grid"](5, centre=(0.0, 0.0), size=(1.0, 100.0))
    assert places[:, 1].mean() == pytest.approx(0.0)


def test_the_first_of_a_circle_stands_nearest_to_the_public():
    places = FORMATIONS["circle"](9, centre=(0.0, 0.0), size=(6.0, 4.0))
    assert places[:, 1].argmax() == 0
