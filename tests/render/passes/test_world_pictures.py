"""Pictures of the worlds: each unlike the others, fades without a jump, no flash on the beat, gobos and patterns."""

import copy
from itertools import combinations, pairwise

import numpy as np
import pytest

from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import (
    BY_ADDRESS,
    FLOOR_PATTERN_NAMES,
    GOBO_NAMES,
    camera_values,
    group_parameter,
    picture_row,
)
from live.base.stage_snapshot import Camera
from live.motion.skeleton import SKELETON
from live.render.adaptive_quality import HARDWARE, SOFTWARE, quality_steps
from live.render.camera import project_points
from live.render.outputs.photosensitivity import FlashLimiter
from live.render.renderer import Renderer
from live.render.uniforms import world_shares
from live.show.desk.worlds import is_drawing_style, world_values
from tests.fixtures.mostly_long import mostly_long
from tests.render.poses import LUNGE, REACH, STEP, stage_view
from tests.render.test_renderer import crowd, empty, read, scene, standing

pytestmark = pytest.mark.gl
SIZE = (240, 136)
ABOVE = Camera((0.0, 9.0, 0.5), (0.0, 0.0, 0.0), 42.0)


def world_row(name, **said):
    """The picture's row in a world; further values by the ends of their addresses, with __ for /."""
    row = picture_row(scene(12))
    for address, value in world_values(name).items() if name else ():
        if is_drawing_style(address):
            for group in range(16):
                row[group_parameter(address, group).row_slice] = value
        else:
            row[BY_ADDRESS[address].row_slice] = value
    for key, value in said.items():
        row[BY_ADDRESS[f"/dance/{key.replace('__', '/')}"].row_slice] = value
    return row


def seen_from(row, camera):
    for address, value in camera_values(camera).items():
        row[BY_ADDRESS[address].row_slice] = value
    return row


class Pictures:
    """Draws a view with a row, at one quality."""

    def __init__(self, ctx, quality=SOFTWARE, size=SIZE):
        self.target = ctx.simple_framebuffer(size)
        self.renderer = Renderer(ctx, scene(12), size=size, quality=quality, warm_up=False)

    def draw(self, row, view=None, beat=None):
        view = crowd() if view is None else view
        view.picture = row
        if beat is not None:
            view.beat, view.phase, view.time = beat, beat % 4.0, beat * 0.5
        self.renderer.draw(view, self.target)
        return read(self.target).astype(int)

    def still(self, row, view=None, beat=None):
        """The second picture of a row, when nothing moves."""
        self.draw(row, view, beat)
        return self.draw(row, view, beat)

    def release(self):
        self.renderer.release()
        self.target.release()


@pytest.fixture(params=[SOFTWARE, pytest.param(HARDWARE, marks=pytest.mark.long)], ids=["software", "card"])
def pictures(request, gl_context):
    made = Pictures(gl_context, request.param)
    yield made
    made.release()


@pytest.fixture
def plain(gl_context):
    made = Pictures(gl_context)
    yield made
    made.release()


def test_no_world_is_taken_for_another(pictures):
    drawn = {name: pictures.still(world_row(name), crowd(), 1.3) for name in WORLD_NAMES}
    for one, other in combinations(WORLD_NAMES, 2):
        difference = np.abs(drawn[one] - drawn[other])
        assert difference.mean() > 9.0, (one, other)
        assert (difference.max(axis=2) > 25).mean() > 0.10, (one, other)
    assert drawn["studio"].mean() > 150.0
    assert drawn["paper"].mean() > 120.0
    assert drawn["constellation"].mean() < 40.0
    dusk = drawn["dusk"].mean(axis=(0, 1))
    assert dusk[0] > dusk[2] * 1.2  # warm
    water = drawn["water"].mean(axis=(0, 1))
    assert water[2] > water[0]  # cool


@pytest.mark.long
def test_both_qualities_show_the_same_worlds(gl_context):
    software, card = Pictures(gl_context), Pictures(gl_context, HARDWARE)
    for name in WORLD_NAMES:
        row, other = world_row(name, pass__bloom=0.0), world_row(name, pass__bloom=0.0)
        difference = software.still(row, crowd(), 1.3) - card.still(other, crowd(), 1.3)
        assert np.abs(difference).mean() < 7.0, name
    software.release()
    card.release()


@mostly_long(("one", "other"), [*pairwise((*WORLD_NAMES, "haze")), ("paper", "water"), ("dusk", "studio")], quick=[])
def test_cross_fade_has_no_jump(plain, one, other):
    begin, end = world_row(one), world_row(other)
    frames, steps = [], 32
    for step in range(steps + 1):
        share = (step / steps) ** 2 * (3.0 - 2.0 * step / steps)  # as the desk fades
        frames.append(plain.draw((1.0 - share) * begin + share * end, crowd(), 1.3))
    whole = np.abs(frames[-1] - frames[0]).mean()
    apart = [np.abs(b - a).mean() for a, b in pairwise(frames)]
    assert max(apart) < 6.0 * whole / steps + 1.0
    np.testing.assert_allclose(world_shares(0.5 * begin + 0.5 * end).sum(), 1.0)
    halfway = frames[steps // 2]
    assert np.abs(halfway - frames[0]).mean() > 0.1 * whole
    assert np.abs(halfway - frames[-1]).mean() > 0.1 * whole


@pytest.mark.long
@pytest.mark.parametrize("name", [*WORLD_NAMES, "patterns"])
def test_no_world_flashes_on_the_beat(gl_context, name):
    """Four measures at 180 bpm, thirty pictures a second: the limit never dims, nor comes near to it."""
    pictures, limiter = Pictures(gl_context), FlashLimiter(gl_context)
    said = {f"floor__pattern__{one}": 1.0 for one in FLOOR_PATTERN_NAMES} if name == "patterns" else {}
    row = world_row("haze" if name == "patterns" else name, **said)
    texture = gl_context.texture(SIZE, 3)
    target = gl_context.framebuffer([texture])
    for frame in range(160):
        time = frame / 30.0
        pictures.draw(row, crowd(), time * 3.0)
        gl_context.copy_framebuffer(target, pictures.target)
        assert limiter.allowed_light(texture, time) == 1.0
    assert limiter.dimmed_count == 0
    assert all(limit.rises(160 / 30.0) == 0 for limit in limiter.limits)
    for thing in (target, texture, limiter, pictures):
        thing.release()


def test_water_mirrors_dancers_and_their_steps_make_rings(plain):
    row = world_row("water")
    alone = np.abs(plain.still(row, standing(), 1.1) - plain.still(row, empty(), 1.1)).max(axis=2)
    x, feet = project_points(Camera(), SIZE, [[0.0, 0.0, 0.0]])[0].astype(int)
    assert (alone[feet + 3 : feet + 12, x - 6 : x + 7] > 12).mean() > 0.15
    view = stage_view([(STEP, (0.0, 0.0), 0.0, 0)])
    lifted = copy.deepcopy(view)
    lifted.joint_position[..., 1] += 0.3
    plain.draw(row, lifted, 4.0)
    plain.draw(row, view, 4.2)
    around = plain.draw(row, view, 4.9) - plain.draw(world_row("water"), view, 4.9)  # time stands still: the same
    assert np.abs(around).max() == 0
    with_rings = plain.draw(row, view, 4.95)
    without = plain.still(row, view, 90.95)  # a cut has forgotten them
    assert np.abs(with_rings - without)[feet - 6 : feet + 14, x - 25 : x + 26].mean() > 1.0


def test_studio_floor_has_no_corner_and_dancers_cast_soft_shadows(plain):
    row = seen_from(world_row("studio", pass__vignette=0.0), Camera())
    bare = plain.still(row, empty(), 1.1).mean(axis=2)
    assert np.abs(np.diff(bare, axis=0)).max() < 5.0  # no line from above to below
    with_dancer = plain.still(row, standing(), 1.1).mean(axis=2)
    gone = bare - with_dancer
    x, feet = project_points(Camera(), SIZE, [[0.0, 0.0, 0.0]])[0].astype(int)
    assert gone[feet : feet + 6, x - 14 : x + 15].max() > 12


def test_constellation_shows_joints_as_points_of_light(plain):
    row = world_row("constellation")
    view = stage_view([(LUNGE, (-0.8, 0.0), 20.0, 0), (REACH, (0.8, 0.0), -20.0, 1)])
    difference = (plain.still(row, view, 1.1) - plain.still(row, empty(), 1.1)).max(axis=2)
    tips = [SKELETON.index(name) for name in ("head", "leftHand", "rightHand", "hips")]
    for dancer in range(2):
        for x, y in project_points(Camera(), SIZE, view.joint_position[dancer, tips]).astype(int):
            assert difference[y - 1 : y + 2, x - 1 : x + 2].max() > 40
    assert (difference > 60).mean() < 0.05  # no bodies


def test_paper_has_ink_around_dancers_and_grain(plain):
    row = world_row("paper")
    picture = plain.still(row, standing(), 1.1)
    assert (picture.max(axis=2) < 70).mean() > 0.0007
    sheet = plain.still(row, empty(), 1.1)[4:40].mean(axis=2)
    assert 0.3 < np.abs(np.diff(sheet, axis=1)).mean() < 8.0


@mostly_long("name", GOBO_NAMES, quick=[0])
def test_gobo_takes_key_light_from_floor_and_bodies(pictures, name):
    base = {"light__rim": 0.0, "light__beams": 0.0, "pass__mirror": 0.0, "pass__bloom": 0.0}
    said = base | {f"light__gobo__{name}": 1.0, "light__gobo__size": 2.0}
    bare, cut = (pictures.still(seen_from(world_row("", **one), ABOVE), empty(), 1.1) for one in (base, said))
    lost = (bare - cut).mean(axis=2)
    assert lost.max() > 6.0
    assert lost.min() > -3.0
    lit = pictures.still(world_row("", **base), crowd(), 1.1)
    assert np.abs(lit - pictures.still(world_row("", **said), crowd(), 1.1)).max() > 25


@pytest.mark.parametrize("name", FLOOR_PATTERN_NAMES[1:])
def test_floor_pattern_moves_with_the_beat_and_stays_on_the_stage(plain, name):
    said = {f"floor__pattern__{name}": 1.0, "pass__mirror": 0.0, "light__pulse": 0.0}
    bare = plain.still(seen_from(world_row("", pass__mirror=0.0, light__pulse=0.0), ABOVE), empty(), 2.0)
    row = seen_from(world_row("", **said), ABOVE)
    one, other = plain.still(row, empty(), 2.02), plain.still(row, empty(), 2.9)
    assert (one - bare).max() > 5
    assert np.abs(one - other).max() > 3
    off_stage = project_points(ABOVE, SIZE, [[-6.2, 0.0, 0.0]])[0].astype(int)
    assert np.abs(one - bare)[off_stage[1], off_stage[0]].max() <= 2


@pytest.mark.long
def test_gobo_is_turned_as_the_view_says(plain):
    row = seen_from(world_row("", light__gobo__window=1.0, pass__mirror=0.0), ABOVE)
    views = [crowd() for _ in range(3)]
    for view, turns in zip(views, (0.1, 0.1, 0.35), strict=True):
        view.gobo_turns = turns
    first, same, other = (plain.still(row, view, 1.1) for view in views)
    assert np.array_equal(first, same)
    assert np.abs(first - other).max() > 10


@pytest.mark.long
def test_ladder_draws_every_world_at_every_step(gl_context):
    target = gl_context.simple_framebuffer(SIZE)
    renderer = Renderer(gl_context, scene(12), size=SIZE, quality=SOFTWARE, steps=True, warm_up=False)
    assert len(renderer.steps) == len(quality_steps(SOFTWARE))
    for name in WORLD_NAMES:
        pictures = []
        for step in range(len(renderer.steps)):
            renderer.set_step(step)
            view = crowd()
            view.picture, view.beat = world_row(name), 1.3
            for _ in range(2):
                renderer.draw(view, target)
            pictures.append(read(target).astype(int))
        assert np.abs(pictures[-1] - pictures[0]).mean() < 9.0, name
    renderer.release()
    target.release()


def test_passes_of_unseen_worlds_draw_nothing(plain):
    plain.draw(world_row(""), crowd(), 1.0)
    pipeline, moment = plain.renderer._pipeline, plain.renderer._moment
    active = {type(one).__name__ for one in pipeline._scene_passes if one.active(moment)}
    assert active.isdisjoint({"RipplePass", "ConstellationPass"})
    assert not any(type(one).__name__ == "PaperPass" for one in pipeline.chain.active(moment, ()))


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0])
def test_waves_do_not_show_the_other_side_at_an_edge(gl_context, quality):
    down = Camera((0.0, 4.5, 6.0), (0.0, 0.8, 0.0), 60.0)  # the light sky above, dark water below
    pictures = Pictures(gl_context, quality)
    try:
        for beat in (1.0, 2.3):
            seen = pictures.still(seen_from(world_row("water", pass__vignette=0.0), down), empty(), beat)
            assert np.abs(seen[0] - seen[-1]).mean() > 40
            assert np.abs(seen[-1] - seen[-4]).mean() < 8
    finally:
        pictures.release()
