"""Holds are detected only where a pair description gives none."""

from pathlib import Path
from typing import Any

import numpy as np

from live.library.partner_pairs import PairsFile, PartnerExamples, RecordedSide, add_found_holds
from live.motion.partner.evaluation import HoldCriterion
from live.motion.partner.point_clouds import ends_cloud
from live.motion.partner.units import Example, Hold, cut_units
from tests.motion.partner.made_examples import standing

WRITTEN = (Hold(0, 0, 10.0, 20.0),)
NEAR = HoldCriterion(0.1, 0.4)


def partner_examples(known: tuple[Hold, ...], **said: Any) -> PartnerExamples:
    """One pair in which both stand at the same position, so that left holds left and right holds right."""
    clip = standing(120, 60.0)
    cloud = ends_cloud(clip)
    units = cut_units([Example("one", cloud, cloud, clip, np.array((0.0, 60.0, 119.0)), np.zeros(0), known)])
    side = {"file": "a.bvh"}
    wanted = PairsFile.model_validate({"pair": [{"leader": side, "follower": side, **said}]})
    one = RecordedSide(clip, 120, 60.0, 60.0)
    return PartnerExamples(Path("a.toml"), wanted, units, (one,), (one,))


def test_holds_are_detected_when_not_given() -> None:
    units = add_found_holds(partner_examples(()), NEAR)
    assert units.examples[0].holds == (Hold(0, 0, 0.0, 119.0), Hold(1, 1, 0.0, 119.0))
    assert units.count == 2


def test_given_holds_and_empty_list_are_kept() -> None:
    assert (
        add_found_holds(partner_examples(WRITTEN, holds=[("left", "left", 0.1, 0.3)]), NEAR).examples[0].holds
        == WRITTEN
    )
    assert add_found_holds(partner_examples((), holds=[]), NEAR).examples[0].holds == ()
