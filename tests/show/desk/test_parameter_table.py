"""Tests of parameters and scenes: fades in measures, storing, recalling, manual values and refusals."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.motion_parameters import ARMS, FOOT_LOCK, LARGER, MIRRORED
from live.base.picture_parameters import EYE, TARGET
from live.show.desk.parameter_table import ROWS, check_setting, parse_value
from live.show.patch.patch_search_path import PatchError
from tests.show.desk.desk_show import DESK, DeskSession

LEVEL = "/dance/light/level"


@pytest.fixture
def session():
    return DeskSession().run(4)


def test_fade_is_symmetric_and_exact_at_end(session):
    assert session.say(LEVEL, 0.2, 2)
    values = [session.value(LEVEL)]
    for _ in range(8 * 32):
        session.run(ticks=1)
        values.append(session.value(LEVEL))
    assert values[4 * 32] == pytest.approx(0.6, abs=1e-9)
    steps = -np.diff(values)
    assert (steps >= 0.0).all()
    assert steps == pytest.approx(steps[::-1], abs=1e-9)
    assert values[-1] == 0.2
    assert session.desk.parameters.fading == 0


def test_immediate_light_change_is_smoothed_and_camera_cuts(session):
    session.say(LEVEL, 0.0)
    session.say("/dance/camera", "side")
    assert session.value("/dance/camera/eye") == 11.5
    assert session.value(LEVEL) == 1.0
    session.run(ticks=2)
    assert 0.0 < session.value(LEVEL) < 1.0
    session.run(ticks=3)
    assert session.value(LEVEL) == 0.0


def test_moving_camera_keeps_distance_to_target(session):
    session.say("/dance/camera", "side", 1)
    row = session.desk.parameters.picture
    for _ in range(4 * 32):
        session.run(ticks=1)
        away = row[EYE] - row[TARGET]
        assert np.hypot(away[0], away[2]) == pytest.approx(11.5, abs=1e-6)
    assert row[EYE].tolist() == [11.5, 3.4, 0.0]


def test_scene_fades_only_named_parameters(session):
    before = session.desk.parameters.value.copy()
    session.say("/dance/scene", "low")
    session.run(2)
    assert session.value(LEVEL) == pytest.approx(0.625)
    session.run(2)
    assert session.value(LEVEL) == 0.25
    assert session.value("/dance/motion/larger", "front") == 0.4
    assert session.show.variation.values[0, LARGER.first] == 0.4
    assert session.show.variation.values[1, LARGER.first] == 0.0
    changed = np.flatnonzero(session.desk.parameters.value != before)
    table = session.desk.parameters.table
    named = [LEVEL, "/dance/motion/larger", "/dance/camera/eye", "/dance/light/key/colour"]
    assert set(changed) <= {place for address in named for known in table.find(address) for place in known.numbers}


def test_stored_scene_restores_values_and_fade_targets(session):
    session.say("/dance/light/haze", 0.5, 4)
    session.say("/dance/motion/arms", 0.7, "back")
    session.say("/dance/scene/store", "mine")
    session.run(1)
    session.say("/dance/scene", "start", 0)
    session.run(1)
    assert session.value("/dance/light/haze") == 0.035
    assert session.show.variation.values[1, ARMS.first] == 0.0
    assert session.say("/dance/scene", " MINE ", 0)
    session.run(1)
    assert session.value("/dance/light/haze") == 0.5
    assert session.show.variation.values[1, ARMS.first] == 0.7


def test_manual_change_removes_value_from_fade(session):
    session.say("/dance/scene", "low", 2)
    session.run(2)
    session.say("/dance/motion/larger", -0.3, "front")
    session.run(8)
    assert session.show.variation.values[0, LARGER.first] == -0.3
    assert session.value(LEVEL) == 0.25


def test_switches_change_at_fade_start():
    scene = (
        '[[scene]]\nname = "x"\nset = {"/dance/motion/foot_lock" = false, "/dance/motion/mirror" = 1}\nmeasures = 4\n'
    )
    session = DeskSession(scene).run(1)
    session.say("/dance/scene", "x")
    assert session.show.variation.values[:2, [FOOT_LOCK.first, MIRRORED.first]].tolist() == [[0.0, 1.0]] * 2


def test_each_refusal_is_counted_and_named(session):
    for call in (("/dance/scene", "nope"), ("/dance/look", "nope"), ("/dance/camera", "nope"),
                 ("/dance/scene/store", "start"), ("/dance/group/colour", 1, 0, 0, "nobody")):  # fmt: skip
        count = session.show.refusals.count
        assert not session.say(*call)
        assert session.show.refusals.count == count + 1
        assert call[-1] in session.words


def test_unused_desk_adds_nothing_to_state_hash(session):
    plain = DeskSession("[look]\nfollow_score = 0\n[[view]]\nname = 'x'\n")
    assert plain.desk.hashed() == ()
    before = session.show.state_hash()
    session.say(LEVEL, 1.5)
    session.run(ticks=1)
    assert session.desk.hashed() != ()
    assert session.show.state_hash() != before


def test_each_address_reports_expected_values():
    for address in ROWS:
        with pytest.raises(PersonError, match="expected"):
            parse_value(address, 1e9)
        with pytest.raises(PersonError):
            check_setting(address, "words")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('set = {"/dance/light/levle" = 1}', "has no value that can be set"),
        ('set = {"/dance/light/level" = 3}', "expected 0 to 2"),
        ('set = {"/dance/light/level" = [1, 1, 1]}', "expected 0 to 2"),
        ('set = {"/dance/light/floor" = 1}', "3 numbers, each 0 to 1"),
        ('set = {"/dance/light/level front" = 1}', "belong to no group"),
        ('set = {"/dance/motion/larger nobody" = 0.1}', "no dancer is called 'nobody'"),
        ('set = {"/dance/motion/larger" = 2}', "expected -0.7 to 0.5"),
        ('set = {"/dance/camera" = "nowhere"}', "nothing is called 'nowhere'; there are: around, front"),
        ('set = {"/dance/look" = 1}', "the name of a look expected"),
        ("measures = -1", "greater than or equal to 0"),
    ],
)
def test_invalid_scene_is_refused_with_line(line, words):
    with pytest.raises(PatchError) as error:
        DeskSession(f'[[scene]]\nname = "x"\n{line}\n')
    assert words in str(error.value)
    assert "test.toml, line 2" in str(error.value)


def test_duplicate_looks_and_zero_light_direction_are_refused():
    with pytest.raises(PatchError, match="two looks are called"):
        DeskSession('[[looks]]\nname = "a"\n[[looks]]\nname = "A"\n')
    with pytest.raises(PatchError, match="the light goes nowhere"):
        DeskSession('[[looks]]\nname = "a"\nkey_direction = [0, 0, 0]\n')
    assert "low" in DeskSession(DESK).desk.scenes.names
