"""Pictures of the renderer: small, seeded, headless; checked by their pixels."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import moderngl
import numpy as np
import numpy.typing as npt
import pytest

from live.base.element_kinds import ATTRACTOR, REPULSOR, SPREADER
from live.base.picture_parameters import BY_ADDRESS
from live.base.stage_snapshot import Camera, Scene, StageView
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.render.adaptive_quality import HARDWARE, SOFTWARE, Quality, choose_quality
from live.render.camera import project_points
from live.render.headless import is_software
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.poses import ARABESQUE, ARMS_DOWN, LUNGE, PLIE, REACH, STEP, stage_view

pytestmark = pytest.mark.gl
SIZE = (320, 180)
NEAR_CAMERA = Camera(eye=(0.0, 1.6, 5.5), target=(0.0, 0.9, 0.0), field_of_view_deg=40.0)
Picture = npt.NDArray[np.uint8]
Draw = Callable[..., Picture]


def scene(count: int, camera: Camera | None = None) -> Scene:
    return Scene((10.0, 8.0), camera or Camera(), count, JOINT_COUNT)


def read(framebuffer: moderngl.Framebuffer) -> Picture:
    width, height = framebuffer.size
    data = np.frombuffer(framebuffer.read(components=3, alignment=1), np.uint8)
    return np.flipud(data.reshape(height, width, 3)).copy()


@pytest.fixture
def draw(gl_context: moderngl.Context) -> Iterator[Draw]:
    """Draws a view once into a new framebuffer; returns its pixels, (H, W, 3) with row 0 on top."""
    made: list[Renderer] = []

    def once(
        view: StageView, *, size: tuple[int, int] = SIZE, camera: Camera | None = None, quality: Quality = SOFTWARE
    ) -> Picture:
        renderer = Renderer(gl_context, scene(len(view.group), camera), size=size, quality=quality)
        made.append(renderer)
        target = gl_context.simple_framebuffer(size)
        assert gl_context.error  # forget those of moderngl's own making: it provokes one for each framebuffer
        renderer.draw(view, target)
        assert gl_context.error == "GL_NO_ERROR"
        picture = read(target)
        target.release()
        return picture

    yield once
    for renderer in made:
        renderer.release()


def crowd() -> StageView:
    turns = (LUNGE, ARABESQUE, REACH, STEP, PLIE, ARMS_DOWN)
    return stage_view([(turns[i % 6], (i % 4 * 1.4 - 2.1, 1.5 - i // 4 * 1.6), 25.0 * i, i % 3) for i in range(12)])


def standing(group: int = 0) -> StageView:
    return stage_view([(ARMS_DOWN, (0.0, 0.0), 0.0, group)])


def empty() -> StageView:
    return StageView.allocate(0, JOINT_COUNT)


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[], ids=["software", "card"])
def test_dancers_cover_the_pixels_of_their_joints(draw: Draw, quality: Quality) -> None:
    view = stage_view([(LUNGE, (-0.8, 0.0), 20.0, 0), (REACH, (0.8, 0.0), -20.0, 1)])
    with_dancers = draw(view, camera=NEAR_CAMERA, quality=quality).astype(int)
    without = draw(empty(), camera=NEAR_CAMERA, quality=quality).astype(int)
    inner = [SKELETON.index(name) for name in ("hips", "spine", "chest", "head", "leftLowerLeg", "rightLowerLeg")]
    for dancer in range(2):
        pixels = project_points(NEAR_CAMERA, SIZE, view.joint_position[dancer, inner])
        for x, y in pixels.astype(int):
            assert np.abs(with_dancers[y, x] - without[y, x]).max() > 12


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])
def test_stage_is_neither_black_nor_overexposed(draw: Draw, quality: Quality) -> None:
    picture = draw(crowd(), quality=quality)
    assert 8.0 < picture.mean() < 110.0
    assert picture.max() > 120
    assert (picture == 255).all(axis=2).mean() < 0.01


@pytest.mark.long
def test_both_qualities_show_same_stage(draw: Draw) -> None:
    plain, film = draw(crowd(), quality=SOFTWARE).astype(int), draw(crowd(), quality=HARDWARE).astype(int)
    assert np.abs(plain - film).mean() < 3.0


@pytest.mark.long
def test_groups_have_their_colours(draw: Draw) -> None:
    x, y = project_points(NEAR_CAMERA, SIZE, standing().joint_position[0, [SKELETON.index("chest")]])[0].astype(int)
    orange, blue = (draw(standing(group), camera=NEAR_CAMERA)[y, x].astype(int) for group in (0, 1))
    assert orange[0] > orange[2] + 20
    assert blue[2] > blue[0] + 20


@pytest.mark.long
def test_blackout_is_black_and_half_light_is_darker(draw: Draw) -> None:
    view = crowd()
    full = draw(view)
    view.brightness = 0.4
    half = draw(view)
    view.brightness = 0.0
    assert half.mean() < 0.8 * full.mean()
    assert draw(view).max() == 0


@pytest.mark.long
def test_shadows_darken_the_floor_on_the_side_away_from_the_light(draw: Draw) -> None:
    top = Camera(eye=(0.0, 7.0, 0.01), target=(0.0, 0.0, 0.0), field_of_view_deg=50.0)
    lit, shaded = draw(empty(), camera=top).astype(int), draw(standing(), camera=top).astype(int)
    toward = np.array(BY_ADDRESS["/dance/light/key/direction"].start)
    spot = np.array([0.0, 0.0]) + 0.9 * toward[[0, 2]] / -toward[1]  # shadow of the chest
    x, y = project_points(top, SIZE, [[spot[0], 0.0, spot[1]]])[0].astype(int)
    here = np.s_[y - 2 : y + 3, x - 2 : x + 3]
    assert shaded[here].mean() < 0.85 * lit[here].mean()
    x, y = project_points(top, SIZE, [[-spot[0] * 1.5, 0.0, -spot[1] * 1.5]])[0].astype(int)
    there = np.s_[y - 2 : y + 3, x - 2 : x + 3]
    assert shaded[there].mean() == pytest.approx(lit[there].mean(), rel=0.05)


@mostly_long(("kind", "warm"), [(ATTRACTOR, True), (REPULSOR, False), (SPREADER, None)], quick=[])
def test_elements_light_floor_around_their_position(draw: Draw, kind: int, warm: bool | None) -> None:
    view = empty()
    dark = draw(view).astype(int)
    view.element_count = 1
    view.element_kind[0], view.element_position[0], view.element_level[0] = kind, (1.5, 1.0), 1.0
    light = draw(view).astype(int) - dark
    ring = [[1.5 + 0.9 * np.cos(a), 0.0, 1.0 + 0.9 * np.sin(a)] for a in np.linspace(0.0, 6.0, 12)]
    near = np.array([light[y, x] for x, y in project_points(Camera(), SIZE, ring).astype(int)])
    far = light[project_points(Camera(), SIZE, [[-3.0, 0.0, 1.0]])[0].astype(int)[1]][:40]
    assert near.mean() > 4.0
    assert np.abs(far).mean() < 1.0
    if warm is not None:
        assert bool(near[:, 0].mean() > near[:, 2].mean()) is warm
    view.element_level[0] = 0.3
    assert 0.0 < (draw(view).astype(int) - dark).sum() < light.sum()


@pytest.mark.long
def test_attractor_light_pulses_with_beat(draw: Draw) -> None:
    view = empty()
    view.element_count, view.element_level[0] = 1, 1.0
    on_the_beat = draw(view).astype(int)
    view.beat = view.phase = 0.7
    assert np.abs(on_the_beat - draw(view).astype(int)).max() > 5


def test_excess_elements_are_ignored(draw: Draw) -> None:
    view = empty()
    view.element_count = 5000
    view.element_level[:] = 1.0
    assert draw(view).mean() > 5.0


@pytest.mark.long
def test_overlay_draws_bright_text_in_corner_only(draw: Draw) -> None:
    view = crowd()
    plain = draw(view, size=(640, 360)).astype(int)
    view.overlay = ("tempo 120.0", "measure 17")
    written = draw(view, size=(640, 360)).astype(int)
    corner = np.s_[: 360 // 4, : 640 // 3]
    assert written[corner].max() > 200 > plain[corner].max()
    changed = np.abs(written - plain).max(axis=2) > 0
    changed[corner] = False
    assert not changed.any()


@mostly_long("count", [0, 1, 1000], quick=[])
def test_any_number_of_dancers_is_drawn(draw: Draw, count: int) -> None:
    one = standing()
    view = StageView.allocate(count, JOINT_COUNT)
    place = np.stack([np.arange(count) % 40 * 0.25 - 5.0, np.zeros(count), np.arange(count) // 40 * 0.3 - 4.0], axis=1)
    view.joint_position[:] = one.joint_position[0] + place[:, None, :].astype(np.float32)
    view.joint_rotation[:] = one.joint_rotation[0]
    picture, bare = draw(view).astype(int), draw(empty()).astype(int)
    covered = (np.abs(picture - bare).max(axis=2) > 10).mean()
    assert (covered == 0.0) if count == 0 else (covered > 0.002)


@pytest.mark.long
def test_view_with_more_dancers_than_scene_is_drawn(gl_context: moderngl.Context) -> None:
    renderer = Renderer(gl_context, scene(1, NEAR_CAMERA), size=SIZE, quality=SOFTWARE)
    target = gl_context.simple_framebuffer(SIZE)
    renderer.draw(standing(), target)
    alone = read(target).astype(int)
    three = [(ARMS_DOWN, (x, 0.0), 0.0, 0) for x in (0.0, -1.2, 1.2)]
    renderer.draw(stage_view(three), target)
    assert (np.abs(read(target).astype(int) - alone).max(axis=2) > 10).mean() > 0.01
    renderer.release()
    target.release()


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])
def test_same_moment_gives_same_picture(gl_context: moderngl.Context, quality: Quality) -> None:
    renderer = Renderer(gl_context, scene(12), size=SIZE, quality=quality)
    target = gl_context.simple_framebuffer(SIZE)
    view, other = crowd(), standing()
    pictures = []
    for moment in (view, other, view):
        renderer.draw(moment, target)
        pictures.append(read(target))
    assert not np.array_equal(pictures[0], pictures[1])
    if is_software(gl_context):
        np.testing.assert_array_equal(pictures[0], pictures[2])
    renderer.release()
    target.release()


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[], ids=["software", "card"])
def test_warm_up_changes_no_picture(gl_context: moderngl.Context, quality: Quality) -> None:
    films = []
    for warm_up in (False, True):
        renderer = Renderer(gl_context, scene(12), size=SIZE, quality=quality, warm_up=warm_up)
        target = gl_context.simple_framebuffer(SIZE)
        pictures = []
        for beat in (0.0, 0.25, 0.5):
            view = crowd()
            view.beat = beat
            renderer.draw(view, target)
            pictures.append(read(target).astype(int))
        films.append(np.array(pictures))
        renderer.release()
        target.release()
    assert np.abs(films[0] - films[1]).max() <= (0 if is_software(gl_context) else 2)


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[], ids=["software", "card"])
def test_resized_renderer_matches_new_renderer(gl_context: moderngl.Context, draw: Draw, quality: Quality) -> None:
    renderer = Renderer(gl_context, scene(12), size=(200, 200), quality=quality)
    view = crowd()
    small, large = gl_context.simple_framebuffer((200, 200)), gl_context.simple_framebuffer(SIZE)
    renderer.draw(view, small)
    renderer.resize(SIZE)
    assert renderer.size == SIZE
    renderer.draw(view, large)
    difference = np.abs(read(large).astype(int) - draw(view, quality=quality).astype(int))
    assert difference.max() <= (0 if is_software(gl_context) else 2)
    renderer.resize((0, 0))  # a minimised window
    assert renderer.size == (1, 1)
    for thing in (renderer, small, large):
        thing.release()


@pytest.mark.long
def test_near_dancers_get_finer_body(draw: Draw) -> None:
    """The finer body for the nearest only: the near count changes only the far dancer's outline."""
    view = stage_view([(ARMS_DOWN, (-0.7, -1.5), 0.0, 0), (ARMS_DOWN, (0.7, 1.0), 0.0, 0)])
    both, one = (draw(view, quality=replace(SOFTWARE, near_count=count)).astype(int) for count in (2, 1))
    changed = np.abs(both - one).max(axis=2) > 0
    assert changed[:, : SIZE[0] // 2].sum() > 20
    x = int(project_points(Camera(), SIZE, view.joint_position[1, :1])[0, 0])
    assert not changed[: SIZE[1] // 2 + 20, x - 3 : x + 4].any()


def test_other_skeleton_is_refused(gl_context: moderngl.Context) -> None:
    with pytest.raises(ValueError, match="joint_count 18"):
        Renderer(gl_context, replace(scene(1), joint_count=18), size=SIZE)


def test_quality_follows_driver(gl_context: moderngl.Context) -> None:
    found = choose_quality(gl_context, 50)
    if is_software(gl_context):
        assert found == SOFTWARE
    assert found.samples <= gl_context.max_samples


@pytest.mark.parametrize(("quality", "name"), [(SOFTWARE, "stage_plain"), (HARDWARE, "stage_film")])
def test_golden_stage(draw: Draw, golden: Callable[..., None], quality: Quality, name: str) -> None:
    view = crowd()
    view.element_count = 3
    view.element_kind[:3] = (ATTRACTOR, REPULSOR, SPREADER)
    view.element_position[:3] = ((0.0, 2.4), (-3.4, -1.0), (3.2, -1.5))
    view.element_level[:3] = (1.0, 0.8, 0.9)
    view.beat = view.phase = 2.25
    golden(draw(view, quality=quality), name, law=lambda seen: 8.0 < seen.mean() < 110.0 < seen.max())


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[], ids=["software", "card"])
def test_reduced_stage_is_dark_beyond_its_border(draw: Draw, quality: Quality) -> None:
    """An enlarged stage is lighter in the added area; the scene's own size changes nothing."""
    plain = draw(empty(), quality=quality).astype(int)
    view = empty()
    view.stage_size = (10.0, 8.0)
    np.testing.assert_array_equal(draw(view, quality=quality), plain)
    floor = {
        "inside": np.array([[0.0, 0.0, 0.5], [1.2, 0.0, 1.0], [-1.2, 0.0, 0.0]]),
        "left out": np.array([[3.2, 0.0, 0.0], [-3.2, 0.0, 1.0], [0.3, 0.0, 3.2]]),
    }
    at = {name: project_points(Camera(), SIZE, place).astype(int) for name, place in floor.items()}
    view.stage_size = (5.0, 4.0)
    small = draw(view, quality=quality).astype(int)
    view.stage_size = (12.0, 11.0)
    large = draw(view, quality=quality).astype(int)
    for x, y in at["left out"]:
        assert small[y, x].sum() < 0.7 * plain[y, x].sum()
        assert large[y, x].sum() >= plain[y, x].sum()
    for x, y in at["inside"]:
        assert small[y, x].sum() > 0.6 * plain[y, x].sum()
