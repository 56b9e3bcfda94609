"""Worlds at the desk: their defaults where the patch says nothing, and cross-fades to them by name."""

import numpy as np
import pytest

from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import BY_ADDRESS, GROUP_PARAMETERS, WORLD_PREFIX, group_parameter
from live.render.uniforms import world_shares
from live.show.desk.parameter_table import parse_value
from live.show.desk.scenes import start_row
from live.show.desk.worlds import BY_NAME, WORLD_PARAMETERS, WORLDS, is_drawing_style, world_values
from live.show.patch.patch_search_path import PatchError
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DeskSession
from tests.show.made_show import made_show


def look(text):
    return f"\n[look]\n{text}\n"


def test_every_world_has_a_row_of_valid_defaults():
    assert tuple(world.name for world in WORLDS) == WORLD_NAMES
    for world in WORLDS:
        values = world_values(world.name)
        assert tuple(values) == WORLD_PARAMETERS
        for address, value in values.items():
            numbers, row = parse_value(address, value), (GROUP_PARAMETERS | BY_ADDRESS)[address]
            assert all(row.low <= number <= row.high for number in numbers), address


@mostly_long("name", WORLD_NAMES, quick=[2, 3, 4])
def test_show_that_begins_in_a_world_equals_one_that_has_faded_to_it(name):
    begun, faded = DeskSession(look(f'world = "{name}"')), DeskSession()
    assert faded.say("/dance/world", name.upper(), 1)
    faded.run(beats=4, ticks=1)
    for row in (begun.desk.parameters.picture, faded.desk.parameters.picture):
        assert world_shares(row)[WORLD_NAMES.index(name)] == 1.0
    differ = np.flatnonzero(begun.desk.parameters.picture != faded.desk.parameters.picture)
    groups = len(begun.show.patch.group)
    unused = {  # groups that the patch does not have keep their start values
        place
        for address in GROUP_PARAMETERS
        for group in range(groups, 64)
        for place in range(*group_parameter(address, group).row_slice.indices(10**6)[:2])
    }
    assert set(differ.tolist()) <= unused


def test_own_look_and_own_drawing_stay_as_the_patch_says():
    own = 'world = "constellation"\nrim = 2.5\n[picture.set]\n"/dance/pass/mirror" = 0.9'
    patch = made_show(look(own)).patch
    row = start_row(patch)
    assert row[BY_ADDRESS["/dance/light/rim"].first] == 2.5
    assert row[BY_ADDRESS["/dance/pass/mirror"].first] == 0.9
    assert row[BY_ADDRESS["/dance/light/key"].first] == BY_NAME["constellation"].values["/dance/light/key"]
    assert row[group_parameter("/dance/draw/solid", 0).first] == 0.0


def test_own_look_is_said_of_the_world_in_which_the_show_begins():
    session = DeskSession(look("rim = 2.5"))
    session.say("/dance/world", "dusk", 0)
    session.run(beats=1)
    assert session.value("/dance/light/rim") == BY_NAME["dusk"].values["/dance/light/rim"]
    session.say("/dance/world", "haze", 0)
    session.run(beats=1)
    assert session.value("/dance/light/rim") == 2.5
    assert session.value("/dance/light/beams") == BY_NAME["haze"].values["/dance/light/beams"]


def test_drawing_of_a_group_that_says_its_own_is_kept():
    session = DeskSession("\n[group.draw]\nsolid = 0.7\n")  # of the last group of the patch
    session.say("/dance/world", "constellation", 0)
    session.run(beats=1)
    assert session.value("/dance/draw/solid", "front") == 0.0
    assert session.value("/dance/draw/solid", "back") == 0.7
    assert session.value("/dance/draw/particles", "back") > 0.0


def test_cross_fade_takes_its_measures_and_shares_always_sum_to_one():
    session = DeskSession(look('world = "studio"'))
    session.say("/dance/world", "water", 2)
    seen = []
    for _ in range(8 * 32 + 2):
        session.run(ticks=1)
        seen.append(world_shares(session.desk.parameters.picture))
    shares = np.array(seen)
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-12)
    water = shares[:, WORLD_NAMES.index("water")]
    assert np.all(np.diff(water) >= 0.0)
    assert np.diff(water).max() < 1.6 / (8 * 32)  # the eased fade's fastest tick
    assert water[4 * 32] == pytest.approx(0.5, abs=0.02)
    assert water[-1] == 1.0


def test_shares_of_any_amounts():
    row = start_row(made_show().patch)
    assert world_shares(row).tolist() == [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    rng = np.random.default_rng(4)
    places = [BY_ADDRESS[WORLD_PREFIX + name].first for name in WORLD_NAMES]
    for _ in range(200):
        row[places] = rng.uniform(0.0, 1.0, 6) * (rng.random(6) < 0.5)
        shares = world_shares(row)
        assert shares.sum() == pytest.approx(1.0)
        assert shares.min() >= 0.0
        if row[places].sum() < 1.0:
            np.testing.assert_allclose(shares[1:], row[places][1:])  # haze fills what is left


def test_scene_look_and_undo_know_worlds():
    session = DeskSession(
        '\n[[scene]]\nname = "sea"\nmeasures = 0\n[scene.set]\n"/dance/world" = "water"\n"/dance/light/key" = 0.2\n'
        '[[looks]]\nname = "evening"\nworld = "dusk"\nkey = 0.4\nmeasures = 0\n'
    )
    session.say("/dance/scene", "sea")
    session.run(beats=1)
    assert (session.value("/dance/world/water"), session.value("/dance/light/key")) == (1.0, 0.2)
    session.say("/dance/look", "evening")
    session.run(beats=1)
    assert (session.value("/dance/world/water"), session.value("/dance/world/dusk")) == (0.0, 1.0)
    assert session.value("/dance/light/key") == 0.4
    session.say("/dance/look", "start")
    session.run(beats=5)
    assert session.value("/dance/world/dusk") == 0.0
    session.say("/dance/undo")
    session.run(beats=1)
    assert session.value("/dance/world/dusk") == 1.0


def test_unknown_world_is_refused_with_the_names():
    session = DeskSession()
    assert not session.say("/dance/world", "ocean", 0)
    assert "ocean" in session.words
    assert "constellation" in session.words
    with pytest.raises(PatchError, match="world"):
        made_show(look('world = "ocean"'))
    with pytest.raises(PatchError, match="ocean"):
        made_show('\n[[scene]]\nname = "sea"\n[scene.set]\n"/dance/world" = "ocean"\n')


def test_each_world_leaves_room_for_every_style():
    for world in WORLDS:
        assert all(not is_drawing_style(key) or key in GROUP_PARAMETERS for key in world.values)


def test_gobo_goes_on_turning_from_where_it_is_when_its_speed_changes():
    session = DeskSession(look("gobo_leaves = 1.0"))
    view, angles = session.show.view(), []
    for turn in (0.5, -1.0, -1.0):
        session.say("/dance/light/gobo/turn", turn)
        session.run(beats=1)
        session.show.fill(view, session.show.time)
        angles.append(view.gobo_turns)
    passed = np.remainder(np.diff(angles) + 0.5, 1.0) - 0.5
    np.testing.assert_allclose(passed, [-0.25, -0.25], atol=0.02)  # a beat is a quarter of a measure
    session.show.fill(view, session.show.time + 1 / 128)
    assert angles[-1] - 0.01 < view.gobo_turns < angles[-1]  # between two ticks, too
