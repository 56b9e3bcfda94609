"""Rows of the element table against a plain list: adds, moves, removals and evictions keep the order."""

import numpy as np

from live.agents.elements.element import Element
from live.agents.elements.element_table import ElementTable
from live.agents.elements.element_table_kernels import CORNERS, END, OUTLINE, SERIAL, X
from live.base.element_kinds import ATTRACTOR, PATH

CAPACITY = 12


def random_element(chance, number):
    x = float(chance.uniform(-5.0, 5.0))
    if chance.random() < 0.2:
        return Element(PATH, ((x, 0.0), (x + 1.0, 2.0), (0.0, 3.0)), end_beat=100.0 + number)
    return Element(ATTRACTOR, ((x, 1.0),), end_beat=100.0 + number, fair=bool(chance.random() < 0.4))


def check_table(table, elements, serials):
    assert table.elements == elements
    rows = table.rows[: len(elements)]
    np.testing.assert_array_equal(rows[:, SERIAL], serials)
    np.testing.assert_array_equal(rows[:, X], [element.x for element in elements])
    np.testing.assert_array_equal(rows[:, END], [element.end_beat for element in elements])
    np.testing.assert_array_equal(rows[:, CORNERS], [len(element.points) for element in elements])
    for row, element in enumerate(elements):
        np.testing.assert_array_equal(table.vertices[row, : len(element.points)], np.float32(element.points))
        np.testing.assert_array_equal(table.outlines[row, : len(element.points)], np.float32(element.points))
        assert table.row_of(element) == row


def test_rows_keep_order_after_any_eviction():
    chance = np.random.default_rng(8)
    table = ElementTable(CAPACITY, half_width=6.0, half_depth=4.0, separation=1.0)
    elements, serials, number, gone = [], [], 0, []
    for round_ in range(800):
        what = chance.random()
        new = random_element(chance, round_)
        if what < 0.7:
            place = None
            if len(elements) == CAPACITY:
                fair = [row for row, old in enumerate(elements) if old.fair]
                place = fair[0] if fair else None if new.fair else 0
            taken = len(elements) < CAPACITY or place is not None
            assert table.add(new) is taken
            if taken:
                if place is not None:
                    gone.append(elements.pop(place))
                    del serials[place]
                number += 1
                elements.append(new)
                serials.append(number)
        elif elements and what < 0.85:
            row = int(chance.integers(len(elements)))
            table.replace(row, new)
            elements[row] = new
        elif elements:
            row = int(chance.integers(len(elements))) if chance.random() < 0.5 else 0
            table.remove(row)
            gone.append(elements.pop(row))
            del serials[row]
        check_table(table, elements, serials)
    assert number > 300
    assert all(table.row_of(element) is None for element in gone)


def test_dancers_follow_all_512_points_of_a_stroke_and_the_picture_fewer():
    """A zigzag, of which no point can be left out."""
    stroke = tuple((0.02 * k - 5.0, 2.0 * (k % 2)) for k in range(512))
    table = ElementTable(2, half_width=6.0, half_depth=4.0, separation=1.0)
    assert table.add(Element(PATH, stroke))
    assert table.rows[0, CORNERS] == 512
    np.testing.assert_array_equal(table.vertices[0], np.float32(stroke))
    assert 2 <= table.rows[0, OUTLINE] <= 64
    assert table.add(Element(PATH, tuple((0.01 * k - 5.0, 2.0 * (k % 2)) for k in range(1024))))
    assert 2 <= table.rows[1, CORNERS] <= 512
