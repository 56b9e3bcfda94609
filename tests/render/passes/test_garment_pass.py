"""Garments in pictures: in both tiers, in shadow and mirror, in the styles of their dancers."""

import numpy as np
import pytest

from live.base.body.appearance import COSTUME, COSTUMES
from live.base.picture_parameters import EYE, STYLE_ADDRESS_PREFIX, TARGET, group_parameter, picture_row
from live.base.stage_snapshot import Camera
from live.motion.cloth.garment_catalogue import PATTERN_NAMES, PATTERNS
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.dancers.garment_meshes import grid_mesh
from live.render.renderer import Renderer
from tests.motion.cloth.cloth_bodies import dressed, grid
from tests.render.poses import ARMS_DOWN, stage_view
from tests.render.test_renderer import read, scene

pytestmark = pytest.mark.gl
SIZE = (240, 180)
CAMERA = Camera(eye=(0.0, 1.2, 3.6), target=(0.0, 0.75, 0.0), field_of_view_deg=36.0)
SCENE = scene(1, CAMERA)


def view_of(*garments, heading=0.0, costume="skirt"):
    """One dancer who stands and wears garments of these patterns, as they hang."""
    view = stage_view([(ARMS_DOWN, (0.0, 0.0), heading, 0)])
    view.appearance[:, COSTUME] = COSTUMES.index(costume)
    places, rows, first = [np.zeros((0, 3), np.float32)], [], 0
    for name in garments:
        batch = dressed(name)
        for _ in range(30):
            batch.tick(view.joint_position, view.joint_rotation, np.zeros(3, np.float32), 3, 1 / 64)
        places.append(grid(batch, view.joint_position, view.joint_rotation)[0].reshape(-1, 3))
        rows.append((0, PATTERN_NAMES.index(name), first))
        first += PATTERNS[name].count
    view.cloth_position = np.concatenate(places)
    view.cloth_garment = np.array(rows, np.int32).reshape(-1, 3)
    return view


def styled(**amounts):
    row = picture_row(SCENE)
    for name, value in ({"solid": 0.0} | amounts).items():
        row[group_parameter(STYLE_ADDRESS_PREFIX + name.replace("__", "/"), 0).row_slice] = value
    return row


@pytest.fixture(
    scope="module",
    params=[SOFTWARE, pytest.param(HARDWARE, marks=pytest.mark.long)],
    ids=["software", "hardware"],
)
def draw(request, headless_context):
    with headless_context:
        renderer = Renderer(headless_context, SCENE, size=SIZE, quality=request.param)
        target = headless_context.simple_framebuffer(SIZE)

    def draw_once(view, row=None):
        with headless_context:
            view.picture = picture_row(SCENE) if row is None else row
            for _ in range(2):
                renderer.draw(view, target)
            return read(target).astype(np.int32)

    return draw_once


def changed(one, other):
    return np.abs(one - other).max(axis=2) > 24


def test_skirt_covers_the_legs_and_mirrors_and_shades_the_floor(draw):
    with_it, without = draw(view_of("skirt")), draw(view_of())
    where = changed(with_it, without)
    rows = np.flatnonzero(where.any(axis=1))
    assert 0.02 < where.mean() < 0.4
    assert rows[0] > 0.3 * SIZE[1]  # nothing above the waist
    below = np.abs(with_it - without)[int(0.84 * SIZE[1]) :].max(axis=2)
    assert (below > 5).sum() > 20  # below the feet: mirror and shadow


def test_both_sides_of_a_skirt_are_seen(draw):
    """From in front of the feet, the lining of the back hides what is behind it, and the front what is above."""

    def below(view):
        row = picture_row(SCENE)
        row[EYE], row[TARGET] = (0.0, 0.15, 0.9), (0.0, 1.0, 0.0)
        return draw(view, row)

    assert changed(below(view_of("long skirt")), below(view_of())).mean() > 0.2


@pytest.mark.parametrize("name", PATTERN_NAMES)
def test_every_garment_is_seen(draw, name):
    assert changed(draw(view_of(name, heading=130.0)), draw(view_of(heading=130.0))).sum() > 20


def test_silhouette_has_its_colour(draw):
    row = styled(silhouette=1.0, silhouette__colour=(0.0, 1.0, 0.0))
    picture = draw(view_of("skirt"), row)
    where = changed(picture, draw(view_of(), row)) & (np.arange(SIZE[1]) < 0.72 * SIZE[1])[:, None]
    colour = picture[where].mean(axis=0)
    assert where.sum() > 100
    assert colour[1] > 1.5 * max(colour[0], colour[2])


def test_it_dissolves_with_its_dancer(draw):
    empty, row = draw(view_of(), styled(solid=0.0)), styled(solid=0.0)
    assert changed(draw(view_of("skirt"), row), empty).mean() < 0.002
    half = changed(draw(view_of("skirt"), styled(solid=0.5)), draw(view_of(), styled(solid=0.5))).mean()
    full = changed(draw(view_of("skirt"), styled(solid=1.0)), draw(view_of(), styled(solid=1.0))).mean()
    assert 0.1 * full < half < full


def test_ink_draws_its_outline(draw):
    row = styled(ink=1.0, ink__colour=(1.0, 0.0, 0.0), ink__width=6.0)
    picture, bare = draw(view_of("skirt"), row), draw(view_of(), row)
    red = (picture[..., 0] > 120) & (picture[..., 1] < 90)
    assert (red & changed(picture, bare)).sum() > 30


def test_dancer_who_is_not_there_wears_nothing(draw):
    view = view_of("skirt", "long hair")
    view.present[:] = False
    empty = view_of()
    empty.present[:] = False
    assert not changed(draw(view), draw(empty)).any()


def test_number_of_garments_may_change_from_picture_to_picture(draw):
    first = draw(view_of("skirt"))
    draw(view_of("skirt", "long hair", "left ribbon", "right ribbon"))
    assert np.array_equal(draw(view_of("skirt")), first)


@pytest.mark.parametrize(("every_row", "every_column"), [(1.0, 1.0), (2.0, 2.0), (1 / 3, 1 / 3), (1.0, 0.5)])
@pytest.mark.parametrize("name", ["skirt", "long hair"])
def test_grid_has_a_cell_for_each_cell_of_the_cloth(name, every_row, every_column):
    pattern = PATTERNS[name]
    vertices, triangles = grid_mesh(pattern, every_row, every_column)
    along = pattern.columns if pattern.closed else pattern.columns - 1
    assert vertices[:, 0].max() == pattern.rows - 1
    assert vertices[:, 1].max() == along
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    first, second = b - a, c - a
    area = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum()
    assert area == pytest.approx((pattern.rows - 1) * along)


@pytest.mark.long
def test_garments_far_from_their_dancer_are_lit_as_on_a_card(gl_context) -> None:
    """A software renderer lights a rectangle only: cloth that flies beyond the joints lies in it, too."""
    lit = {}
    for quality in (SOFTWARE, HARDWARE):
        view = stage_view([(ARMS_DOWN, (-0.6, 0.0), 0.0, 0)])
        rows, columns = PATTERNS["skirt"].rows, PATTERNS["skirt"].columns
        side, down = np.meshgrid(np.linspace(0.9, 1.5, columns), np.linspace(1.4, 0.9, rows))
        view.cloth_position = np.stack([side, down, np.zeros_like(side)], axis=-1).reshape(-1, 3).astype(np.float32)
        view.cloth_garment = np.array([[0, PATTERN_NAMES.index("skirt"), 0]], np.int32)
        camera = Camera((0.0, 1.2, 4.0), (0.0, 1.0, 0.0), 45.0)
        renderer = Renderer(gl_context, scene(1, camera), size=(320, 180), quality=quality)
        target = gl_context.simple_framebuffer((320, 180))
        renderer.draw(view, target)
        picture = read(target).astype(int)
        lit[quality.samples > 0] = ((picture[..., 0] > picture[..., 2] + 30)[:, 190:]).sum()
        renderer.release()
        target.release()
    assert lit[True] > 200
    assert lit[False] > 0.7 * lit[True]
