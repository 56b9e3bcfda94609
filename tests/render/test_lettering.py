"""Letters of the overlay."""

import numpy as np

from live.render.lettering import letter


def test_every_letter_but_the_space_leaves_ink_within_its_own_cell() -> None:
    lettering = letter(16)
    width, tall = lettering.cell
    columns = lettering.picture.shape[1] // width
    for one, cell in lettering.index.items():
        x, y = cell % columns * width, cell // columns * tall
        ink = lettering.picture[y : y + tall, x : x + width]
        if one.isspace() or one == "\xad":
            continue
        assert ink.max() > 100, one


def test_digits_are_equally_wide_so_that_numbers_do_not_dance() -> None:
    lettering = letter(18)
    assert len({lettering.advance[digit] for digit in "0123456789"}) == 1


def test_lines_run_right_and_down_and_spaces_cost_nothing() -> None:
    lettering = letter(14)
    laid = lettering.lay_out(("ab", "c d"), (10.0, 20.0), 100)
    assert laid.shape == (4, 4)
    assert laid[1, 0] > laid[0, 0]
    np.testing.assert_array_equal(laid[:, 1], [20.0, 20.0, 20.0 + lettering.cell[1], 20.0 + lettering.cell[1]])


def test_unknown_letters_become_question_marks_and_length_is_limited() -> None:
    lettering = letter(14)
    strange = lettering.lay_out(("\u6f22",), (0.0, 0.0), 10)
    known = lettering.lay_out(("?",), (0.0, 0.0), 10)
    np.testing.assert_array_equal(strange, known)
    assert len(lettering.lay_out(("x" * 500,), (0.0, 0.0), 64)) == 64
    assert lettering.lay_out((), (0.0, 0.0), 10).shape == (0, 4)
