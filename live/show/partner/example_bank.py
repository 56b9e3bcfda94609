"""Example motion from which partners answer."""

import hashlib

from live.motion.partner_live.stage_partner import PartnerExamples


class ExampleBank:
    """Example motion for each `[[partner]]` of a patch; immutable."""

    def __init__(self, example_sets: tuple[PartnerExamples, ...]) -> None:
        self.example_sets = example_sets

    @property
    def labels(self) -> frozenset[str]:
        """Case-folded names of the recordings or steps whose units may be danced."""
        return frozenset(one.name.casefold() for lore in self.example_sets for one in lore.units.examples)

    def digest(self) -> str:
        """Return a short hash of all motion in it."""
        found = hashlib.blake2b(digest_size=8)
        for lore in self.example_sets:
            found.update(f"{lore.per_beat} {lore.unit_beats} {lore.stretch:g} {lore.units.count}".encode())
            for one in lore.units.examples:
                found.update(one.name.encode())
                if one.holds:
                    found.update(repr(one.holds).encode())
                for array in (one.cuts, one.control.floor, one.follower.rotation, one.follower.root_position):
                    found.update(array.tobytes())
        return found.hexdigest()
