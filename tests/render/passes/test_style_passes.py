"""Dancer styles: appearance, separation by group, fading, and no effect when off."""

import numpy as np
import pytest

from live.base.element_kinds import ATTRACTOR
from live.base.picture_parameters import STYLE_ADDRESS_PREFIX, group_parameter, picture_row
from live.base.stage_snapshot import Camera
from live.render.adaptive_quality import SOFTWARE
from live.render.camera import project_points
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.passes.test_element_pass import add_element
from tests.render.poses import ARMS_DOWN, LUNGE, REACH, STEP, stage_view
from tests.render.test_renderer import read, scene

pytestmark = pytest.mark.gl
SIZE = (240, 135)
CAMERA = Camera(eye=(0.0, 1.5, 4.2), target=(0.0, 0.95, 0.0), field_of_view_deg=40.0)
SCENE = scene(3, CAMERA)
GREY = np.array([0.2126, 0.7152, 0.0722])


def row_with(group=None, **said):
    """The picture row of the scene with these styles for one group (or all three); solid is 0 unless given."""
    row = picture_row(SCENE)
    for one in range(3) if group is None else (group,):
        for name, value in ({"solid": 0.0} | said).items():
            row[group_parameter(STYLE_ADDRESS_PREFIX + name.replace("__", "/"), one).row_slice] = value
    return row


def three_dancers(beat=0.0, swing=0.0):
    """Three dancers of three groups; `swing` moves arms and positions."""
    lift = 75.0 * np.sin(1.5 * swing)
    arms = {"leftUpperArm": (0, 50 * np.cos(swing), lift - 5), "rightUpperArm": (0, -40, 10 - lift)}
    view = stage_view(
        [
            (LUNGE | arms, (-1.2 + 0.1 * swing, 0.0), 20.0, 0),
            (STEP | arms, (0.15 * swing, 0.2), 30.0 * swing, 1),
            ((REACH if swing == 0.0 else ARMS_DOWN | arms), (1.2, 0.0), -15.0, 2),
        ]
    )
    view.beat, view.phase = beat, beat % 4
    return view


@pytest.fixture(scope="module")
def draw_last(headless_context):
    """Draws moments (view, row) with one renderer whose history was cleared; returns the last picture."""
    with headless_context:
        renderer = Renderer(headless_context, SCENE, size=SIZE, quality=SOFTWARE)
        target = headless_context.simple_framebuffer(SIZE)

    def draw(*moments):
        with headless_context:
            for view, row in ((three_dancers(), picture_row(SCENE)), *moments):
                view.picture = row
                renderer.draw(view, target)
            return read(target)

    yield draw
    with headless_context:
        renderer.release()
        target.release()


def dance_moments(row, beats=3.1, frames=48):
    """Moments of a movement over a number of beats."""
    return [(three_dancers(beats * k / frames + 0.05, 4.0 * k / frames + 0.01), row) for k in range(frames + 1)]


def luminance(picture):
    return picture @ GREY


def dancer_columns(picture, dancer, half=36):
    """The part of the picture around one dancer [pixels]."""
    middle = int(project_points(CAMERA, SIZE, [[(-1.2, 0.0, 1.2)[dancer], 1.0, 0.0]])[0, 0])
    return picture[:, middle - half : middle + half]


def is_flat_white(picture):
    """A large area of pure white."""
    return 0.02 < (luminance(picture) > 225).mean() < 0.2


def has_thin_lines(picture):
    """White lines without wide areas, and some black."""
    seen = luminance(picture)
    white = seen > 150
    broad = white[1:-1, 1:-1] & white[:-2, 1:-1] & white[2:, 1:-1] & white[1:-1, :-2] & white[1:-1, 2:]
    return white.mean() > 0.005 and broad.mean() < 0.3 * white.mean() and (seen < 10).mean() > 0.02


def has_dots(picture):
    """Many bright dots: pixels brighter than those two pixels to the left and right."""
    seen = luminance(picture)
    peaks = (
        (seen[2:-2, 2:-2] > 70) & (seen[2:-2, 2:-2] > seen[2:-2, 4:] + 15) & (seen[2:-2, 2:-2] > seen[2:-2, :-4] + 15)
    )
    return peaks.sum() > 70


STILL = {
    "silhouette": is_flat_white,
    "ink": has_thin_lines,
    "particles": has_dots,
    "xray": lambda seen: (luminance(seen) > 120).mean() > 0.004,
}


@pytest.mark.parametrize("style", STILL)
def test_golden_styles(draw_last, golden, style):
    golden(draw_last((three_dancers(0.3), row_with(**{style: 1.0}))), f"style_{style}", law=STILL[style], off=0.01)


@mostly_long("style", ["ribbons", "trails"], quick=[])
def test_golden_motion_history_styles(draw_last, golden, style):
    """The same moment with and without its history: light is added, and only outside the dancers."""
    moments = dance_moments(row_with(**{style: 1.0, "solid": 1.0}))
    seen, alone = draw_last(*moments), draw_last(moments[-1])

    def law(picture):
        more = luminance(picture) - luminance(alone)
        return (more > 12).mean() > 0.008 and (more < -60).mean() < 0.01

    golden(seen, f"style_{style}", law=law, off=0.01)


def test_golden_mixed_styles(draw_last, golden):
    row = row_with(0, solid=0.5, emission=0.5) + row_with(1, solid=1.0, ink=1.0) - picture_row(SCENE)
    row += row_with(2, solid=0.3, xray=1.0, particles=0.4) - picture_row(SCENE)
    whole = draw_last((three_dancers(0.3), picture_row(SCENE)))

    def law(picture):
        changed = np.abs(picture.astype(int) - whole).max(axis=2) > 20
        return all(dancer_columns(changed[:, :, None], dancer).mean() > 0.02 for dancer in range(3))

    golden(draw_last((three_dancers(0.3), row)), "style_mixed", law=law, off=0.01)


def test_style_affects_only_its_group(draw_last):
    """The style of the middle dancer leaves the others unchanged, except for the light on them."""
    plain = picture_row(SCENE)
    one, other = (
        draw_last((three_dancers(), row_with(1, **{style: 1.0}))).astype(int) for style in ("silhouette", "particles")
    )
    change = np.abs(other - one).max(axis=2)[:, :, None]
    assert (dancer_columns(change, 1) > 30).mean() > 0.02
    for dancer in (0, 2):
        assert (dancer_columns(change, dancer, 15)[:90] > 6).mean() < 0.01
    before = draw_last((three_dancers(), plain)).astype(int)
    assert (
        np.abs(before - one).mean()
        < np.abs(draw_last((three_dancers(), row_with(silhouette=1.0))).astype(int) - one).mean()
    )


def test_silhouette_has_its_colour_and_fades_in_monotonically(draw_last):
    x, y = project_points(CAMERA, SIZE, three_dancers().joint_position[1, [2]])[0].astype(int)
    steps = [
        draw_last((three_dancers(), row_with(solid=1.0 - share, silhouette=share, silhouette__colour=(0.0, 1.0, 0.0))))[
            y, x
        ]
        for share in (0.0, 0.5, 1.0)
    ]
    green = [int(one[1]) for one in steps]
    assert green[0] < green[1] < green[2]
    assert green[2] > 220
    assert steps[2][0] < 30 > steps[2][2]


def test_dissolved_share_follows_amount(draw_last):
    """The share of body pixels still visible follows the amount."""
    none, whole = (draw_last((three_dancers(), row_with(silhouette=share))) for share in (1e-4, 1.0))
    body = luminance(whole) - luminance(none) > 90
    left = [
        (luminance(draw_last((three_dancers(), row_with(silhouette=share))))[body] - luminance(none)[body] > 60).mean()
        for share in (0.25, 0.5, 0.75)
    ]
    assert left[0] < left[1] < left[2]
    assert 0.02 < left[0] < 0.45
    assert 0.3 < left[1] < 0.75
    assert 0.6 < left[2] < 0.99


def test_particles_depend_only_on_beat(draw_last):
    row = row_with(particles=1.0)
    first, again, later = (draw_last((three_dancers(beat), row)).astype(int) for beat in (1.25, 1.25, 1.75))
    assert np.array_equal(first, again)
    assert (np.abs(first - later).max(axis=2) > 25).mean() > 0.005
    few = draw_last((three_dancers(1.25), row_with(particles=1.0, particles__share=0.1)))
    none = draw_last((three_dancers(1.25), row_with()))
    assert 0.03 < (luminance(few) - luminance(none)).sum() / (luminance(first) - luminance(none)).sum() < 0.3


def test_colours_pulse_with_beat_by_amount(draw_last):
    on, off = ({"solid": 1.0, "pulse": share} for share in (1.0, 0.0))
    x, y = project_points(CAMERA, SIZE, three_dancers().joint_position[1, [2]])[0].astype(int)
    here = np.s_[y - 3 : y + 4, x - 2 : x + 3]
    swing = [
        luminance(draw_last((three_dancers(0.0), row_with(**how)))[here]).mean()
        - luminance(draw_last((three_dancers(0.8), row_with(**how)))[here]).mean()
        for how in (off, on)
    ]
    assert swing[1] > swing[0] + 20


@pytest.mark.long
def test_jump_back_in_time_clears_history(draw_last):
    row = row_with(solid=1.0, ribbons=1.0, trails=1.0)
    moments = dance_moments(row)
    fresh = draw_last((three_dancers(0.01, 1.0), row))
    assert np.array_equal(draw_last(*moments, (three_dancers(0.01, 1.0), row)), fresh)


def test_regions_on_the_floor_leave_the_styles_alone(draw_last):
    """Regions have a uniform block of their own; with the styles' binding it took the bodies away."""
    view = three_dancers()
    add_element(view, ATTRACTOR, ((-2.0, -3.0), (2.0, -3.0), (0.0, -2.5)), closed=True)
    picture = draw_last((view, row_with(silhouette=1.0, silhouette__colour=(1.0, 1.0, 1.0))))
    for dancer in range(3):
        assert is_flat_white(dancer_columns(picture, dancer))
