"""Tests of the picture passes: effect, amount, unchanged picture at 0, and order in the patch."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.custom_pass import PASSES
from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Camera
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.poses import ARMS_DOWN, LUNGE, REACH, stage_view
from tests.render.test_renderer import read, scene

pytestmark = pytest.mark.gl
SIZE = (256, 144)
CAMERA = Camera(eye=(0.0, 1.6, 5.5), target=(0.0, 0.9, 0.0), field_of_view_deg=40.0)
SCENE = scene(3, CAMERA)
GREY = np.array([0.2126, 0.7152, 0.0722])


def row_with(**said):
    row = picture_row(SCENE)
    for name, value in said.items():
        row[BY_ADDRESS["/dance/pass/" + name.replace("__", "/")].row_slice] = value
    return row


def three_dancers(shift=0.0):
    return stage_view(
        [
            (LUNGE, (-1.3 + shift, 0.0), 20.0, 0),
            (ARMS_DOWN, (0.0 + shift, 0.3), 0.0, 1),
            (REACH, (1.3 + shift, 0.0), 0.0, 2),
        ]
    )


@pytest.fixture(scope="module")
def draw_moments(headless_context):
    """One cached renderer per quality and order of passes, for all tests of this file."""
    kept, target = {}, None

    def drawn(*moments, quality=SOFTWARE, passes=PASSES):
        """The picture of the last moment (view, row, beat), after a dark one that clears the history."""
        nonlocal target
        with headless_context:
            key = quality, passes
            if key not in kept:
                kept[key] = Renderer(headless_context, replace(SCENE, passes=passes), size=SIZE, quality=quality)
            target = target or headless_context.simple_framebuffer(SIZE)
            dark = three_dancers()
            dark.brightness = 0.0
            kept[key].draw(dark, target)
            for view, row, beat in moments:
                view.picture, view.beat = row, beat
                kept[key].draw(view, target)
            return read(target)

    yield drawn
    with headless_context:
        for one in kept.values():
            one.release()


@pytest.fixture
def draw_once(draw_moments, gl_context):
    def drawn(quality=SOFTWARE, passes=PASSES, **said):
        return draw_moments((three_dancers(), row_with(**said), 0.0), quality=quality, passes=passes)

    return drawn


TIERS = mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])


@TIERS
def test_ink_lies_on_dancer_outlines(draw_once, quality):
    inked = draw_once(quality, ink=1.0, ink__colour=(0.0, 1.0, 0.0)).astype(int)
    green = (inked[..., 1] > 120) & (inked[..., 0] < 60) & (inked[..., 2] < 60)
    assert 0.01 < green.mean() < 0.10
    chest = project_points(CAMERA, SIZE, three_dancers().joint_position[1, [3]])[0].astype(int)
    assert not green[chest[1], chest[0]]  # no line in the middle of a body
    # every row through the standing dancer's hips meets a line on either side
    hips = project_points(CAMERA, SIZE, three_dancers().joint_position[1, [0]])[0].astype(int)
    across = green[hips[1], hips[0] - 25 : hips[0] + 25]
    assert across[:25].any()
    assert across[25:].any()
    assert not green[:20].any()


def test_half_ink_lies_between_none_and_full(draw_once):
    none, half, full = (
        draw_once(ink=amount, ink__colour=(0.0, 1.0, 0.0)).astype(int)[..., 1].sum() for amount in (0, 0.5, 1)
    )
    assert none < half < full


@TIERS
def test_passes_with_amount_of_0_leave_picture_unchanged(draw_once, quality):
    plain = draw_once(quality)
    assert np.array_equal(draw_once(quality, trails=0.0, ink=0.0, grade=1.0), plain)
    assert np.array_equal(draw_once(quality, grade=0.0, grade__gain=(0.1, 0.1, 0.1)), plain)


def test_half_float_path_matches_direct_path(draw_once):
    """A nearly neutral grade takes the half-float path: switching it on must not be visible."""
    plain, soft = draw_once().astype(int), draw_once(grade__gain=(1.0001, 1.0, 1.0)).astype(int)
    assert not np.array_equal(plain, soft)
    assert np.abs(plain - soft).mean() < 0.6
    assert (np.abs(plain - soft).max(axis=2) > 20).mean() < 0.005  # edges are softened a little otherwise


@pytest.mark.long
def test_grade_parameters_change_picture_as_named(draw_once):
    plain = draw_once().astype(float)
    warm, cold = draw_once(grade__temperature=0.6).astype(float), draw_once(grade__temperature=-0.6).astype(float)
    assert warm[..., 0].sum() / warm[..., 2].sum() > 1.2 * plain[..., 0].sum() / plain[..., 2].sum()
    assert cold[..., 0].sum() / cold[..., 2].sum() < 0.85 * plain[..., 0].sum() / plain[..., 2].sum()
    assert (warm @ GREY).mean() == pytest.approx((plain @ GREY).mean(), rel=0.25)
    assert draw_once(grade__gain=(0.5, 0.5, 0.5)).mean() < 0.7 * plain.mean()
    assert draw_once(grade__gamma=(1.6, 1.6, 1.6)).mean() > 1.3 * plain.mean()
    lifted = draw_once(grade__lift=(0.3, 0.3, 0.3))
    assert lifted.min() > plain.min() + 20
    flat, hard = draw_once(grade__contrast=0.5), draw_once(grade__contrast=1.4)
    assert flat.std() < plain.std() < hard.std()


def test_lifted_picture_still_fades_to_black(draw_moments, gl_context):
    row = row_with(grade__lift=(0.5, 0.5, 0.5), ink=1.0, ink__paper=1.0)
    row[BY_ADDRESS["/dance/light/level"].first] = 0.004
    assert draw_moments((three_dancers(), row, 0.0)).mean() < 12.0


def test_trails_stay_at_past_positions_and_fade_by_beats(draw_moments, gl_context):
    row = row_with(trails=1.0, trails__beats=0.5)
    still = draw_moments((three_dancers(), row, 0.0)).astype(int)
    there = draw_moments((three_dancers(), row, 0.0), (three_dancers(1.3), row, 0.125)).astype(int)
    later = draw_moments(
        (three_dancers(), row, 0.0), (three_dancers(1.3), row, 0.125), (three_dancers(1.3), row, 4.0)
    ).astype(int)
    fresh = draw_moments((three_dancers(1.3), row, 0.0)).astype(int)
    was = project_points(CAMERA, SIZE, three_dancers().joint_position[0, [3]])[0].astype(
        int
    )  # nobody stands there any more
    where = np.s_[was[1] - 2 : was[1] + 3, was[0] - 2 : was[0] + 3]
    assert there[where].mean() > fresh[where].mean() + 8
    assert there[where].mean() < still[where].mean()
    assert later[where].mean() < fresh[where].mean() + 4
    assert (
        np.abs(still - draw_moments((three_dancers(), row_with(), 0.0)).astype(int)).mean() < 0.7
    )  # what stands still leaves none


def test_trails_fade_independent_of_frame_rate(draw_moments, gl_context):
    row = row_with(trails=1.0, trails__beats=0.5)
    moved = [(three_dancers(1.3), row, beat) for beat in np.linspace(0.0625, 1.0, 16)]
    often = draw_moments((three_dancers(), row, 0.0), *moved).astype(int)
    rarely = draw_moments((three_dancers(), row, 0.0), *(moved[i] for i in (3, 7, 11, 15))).astype(int)
    assert np.abs(often - rarely).mean() < 0.3


def test_trails_shift_to_trail_colour(draw_moments, gl_context):
    blue = row_with(trails=1.0, trails__beats=0.5, trails__colour=(0.05, 0.1, 1.0))
    plain = row_with(trails=1.0, trails__beats=0.5)
    left = [
        draw_moments((three_dancers(), row, 0.0), (three_dancers(1.3), row, 0.4)).astype(int) for row in (plain, blue)
    ]
    was = project_points(CAMERA, SIZE, three_dancers().joint_position[0, [3]])[0].astype(int)
    assert left[1][was[1], was[0], 0] < left[0][was[1], was[0], 0] - 5


@pytest.mark.long
def test_shadow_and_mirror_disappear_when_off(draw_once):
    plain = draw_once().astype(int)
    lit = draw_once(shadow=0.0).astype(int)
    assert (lit - plain).max() > 8
    assert ((lit - plain) < -2).mean() < 0.002  # but for softened edges
    dull = draw_once(mirror=0.0).astype(int)
    assert (plain - dull).max() > 8
    assert ((plain - dull) < -2).mean() < 0.002
    half = draw_once(mirror=0.25).astype(int)
    assert dull.sum() < half.sum() < plain.sum()
    assert np.array_equal(draw_once(passes=("vignette",)), draw_once(shadow=0.0, mirror=0.0))


@pytest.mark.long
def test_vignette_is_equal_at_any_position_in_order(draw_once):
    at_end, early = draw_once(), draw_once(passes=("shadow", "mirror", "vignette", "grade"))
    assert np.abs(at_end.astype(int) - early).mean() < 0.8
    none = draw_once(vignette=0.0).astype(int)
    assert (none[:20, :20] >= at_end[:20, :20]).all()
    assert none[:20, :20].sum() > at_end[:20, :20].sum()
    assert np.array_equal(draw_once(passes=PASSES[:-1], grade=0.0), none)


def test_bloom_adds_light_by_amount(draw_once):
    """Only on hardware: software quality draws no bloom."""
    none, usual, much = (draw_once(HARDWARE, bloom=amount).astype(int) for amount in (0.0, 1.0, 4.0))
    assert none.sum() < usual.sum() < much.sum()
    assert (usual - none).min() >= -1
    assert np.array_equal(draw_once(bloom=4.0), draw_once(bloom=0.0))


def test_bloom_is_equal_before_other_pass_and_at_end(draw_once):
    alone, before = draw_once(HARDWARE, bloom=3.0), draw_once(HARDWARE, bloom=3.0, grade__gain=(1.0001, 1.0, 1.0))
    assert np.abs(alone.astype(int) - before).mean() < 0.5


def has_detail(picture):
    """Condition against an empty picture: many brightness levels, and some bright pixels."""
    grey = picture @ GREY
    return len(np.unique(grey.round())) > 60 and grey.max() > 120


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("pass_ink", {"ink": 1.0}),
        ("pass_paper", {"ink": 1.0, "ink__paper": 1.0}),
        ("pass_grade", {"grade__temperature": 0.6, "grade__contrast": 1.2, "grade__lift": (0.0, 0.01, 0.03)}),
        ("pass_vignette", {"vignette": 1.5}),
        ("pass_bare", {"shadow": 0.0, "mirror": 0.0, "vignette": 0.0}),
    ],
)
def test_golden_passes(draw_once, golden, name, said):
    golden(draw_once(**said), name, law=has_detail)


def test_golden_bloom(draw_once, golden):
    golden(draw_once(HARDWARE, bloom=4.0), "pass_bloom", law=has_detail)


def test_golden_trails(draw_moments, golden):
    row = row_with(trails=1.0, trails__beats=1.0, trails__colour=(0.3, 0.5, 1.0))
    steps = [(three_dancers(0.06 * step), row, step / 16) for step in range(12)]
    golden(draw_moments(*steps), "pass_trails", law=has_detail)
