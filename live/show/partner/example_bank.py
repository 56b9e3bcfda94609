"""Example motion from which partners answer."""

import hashlib
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from live.base.errors import PersonError
from live.motion.partner_live.stage_partner import ALL_STYLES, PartnerExamples
from live.show.partner.partner_pairs import PartnerSettings


class ExampleBank:
    """Example motion for each `[[partner]]` of a patch; immutable."""

    def __init__(
        self, example_sets: tuple[PartnerExamples, ...], texts: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        """`texts`: the files of pairs that were read, by their names in the patch."""
        self.example_sets = example_sets
        self.texts = dict(texts)
        self._digest = ""

    @property
    def labels(self) -> frozenset[str]:
        """Case-folded names of the recordings or steps whose units may be danced."""
        return frozenset(one.name.casefold() for lore in self.example_sets for one in lore.units.examples)

    def digest(self) -> str:
        """Return a short hash of all motion in it, and of the styles."""
        self._digest = self._digest or self._hash()
        return self._digest

    def _hash(self) -> str:
        found = hashlib.blake2b(digest_size=8)
        for lore in self.example_sets:
            found.update(f"{lore.per_beat} {lore.unit_beats} {lore.stretch:g} {lore.units.count}".encode())
            if any(lore.styles):
                found.update(repr(lore.styles).encode())
            for one in lore.units.examples:
                found.update(one.name.encode())
                if one.holds:
                    found.update(repr(one.holds).encode())
                for array in (one.cuts, one.control.floor, one.follower.rotation, one.follower.root_position):
                    found.update(array.tobytes())
        return found.hexdigest()

    def weights(self, index: int) -> dict[str, float]:
        """Return how much each example of a partner counts, by its name (H026)."""
        lore = self.example_sets[index]
        weight = lore.filter.model.example_weight.tolist()
        return {one.name: round(value, 3) for one, value in zip(lore.units.examples, weight, strict=True)}


def check_styles(settings: Sequence[PartnerSettings], bank: ExampleBank) -> None:
    """Raise PersonError for a partner with a style that none of the examples has."""
    for index, (one, lore) in enumerate(zip(settings, bank.example_sets, strict=True)):
        if one.style not in lore.filters:
            known = ", ".join(name for name in lore.filters if name != ALL_STYLES)
            raise PersonError(
                f"partner {one.name!r}: no pair has the style {one.style[:64]!r}; "
                + (f"there are: {known}" if known else "no pair has a style"),
                'style = "..." of a [[pair]]; "" is all of them',
                ("partner", index, "style"),
            )
