"""Tests of side and back light, beams, follow spots, gradient, and light driven by energy and beat."""

import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.test_renderer import SIZE, crowd, read, scene, standing

pytestmark = pytest.mark.gl
DIM = {"light/key": 0.15, "light/rim": 0.4, "light/ambient": 0.05}


@pytest.fixture
def draw(gl_context):
    """Draws the crowd with picture parameters given by the end of their addresses."""
    target, made = gl_context.simple_framebuffer(SIZE), {}

    def draw(said=None, view=None, quality=SOFTWARE, energy=0.5):
        if quality not in made:
            made[quality] = Renderer(gl_context, scene(12), size=SIZE, quality=quality)
        view = crowd() if view is None else view
        view.picture, view.energy = picture_row(scene(12)), energy
        for name, value in (said or {}).items():
            view.picture[BY_ADDRESS[f"/dance/{name}"].row_slice] = value
        for _ in range(2):  # in the second frame light stands
            made[quality].draw(view, target)
        return read(target).astype(int)

    yield draw
    for thing in (*made.values(), target):
        thing.release()


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[], ids=["software", "card"])
def test_side_light_lights_its_side_in_its_colour(draw, quality):
    view = standing()  # alone and straight: nobody hides a side of her, no limb has sides of its own
    dark, lit = draw(DIM, view, quality), []
    for side, other in (("left", "right"), ("right", "left")):
        colours = {f"light/side/{side}": (1, 0, 0), f"light/side/{other}": (0, 0, 0)}
        more = draw(DIM | {"light/side": 2.0} | colours, view, quality) - dark
        assert (more[..., 1:] > 40).sum() < 8  # red alone, but where edges are smoothed
        gained = np.where(more[..., 0] > 20, more[..., 0], 0)
        assert (gained > 40).sum() > 20
        lit.append((gained.sum(axis=0) * np.arange(SIZE[0])).sum() / gained.sum())
    assert lit[0] + 0.3 < lit[1]


@pytest.mark.long
def test_back_light_reaches_edges_but_not_chest(draw):
    view = crowd()
    more = draw(DIM | {"light/back": 2.0}, view) - draw(DIM, view)
    lit = more.max(axis=2) > 25
    chest = project_points(scene(12).camera, SIZE, view.joint_position[0, 3] + (0.0, 0.0, 0.12))[0].astype(int)
    assert lit.sum() > 50
    assert not lit[chest[1], chest[0]]


@pytest.mark.long
def test_beams_are_visible_in_air_and_sway_with_beat(draw):
    view = crowd()
    plain = draw(DIM, view)
    view.beat = 0.0
    here = draw(DIM | {"light/beams": 2.0}, view)
    view.beat = 2.0
    there = draw(DIM | {"light/beams": 2.0}, view)
    upper = slice(0, SIZE[1] // 3)
    assert (here - plain)[upper].max() > 30
    assert np.abs(here - there)[upper].max() > 10
    view.beat = 64.0
    assert np.array_equal(draw(DIM | {"light/beams": 2.0}, view), here)  # and comes back
    still = DIM | {"light/beams": 2.0, "light/beams/sway": 0.0}
    assert np.abs(draw(still, view)[upper] - plain[upper]).max() > 30


def test_follow_spot_lights_only_followed_dancer(draw):
    view = crowd()
    view.spot[1] = view.joint_position[4, 0, [0, 2]]
    more = (draw(DIM | {"spot/2": 1.0, "spot/2/radius": 0.5}, view) - draw(DIM, view)).sum(axis=2)
    at = project_points(scene(12).camera, SIZE, view.joint_position[:, 3] + (0.0, 0.0, 0.12)).astype(int)
    gained = np.array([more[max(y - 2, 0) : y + 3, max(x - 2, 0) : x + 3].max() for x, y in at])
    away = np.hypot(*(view.joint_position[:, 0, [0, 2]] - view.spot[1]).T)
    assert gained[4] > 100
    assert gained[away > 2.0].max() < 0.4 * gained[4]


@pytest.mark.long
def test_picture_without_stage_light_is_black_except_dancers(draw):
    black = draw({"light/stage": 0.0})
    assert (black.max(axis=2) == 0).mean() > 0.6
    assert black.max() > 100


def test_gradient_colours_wall_only(draw):
    colours = {"background/gradient": 1.0, "background/top": (0, 0, 0.5), "background/bottom": (0.5, 0, 0)}
    more = draw(colours) - draw()
    middle = slice(SIZE[0] // 2 - 10, SIZE[0] // 2 + 10)
    assert more[:6, middle, 2].mean() > more[:6, middle, 0].mean()
    assert more[..., 0].max() > 40
    assert np.abs(more[-3:, middle, 0]).max() < 25  # hardly any of it on the floor in front


@pytest.mark.long
def test_light_follows_energy_and_beat_by_amount(draw):
    means = [draw({"light/energy": 1.0}, energy=energy).mean() for energy in (0.0, 0.5, 1.0)]
    assert means[0] < 0.8 * means[1] < 0.75 * means[2]
    assert means[1] == draw().mean()
    view = crowd()
    view.beat = view.phase = 0.0
    on = {pulse: draw({"light/pulse": pulse}, view).mean() for pulse in (0.0, 1.0)}
    view.beat = 0.9
    off = {pulse: draw({"light/pulse": pulse}, view).mean() for pulse in (0.0, 1.0)}
    assert on[1.0] > 1.3 * off[1.0]
    assert abs(on[0.0] - off[0.0]) < 0.5
