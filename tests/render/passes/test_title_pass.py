"""Titles: size and place, depth, entrances, letters that a font lacks, letters that are still being made."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.picture_parameters import picture_row
from live.base.stage_snapshot import Title
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.lettering.distance_field import CELL, EM, SPREAD, LetterField, bake_field, read_font
from live.render.renderer import Renderer
from tests.control.waiting import wait_for
from tests.fixtures.mostly_long import mostly_long
from tests.render.test_renderer import SIZE, read, scene, standing

WHITE = (1.0, 1.0, 1.0)
BOTH = mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])


@pytest.fixture
def draw(gl_context):
    """Draws one dancer with titles; returns the picture and the problems."""

    def once(*titles, quality=SOFTWARE, size=SIZE, brightness=1.0, transparent=False):
        of = scene(1)
        renderer = Renderer(
            gl_context, of, size=size, quality=None if transparent else quality, blocking_video=True, warm_up=False,
            transparent=transparent,
        )  # fmt: skip
        target = gl_context.framebuffer([gl_context.texture(size, 4)])
        view = standing()
        view.picture, view.titles, view.brightness = picture_row(of), titles, brightness
        renderer.draw(view, target)
        seen, problems = read(target).astype(int), renderer.problems
        alpha = np.flipud(np.frombuffer(target.read(components=4), np.uint8).reshape(*size[::-1], 4)[..., 3])
        renderer.release()
        target.release()
        return (seen, alpha) if transparent else (seen, problems)

    return once


def test_field_is_the_distance_to_the_outline():
    field = bake_field("I", read_font("", 4 * EM)).astype(float)
    rows, columns = np.nonzero(field > 127.5)
    middle = int(rows.mean())
    across = field[middle]
    inside = np.flatnonzero(across > 127.5)
    left = np.interp(127.5, across[inside[0] - 1 : inside[0] + 1], [inside[0] - 1, inside[0]])
    for away in (2.0, 4.0, 6.0):  # outside, the level falls by 127.5 in SPREAD texels
        expected = 127.5 - 127.5 * away / SPREAD
        assert np.interp(left - away, np.arange(CELL), across) == pytest.approx(expected, abs=3.0)
    assert columns.min() > SPREAD - 3


@pytest.mark.long
@pytest.mark.gl
def test_letter_in_the_picture_has_its_height_and_place(draw):
    size = (640, 360)
    bare, _ = draw(size=size)
    seen, problems = draw(Title("H", at=(0.3, 0.4, 0.0), size=0.4, colour=WHITE, entrance="cut"), size=size)
    assert problems == []
    rows, columns = np.nonzero((seen - bare).sum(axis=2) > 250)
    assert np.ptp(rows) + 1 == pytest.approx(0.4 * 360, abs=2.5)
    assert 0.5 * (rows.min() + rows.max()) == pytest.approx(0.4 * 360, abs=2.5)
    assert 0.5 * (columns.min() + columns.max()) == pytest.approx(0.3 * 640, abs=3.5)
    edge = seen[144, columns.min() - 3 : columns.min() + 5].sum(axis=1)
    assert (np.abs(np.diff(edge)) > 60).sum() <= 3  # sharp, however large


@pytest.mark.gl
@BOTH
def test_letters_in_the_stage_hide_and_are_hidden_by_depth(draw, quality):
    chest = standing().joint_position[0, 3]
    x, y = project_points(scene(1).camera, SIZE, [chest])[0].astype(int)
    bare, _ = draw(quality=quality)
    behind, front = (
        draw(Title("HHHHH", "stage", (0.0, float(chest[1]), z), 1.6, 0.0, (2.0, 2.0, 2.0), "cut"), quality=quality)[0]
        for z in (-2.0, 2.0)
    )
    assert np.abs(behind[y, x] - bare[y, x]).max() < 40  # a card's glow
    changed = (np.abs(behind - bare).max(axis=2) > 60).sum()
    assert changed > 300
    around = (front[y - 6 : y + 7, x - 12 : x + 13] - bare[y - 6 : y + 7, x - 12 : x + 13]).sum(axis=2)
    assert (around > 200).sum() > 20


@pytest.mark.long
@pytest.mark.gl
def test_title_in_the_stage_has_its_height_in_metres(draw):
    bare, _ = draw(size=(640, 360))
    seen, _ = draw(Title("H", "stage", (2.5, 2.0, 0.0), 1.0, colour=WHITE, entrance="cut"), size=(640, 360))
    rows, _ = np.nonzero(((seen - bare).sum(axis=2) > 200)[:, 400:])
    upper, lower = project_points(scene(1).camera, (640, 360), [(2.5, 2.5, 0.0), (2.5, 1.5, 0.0)])[:, 1]
    assert rows.min() == pytest.approx(upper, abs=2.5)
    above_floor = rows[rows < 0.5 * (lower + 360)]  # below lies its mirror image
    assert np.percentile(above_floor, 99) == pytest.approx(lower, abs=5.0)


@pytest.mark.gl
@mostly_long("entrance", ["fade", "rise", "wipe", "type"], quick=[])
def test_entrances_begin_with_nothing_grow_and_end_complete(draw, entrance):
    bare, _ = draw()
    lit = []
    for progress in (0.0, 0.3, 0.6, 1.0):
        seen, _ = draw(Title("HHHHHHHH", size=0.12, colour=WHITE, entrance=entrance, progress=progress))
        lit.append(int(np.abs(seen - bare).sum()))
    complete, _ = draw(Title("HHHHHHHH", size=0.12, colour=WHITE, entrance="cut"))
    assert lit[0] < 0.02 * lit[3]
    assert lit[0] < lit[1] < lit[2] < lit[3]
    assert lit[3] == pytest.approx(np.abs(complete - bare).sum(), rel=0.02)


@pytest.mark.long
@pytest.mark.gl
def test_letters_that_the_font_lacks_are_nothing_and_told_once(draw):
    plain, none = draw(Title("AB", size=0.2)), draw(Title("A\u0416B\u0416", size=0.2), Title("\u0416", size=0.1))
    assert np.array_equal(plain[0], none[0])
    assert len([words for words in none[1] if "U+0416" in words]) == 1
    other, replaced = draw(Title("ß –", size=0.1)), draw(Title("ss -", size=0.1))
    assert other[1] == []
    assert np.array_equal(other[0], replaced[0])


@pytest.mark.gl
@mostly_long(("accented", "plain", "above"), [("É", "E", True), ("ñ", "n", True), ("Ç", "C", False)], quick=[])
def test_accents_that_the_font_lacks_are_composed(draw, accented, plain, above):
    (with_accent, problems), (without, _) = (
        draw(Title(letter, size=0.3, colour=WHITE, entrance="cut")) for letter in (accented, plain)
    )
    assert problems == []
    ink = np.nonzero(np.abs(without - draw()[0]).sum(axis=2) > 200)[0]
    more = np.nonzero(with_accent.sum(axis=2) - without.sum(axis=2) > 200)[0]
    assert len(more) > 15
    assert (more < ink.min() + 2).mean() > 0.9 if above else (more > ink.max() - 4).mean() > 0.9


@pytest.mark.long
@pytest.mark.gl
def test_title_too_long_for_the_picture_is_smaller(draw):
    seen, _ = draw(Title("H" * 40, size=0.3, colour=WHITE, entrance="cut"))
    columns = np.nonzero(np.abs(seen - draw()[0]).sum(axis=2) > 200)[1]
    assert columns.min() > 0.02 * SIZE[0]
    assert columns.max() < 0.98 * SIZE[0]
    assert np.ptp(columns) > 0.85 * SIZE[0]


@pytest.mark.long
@pytest.mark.gl
def test_blackout_and_level_hide_titles(draw):
    dark, _ = draw(Title("HHH", size=0.3), brightness=0.0)
    assert dark.max() == 0
    assert np.array_equal(draw(Title("HHH", size=0.3, level=0.0))[0], draw()[0])


@pytest.mark.gl
def test_title_is_drawn_into_pictures_with_alpha(draw):
    picture, alpha = draw(Title("H", at=(0.2, 0.3, 0.0), size=0.3, colour=WHITE, entrance="cut"), transparent=True)
    where = alpha[20:90, 40:90] > 200
    assert where.sum() > 100
    assert picture[20:90, 40:90][where].mean() > 180


def test_letters_are_made_by_a_thread_and_drawn_when_they_are_there():
    field = LetterField({})
    field.request("Hope", "")
    made = []
    assert wait_for(lambda: (one := field.made()) is not None and (made.append(one), len(made) == 4)[1], 10.0)
    assert sorted(cell for cell, _ in made) == [0, 1, 2, 3]
    letters, half_width, half_height = field.lay_out("Hope|H", "", 0.1)
    assert len(letters) == 5
    assert half_width == pytest.approx(0.5 * (read_font("", EM).getlength("Hope") / EM + 0.3), abs=0.02)
    assert half_height > field.cap_height("")
    field.close()


def test_font_that_cannot_be_read_is_told_and_replaced(tmp_path):
    (tmp_path / "bad.ttf").write_bytes(b"no font")
    field = LetterField({"own": str(tmp_path / "bad.ttf")}, blocking=True)
    field.request("A", "own")
    assert field.made() is not None
    assert field.missing == ["the font bad.ttf cannot be read; the usual one is drawn"]


@pytest.mark.long
@pytest.mark.gl
def test_more_letters_than_there_is_room_for_are_left_out(draw):
    many = tuple(replace(Title("M" * 250, size=0.02), at=(0.5, 0.1 * n, 0.0)) for n in range(10))
    seen, _ = draw(*many)
    assert seen.max() > 100
