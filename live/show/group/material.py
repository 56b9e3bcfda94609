"""Evolutions of a patch as material: their ways, or those of others transformed, computed when a show is loaded
(T145, T146)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from live.agents.formations.formation_spec import FormationSpec, spec_from_table
from live.agents.formations.like import resolved, transform_of
from live.agents.material.ways import Material, danced_ways
from live.base.arrays import Float32
from live.base.errors import PersonError, error_context
from live.show.patch.patch import Patch
from live.show.patch.section_score import EvolutionSection

MAX_DEPTH: Final = 16
"""Longest row of evolutions that are each like the next one."""

Find = Callable[[str], FormationSpec]
"""Returns the formation of a name or of words; PersonError if there is none."""


def material_of(patch: Patch, name: str, find: Find, above: tuple[str, ...] = ()) -> Material:
    """Return the evolution of this name. PersonError if there is none, or one is like itself."""
    folded = name.casefold().strip()
    section = next((one for one in patch.evolution if one.name.casefold().strip() == folded), None)
    if section is None:
        known = ", ".join(one.name for one in patch.evolution)
        raise PersonError(f"no evolution is called {name!r}", f"there are: {known}" if known else "there are none yet")
    if section.like is None:
        return Material(section.ways)
    if folded in above or len(above) >= MAX_DEPTH:
        raise PersonError(f"like leads back to itself or too far: {' → '.join((*above, folded))}")
    other = material_of(patch, section.like, find, (*above, folded))
    return Material(like=other, transform=transform_of(resolved(transform_spec(section), find)))


def transform_spec(section: EvolutionSection) -> FormationSpec:
    """Return a formation spec with the keys that transform an evolution. PersonError, naming the key, for an invalid
    one."""
    spec = spec_from_table({"name": section.name, "like": "grid", **section.transform_table})
    return replace(spec, like=FormationSpec())


def evolution_ways(patch: Patch, name: str, find: Find) -> Float32:
    """Return the ways of an evolution as knots at even times, (D, K, 2) [m]; fast if it was computed before."""
    return danced_ways(material_of(patch, name, find))


def compute_evolutions(patch: Patch, find: Find) -> None:
    """Compute all evolutions of a patch, so that nothing is computed while its show runs. PersonError, naming the
    entry, for one that is unusable."""
    for index, section in enumerate(patch.evolution):
        with error_context(f"evolution {section.name!r}", ("evolution", index)):
            evolution_ways(patch, section.name, find)
