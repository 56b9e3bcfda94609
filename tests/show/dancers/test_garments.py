"""Garments of a show: who wears what from patch and live, at ticks, in snapshots, within a budget, after stalls."""

from pathlib import Path

import numpy as np
import pytest

from live.base.picture_parameters import EYE
from live.clock.ticks import TICK
from live.control.events import events
from live.show.circuit_breakers import Stage
from live.show.dancers.garments import BUDGET, FEWEST_SUBSTEPS, SUBSTEPS
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import SnapshotError, restore
from tests.fixtures.mostly_long import mostly_long
from tests.motion.cloth.cloth_bodies import grid, stretch
from tests.show.made_show import GRAPH, PATCH
from tests.show.state.test_snapshot import capture_from, run

DRESSED = PATCH.replace(
    'name = "front"', 'name = "front"\ndraw = { costume = "skirt", hair = "long", fabric = "silk" }'
)
DRESSED = DRESSED.replace(
    'name = "back"', 'name = "back"\ndraw = { hair = "ponytail", extras = "sleeves and ribbons" }'
)
SHOW = LoadedShow(Path("test.toml"), parse_patch(DRESSED.replace("reserve = 0", "reserve = 1"), "test.toml"), GRAPH)
SCRIPT = {
    90: events.SetParameter(time=1.4, source="osc", address="/dance/draw/costume", value=(8.0,), group="back"),
    150: events.SetParameter(time=2.3, source="osc", address="/dance/cloth/wind", value=(3.0, 0.0, 1.0), group="*"),
    200: events.TicksSkipped(time=3.1, source="engine", count=640),
    260: events.SetParameter(time=4.0, source="osc", address="/dance/draw/cloth", value=(2.0,), group="front"),
    330: events.SetParameter(time=5.1, source="osc", address="/dance/draw/cloth", value=(1.0,), group="front"),
}


def ticked(show, last, first=1):
    for tick in range(first, last + 1):
        if tick in SCRIPT:
            show.apply(SCRIPT[tick])
        show.tick(tick * TICK)
    return show


def crowd(front, back=1):
    text = DRESSED.replace("dancers = 4", f"dancers = {back}").replace("dancers = 5", f"dancers = {front}")
    return LoadedShow(Path("test.toml"), parse_patch(text, "test.toml"), GRAPH).start()


def test_patch_says_who_wears_what():
    show = ticked(SHOW.start(), 2)
    worn = {name: batch.rows.ravel()[: batch.count].tolist() for name, batch in show.garments.simulated.items()}
    assert worn["skirt/silk"] == worn["long hair/silk"] == [0, 1, 2, 3, 4, 9]  # the one in reserve, too
    assert worn["left ribbon/cotton"] == worn["ponytail/cotton"] == [5, 6, 7, 8]
    view = show.view()
    show.fill(view, 2 * TICK)
    assert len(view.cloth_garment) == 6 * 2 + 4 * 5
    assert np.isfinite(view.cloth_position).all()
    assert view.cloth_garment[:, 2].max() < len(view.cloth_position)


def test_show_without_garments_has_none_and_its_hash_does_not_change():
    show = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH).start()
    ticked(show, 30)
    assert not show.garments.any
    assert not show.garments.hashed()


@pytest.mark.long
def test_clothes_change_live():
    show = ticked(SHOW.start(), 100)
    assert show.garments.simulated["skirt/cotton"].count == 4
    ticked(show, 270, 101)
    assert "skirt/silk" not in show.garments.simulated  # skinned by now
    view = show.view()
    show.fill(view, 270 * TICK)
    assert {0, 1, 2, 3, 4} <= set(view.cloth_garment[:, 0].tolist())  # and drawn all the same


@pytest.mark.long
def test_two_runs_have_the_same_bits():
    assert run(SHOW.start(), 1, 400, SCRIPT) == run(SHOW.start(), 1, 400, SCRIPT)


@pytest.mark.long
def test_pictures_do_not_change_the_simulation():
    one, two, view = SHOW.start(), SHOW.start(), SHOW.start().view()
    for tick in range(1, 120):
        one.tick(tick * TICK)
        two.tick(tick * TICK)
        if tick % 3 == 0:
            two.fill(view, tick * TICK + 0.006)
    assert one.state_hash() == two.state_hash()


@mostly_long("tick", [95, 270, *(pytest.param(one, marks=pytest.mark.long) for one in (20, 160, 201, 335))], quick=[0])
def test_restored_show_goes_on_with_the_same_bits(tick):
    show = SHOW.start()
    run(show, 1, tick, SCRIPT)
    at, data = capture_from(show, tick, SCRIPT)
    again = restore(SHOW, data)
    assert again.state_hash() == show.state_hash()
    assert run(again, at + 1, at + 120, SCRIPT) == run(show, at + 1, at + 120, SCRIPT)


def test_snapshot_with_arrays_of_another_size_is_refused():
    show = ticked(SHOW.start(), 30)
    batch = show.garments.simulated["skirt/silk"]
    batch.joints = batch.joints[:, :, :-1].copy()
    _, data = capture_from(show, 30)
    with pytest.raises(SnapshotError):
        restore(SHOW, data)


@pytest.mark.long
def test_after_skipped_ticks_they_hang_again():
    show = ticked(SHOW.start(), 199)
    batch = show.garments.simulated["skirt/silk"]
    show.apply(SCRIPT[200])
    assert batch.fresh.all()
    ticked(show, 230, 201)
    places = grid(batch, *show.garments.joints)
    assert stretch(batch, places)[0].max() < 0.05
    assert np.abs(batch.velocity).max() <= 9.001


def test_tripped_stage_draws_them_fixed_to_the_body_and_can_be_reset():
    show, view = SHOW.start(), SHOW.start().view()
    ticked(show, 60)
    show.apply(events.BreakerTripped(time=1.0, source="supervisor", name="cloth", why="a test"))
    assert show.breakers.trip_count(Stage.CLOTH) == 1
    position = show.garments.simulated["skirt/silk"].position.copy()
    ticked(show, 80, 61)
    assert np.array_equal(position, show.garments.simulated["skirt/silk"].position)
    show.fill(view, 80 * TICK)
    hips = view.joint_position[view.cloth_garment[:, 0], 0]
    for (_, _, first), hip in zip(view.cloth_garment.tolist(), hips, strict=True):
        assert np.linalg.norm(view.cloth_position[first] - hip) < 1.6  # it is where the dancer is
    show.apply(events.ResetBreaker(time=1.4, source="osc", name="cloth"))
    ticked(show, 90, 81)
    assert not np.array_equal(position, show.garments.simulated["skirt/silk"].position)


@mostly_long(("dancers", "substeps"), [(49, SUBSTEPS), (75, FEWEST_SUBSTEPS), (200, FEWEST_SUBSTEPS)], quick=[0, 1])
def test_many_garments_stay_within_the_budget(dancers, substeps):
    show = crowd(dancers)
    ticked(show, 3)
    garments = show.garments
    particles = sum(batch.particles for batch in garments.simulated.values())
    assert garments.substeps == substeps
    assert particles * substeps <= BUDGET
    view = show.view()
    show.fill(view, 3 * TICK)
    assert len(set(view.cloth_garment[:, 0].tolist())) == dancers + 1  # everybody is drawn with theirs
    moved = {int(a) for batch in garments.simulated.values() for a in batch.rows.ravel()[: batch.count]}
    assert len(moved) == dancers + 1 or 60 < len(moved) < dancers


@pytest.mark.long
def test_those_nearest_to_the_camera_are_simulated():
    show = crowd(200)
    for tick in range(1, 150):
        show.tick(tick * TICK)
    garments = show.garments
    moved = np.zeros(len(show.group), np.bool_)
    for batch in garments.simulated.values():
        moved[batch.rows.ravel()[: batch.count]] = True
    away = np.linalg.norm(garments._hips - show.desk.parameters.picture[EYE], axis=1)
    assert np.median(away[:200][moved[:200]]) < np.median(away[:200][~moved[:200]])


@pytest.mark.long
def test_frozen_picture_keeps_its_garments():
    show, view = SHOW.start(), SHOW.start().view()
    ticked(show, 40)
    show.apply(events.FreezePicture(time=0.7, source="osc", on=True))
    show.fill(view, 40 * TICK)
    still = view.cloth_position.copy()
    ticked(show, 60, 41)
    other = show.view()
    show.fill(other, 60 * TICK)
    assert np.array_equal(other.cloth_position, still)
