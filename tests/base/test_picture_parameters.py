"""The picture's parameter row: one table without gaps that contains exactly the values of a scene."""

from dataclasses import replace

import numpy as np

from live.base import picture_parameters
from live.base.stage_snapshot import Camera, Scene

SCENE = Scene(
    (10.0, 8.0), Camera((0.1, 3.4, 11.7), (0.3, 0.9, -0.2), 37.3), 3, 22, start_values=(("/dance/light/ambient", 0.3),)
)


def test_parameter_slices_fill_the_row_without_gaps():
    places = [
        place
        for known in picture_parameters.PARAMETERS
        for place in range(picture_parameters.ROW_SIZE)[known.row_slice]
    ]
    groups = [
        place
        for n in range(picture_parameters.PART_COUNT)
        for place in range(picture_parameters.ROW_SIZE)[
            picture_parameters.group_parameter(picture_parameters.GROUP_COLOUR_ADDRESS, n).row_slice
        ]
    ]
    own = [
        address for address in picture_parameters.GROUP_PARAMETERS if address != picture_parameters.GROUP_COLOUR_ADDRESS
    ]
    styles = [
        place
        for n in range(picture_parameters.PART_COUNT)
        for address in own
        for place in range(picture_parameters.ROW_SIZE)[picture_parameters.group_parameter(address, n).row_slice]
    ]
    passes = list(range(picture_parameters.ROW_SIZE))[picture_parameters.CUSTOM_PASS_SLICE]
    assert places + passes + groups + styles == list(range(picture_parameters.ROW_SIZE))


def test_every_parameter_has_valid_start_and_description():
    for known in (*picture_parameters.PARAMETERS, *picture_parameters.GROUP_PARAMETERS.values()):
        assert len(known.start) == known.size
        assert all(known.low <= value <= known.high for value in known.start)
        assert known.description.endswith(".")
        assert known.address.startswith("/dance/")


def test_scene_is_recovered_exactly_from_its_row():
    row = picture_parameters.picture_row(SCENE)
    assert picture_parameters.camera_from_row(row) == SCENE.camera
    assert row[picture_parameters.BY_ADDRESS["/dance/light/ambient"].first] == 0.3
    for address in ("/dance/light/floor", "/dance/light/rim/colour"):
        known = picture_parameters.BY_ADDRESS[address]
        assert tuple(row[known.row_slice]) == known.start


def test_row_of_default_scene_has_the_table_defaults():
    row = picture_parameters.picture_row(Scene((10.0, 8.0), Camera(), 3, 22))
    for known in picture_parameters.PARAMETERS:
        assert tuple(row[known.row_slice]) == known.start


def test_group_colors_repeat_beyond_the_list():
    colours = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    row = picture_parameters.picture_row(replace(SCENE, group_colours=colours))
    rows = row[picture_parameters.COLOURS_START : picture_parameters.STYLES_START].reshape(-1, 3)
    assert len(rows) == picture_parameters.PART_COUNT
    assert np.array_equal(rows[0], rows[2])
    assert np.array_equal(rows[1], rows[5])


def test_styles_change_only_their_groups():
    styles = (), (("/dance/draw/ink", (1.0,)), ("/dance/draw/ink/colour", (0.1, 0.2, 0.3)))
    row = picture_parameters.picture_row(replace(SCENE, group_styles=styles))
    usual = picture_parameters.picture_row(SCENE)
    assert row[picture_parameters.group_parameter("/dance/draw/ink", 1).first] == 1.0
    assert tuple(row[picture_parameters.group_parameter("/dance/draw/ink/colour", 1).row_slice]) == (0.1, 0.2, 0.3)
    assert sorted(np.flatnonzero(row != usual)) == sorted(
        [
            picture_parameters.group_parameter("/dance/draw/ink", 1).first,
            *range(picture_parameters.ROW_SIZE)[
                picture_parameters.group_parameter("/dance/draw/ink/colour", 1).row_slice
            ],
        ]
    )
    for address, known in picture_parameters.GROUP_PARAMETERS.items():
        if address != picture_parameters.GROUP_COLOUR_ADDRESS:
            assert tuple(usual[picture_parameters.group_parameter(address, 15).row_slice]) == known.start
