"""Formations of a show by name: from the patch, defined live, or said in a few words; made for any count (T087)."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.intention import Places
from live.agents.formations.formation import check_formation, formation_of
from live.agents.formations.formation_notation import spec_from_words
from live.agents.formations.formation_spec import FormationSpec
from live.base.errors import PersonError, named
from live.show.patch.section_motion import GroupSection

Float64 = npt.NDArray[np.float64]

BODY: Final = 0.3
"""Room [m] around each place of a formation that is fitted to a smaller stage."""
KEPT: Final = 64
"""Counts for which a formation's places are kept."""


known_formation = lru_cache(maxsize=1024)(formation_of)
"""The same formation, count and seed are worked out once, whoever asks: nobody changes what comes out."""


@dataclass(slots=True, eq=False)
class NamedFormation:
    """A formation that is made for as many dancers as there are, and kept."""

    name: str
    spec: FormationSpec
    seed: int
    _made: "OrderedDict[int, Places]"
    half: Float64 | None = None
    """Half sizes [m] of the stage that it has to be fitted to, (2,); None: it stands as it is."""

    @staticmethod
    def of(name: str, spec: FormationSpec, seed: int) -> "NamedFormation":
        """Raises PersonError if the spec gives no formation."""
        check_formation(spec)
        return NamedFormation(name, spec, seed, OrderedDict())

    def made(self, count: int) -> Places:
        """The places for `count` dancers: made smaller, and moved, as far as a stage that shrank asks for it."""
        if count not in self._made:
            formation = known_formation(self.spec, count, self.seed)
            self._made[count] = Places(self.name, formation.slots, formation.heading, formation.marks)
            if len(self._made) > KEPT:
                self._made.popitem(last=False)
        places = self._made[count]
        return places if self.half is None else replace(places, slots=fitted(places.slots, self.half))


def fitted(slots: npt.NDArray[np.floating], half: Float64) -> Float64:
    """The `slots` (S, 2) [m], no larger and no farther out than fits a stage of these half sizes [m] with bodies."""
    edge = np.maximum(half - BODY, 0.0)
    if not len(slots):
        return np.asarray(slots, np.float64)
    low, high = slots.min(axis=0), slots.max(axis=0)
    middle, reach = 0.5 * (low + high), 0.5 * (high - low)
    factor = min(1.0, float((edge / np.maximum(reach, 1e-9)).min()))
    room = np.maximum(edge - factor * reach, 0.0)
    return np.asarray(np.clip(middle, -room, room) + factor * (slots - middle))


class Formations:
    """All formations of a show: names are looked up first, anything else is read as words for one."""

    def __init__(self, specs: Sequence[FormationSpec], *, seed: int) -> None:
        """Raises PersonError if one of them cannot be."""
        self._seed = seed
        self._named: dict[str, NamedFormation] = {}
        for index, spec in enumerate(specs):
            with named(f"formation {spec.name!r}", ("formation", index)):
                self._named[spec.name.casefold()] = NamedFormation.of(spec.name, spec, seed)
        self._written = dict(self._named)
        self._said: OrderedDict[str, NamedFormation] = OrderedDict()
        self._half: Float64 | None = None

    def find(self, words: str, *, live: bool = False) -> NamedFormation:
        """The formation of this name, or the one that the words say; PersonError with what there is.

        `live`: while a show runs, which must not wait for the reader of SVG paths to be loaded.
        """
        folded = words.casefold().strip()
        if folded in self._named:
            return self._named[folded]
        if words not in self._said:
            if live and folded.startswith("path:"):
                raise PersonError(
                    "a path cannot be read while a show runs", "give it a name in the patch's [[formation]]"
                )
            try:
                spec = spec_from_words(words)
            except PersonError as error:
                names = ", ".join(formation.name for formation in self._named.values())
                raise PersonError(f"{error}", f"formations of this show: {names}" if names else None) from None
            self._said[words] = NamedFormation.of(words, spec, self._seed)
            self._said[words].half = self._half
            if len(self._said) > KEPT:
                self._said.popitem(last=False)
        return self._said[words]

    def define(self, name: str, words: str) -> NamedFormation:
        """Make, or change, the formation called `name` as the words say; PersonError if they say none."""
        if name.casefold().strip() not in self._named and len(self._named) >= 2000:
            raise PersonError("more formations than anybody can dance", "change one of those there are")
        formation = NamedFormation.of(name, self.find(words, live=True).spec, self._seed)
        formation.half = self._half
        self._named[name.casefold().strip()] = formation
        return formation

    def take_patch(self, fresh: "Formations") -> list[NamedFormation]:
        """Take over the formations of another patch; those that were edited in it, made already.

        What was defined live stays, unless the patch has that very one otherwise now.
        """
        edited = []
        for name, formation in fresh._written.items():
            old = self._written.get(name)
            if old is None or old.spec != formation.spec:
                formation.half = self._half
                self._named[name] = formation
                edited.append(formation)
        for name, old in self._written.items():
            if name not in fresh._written and self._named.get(name) is old:
                del self._named[name]
        self._written = {
            name: self._written[name] if name in self._written and self._written[name].spec == new.spec else new
            for name, new in fresh._written.items()
        }
        return edited

    @property
    def named(self) -> dict[str, NamedFormation]:
        """All that have a name, by it, folded."""
        return dict(self._named)

    def restore(self, name: str, formation: NamedFormation | None) -> None:
        """The formation of this folded name shall be this one, as it was made before; None: there shall be none."""
        if formation is None:
            self._named.pop(name, None)
        else:
            formation.half = self._half
            self._named[name] = formation

    def fit(self, half: Float64 | None) -> bool:
        """Let all fit a stage of these half sizes [m], (2,), or (None) be as they were made; False: they are."""
        if half is None and self._half is None:
            return False
        self._half = half
        for formation in (*self._named.values(), *self._said.values()):
            formation.half = half
        return True

    def warm(self, counts: set[int]) -> None:
        """Make all named ones for so many dancers, so that nothing is made while a show runs."""
        for formation in self._named.values():
            for count in sorted(counts):
                formation.made(count)

    def beginning(self, section: GroupSection) -> Float64:
        """Where the dancers of a group begin, (dancers, 2) [m]; those without a place stand in rows around its middle.

        Words for a formation take the group's centre and size.
        """
        folded = section.formation.casefold().strip()
        if folded in self._named:
            spec = self._named[folded].spec
        else:
            spec = replace(spec_from_words(section.formation), centre=section.centre, size=section.size)
        places = known_formation(spec, section.dancers, self._seed).slots
        missing = section.dancers - len(places)
        if missing > 0:
            rows = FormationSpec(shape="grid", centre=section.centre, size=section.size)
            places = np.concatenate([places, formation_of(rows, missing, self._seed).slots])
        return np.asarray(places[: section.dancers], np.float64)
