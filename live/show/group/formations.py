"""Formations of a show: named in the patch, defined live or given in formation notation, for any count (T087)."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.intention import Places
from live.agents.formations.formation import check_formation, formation_of
from live.agents.formations.formation_notation import parse_formation
from live.agents.formations.formation_spec import FormationSpec
from live.base.arrays import Float64
from live.base.errors import PersonError, error_context
from live.show.patch.section_motion import GroupSection

SLOT_MARGIN: Final = 0.3
"""Margin around each place of a formation that is fitted to a smaller stage [m]."""
CACHE_SIZE: Final = 64
"""Size of the caches: counts per formation, and unnamed formations."""


cached_formation = lru_cache(maxsize=1024)(formation_of)
"""Cached `formation_of`. Callers must not change the result."""


@dataclass(slots=True, eq=False)
class NamedFormation:
    """A formation with a cache of its places for each count of dancers."""

    name: str
    spec: FormationSpec
    seed: int
    _cache: "OrderedDict[int, Places]"
    half: Float64 | None = None
    """Half sizes of the stage that the formation is fitted to [m], (2,); None for no fitting."""

    @staticmethod
    def of(name: str, spec: FormationSpec, seed: int) -> "NamedFormation":
        """Create the formation of a spec. Raises PersonError if the spec is invalid."""
        check_formation(spec)
        return NamedFormation(name, spec, seed, OrderedDict())

    def places_for(self, count: int) -> Places:
        """Return the places for `count` dancers, scaled and moved to fit a stage that has shrunk."""
        if count not in self._cache:
            formation = cached_formation(self.spec, count, self.seed)
            self._cache[count] = Places(self.name, formation.slots, formation.heading, formation.marks)
            if len(self._cache) > CACHE_SIZE:
                self._cache.popitem(last=False)
        places = self._cache[count]
        return places if self.half is None else replace(places, slots=fit_slots(places.slots, self.half))


def fit_slots(slots: npt.NDArray[np.floating], half: Float64) -> Float64:
    """Return the `slots` (S, 2) [m], scaled down and moved to fit a stage of these half sizes [m] with a margin."""
    edge = np.maximum(half - SLOT_MARGIN, 0.0)
    if not len(slots):
        return np.asarray(slots, np.float64)
    low, high = slots.min(axis=0), slots.max(axis=0)
    middle, reach = 0.5 * (low + high), 0.5 * (high - low)
    factor = min(1.0, float((edge / np.maximum(reach, 1e-9)).min()))
    room = np.maximum(edge - factor * reach, 0.0)
    return np.asarray(np.clip(middle, -room, room) + factor * (slots - middle))


class Formations:
    """All formations of a show. A name is looked up first; anything else is parsed as formation notation."""

    def __init__(self, specs: Sequence[FormationSpec], *, seed: int) -> None:
        """Create the formations of the specs. Raises PersonError for an invalid one."""
        self._seed = seed
        self._named: dict[str, NamedFormation] = {}
        for index, spec in enumerate(specs):
            with error_context(f"formation {spec.name!r}", ("formation", index)):
                self._named[spec.name.casefold()] = NamedFormation.of(spec.name, spec, seed)
        self._from_patch = dict(self._named)
        self._unnamed: OrderedDict[str, NamedFormation] = OrderedDict()
        self._half: Float64 | None = None

    def find(self, words: str, *, live: bool = False) -> NamedFormation:
        """Return the formation with this name or notation. Raises PersonError, with the known names, for others.

        `live`: while a show runs, SVG paths are refused, as loading their reader takes too long.
        """
        folded = words.casefold().strip()
        if folded in self._named:
            return self._named[folded]
        if words not in self._unnamed:
            if live and folded.startswith("path:"):
                raise PersonError(
                    "a path cannot be read while a show runs", "give it a name in the patch's [[formation]]"
                )
            try:
                spec = parse_formation(words)
            except PersonError as error:
                names = ", ".join(formation.name for formation in self._named.values())
                raise PersonError(f"{error}", f"formations of this show: {names}" if names else None) from None
            self._unnamed[words] = NamedFormation.of(words, spec, self._seed)
            self._unnamed[words].half = self._half
            if len(self._unnamed) > CACHE_SIZE:
                self._unnamed.popitem(last=False)
        return self._unnamed[words]

    def written(self, words: str) -> FormationSpec:
        """Return the formation with this name in the patch, or of this notation. Raises PersonError for others."""
        named = self._from_patch.get(words.casefold().strip())
        return parse_formation(words) if named is None else named.spec

    def define(self, name: str, words: str) -> NamedFormation:
        """Define or replace the formation `name` by formation notation. Raises PersonError if it is invalid."""
        if name.casefold().strip() not in self._named and len(self._named) >= 2000:
            raise PersonError("there are too many formations", "redefine an existing one")
        formation = NamedFormation.of(name, self.find(words, live=True).spec, self._seed)
        formation.half = self._half
        self._named[name.casefold().strip()] = formation
        return formation

    def apply_patch(self, fresh: "Formations") -> list[NamedFormation]:
        """Apply the formations of another patch, and return those that were edited.

        Formations defined live stay, unless the patch has edited the one of that name.
        """
        edited = []
        for name, formation in fresh._from_patch.items():
            old = self._from_patch.get(name)
            if old is None or old.spec != formation.spec:
                formation.half = self._half
                self._named[name] = formation
                edited.append(formation)
        for name, old in self._from_patch.items():
            if name not in fresh._from_patch and self._named.get(name) is old:
                del self._named[name]
        self._from_patch = {
            name: self._from_patch[name]
            if name in self._from_patch and self._from_patch[name].spec == new.spec
            else new
            for name, new in fresh._from_patch.items()
        }
        return edited

    @property
    def named(self) -> dict[str, NamedFormation]:
        """All named formations, by case-folded name."""
        return dict(self._named)

    def restore(self, name: str, formation: NamedFormation | None) -> None:
        """Set the formation of this case-folded name to an earlier one; None removes it."""
        if formation is None:
            self._named.pop(name, None)
        else:
            formation.half = self._half
            self._named[name] = formation

    def fit(self, half: Float64 | None) -> bool:
        """Fit all formations to a stage of these half sizes [m], (2,), or to none (None). Returns False if there was
        nothing to change."""
        if half is None and self._half is None:
            return False
        self._half = half
        for formation in (*self._named.values(), *self._unnamed.values()):
            formation.half = half
        return True

    def precompute(self, counts: set[int]) -> None:
        """Fill the caches of all named formations for these counts, so that nothing is computed while a show runs."""
        for formation in self._named.values():
            for count in sorted(counts):
                formation.places_for(count)

    def starting_places(self, section: GroupSection) -> Float64:
        """Return the starting places of a group's dancers, (dancers, 2) [m].

        Formation notation uses the group's centre and size. Dancers without a place stand in rows around its centre.
        """
        folded = section.formation.casefold().strip()
        if folded in self._named:
            spec = self._named[folded].spec
        else:
            spec = replace(parse_formation(section.formation), centre=section.centre, size=section.size)
        places = cached_formation(spec, section.dancers, self._seed).slots
        missing = section.dancers - len(places)
        if missing > 0:
            rows = FormationSpec(shape="grid", centre=section.centre, size=section.size)
            places = np.concatenate([places, formation_of(rows, missing, self._seed).slots])
        return np.asarray(places[: section.dancers], np.float64)
