"""Light of elements on the floor: position against shapely's distances, and direction of motion."""

import colorsys
from collections.abc import Iterator

import moderngl
import numpy as np
import pytest
import shapely

from live.base.element_kinds import (
    ATTRACTOR,
    CROSSING,
    DRAWN,
    EVADE,
    FLOCK,
    FLOW,
    FOLLOW,
    PARTICIPANT,
    PATH,
    PURSUE,
    RADIAL,
    REPULSOR,
    SPREADER,
    UNIFORM,
    VORTEX,
    WANDER,
)
from live.base.stage_snapshot import StageView
from live.motion.skeleton import JOINT_COUNT
from live.render.passes.element_pass import ElementPass
from tests.fixtures.mostly_long import mostly_long
from tests.render.passes.conftest import STAGE, TEXEL, Draw, Floats, FloorLight

pytestmark = pytest.mark.gl
Points = tuple[tuple[float, float], ...]
BENT: Points = ((-3.0, 1.0), (-0.5, -1.0), (0.5, 1.5), (3.0, 1.0))
ARROW: Points = ((-2.5, -1.5), (2.5, -1.5), (2.5, 2.0), (0.0, 0.0), (-2.5, 2.0))


@pytest.fixture
def elements(gl_context: moderngl.Context) -> Iterator[ElementPass]:
    made = ElementPass(gl_context, TEXEL)
    yield made
    made.release()


def add_element(
    view: StageView,
    kind: int,
    points: Points,
    *,
    closed: bool = False,
    radius: float = 0.0,
    strength: float = 1.0,
    flow: int = UNIFORM,
    level: float = 1.0,
) -> StageView:
    place = view.element_count
    used = int((view.element_first + view.element_corners)[:place].max(initial=0))
    corners = (*points, points[0]) if closed else points
    view.element_kind[place], view.element_position[place], view.element_level[place] = kind, points[0], level
    view.element_radius[place], view.element_strength[place], view.element_flow[place] = radius, strength, flow
    view.element_first[place], view.element_corners[place] = used, len(corners) if len(corners) > 1 else 0
    view.element_corner[used : used + len(corners)] = corners
    view.element_count += 1
    return view


def view_of(kind: int, *points: tuple[float, float], beat: float = 0.3, **form: object) -> StageView:
    view = StageView.allocate(0, JOINT_COUNT)
    view.beat = view.phase = beat
    return add_element(view, kind, points, **form)  # type: ignore[arg-type]


def distance(floor: FloorLight, shape: shapely.Geometry) -> Floats:
    away: Floats = shapely.distance(shape, shapely.points(floor.x, floor.z))
    return away


@pytest.mark.parametrize("kind", [ATTRACTOR, REPULSOR])
@pytest.mark.parametrize(("points", "closed"), [(BENT, False), (ARROW, True)])
def test_light_of_lines_and_regions_depends_on_distance_only(
    floor: Draw, elements: ElementPass, kind: int, points: Points, closed: bool
) -> None:
    drawn = floor(elements, view_of(kind, *points, closed=closed))
    line = shapely.LinearRing(points) if closed else shapely.LineString(points)
    d = distance(drawn, line)
    if closed:
        d = np.where(shapely.contains(shapely.Polygon(points), shapely.points(drawn.x, drawn.z)), -d, d)
    light = drawn.brightness
    at, value = np.sort(d.ravel()), light.ravel()[d.ravel().argsort()]
    near = np.abs(at) < 1.1
    steps = np.diff(value[near]) / np.maximum(np.diff(at[near]), 1e-3)
    assert np.abs(steps).max() < 15.0  # one curve: texels of nearly one distance have nearly one light
    assert light[d > 1.4].max() < 1e-3
    warm, cool = drawn.light[..., 0].sum(), drawn.light[..., 2].sum()
    assert warm > 2.0 * cool if kind == ATTRACTOR else cool > 2.0 * warm
    if kind == ATTRACTOR:
        assert light[np.abs(d) < 0.04].min() > 2.5 * light[np.abs(d - 0.5) < 0.04].max()
    if closed:
        assert light[np.abs(d + 0.7) < 0.04].min() > light[np.abs(d - 1.1) < 0.04].max()


@pytest.mark.long
def test_disc_and_wide_line_have_border_at_radius(floor: Draw, elements: ElementPass) -> None:
    for points, shape in (((1.0, 0.5),), shapely.Point(1.0, 0.5)), (BENT, shapely.LineString(BENT)):
        drawn = floor(elements, view_of(ATTRACTOR, *points, radius=0.8))
        d = distance(drawn, shape)
        border = drawn.brightness[np.abs(d - 0.8) < 0.03].min()
        assert border > 1.3 * drawn.brightness[np.abs(d - 0.8) > 0.25].max()
        assert drawn.brightness[d < 0.5].min() > 0.02


@pytest.mark.long
def test_crossing_is_full_line_with_sparks_to_both_sides(floor: Draw, elements: ElementPass) -> None:
    frames = [floor(elements, view_of(CROSSING, (-0.1, 0.5), (0.1, 0.5), beat=b)) for b in np.arange(0.0, 2.0, 0.125)]
    for drawn in frames:
        for x in (-4.5, 0.0, 4.5):
            assert drawn.at(x, 0.5)[:3].sum() > 0.15
        assert drawn.brightness[np.abs(drawn.x) > STAGE[0] / 2 + 1.0].max() == 0.0
    light = np.array([drawn.brightness for drawn in frames])
    across, deep = frames[0].x, frames[0].z
    ways = []
    for lane in range(-5, 5):
        inside = (np.abs(across - (lane + 0.5) * 0.7) < 0.1) & (np.abs(np.abs(deep - 0.5) - 0.8) < 0.5)
        ways.append(np.sign(motion_along(light[:, inside.any(1)][:, :, inside.any(0)], axis=1)))
    assert ways == [1.0, -1.0] * 5 or ways == [-1.0, 1.0] * 5


def motion_along(frames: Floats, axis: int) -> float:
    """Positive if the picture in `frames` (time first) moves along `axis`, negative if it moves against it."""
    # of a moving picture dI/dt = -v dI/dx
    change, slope = np.diff(frames, axis=0), np.gradient(frames, axis=axis)[:-1]
    return -float((change * slope).sum())


@mostly_long("way", [1.0, -1.0], quick=[0])
@mostly_long(
    ("points", "flow", "radius", "field"),
    [
        (((-1.0, 0.0), (1.0, 0.0)), UNIFORM, 0.0, lambda x, z: (1.0 + 0 * x, 0 * z)),
        (((-2.0, -1.0), (2.0, 1.0)), UNIFORM, 0.8, lambda x, z: (2.0 + 0 * x, 1.0 + 0 * z)),
        (((-3.0, 1.0), (0.0, 0.9), (3.0, 1.0)), DRAWN, 0.0, lambda x, z: (1.0 + 0 * x, 0 * z)),
        (((0.0, 0.0),), RADIAL, 0.0, lambda x, z: (x, z)),
        (((0.0, 0.0),), VORTEX, 0.0, lambda x, z: (-z, x)),
    ],
    quick=[1, 2, 3, 4],
    ids=["uniform", "uniform within", "drawn", "radial", "vortex"],
)
def test_flow_light_moves_along_field(
    floor: Draw, elements: ElementPass, points: Points, flow: int, radius: float, field: object, way: float
) -> None:
    frames = [
        floor(elements, view_of(FLOW, *points, flow=flow, radius=radius, strength=way, beat=beat))
        for beat in np.arange(5.0, 6.0, 0.05)
    ]
    light = np.array([drawn.brightness for drawn in frames])
    to_x, to_z = field(frames[0].x, frames[0].z)  # type: ignore[operator]
    slope_z, slope_x = np.gradient(light, axis=(1, 2))
    change = np.diff(light, axis=0)
    carried = -(change * (slope_x * to_x + slope_z * to_z)[:-1]).sum()
    assert carried * way > 0.0
    aside = -(change * (slope_z * to_x - slope_x * to_z)[:-1]).sum()
    assert abs(aside) < 0.3 * abs(carried)


def test_reversed_flow_is_mirror_image(floor: Draw, elements: ElementPass) -> None:
    there = floor(elements, view_of(FLOW, (-1.0, 0.0), (1.0, 0.0))).brightness
    back = floor(elements, view_of(FLOW, (-1.0, 0.0), (1.0, 0.0), strength=-1.0)).brightness
    np.testing.assert_allclose(back, there[:, ::-1], atol=2e-3)


def test_path_is_dashed_and_dashes_move_forward(floor: Draw, elements: ElementPass) -> None:
    points = ((-4.0, 1.0), (0.0, 1.0), (4.0, 1.0))
    frames = np.array([floor(elements, view_of(PATH, *points, beat=b)).brightness for b in np.arange(0.0, 1.0, 0.05)])
    row = floor(elements, view_of(PATH, *points))
    along = row.brightness[np.abs(row.z[:, 0] - 1.0).argmin()]
    dashes = int((np.diff((along > 0.5 * along.max()).astype(int)) == 1).sum())
    assert dashes == pytest.approx(8.0 / 0.55, abs=1.5)
    assert motion_along(frames, axis=2) > 0.0


def test_participant_lights_add_up_within_limit(floor: Draw, elements: ElementPass) -> None:
    one = floor(elements, view_of(PARTICIPANT, (1.0, 1.0)))
    assert one.brightness.max() > 0.2
    assert one.brightness[np.hypot(one.x - 1.0, one.z - 1.0) > 0.9].max() == 0.0
    crowd = view_of(PARTICIPANT, (1.0, 1.0))
    for _ in range(255):
        add_element(crowd, PARTICIPANT, ((1.0, 1.0),))
    many = floor(elements, crowd)
    assert many.brightness.max() > 1.5 * one.brightness.max()
    assert many.light.max() <= 1.0


def test_phone_lights_have_own_hue_and_repelling_lights_are_rings(floor: Draw, elements: ElementPass) -> None:
    hues = np.arange(6) / 6.0
    view = view_of(ATTRACTOR, (-5.0, -3.0))
    view.light_count = 6
    view.light[:6, 0], view.light[:6, 2], view.light[:6, 3] = np.linspace(-4.0, 4.0, 6), hues, 1.0
    seen = floor(elements, view)
    for hue, x in zip(hues, np.linspace(-4.0, 4.0, 6), strict=True):
        colour = np.array(colorsys.hsv_to_rgb(hue, 0.85, 1.0))
        there = seen.at(x, 0.0)[:3]
        np.testing.assert_allclose(there / there.max(), colour / colour.max(), atol=0.05)
    assert seen.at(-5.0, -3.0).max() > 0.1  # beside the elements, not instead of them
    view.light_count, view.light[0] = 1, (0.0, 0.0, 0.3, 1.0, 1.0)
    ring = floor(elements, view)
    away = np.hypot(ring.x, ring.z)
    assert ring.brightness[(away > 0.3) & (away < 0.5)].max() > 5.0 * ring.at(0.0, 0.0).sum()
    view.light_count = 0
    assert floor(elements, view).at(4.0, 0.0).max() == 0.0


@pytest.mark.parametrize("kind", [FOLLOW, PURSUE, EVADE, FLOCK, WANDER])
def test_element_without_position_gives_no_light(floor: Draw, elements: ElementPass, kind: int) -> None:
    assert not floor(elements, view_of(kind, (0.0, 0.0))).light.any()
    assert not floor(elements, view_of(kind, *BENT, radius=1.0)).light.any()


EVERY = (
    (ATTRACTOR, ((0.0, 0.0),), UNIFORM),
    (SPREADER, ((0.0, 0.0),), UNIFORM),
    (ATTRACTOR, BENT, UNIFORM),
    (CROSSING, BENT, UNIFORM),
    (FLOW, BENT, UNIFORM),
    (FLOW, BENT, DRAWN),
    (FLOW, ((0.0, 0.0),), VORTEX),
    (PATH, BENT, UNIFORM),
    (PARTICIPANT, ((0.0, 0.0),), UNIFORM),
)


@pytest.mark.parametrize(("kind", "points", "flow"), EVERY)
def test_light_scales_with_level_and_repeats_after_64_beats(
    floor: Draw, elements: ElementPass, kind: int, points: Points, flow: int
) -> None:
    full, half, none = (floor(elements, view_of(kind, *points, flow=flow, level=level)) for level in (1.0, 0.5, 0.0))
    assert full.brightness.max() > 0.1
    np.testing.assert_allclose(half.light, 0.5 * full.light, atol=1e-6)
    assert not none.light.any()
    assert not full.light[..., 3].any()  # it takes no light away
    later = floor(elements, view_of(kind, *points, flow=flow, beat=0.3 + 640.0))
    np.testing.assert_allclose(later.light, full.light, atol=2e-3)


def test_light_of_several_elements_is_sum_of_each(floor: Draw, elements: ElementPass) -> None:
    """The corners of all elements lie in one array: each element uses only its own."""
    forms: tuple[tuple[int, Points, bool], ...] = (
        (ATTRACTOR, ((-4.0, -3.0), (-4.0, -1.0)), False),
        (REPULSOR, ((3.0, 2.0), (4.5, 2.0), (4.0, 3.5)), True),
        (PATH, ((-4.0, 3.5), (-1.0, 3.5)), False),
        (FLOW, ((3.0, -3.0), (4.5, -2.0)), False),
    )
    together = StageView.allocate(0, JOINT_COUNT)
    apart = np.zeros(())
    together.beat = together.phase = 0.3
    for kind, points, closed in forms:
        add_element(together, kind, points, closed=closed, flow=DRAWN)
        apart = apart + floor(elements, view_of(kind, *points, closed=closed, flow=DRAWN)).light
    np.testing.assert_allclose(floor(elements, together).light, apart, atol=2e-3)
