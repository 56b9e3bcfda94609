"""Costumes: what is cloth, skin or shoe at places of the body, seen in pictures of a standing dancer."""

import numpy as np
import pytest

from live.base.body.appearance import COSTUME, COSTUMES, SHOES, SHOES_WORN, SKIN
from live.base.picture_parameters import group_parameter, picture_row
from live.base.stage_snapshot import Camera, Scene
from live.motion.skeleton import JOINT_COUNT
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.poses import REST, stage_view

pytestmark = pytest.mark.gl
SIZE = (960, 720)
CAMERA = Camera((0.0, 0.95, 4.0), (0.0, 0.92, 0.0), 28.0)
# places on the front of the body in the rest pose: arms point sideways
PLACES = {
    "breast": (0.05, 1.24, 0.10), "belly": (0.03, 1.06, 0.08), "seat": (0.09, 0.90, 0.08), "thigh": (0.09, 0.74, 0.08),
    "shin": (0.09, 0.40, 0.04), "upper arm": (0.25, 1.38, 0.03), "forearm": (0.54, 1.38, 0.02),
}  # fmt: skip
WORN = {
    "leotard": {"breast": "r", "belly": "r", "thigh": "b", "shin": "b", "upper arm": "s", "forearm": "s"},
    "unitard": {"breast": "r", "belly": "r", "thigh": "r", "shin": "r", "upper arm": "r", "forearm": "r"},
    "trousers": {"breast": "r", "belly": "r", "seat": "b", "shin": "b", "upper arm": "r", "forearm": "s"},
    "dress": {"breast": "r", "belly": "r", "seat": "r", "shin": "s", "upper arm": "s", "forearm": "s"},
    "skirt": {"breast": "b", "belly": "b", "shin": "s", "upper arm": "b", "forearm": "s"},
    "jacket": {"seat": "r", "thigh": "b", "shin": "b", "upper arm": "r", "forearm": "r"},
    "bare": {"breast": "r", "belly": "s", "seat": "r", "shin": "s", "upper arm": "s", "forearm": "s"},
}


def _picture(gl_context, quality, costume, shoes="barefoot", body="dancer"):
    view = stage_view([(REST, (0.0, 0.0), 0.0, 0)])
    view.appearance[0, [COSTUME, SHOES_WORN, SKIN]] = COSTUMES.index(costume), SHOES.index(shoes), 160
    scene = Scene((10.0, 8.0), CAMERA, 1, JOINT_COUNT, group_colours=((0.6, 0.0, 0.0),), bodies=(body,))
    row = view.picture = picture_row(scene)
    row[group_parameter("/dance/draw/accent", 0).row_slice] = 0.0, 0.0, 0.6
    row[group_parameter("/dance/draw/accent/amount", 0).row_slice] = 1.0
    renderer, target = Renderer(gl_context, scene, size=SIZE, quality=quality), gl_context.simple_framebuffer(SIZE)
    renderer.draw(view, target)
    data = np.frombuffer(target.read(components=3, alignment=1), np.uint8)
    renderer.release()
    target.release()
    return np.flipud(data.reshape(SIZE[1], SIZE[0], 3)).astype(np.int64)


def _seen(picture, place):
    """Red cloth, blue cloth or skin, by the colour around a place."""
    x, y = np.rint(project_points(CAMERA, SIZE, [place])[0]).astype(int)
    red, green, blue = picture[y - 1 : y + 2, x - 1 : x + 2].mean(axis=(0, 1))
    return "r" if red > 2.2 * green and red > blue else "b" if blue > 1.7 * red else "s"


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "hardware"])
def test_costume_covers_what_its_cut_says(gl_context, quality) -> None:
    assert set(WORN) == set(COSTUMES)
    for costume, places in WORN.items():
        picture = _picture(gl_context, quality, costume)
        seen = {place: _seen(picture, PLACES[place]) for place in places}
        assert seen == places, costume


@pytest.mark.long
def test_men_wear_no_top_with_bare(gl_context) -> None:
    picture = _picture(gl_context, SOFTWARE, "bare", body="man")
    seen = {place: _seen(picture, PLACES[place]) for place in WORN["bare"]}
    assert seen == WORN["bare"] | {"breast": "s"}


@pytest.mark.long
def test_shoes_differ_on_feet_and_nowhere_else(gl_context) -> None:
    bare = _picture(gl_context, SOFTWARE, "dress")
    top = int(project_points(CAMERA, SIZE, [(0.0, 0.60, 0.0)])[0, 1])
    for shoes in SHOES[1:]:
        worn = _picture(gl_context, SOFTWARE, "dress", shoes)
        assert np.abs(worn[top:] - bare[top:]).max() > 40, shoes
        np.testing.assert_array_equal(worn[: top - 20], bare[: top - 20])
