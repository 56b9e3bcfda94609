"""Holds of pairs that nobody annotated, found in their recordings."""

from dataclasses import replace

from live.library.pairs_file import Examples
from live.motion.partner.found_holds import Near, found_holds
from live.motion.partner.units import Example, Units


def with_holds(known: Examples, near: Near) -> Units:
    """The units of `known` with the holds found in those pairs whose table says nothing of `holds`."""
    return replace(known.units, examples=tuple(_one(known, n, near) for n in range(len(known.leaders))))


def _one(known: Examples, n: int, near: Near) -> Example:
    example, leader = known.units.examples[n], known.leaders[n]
    if leader is None or "holds" in known.wanted.pair[n].model_fields_set:
        return example
    return replace(example, holds=found_holds(leader.clip, example.follower, near))
