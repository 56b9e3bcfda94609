"""Tests of the patch's `draw` and `bodies` keys: initial styles, looks, errors and seeded bodies."""

import pytest
from pydantic import ValidationError

from live.base import picture_parameters
from live.show.desk.look_settings import DRAW_KEYS, look_settings
from live.show.patch.patch import Patch
from live.show.patch_checks.patch_check import PATCH_CHECKS
from live.show.view.render_scene import make_scene


def patch_values(**group):
    first = {"name": "ember", "dancers": 30, "steps": ["groove"]}
    return {"name": "p", "group": [first | group, {"name": "tide", "dancers": 3, "steps": ["groove"]}]}


def validate(values):
    return Patch.model_validate(values, context=PATCH_CHECKS)


def test_group_starts_with_draw_styles_of_its_patch():
    made = validate(patch_values(draw={"solid": 0.0, "ink": 1, "ink_width": 3.5, "silhouette_colour": [0.1, 0.2, 0.3]}))
    row = picture_parameters.picture_row(make_scene(made))
    said = {"solid": (0.0,), "ink": (1.0,), "ink/width": (3.5,), "silhouette/colour": (0.1, 0.2, 0.3)}
    for name, numbers in said.items():
        assert (
            tuple(row[picture_parameters.group_parameter(picture_parameters.STYLE_ADDRESS_PREFIX + name, 0).row_slice])
            == numbers
        )
    plain = picture_parameters.picture_row(make_scene(Patch.model_validate(patch_values())))
    assert (
        row[picture_parameters.STYLES_START + picture_parameters.STYLE_SIZE :]
        == plain[picture_parameters.STYLES_START + picture_parameters.STYLE_SIZE :]
    ).all()


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        ({"inky": 1.0}, "group 'ember': nothing is drawn by 'inky'; there are: solid, silhouette"),
        ({"ink": 2.0}, "/dance/draw/ink' = 2.0"),
        ({"ink_colour": 1.0}, "expected 3 numbers"),
    ],
)
def test_invalid_draw_key_is_refused_with_reason(draw, words):
    with pytest.raises(ValidationError, match=words):
        validate(patch_values(draw=draw))


def test_look_sets_styles_of_all_groups_or_one():
    look = {"name": "lines", "draw": {"solid": 0, "ink": 1, "xray tide": 1}}
    made = validate(patch_values() | {"looks": [look]})
    assert look_settings(made, made.looks[0]) == {
        "/dance/draw/solid": 0.0,
        "/dance/draw/ink": 1.0,
        "/dance/draw/xray tide": 1.0,
    }
    with pytest.raises(ValidationError, match="look 'lines': nothing is drawn by 'lnk'"):
        validate(patch_values() | {"looks": [look | {"draw": {"lnk": 1}}]})


def test_every_style_parameter_has_a_draw_key():
    assert len(DRAW_KEYS) == len(picture_parameters.GROUP_PARAMETERS) - 1
    assert {"solid", "silhouette_colour", "trails_spacing"} <= set(DRAW_KEYS)


def test_bodies_are_drawn_by_seed_for_initial_group_members():
    bodies = {"bodies": ["slim", "strong", "strong"]}
    one, same, other = (
        make_scene(Patch.model_validate(patch_values(**bodies) | {"seed": seed})).bodies for seed in (5, 5, 6)
    )
    assert one == same != other
    assert set(one[:30]) == {"slim", "strong"}
    assert one[:30].count("strong") > one[:30].count("slim")
    assert one[30:] == ("dancer",) * 3
    assert make_scene(Patch.model_validate(patch_values())).bodies == ()
    with pytest.raises(ValidationError, match="'child', 'older woman' or 'older man'"):
        Patch.model_validate(patch_values(bodies=["tall"]))
