"""Limbs fitted to the bodies: they cover the skin, and are no wider than need be."""

import numpy as np

from live.base.body.catalogue import BODIES
from live.motion.cloth.body_sections import LIMBS, half_widths
from live.render.body.body_limbs import body_sections
from live.render.body.body_mesh import LIGHT, build_body
from tests.fixtures.mostly_long import mostly_long


def distance(points, limb, section):
    """Signed distance of first order from a limb, in numpy."""
    own = (points - np.array(limb.start)) @ limb.axes()
    along = np.clip(own[:, 1], 0.0, limb.length)
    widths = np.array([half_widths(section, place) for place in along / limb.length])
    depth = np.where(own[:, 2] > 0.0, widths[:, 1], widths[:, 2])
    end = np.where(own[:, 1] > along, 1.0 / section[-1], 1.0 / section[-2])
    radii = np.stack([widths[:, 0], end, depth], axis=1)
    unit = np.stack([own[:, 0], own[:, 1] - along, own[:, 2]], axis=1) / radii
    k0 = np.linalg.norm(unit, axis=1)
    return k0 * (k0 - 1.0) / np.maximum(np.linalg.norm(unit / radii, axis=1), 1e-9)


@mostly_long("body", BODIES, quick=[0, 1, 4, 5])
def test_limbs_are_the_body_that_is_drawn(body):
    """From knees to shoulders nine tenths of the skin are within 1.5 cm of the limbs' surface."""
    sections, skin = body_sections(body), build_body(LIGHT, body).position.astype(np.float64)
    skin = skin[(skin[:, 1] > 0.15) & (skin[:, 1] < 1.40) & (np.abs(skin[:, 0]) < 0.62)]
    away = np.min([distance(skin, limb, row) for limb, row in zip(LIMBS, sections, strict=True)], axis=0)
    assert np.percentile(away, 97) < 0.012
    assert np.percentile(away, 5) > -0.035
    assert np.mean(np.abs(away) < 0.015) > 0.8


def test_both_sides_are_alike():
    sections = body_sections("dancer")
    rows = {limb.name: row for limb, row in zip(LIMBS, sections, strict=True)}
    for name, row in rows.items():
        if name.startswith("left"):
            assert np.array_equal(row, rows[name.replace("left", "right")])


def test_character_has_the_usual_limbs():
    assert np.array_equal(body_sections("anna.vrm"), body_sections("dancer"))


def test_round_body_is_wider_at_the_waist():
    place = next(k for k, limb in enumerate(LIMBS) if limb.name == "waist")
    usual, wide = (half_widths(body_sections(name)[place], 0.5) for name in ("dancer", "round"))
    assert all(w > u for w, u in zip(wide, usual, strict=True))
