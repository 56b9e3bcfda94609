"""Golden pictures of lights and framing: lamps, beams, spots, backgrounds, the set, bodies and cameras.

One renderer for all of them; each picture has a law against the picture of the same dancers in default light.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from live.base.floor_corners import floor_corners
from live.base.picture_parameters import (
    ALONG,
    BY_ADDRESS,
    EYE,
    FOLLOWING,
    TARGET,
    camera_from_row,
    camera_values,
    picture_row,
)
from live.base.projector_perspective import camera_from_corners
from live.base.set_geometry import SetItem
from live.base.stage_snapshot import Background, Camera
from live.render.adaptive_quality import SOFTWARE
from live.render.camera import project_points
from live.render.renderer import Renderer
from live.show.desk.camera_rig import CameraRig
from live.show.desk.parameters import turn_eye
from live.show.desk.scenes import view_settings
from live.show.patch.patch import Patch
from tests.fixtures.mostly_long import mostly_long
from tests.render.media import write_image, write_video
from tests.render.test_renderer import crowd, read, scene

pytestmark = pytest.mark.gl
SIZE = (192, 108)
BODIES = ("dancer", "slim", "strong", "round", "child")
SET = (
    SetItem("steps", (-2.8, -3.0), (2.4, 1.0, 1.4), colour=(0.2, 0.2, 0.22)),
    SetItem("cylinder", (3.2, -2.6), (0.7, 2.4, 0.7)),
)
NEAR = Camera((0.0, 2.6, 8.5), (0.0, 1.0, 0.0), 34.0)
DIM = {"light/key": 0.15, "light/rim": 0.3, "light/ambient": 0.05}
GREY = np.array([0.2126, 0.7152, 0.0722])
Law = Callable[[np.ndarray, np.ndarray], bool]


@pytest.fixture(scope="module")
def draw_stage(headless_context, tmp_path_factory):
    """Draws the crowd with picture parameters by the end of their addresses; `row`: a row with another camera."""
    folder, kept = tmp_path_factory.mktemp("media"), []
    files = (Background(str(write_image(folder / "a.png")), width=12.0),
             Background(str(write_video(folder / "v.mp4")), fit="picture", beats=10.0, brightness=1.0))  # fmt: skip
    of = replace(scene(12, NEAR), backgrounds=files, items=SET, bodies=tuple(BODIES[n % 5] for n in range(12)))

    def draw(said, row=None):
        with headless_context:
            if not kept:
                kept.append(Renderer(headless_context, of, size=SIZE, quality=SOFTWARE, blocking_video=True))
                kept.append(headless_context.simple_framebuffer(SIZE))
            renderer, target = kept
            view = crowd()
            view.beat = view.phase = 2.25
            view.spot[:2] = view.joint_position[[4, 2], 0][:, [0, 2]]
            view.picture = picture_row(of) if row is None else row
            for name, value in said.items():
                view.picture[BY_ADDRESS["/dance/" + name].row_slice] = value
            for _ in range(2):  # in the second frame light stands
                renderer.draw(view, target)
            return read(target)

    yield draw
    with headless_context:
        for thing in kept:
            thing.release()


def gain(seen, plain):
    """Brightness gain of each pixel, (H, W)."""
    return (seen.astype(int) - plain) @ GREY


def hue(seen, plain, colour):
    """Share of pixels with a brightness gain that is largest in one colour."""
    gained = seen.astype(int) - plain
    return float(((gained.max(axis=2) > 12) & (gained.argmax(axis=2) == colour)).mean())


LAMPS: dict[str, tuple[dict[str, object], Law]] = {
    "key": ({"light/rim": 0.0, "light/ambient": 0.0}, lambda seen, plain: 0.5 < seen.mean() / plain.mean() < 1.0),
    "rim": ({"light/key": 0.0, "light/ambient": 0.0, "light/rim": 2.0},
            lambda seen, plain: seen[..., 2].mean() > seen[..., 0].mean() and gain(seen, plain).min() < -40),
    "side": (DIM | {"light/side": 1.5, "light/side/left": (1, 0.1, 0), "light/side/right": (0, 0.2, 1)},
             lambda seen, plain: hue(seen, plain, 0) > 0.002 and hue(seen, plain, 2) > 0.004),
    "back": (DIM | {"light/back": 2.0, "light/back/colour": (1, 0.6, 0.2)},
             lambda seen, plain: hue(seen, plain, 0) > 0.002 and gain(seen, plain).mean() < 0),
    "ambient": ({"light/key": 0.0, "light/rim": 0.0, "light/ambient": 1.0, "light/ambient/colour": (0.3, 1, 0.3)},
                lambda seen, plain: (seen[..., 1] > 12.0 + seen[..., [0, 2]].max(axis=2)).mean() > 0.01),
    "beams": (DIM | {"light/beams": 2.0, "light/beams/colour": (0.4, 0.6, 1.0)},
              lambda seen, plain: gain(seen, plain)[:30].max() > 20 and hue(seen, plain, 2) > 0.03),
    "spots": (DIM | {"spot/1": 1.0, "spot/2": 1.0, "spot/2/colour": (1, 0.2, 0.2), "spot/1/radius": 0.6},
              lambda seen, plain: seen.max() > 200 and gain(seen, plain).mean() < -5),
    "gradient": ({"background/gradient": 1.0, "background/top": (0, 0, 0.4), "background/bottom": (0.4, 0.1, 0)},
                 lambda seen, plain: hue(seen, plain, 2) > 0.05 and hue(seen, plain, 0) > 0.05),
    "gauze": ({"light/stage": 0.0}, lambda seen, plain: (seen.max(axis=2) == 0).mean() > 0.5 and seen.max() > 100),
    "image": ({"background/1": 1.0}, lambda seen, plain: (seen.min(axis=2) > 120).mean() > 0.03),
    "video": ({"background/2": 0.8}, lambda seen, plain: gain(seen, plain)[:20].min() > 5),
    "no_shadow": ({"pass/shadow": 0.0}, lambda seen, plain: gain(seen, plain).mean() > 0.2),
    "no_mirror": ({"pass/mirror": 0.0}, lambda seen, plain: np.abs(gain(seen, plain)).max() > 5),
}  # fmt: skip
"""Parameters, and the condition on the picture against the default light."""


@mostly_long("lamp", LAMPS, quick=[1, 3, 11, 12])
def test_golden_lights_and_backgrounds(draw_stage, golden, lamp):
    said, law = LAMPS[lamp]
    plain = draw_stage({})
    golden(draw_stage(said), f"light_{lamp}", law=lambda seen: law(seen, plain))


PATCH = Patch.model_validate(
    {"name": "x", "stage": {"width": 10.0, "depth": 8.0},
     "group": [{"name": "a", "dancers": 1, "steps": ["groove"]}]}
)  # fmt: skip
LENS = (2.5, 5.0, 11.0)
FLOOR = [(x, 0.0, z) for x, z in floor_corners(10.0, 8.0)]
THROWN = project_points(Camera(LENS, (0.3, 0.4, 0.0), 38.0), SIZE, FLOOR) / SIZE + (
    (0.012, 0),
    (0, 0),
    (0, 0.015),
    (0, 0),
)
"""Measured floor corners in the projector's picture, with small errors, (4, 2)."""


def camera_row(name):
    """The picture row of a camera view as in the show: `around` after an eighth of its orbit, `follow` aimed at
    a dancer to the side.
    """
    row = picture_row(scene(12))
    for address, value in view_settings(PATCH)["front" if name in ("projector", "follow") else name][0].items():
        row[BY_ADDRESS[address].row_slice] = value
    if name == "around":
        row[EYE] = turn_eye(row[EYE], row[TARGET], math.tau / 8)
    elif name == "follow":
        whom = crowd().joint_position[3, 0, [0, 2]]
        row[[FOLLOWING, ALONG]] = 1.0, 0.5
        rig = CameraRig(SimpleNamespace(held=False), SimpleNamespace(), None, beats=4)
        rig.follower = SimpleNamespace(running=True, position_at=lambda seconds: whom)
        rig.place(row, 0.0, 0.0)
        row[BY_ADDRESS["/dance/camera/field_of_view"].first] = 16.0
    elif name == "projector":
        seen = camera_from_corners(LENS, THROWN, (10.0, 8.0), SIZE[0] / SIZE[1])
        for address, value in camera_values(seen).items():
            row[BY_ADDRESS[address].row_slice] = value
    return row


@pytest.mark.parametrize("name", ["front", "side", "around", "top", "follow", "projector"])
def test_golden_cameras(draw_stage, golden, name):
    """Every dancer within the frame is drawn at the projected position."""
    row, view = camera_row(name), crowd()
    hips = project_points(camera_from_row(row), SIZE, view.joint_position[:, 0])
    within = [(x, y) for x, y in hips.astype(int) if 4 <= x < SIZE[0] - 4 and 4 <= y < SIZE[1] - 4]
    assert len(within) >= (1 if name == "follow" else 12)
    seen = draw_stage({}, row)
    bright = [gain(seen, 0)[y - 3 : y + 4, x - 3 : x + 4].max() for x, y in within]
    golden(seen, f"camera_{name}", law=lambda picture: min(bright) > 25 and picture.std() > 8)


def test_projector_camera_matches_measured_floor_corners():
    """The floor corners are drawn at their measured positions."""
    found = project_points(camera_from_row(camera_row("projector")), SIZE, FLOOR)
    assert found / SIZE == pytest.approx(THROWN, abs=1e-9)
