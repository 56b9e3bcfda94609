"""Tests of the glyph atlas and text layout of the overlay."""

import numpy as np
from PIL import ImageFont

from live.render.lettering.glyph_atlas import bake_atlas, without_accents


def test_every_printable_glyph_has_ink_in_its_cell() -> None:
    lettering = bake_atlas(16)
    width, tall = lettering.cell
    columns = lettering.coverage.shape[1] // width
    for one, cell in lettering.index.items():
        x, y = cell % columns * width, cell // columns * tall
        ink = lettering.coverage[y : y + tall, x : x + width]
        if one.isspace() or one == "\xad":
            continue
        assert ink.max() > 100, one


def test_digits_have_equal_width() -> None:
    lettering = bake_atlas(18)
    assert len({lettering.advance[digit] for digit in "0123456789"}) == 1


def test_lines_run_right_and_down_and_spaces_use_no_glyph() -> None:
    lettering = bake_atlas(14)
    laid = lettering.lay_out(("ab", "c d"), (10.0, 20.0), 100)
    assert laid.shape == (4, 4)
    assert laid[1, 0] > laid[0, 0]
    np.testing.assert_array_equal(laid[:, 1], [20.0, 20.0, 20.0 + lettering.cell[1], 20.0 + lettering.cell[1]])


def test_unknown_characters_become_question_marks_and_length_is_limited() -> None:
    lettering = bake_atlas(14)
    strange = lettering.lay_out(("\u6f22",), (0.0, 0.0), 10)
    known = lettering.lay_out(("?",), (0.0, 0.0), 10)
    np.testing.assert_array_equal(strange, known)
    assert len(lettering.lay_out(("x" * 500,), (0.0, 0.0), 64)) == 64
    assert lettering.lay_out((), (0.0, 0.0), 10).shape == (0, 4)


def test_accents_are_removed() -> None:
    lettering = bake_atlas(14)
    laid = lettering.lay_out(("Dan\u00e7a S\u00e3o, \u00c9lan",), (3.0, 4.0), 100)
    np.testing.assert_array_equal(laid, lettering.lay_out(("Danca Sao, Elan",), (3.0, 4.0), 100))
    assert without_accents("Stra\u00dfe \u00d8rsted") == "Strasse Orsted"
    assert without_accents("plain, 1-2") == "plain, 1-2"
    assert without_accents("\u6f22") == "?"


def test_no_atlas_glyph_is_missing_glyph_box() -> None:
    font = ImageFont.load_default(size=20)
    missing = bytes(font.getmask("\uffff"))
    for one in bake_atlas(20).index:
        if one.strip():
            assert bytes(font.getmask(one)) != missing, one
