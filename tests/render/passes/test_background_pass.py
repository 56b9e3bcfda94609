"""Background images and videos: colour, orientation, occlusion by dancers, amount and timing."""

import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Background, StageView
from live.base.system.picture_ring import FrameRing
from live.motion.skeleton import JOINT_COUNT
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.pass_context import PassSetup
from live.render.passes.background_pass import BackgroundPass, plane_of, video_position
from live.render.renderer import Renderer
from tests.control.waiting import wait_for
from tests.fixtures.mostly_long import mostly_long
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


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[1], ids=["software", "card"])
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


@pytest.mark.long
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
    one._sources[0].stream.problem = "cut off"
    assert one.problems == ["background v.mp4: cut off"]
    one.release()


def test_video_position_follows_beat_or_time_or_holds_its_end():
    view = crowd()
    view.beat, view.time = 18.0, 7.5
    age = (3.0, 6.0)
    assert video_position(view, Background("", beats=16.0), 4.0, age) == pytest.approx(0.5)
    assert video_position(view, Background(""), 4.0, age) == pytest.approx(3.5)
    assert video_position(view, Background("", end="hold"), 4.0, age) == pytest.approx(3.0)
    assert video_position(view, Background("", end="hold"), 2.0, age) == pytest.approx(2.0)
    assert video_position(view, Background("", end="hold", beats=8.0), 2.0, age) == pytest.approx(1.5)
    assert grey_of(FRAMES - 1) < 255


def pixel(*at):
    return project_points(scene(12).camera, SIZE, [at])[0].astype(int)


def red_of(picture, at):
    return picture[at[1], at[0], 0] - picture[at[1], at[0], 1]


SOFT = {"pass/grade/contrast": 1.0005}
"""Draws in half floats without any plane, too: edges are smoothed as they are then."""
ON = {"background/1": 1.0} | SOFT
BOTH = mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])


@BOTH
def test_floor_picture_lies_under_feet_and_is_turned_as_a_dancer(show, tmp_path, quality):
    file = str(write_image(tmp_path / "a.png", (250, 5, 5), size=(64, 64)))
    draw = show(Background(file, place="floor", width=4.0, at=(0.0, 2.0), turn_deg=90.0), quality=quality)
    off, on = draw(SOFT), draw(ON)
    chest = project_points(scene(12).camera, SIZE, crowd().joint_position[1, 3])[0].astype(int)
    assert np.abs(on - off)[chest[1], chest[0]].max() < 12
    # the white quarter is at the upper left; a quarter turn to +x brings the upper edge (-z) to -x, left (-x) to +z
    white, red = pixel(-1.5, 0.0, 3.5), pixel(1.5, 0.0, 0.6)
    assert on[white[1], white[0]].min() > 120
    assert red_of(on, red) > 60
    away = pixel(-4.0, 0.0, 2.0)
    assert np.abs(on - off)[away[1], away[0]].max() < 8


@BOTH
def test_front_picture_hides_dancers_behind_it_but_not_those_before_it(show, tmp_path, quality):
    file = str(write_image(tmp_path / "a.png", (250, 5, 5)))
    draw = show(Background(file, place="front", width=30.0, at=(0.0, 0.8)), quality=quality)
    off, on = draw(SOFT), draw(ON)
    joints = crowd().joint_position
    before = [number for number in range(12) if joints[number, :, 2].min() > 0.9]
    behind = [number for number in range(12) if joints[number, :, 2].max() < 0.3]
    assert before
    for number in before:
        chest = project_points(scene(12).camera, SIZE, joints[number, 3])[0].astype(int)
        assert np.abs(on - off)[chest[1], chest[0]].max() < 40  # on a card bright pictures glow over their edges
    covered = 0
    for number in behind:
        chest = project_points(scene(12).camera, SIZE, joints[number, 3])[0].astype(int)
        covered += red_of(on, chest) > red_of(off, chest) + 20 or on[chest[1], chest[0]].min() > 150
    assert covered >= len(behind) - 2  # some are hidden by those before


@pytest.mark.long
@BOTH
def test_added_light_of_a_gauze_is_clear_where_it_is_black(show, tmp_path, quality):
    black, grey = (str(write_image(tmp_path / f"{level}.png", (level,) * 3)) for level in (0, 90))
    for file in (black, grey):
        Image.fromarray(np.full((8, 8, 3), 0 if file == black else 90, np.uint8)).save(file)
    draw = show(
        Background(black, place="front", blend="add", brightness=1.0),
        Background(grey, place="front", blend="add", brightness=1.0), quality=quality,
    )  # fmt: skip
    off, clear, more = draw(SOFT), draw(ON), draw({"background/2": 1.0} | SOFT)
    assert np.abs(clear - off).max() <= 3
    assert np.percentile(more - off, 0.5) > -3  # light is added, nothing is darker but smoothed edges
    assert (more - off).mean() > 8.0


@pytest.mark.long
def test_opaque_and_transparent_parts_of_one_image(show, tmp_path):
    half = np.zeros((8, 8, 4), np.uint8)
    half[:, 4:] = 255, 0, 0, 255
    Image.fromarray(half).save(tmp_path / "half.png")
    draw = show(Background(str(tmp_path / "half.png"), place="front", fit="picture"))
    off, on = draw(SOFT), draw(ON)
    assert np.abs(on - off)[:, : SIZE[0] // 2 - 30].max() < 8
    assert red_of(on, (SIZE[0] - 20, 20)) > 100


def test_planes_have_their_size_and_place():
    corner, across, down = plane_of(Background("", place="floor", width=4.0, turn_deg=0.0), 2.0, (10.0, 8.0))
    assert corner == pytest.approx((-2.0, 0.004, -1.0))
    assert (across, down) == (pytest.approx((4.0, 0.0, 0.0)), pytest.approx((0.0, 0.0, 2.0)))
    corner, across, down = plane_of(Background("", place="front", bottom=1.0), 3.0, (10.0, 8.0))
    assert corner == pytest.approx((-7.5, 6.0, 4.3))
    assert down == pytest.approx((0.0, -5.0, 0.0))


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="memory files are at another place here")
def test_live_input_is_drawn_and_stays_when_it_ends(show, tmp_path):
    name = f"choreographics-plane-{os.getpid()}"
    ring = FrameRing(name, (64, 36))
    draw = show(Background("", fit="picture", input=f"shm:{name}", brightness=1.0))
    ring.write(np.full((36, 64, 3), (240, 20, 20), np.uint8), 0.0)
    said = ON | {"light/stage": 0.0}
    try:
        assert wait_for(lambda: red_of(draw(said), (4, 4)) > 100, 10.0)
    finally:
        ring.close()
    assert red_of(draw(said), (4, 4)) > 100


@pytest.mark.long
def test_pictures_with_alpha_have_no_planes(gl_context, tmp_path):
    of = replace(
        scene(1), backgrounds=(Background(str(write_image(tmp_path / "a.png")), place="front", fit="picture"),)
    )
    renderer = Renderer(gl_context, of, size=SIZE, transparent=True)
    target = gl_context.framebuffer([gl_context.texture(SIZE, 4)])
    view = StageView.allocate(0, JOINT_COUNT)
    view.picture = picture_row(of)
    view.picture[BY_ADDRESS["/dance/background/1"].first] = 1.0
    renderer.draw(view, target)
    assert np.frombuffer(target.read(components=4), np.uint8).max() == 0
    renderer.release()
    target.release()
