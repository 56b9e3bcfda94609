"""How far back a part of a film has to go, by what its pictures remember."""

import math

import pytest

from live.base.custom_pass import CustomShader
from live.base.picture_parameters import (
    BY_ADDRESS,
    CUSTOM_PASS_SLICE,
    PLAN,
    STYLE_ADDRESS_PREFIX,
    group_parameter,
    picture_row,
)
from live.base.stage_snapshot import Camera, Scene
from live.motion.skeleton import JOINT_COUNT
from live.render.film.picture_memory import DRAWN_FRAMES, EASING_MEMORY_S, STILL_FRAMES, PictureMemory, least_reach
from tests.fixtures.mostly_long import mostly_long

FPS, BEATS_PER_S = 30.0, 2.0
SCENE = Scene((8.0, 6.0), Camera(), 3, JOINT_COUNT)
AT = 1200


def reach_of(said=(), *, scene=SCENE, until=AT, off_before=0, frozen=(), first=0, **options):
    """The reach of the frame `until` of a show with these values of the picture from frame `off_before` on."""
    memory, row, plain = PictureMemory(scene, first), picture_row(scene), picture_row(scene)
    plain[CUSTOM_PASS_SLICE] = 0.0  # own passes begin with the show
    for place, value in said:
        row[place] = value
    for frame in range(first, until + 1):
        values = row if frame >= off_before else plain
        memory.add(values, frame / FPS, frame / FPS * BEATS_PER_S, frozen=frame in frozen)
    return memory.reach(until, **options)


def place(name):
    return BY_ADDRESS[f"/dance/{name}"].first


def group(name, part=2):
    return group_parameter(STYLE_ADDRESS_PREFIX + name, part).first


def test_plain_picture_remembers_arms_and_backdrop_only():
    reach = reach_of()
    assert AT - reach.draw == DRAWN_FRAMES
    assert AT - reach.follow == pytest.approx(max(EASING_MEMORY_S * FPS, STILL_FRAMES), abs=4)
    assert AT - reach.follow == least_reach(FPS)
    assert (reach_of(until=20).follow, reach_of(until=1).draw) == (0, 0)


@mostly_long(
    ("said", "beats"),
    [
        ([(group("ribbons"), 0.5)], 9.0),
        ([(group("trails"), 0.5), (group("trails/spacing"), 2.0)], 18.0),
        ([(PLAN, 0.2)], 8.125),
        ([(place("floor/pattern/rings"), 1.0)], 10.5),
        ([(place("world/water"), 0.1)], 10.5),
    ], quick=[1, 3, 4],
)  # fmt: skip
def test_what_passes_show_of_the_last_beats_is_followed(said, beats):
    reach = reach_of(said)
    assert AT - reach.follow == pytest.approx(beats / BEATS_PER_S * FPS, abs=5)
    assert AT - reach.draw == DRAWN_FRAMES
    assert AT - reach_of(said, patience=2.0).follow >= 2 * (AT - reach.follow) - 4


def test_automatic_focus_is_followed_for_twelve_seconds_and_a_set_one_not():
    said = [(place("pass/focus"), 1.0)]
    assert AT - reach_of(said).follow == pytest.approx(12.0 * FPS, abs=5)
    assert reach_of([*said, (place("pass/focus/distance"), 4.0)]) == reach_of()


def test_light_of_trails_is_drawn_until_none_is_left():
    said = [(place("pass/trails"), 0.5), (place("pass/trails/beats"), 1.0)]
    reach = reach_of(said)
    assert AT - reach.draw == pytest.approx(26 * 0.5 / BEATS_PER_S * FPS, abs=2)
    assert reach.follow < reach.draw
    begun = reach_of(said, off_before=AT - 50)  # nothing is left of what was before they were switched on
    assert begun.draw == AT - 51


def test_own_pass_that_reads_its_last_picture_is_drawn_from_where_it_was_switched_on():
    own = CustomShader("echo", "vec4 pass(vec2 at) { return vec4(0.9 * last(at), 1.0); }", ())
    plain = CustomShader("wave", "vec4 pass(vec2 at) { return vec4(light(at), 1.0); }", ())
    amount = [(CUSTOM_PASS_SLICE.start, 1.0)]
    for shader, draw in ((own, 299), (plain, AT - DRAWN_FRAMES)):
        scene = Scene((8.0, 6.0), Camera(), 3, JOINT_COUNT, passes=(shader.name,), custom_passes=(shader,))
        assert reach_of(amount, scene=scene, off_before=300).draw == draw
    assert math.isfinite(reach_of(amount).draw)  # the scene has none


def test_frozen_picture_reaches_back_to_the_last_one_that_moved():
    reach = reach_of(frozen=range(700, AT + 1))
    assert reach.draw == AT - DRAWN_FRAMES
    assert reach.follow < 700 - STILL_FRAMES


def test_memory_that_begins_too_late_says_so():
    assert reach_of(first=AT - 30).follow < AT - 30
    assert reach_of(first=AT - 400).follow > AT - 400
