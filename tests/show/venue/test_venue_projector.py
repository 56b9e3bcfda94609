"""`[projector]` of a venue: every show in the hall is drawn from the projector's position."""

import numpy as np
import pytest

from live.app.launch_options import LaunchOptions
from live.base.compression import decompress_text
from live.base.errors import PersonError
from live.base.floor_corners import floor_corners
from live.render.camera import project_points
from live.show.desk.scenes import start_row, view_settings
from live.show.loader import LoadedShow
from live.show.patch.hot_reload import PatchWatch
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch, read_patch
from live.show.patch.toml_model import parse_model
from live.show.venue.venue import Venue
from live.show.venue.venue_output import with_venue_projector
from live.show.view.render_scene import initial_camera
from tests.show.made_show import GRAPH
from tests.show.made_show import PATCH_WITHOUT_CAMERA as PATCH

CORNERS = [[0.21, 0.36], [0.79, 0.35], [0.96, 0.91], [0.05, 0.90]]
HALL = f"""
name = "hall"
[projector]
at = [0.0, 5.2, 14.0]
corners = {CORNERS}
"""
OTHER = "[projector]\nat = [1, 4, 9]\ncorners = [[0.3, 0.4], [0.7, 0.4], [0.9, 0.8], [0.1, 0.8]]\n"
STAGE = "[stage]\nwidth = 10\ndepth = 8\n"
CAMERA = '[camera]\neye = [0.0, 3.0, 12.0]\nfollow = "*"\n'


def hall(text: str = HALL) -> Venue:
    return parse_model(text, "hall.toml", Venue, "venue")


def patch(more: str = "") -> Patch:
    return parse_patch(PATCH + STAGE + more, "test.toml")


def projected_floor(camera):
    corners = [(x, 0.0, z) for x, z in floor_corners(10.0, 8.0)]
    return project_points(camera, (1600, 900), corners) / (1600, 900)


@pytest.mark.parametrize("more", ["", CAMERA, OTHER])
def test_venue_projector_overrides_the_camera_of_the_show(more):
    played = with_venue_projector(patch(more), hall().projector)
    np.testing.assert_allclose(projected_floor(initial_camera(played)), CORNERS, atol=1e-9)
    assert start_row(played) is not None
    assert not played.camera.follow
    assert "projector" in view_settings(played)
    assert Patch.model_validate(played.to_json_values()) == played  # as the journal has it
    assert initial_camera(Patch.model_validate(played.to_json_values())) == initial_camera(played)


def test_projector_can_be_a_view_beside_show_camera():
    played = with_venue_projector(patch(CAMERA), hall(HALL + "begins = false\n").projector)
    assert initial_camera(played).eye == (0.0, 3.0, 12.0)
    assert played.camera.follow == "*"
    assert "projector" in view_settings(played)


def test_venue_without_projector_keeps_the_patch():
    plain = patch(CAMERA)
    assert with_venue_projector(plain, hall('name = "hall"').projector) is plain


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("[0.79, 0.35]", "[0.21, 0.36]"), "projector.corners: "),
        (("[0.79, 0.35], [0.96, 0.91]", "[0.96, 0.91], [0.79, 0.35]"), "corners' lines cross"),
        (("5.2", "0.0"), "lies on the floor"),
        (("corners", "corner"), "corner"),
    ],
)
def test_invalid_projector_is_refused_before_the_show(change, words):
    with pytest.raises(PersonError, match=words):
        with_venue_projector(patch(), hall(HALL.replace(*change)).projector)


def test_edited_patch_keeps_the_venue_projector(tmp_path):
    file = tmp_path / "show.toml"
    file.write_text(PATCH + STAGE + CAMERA)
    loaded = LoadedShow(file, read_patch(file), GRAPH).with_projector(hall().projector)
    posted = []
    watch = PatchWatch(loaded, loaded.start(), post=posted.append, now=lambda: 0.0)
    file.write_text(PATCH.replace('name = "test"', 'name = "other"') + STAGE + CAMERA)
    assert [watch.poll() for _ in range(2)][-1]
    assert (watch.problem, len(posted)) == ("", 1)
    changed = Patch.model_validate_json(decompress_text(posted[0].patch))
    assert changed.name == "other"
    np.testing.assert_allclose(projected_floor(initial_camera(changed)), CORNERS, atol=1e-9)


def test_venue_option_applies_the_projector(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    (tmp_path / "venues").mkdir()
    (tmp_path / "venues" / "hall.toml").write_text(HALL)
    loaded = LoadedShow(tmp_path / "show.toml", patch(CAMERA), GRAPH)
    monkeypatch.setattr("live.show.loader.load_show", lambda path, **options: loaded)
    played = LaunchOptions(venue="hall").load()
    np.testing.assert_allclose(projected_floor(played.scene().camera), CORNERS, atol=1e-9)
    assert LaunchOptions().load() is loaded
