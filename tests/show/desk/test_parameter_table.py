"""Parameters and scenes: fades in measures, softly, at once; stored, recalled, held; what cannot be is refused."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.picture_parameters import EYE, TARGET
from live.show.desk.parameter_table import addresses, check_setting, parse_value
from live.show.patch.patch_search_path import PatchError
from tests.show.desk.desk_show import DESK, Hands

LEVEL = "/dance/light/level"


@pytest.fixture
def hands():
    return Hands().run(4)


def test_a_fade_is_half_way_at_half_time_even_and_exact_at_its_end(hands):
    assert hands.say(LEVEL, 0.2, 2)
    values = [hands.value(LEVEL)]
    for _ in range(8 * 32):
        hands.run(ticks=1)
        values.append(hands.value(LEVEL))
    assert values[4 * 32] == pytest.approx(0.6, abs=1e-9)
    steps = -np.diff(values)
    assert (steps >= 0.0).all()
    assert steps == pytest.approx(steps[::-1], abs=1e-9)
    assert values[-1] == 0.2
    assert hands.desk.parameters.fading == 0


def test_light_set_at_once_is_soft_and_a_camera_is_cut(hands):
    hands.say(LEVEL, 0.0)
    hands.say("/dance/camera", "side")
    assert hands.value("/dance/camera/eye") == 11.5
    assert hands.value(LEVEL) == 1.0
    hands.run(ticks=2)
    assert 0.0 < hands.value(LEVEL) < 1.0
    hands.run(ticks=3)
    assert hands.value(LEVEL) == 0.0


def test_a_moving_camera_goes_around_what_it_looks_at(hands):
    hands.say("/dance/camera", "side", 1)
    row = hands.desk.parameters.picture
    for _ in range(4 * 32):
        hands.run(ticks=1)
        away = row[EYE] - row[TARGET]
        assert np.hypot(away[0], away[2]) == pytest.approx(11.5, abs=1e-6)
    assert row[EYE].tolist() == [11.5, 3.4, 0.0]


def test_a_scene_fades_all_that_it_names_and_nothing_else(hands):
    before = hands.desk.parameters.value.copy()
    hands.say("/dance/scene", "low")
    hands.run(2)
    assert hands.value(LEVEL) == pytest.approx(0.625)
    hands.run(2)
    assert hands.value(LEVEL) == 0.25
    assert hands.value("/dance/motion/larger", "front") == 0.4
    assert hands.show.variation.settings[0].larger == 0.4
    assert hands.show.variation.settings[1].larger == 0.0
    changed = np.flatnonzero(hands.desk.parameters.value != before)
    table = hands.desk.parameters.table
    named = [LEVEL, "/dance/motion/larger", "/dance/camera/eye", "/dance/light/key/colour"]
    assert set(changed) <= {place for address in named for known in table.find(address) for place in known.numbers}


def test_a_stored_scene_brings_everything_back_also_where_a_fade_was_going(hands):
    hands.say("/dance/light/haze", 0.5, 4)
    hands.say("/dance/motion/arms", 0.7, "back")
    hands.say("/dance/scene/store", "mine")
    hands.run(1)
    hands.say("/dance/scene", "start", 0)
    hands.run(1)
    assert hands.value("/dance/light/haze") == 0.035
    assert hands.show.variation.settings[1].arms == 0.0
    assert hands.say("/dance/scene", " MINE ", 0)
    hands.run(1)
    assert hands.value("/dance/light/haze") == 0.5
    assert hands.show.variation.settings[1].arms == 0.7


def test_a_hand_takes_its_value_out_of_a_fade(hands):
    hands.say("/dance/scene", "low", 2)
    hands.run(2)
    hands.say("/dance/motion/larger", -0.3, "front")
    hands.run(8)
    assert hands.show.variation.settings[0].larger == -0.3
    assert hands.value(LEVEL) == 0.25


def test_switches_change_when_the_fade_begins():
    scene = (
        '[[scene]]\nname = "x"\nset = {"/dance/motion/foot_lock" = false, "/dance/motion/mirror" = 1}\nmeasures = 4\n'
    )
    hands = Hands(scene).run(1)
    hands.say("/dance/scene", "x")
    assert [(variety.lock, variety.mirror) for variety in hands.show.variation.settings] == [(0.0, 1.0)] * 2


def test_nothing_is_refused_silently(hands):
    for call in (("/dance/scene", "nope"), ("/dance/look", "nope"), ("/dance/camera", "nope"),
                 ("/dance/scene/store", "start"), ("/dance/group/colour", 1, 0, 0, "nobody")):  # fmt: skip
        count = hands.show.refusals.count
        assert not hands.say(*call)
        assert hands.show.refusals.count == count + 1
        assert call[-1] in hands.words


def test_a_show_whose_desk_is_not_used_has_the_hash_of_before(hands):
    plain = Hands("[[view]]\nname = 'x'\n")
    assert plain.desk.hashed() == ()
    before = hands.show.state_hash()
    hands.say(LEVEL, 1.5)
    hands.run(ticks=1)
    assert hands.desk.hashed() != ()
    assert hands.show.state_hash() != before


def test_every_address_of_the_table_can_be_set_and_says_what_it_takes():
    for address in addresses():
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
        ('set = {"/dance/motion/larger nobody" = 0.1}', "no group is called 'nobody'; there are: "),
        ('set = {"/dance/motion/larger" = 2}', "out of range"),
        ('set = {"/dance/camera" = "nowhere"}', "nothing is called 'nowhere'; there are: around, front"),
        ('set = {"/dance/look" = 1}', "the name of a look expected"),
        ("measures = -1", "greater than or equal to 0"),
    ],
)
def test_a_scene_that_cannot_be_is_named_with_its_line(line, words):
    with pytest.raises(PatchError) as error:
        Hands(f'[[scene]]\nname = "x"\n{line}\n')
    assert words in str(error.value)
    assert "test.toml, line 2" in str(error.value)


def test_the_looks_of_nowhere_and_two_scenes_of_one_name_are_refused():
    with pytest.raises(PatchError, match="two looks are called"):
        Hands('[[looks]]\nname = "a"\n[[looks]]\nname = "A"\n')
    with pytest.raises(PatchError, match="the light goes nowhere"):
        Hands('[[looks]]\nname = "a"\nkey_direction = [0, 0, 0]\n')
    assert "low" in Hands(DESK).desk.scenes.names
