"""The row of the picture: one table, laid out without gaps, exactly what a scene says."""

from dataclasses import replace

import numpy as np

from live.base import picture_parameters
from live.base.stage_snapshot import Camera, Look, Scene

SCENE = Scene((10.0, 8.0), Camera((0.1, 3.4, 11.7), (0.3, 0.9, -0.2), 37.3), Look(ambient=0.3), 3, 22)


def test_the_numbers_of_all_parameters_lie_side_by_side():
    places = [place for known in picture_parameters.PARAMETERS for place in range(picture_parameters.SIZE)[known.where]]
    groups = [
        place
        for n in range(picture_parameters.GROUPS)
        for place in range(picture_parameters.SIZE)[picture_parameters.colour_of_group(n).where]
    ]
    own = [address for address in picture_parameters.OF_GROUPS if address != picture_parameters.COLOUR_OF_GROUP]
    styles = [
        place
        for n in range(picture_parameters.GROUPS)
        for address in own
        for place in range(picture_parameters.SIZE)[picture_parameters.of_group(address, n).where]
    ]
    passes = list(range(picture_parameters.SIZE))[picture_parameters.OWN]
    assert places + passes + groups + styles == list(range(picture_parameters.SIZE))


def test_every_parameter_starts_within_its_range_and_has_words():
    for known in (*picture_parameters.PARAMETERS, *picture_parameters.OF_GROUPS.values()):
        assert len(known.start) == known.size
        assert all(known.low <= value <= known.high for value in known.start)
        assert known.words.endswith(".")
        assert known.address.startswith("/dance/")


def test_a_scene_comes_back_from_its_row_bit_by_bit():
    row = picture_parameters.picture_of(SCENE)
    assert picture_parameters.camera_of(row) == SCENE.camera
    assert row[picture_parameters.BY_ADDRESS["/dance/light/ambient"].first] == 0.3
    for address, value in (("/dance/light/floor", SCENE.look.floor), ("/dance/light/rim/colour", SCENE.look.rim_light)):
        assert tuple(row[picture_parameters.BY_ADDRESS[address].where]) == value


def test_the_row_of_a_default_scene_is_the_table_s():
    row = picture_parameters.picture_of(Scene((10.0, 8.0), Camera(), Look(), 3, 22))
    for known in picture_parameters.PARAMETERS:
        assert tuple(row[known.where]) == known.start


def test_groups_beyond_the_colours_begin_with_the_first_again():
    colours = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    row = picture_parameters.picture_of(replace(SCENE, look=replace(SCENE.look, group_colours=colours)))
    rows = row[picture_parameters.COLOURS : picture_parameters.STYLES].reshape(-1, 3)
    assert len(rows) == picture_parameters.GROUPS
    assert np.array_equal(rows[0], rows[2])
    assert np.array_equal(rows[1], rows[5])


def test_styles_of_a_look_are_those_of_their_groups_and_all_others_are_as_usual():
    look = replace(
        SCENE.look, group_styles=((), (("/dance/draw/ink", (1.0,)), ("/dance/draw/ink/colour", (0.1, 0.2, 0.3))))
    )
    row, usual = picture_parameters.picture_of(replace(SCENE, look=look)), picture_parameters.picture_of(SCENE)
    assert row[picture_parameters.of_group("/dance/draw/ink", 1).first] == 1.0
    assert tuple(row[picture_parameters.of_group("/dance/draw/ink/colour", 1).where]) == (0.1, 0.2, 0.3)
    assert sorted(np.flatnonzero(row != usual)) == sorted(
        [
            picture_parameters.of_group("/dance/draw/ink", 1).first,
            *range(picture_parameters.SIZE)[picture_parameters.of_group("/dance/draw/ink/colour", 1).where],
        ]
    )
    for address, known in picture_parameters.OF_GROUPS.items():
        if address != picture_parameters.COLOUR_OF_GROUP:
            assert tuple(usual[picture_parameters.of_group(address, 15).where]) == known.start
