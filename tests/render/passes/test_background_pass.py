"""Background images and videos: colour, orientation, occlusion by dancers, amount and timing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Background
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.pass_context import PassSetup
from live.render.passes.background_pass import BackgroundPass, video_position
from live.render.renderer import Renderer
from tests.render.media import FRAMES, grey_of, write_image, write_video
from tests.render.test_renderer import SIZE, crowd, read, scene

pytestmark = pytest.mark.gl


@pytest.fixture
def show(gl_context):
    """Draws the crowd in front of backgrounds."""
    kept = []

    def make(*backgrounds, quality=SOFTWARE):
        of = replace(scene(12), backgrounds=backgrounds)
        renderer = Renderer(gl_context, of, size=SIZE, quality=quality, blocking_video=True)
        target = gl_context.simple_framebuffer(SIZE)
        kept.extend((renderer, target))

        def draw(said=None, beat=0.0):
            view = crowd()
            view.beat, view.picture = beat, picture_row(of)
            for name, value in (said or {}).items():
                view.picture[BY_ADDRESS[f"/dance/{name}"].first] = value
            renderer.draw(view, target)
            renderer.draw(view, target)
            return read(target).astype(int)

        return draw

    yield make
    for thing in kept:
        thing.release()


@pytest.mark.parametrize("quality", [SOFTWARE, HARDWARE], ids=["software", "card"])
def test_wall_image_is_upright_and_behind_dancers(show, tmp_path, quality):
    draw = show(Background(str(write_image(tmp_path / "a.png")), width=12.0), quality=quality)
    off, on = draw(), draw({"background/1": 1.0})
    back = -scene(12).stage_size[1] / 2 - 3.0
    white, red = (
        project_points(scene(12).camera, SIZE, [at])[0].astype(int) for at in ((-2, 4.2, back), (4.5, 2.0, back))
    )
    assert on[white[1], white[0]].min() > 150
    assert on[red[1], red[0], 0] > 150 > 3 * on[red[1], red[0], 1]
    chest = project_points(scene(12).camera, SIZE, crowd().joint_position[0, 3])[0].astype(int)
    assert np.abs(on - off)[chest[1], chest[0]].max() < 12
    assert np.abs(on - off)[SIZE[1] // 3].max() > 100


def test_full_picture_background_keeps_file_colours(show, tmp_path):
    colour = (120, 60, 30)
    draw = show(Background(str(write_image(tmp_path / "a.png", colour)), fit="picture", brightness=1.0))
    seen = draw({"background/1": 1.0, "light/stage": 0.0, "pass/vignette": 0.0})
    corner = seen[-3:, -3:].reshape(-1, 3).mean(axis=0)
    assert corner[0] > corner[1] > corner[2] > 5
    assert (seen[2, 2] > 180).all()  # white in the upper left
    half = draw({"background/1": 0.5, "light/stage": 0.0, "pass/vignette": 0.0})[-3:, -3:].reshape(-1, 3).mean(axis=0)
    assert (half < corner).all()
    dark = draw({"background/1": 0.0, "light/stage": 0.0})
    assert dark[-3:, -3:].max() == 0


@pytest.mark.long
def test_video_follows_beat_and_loops(show, tmp_path):
    draw = show(Background(str(write_video(tmp_path / "v.mp4")), fit="picture", beats=10.0, brightness=1.0))
    said = {"background/1": 1.0, "light/stage": 0.0, "pass/vignette": 0.0}
    levels = [draw(said, beat)[2, 2, 0] for beat in (0.3, 2.8, 5.3, 9.8, 12.8)]
    assert levels[0] < levels[1] < levels[2] < levels[3]
    assert levels[4] == levels[1]


def test_missing_background_is_inactive_and_video_problem_is_reported(gl_context, tmp_path):
    file = write_video(tmp_path / "v.mp4")
    of = replace(scene(1), backgrounds=(Background(""), Background(str(file), fit="picture", brightness=1.0)))
    making = PassSetup(gl_context, of, SOFTWARE, SIZE)
    one = BackgroundPass(making)
    row = picture_row(of)
    moment = SimpleNamespace(parameter=lambda place: float(row[place]))
    row[BY_ADDRESS["/dance/background/1"].first] = 1.0
    assert not one.active(moment)
    row[BY_ADDRESS["/dance/background/2"].first] = 1.0
    assert one.active(moment)
    assert one.problems == []
    next(source for source in one._sources if source is not None).video.problem = "cut off"
    assert one.problems == ["background v.mp4: cut off"]
    one.release()


def test_video_position_follows_beat_or_time():
    view = crowd()
    view.beat, view.time = 18.0, 7.5
    assert video_position(view, 16.0, 4.0) == pytest.approx(0.5)
    assert video_position(view, None, 4.0) == pytest.approx(3.5)
    assert grey_of(FRAMES - 1) < 255
