"""Test cards of render nodes: their line meets across a seam if both show the same tick, which is written."""

import numpy as np

from live.render.outputs.output import Output

HALF = (160, 180)  # pixels of a half of the picture
LEFT, RIGHT = Output("left", node="a", crop=(0.0, 0.0, 0.5, 1.0)), Output("right", node="b", crop=(0.5, 0.0, 0.5, 1.0))
BLACK = np.zeros((180, 320, 3), np.uint8)


def yellow(picture):
    """Where the moving line is: red and green without blue."""
    return (picture[..., 0] > 150) & (picture[..., 1] > 130) & (picture[..., 2] < 120)


def line_places(picture, rows):
    """The line's column in each of these rows; NaN where it is not."""
    lit = yellow(picture)
    return np.array([np.flatnonzero(lit[row]).mean() if lit[row].any() else np.nan for row in rows])


def test_line_continues_across_the_seam_of_two_nodes_at_the_same_tick(throw):
    rows = range(20, 140)
    whole = throw(BLACK, Output("whole", node="a"), card="name", tick=128)
    left, right = (throw(BLACK, side, HALF, card="name", tick=128) for side in (LEFT, RIGHT))
    assert yellow(left[20:140]).any()  # the line crosses the seam: both show a part of it
    assert yellow(right[20:140]).any()
    places, wanted = (line_places(shown, rows) for shown in (np.concatenate([left, right], axis=1), whole))
    assert np.isfinite(wanted).all()
    assert np.abs(places - wanted).max() <= 1.0


def test_line_breaks_where_a_node_is_late(throw):
    late = throw(BLACK, LEFT, HALF, card="name", tick=120)
    right = throw(BLACK, RIGHT, HALF, card="name", tick=128)
    whole = throw(BLACK, Output("whole", node="a"), card="name", tick=128)
    rows = range(20, 140)
    off = np.abs(line_places(np.concatenate([late, right], axis=1), rows) - line_places(whole, rows))
    assert np.nanmax(off) > 4.0  # eight ticks are ten columns here


def test_card_writes_the_tick(throw):
    shown = [throw(BLACK, LEFT, (640, 720), card="name", tick=tick)[650:705] for tick in (1, 1, 2, 12345)]
    np.testing.assert_array_equal(shown[0], shown[1])
    assert np.abs(shown[0].astype(int) - shown[2]).max() > 100
    assert (shown[3] > 128).sum() != (shown[0] > 128).sum()


def test_cards_of_other_outputs_stay_as_they_were(throw):
    np.testing.assert_array_equal(
        throw(BLACK, Output("one"), card="grid"), throw(BLACK, Output("one"), card="grid", tick=-1)
    )
