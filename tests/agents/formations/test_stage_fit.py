"""Stage fit of a formation: the suggested remedy makes it fit."""

from dataclasses import replace

import pytest

from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import FormationSpec
from live.agents.formations.stage_fit import fit_stage


def test_small_formation_fits_the_stage():
    assert fit_stage(formation_of(FormationSpec(shape="circle"), 20), 12, 8).fits
    assert fit_stage(formation_of(FormationSpec(shape="circle"), 0), 2, 2).fits


def test_stage_fit_includes_body_radius():
    formation = formation_of(FormationSpec(shape="line", size=(8.0, 1.0)), 9)
    assert fit_stage(formation, 8.5, 4).fits
    assert fit_stage(formation, 8.4, 4).outside == (0, 8)


@pytest.mark.parametrize("spec", [
    FormationSpec(shape="circle", size=(6.0, 6.0), centre=(4.0, -3.0)),
    FormationSpec(shape="star", size=(20.0, 18.0), centre=(1.0, 0.0)),
    FormationSpec(shape="line", size=(30.0, 1.0), rotation_deg=50),
    FormationSpec(shape="rectangle", pattern="poisson", size=(13.0, 4.0), centre=(0.0, 5.0)),
])  # fmt: skip
def test_suggested_remedy_makes_formation_fit(spec):
    formation = formation_of(spec, 30)
    fit = fit_stage(formation, 12, 8)
    assert not fit.fits
    assert fit.remedy
    centre = (spec.centre[0] + fit.offset[0], spec.centre[1] + fit.offset[1])
    size = (spec.size[0] * fit.scale, spec.size[1] * fit.scale)
    assert fit_stage(formation_of(replace(spec, size=size, centre=centre), 30), 12.02, 8.02).fits or fit.scale < 1
    scaled = (formation.slots - formation.slots.mean(axis=0)) * fit.scale
    assert (scaled.max(axis=0) - scaled.min(axis=0) <= [11.5001, 7.5001]).all()
