"""Marked corners of the real floor: the camera follows at once, and the venue file keeps them."""

import tomllib
from types import SimpleNamespace

import numpy as np
import pytest

from live.app.output_config import DEFAULT_CORNERS, FloorCorners, VenueWriter, outputs_of, visible_corners
from live.base.errors import PersonError
from live.base.picture_parameters import camera_from_row
from live.base.stage_snapshot import Camera
from live.render.camera import project_points
from live.render.outputs.output import Output
from live.show.patch.toml_model import parse_model
from live.show.venue.venue import Venue, venue_path
from tests.show.desk.desk_show import DeskSession

AT = 'name = "hall"   # ours\n[projector]\nat = [2.0, 5.0, 12.0]   # with a laser\n'


@pytest.fixture
def save_corners(tmp_path, monkeypatch):
    """Saves corners for a show in a venue with this file text; returns the message, the show, and the new text."""
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))

    def keep(text, corners=None):
        path = venue_path("hall")
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        hands = DeskSession()
        view = hands.show.view()
        hands.show.fill(view, 0.0)
        session = SimpleNamespace(
            venue=parse_model(text, "hall.toml", Venue, "venue"), engine=SimpleNamespace(view=view), show=hands.show,
            clock=SimpleNamespace(now=lambda: 0.0), inbox=SimpleNamespace(put=hands.show.apply),
        )  # fmt: skip
        told = []
        keeping = VenueWriter("hall", told.append)
        floor = FloorCorners(session, keeping, lambda: (1600, 900))
        seen = floor.corners()
        words = floor.save(corners or seen)
        keeping.wait()
        hands.run(ticks=1)
        hands.show.fill(view, hands.show.time)
        return SimpleNamespace(
            words=words, seen=seen, camera=camera_from_row(view.picture), text=path.read_text(), floor=floor
        )

    return keep


def floor_in_picture(camera, stage):
    x, z = 0.5 * stage[0], 0.5 * stage[1]
    return project_points(camera, (1600, 900), [(-x, 0, -z), (x, 0, -z), (x, 0, z), (-x, 0, z)]) / (1600, 900)


def test_camera_follows_corners_at_once_and_file_contains_them(save_corners):
    corners = [(0.22, 0.4), (0.77, 0.36), (0.93, 0.88), (0.04, 0.93)]
    done = save_corners(AT, corners)
    assert done.words == ""
    stage = DeskSession().show.patch.stage
    np.testing.assert_allclose(floor_in_picture(done.camera, (stage.width, stage.depth)), corners, atol=1e-6)
    assert done.camera.eye == pytest.approx((2.0, 5.0, 12.0), abs=1e-6)
    said = tomllib.loads(done.text)["projector"]
    assert said == {"at": [2.0, 5.0, 12.0], "corners": [list(one) for one in corners], "aspect": 1.77778}
    assert "# with a laser" in done.text
    assert done.floor.corners() == tuple(corners)


@pytest.mark.parametrize("text", ['name = "hall"\n', AT.replace("5.0", "0.0")])
def test_unusable_projector_position_is_reported_and_file_is_unchanged(save_corners, text):
    done = save_corners(text)
    assert done.words.startswith("NOT SAVED: ")
    assert done.text == text
    assert done.floor.corners() == done.seen


def test_corners_start_at_visible_floor_or_default():
    camera = Camera()
    np.testing.assert_allclose(visible_corners(camera, (6.0, 5.0), (1600, 900)), floor_in_picture(camera, (6.0, 5.0)))
    assert visible_corners(camera, (14.0, 8.0), (1600, 900)) == DEFAULT_CORNERS
    assert visible_corners(Camera((0.0, 1.0, 1.0), (0.0, 1.0, -5.0)), (10.0, 8.0), (1600, 900)) == DEFAULT_CORNERS
    assert visible_corners(None, (10.0, 8.0), (1600, 900)) == DEFAULT_CORNERS


NODES = """
[[output]]
name = "desk"
[[output]]
name = "left wall"
node = "left"
crop = [0.0, 0.0, 0.6, 1.0]
[[output]]
name = "right wall"
node = "right"
crop = [0.4, 0.0, 0.6, 1.0]
"""


def test_each_machine_opens_only_its_outputs():
    venue = parse_model(f'name = "hall"{NODES}', "hall.toml", Venue, "venue")
    names = {node: [one.name for one in outputs_of(venue, "hall", node)] for node in ("", "left", "right")}
    assert names == {"": ["desk"], "left": ["left wall"], "right": ["right wall"]}
    assert outputs_of(venue, "hall", "right")[0].crop == (0.4, 0.0, 0.6, 1.0)
    with pytest.raises(PersonError, match="no output is drawn by a node 'middle'; nodes: left, right") as error:
        outputs_of(venue, "hall", "middle")
    assert error.value.remedy == 'write node = "middle" below one of its [[output]]'


def test_machine_whose_outputs_are_all_drawn_by_nodes_shows_the_whole_picture():
    only = parse_model('name = "hall"\n[[output]]\nnode = "left"\n', "hall.toml", Venue, "venue")
    assert outputs_of(only, "hall") == (Output(),)
    assert outputs_of(None, None, "left") == (Output(node="left"),)
