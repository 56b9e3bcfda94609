"""Facing: where the dancers of a group look, in a few words, in the patch and live."""

import math
import re
from dataclasses import dataclass
from typing import Final

from live.base.errors import PersonError

PUBLIC: Final = "public"
PATH: Final = "path"
CENTRE: Final = "centre"
ATTRACTOR: Final = "attractor"
DEGREES: Final = "degrees"
DANCER: Final = "dancer"
GROUP: Final = "group"
_WAYS: Final = "public, path, centre, attractor, a number of degrees, `dancer 3`, `group tide`"


@dataclass(frozen=True, slots=True)
class Facing:
    """Where to look."""

    kind: str = PUBLIC
    degrees: float = 0.0
    """The heading, for DEGREES: 0 is the public, towards +90 the right as the audience sees it."""
    dancer: int = 0
    """Whom to look at, for DANCER, from 0."""
    name: str = ""
    """The group, for GROUP."""

    @property
    def heading(self) -> float:
        """The heading [rad], for DEGREES."""
        return math.radians(self.degrees)


def parse_facing(words: str, *, dancers: int, groups: tuple[str, ...]) -> Facing:
    """What the words mean where there are so many dancers, and groups of these names (casefolded); else PersonError."""
    said = " ".join(words.casefold().split())
    if said in (PUBLIC, PATH, CENTRE, ATTRACTOR):
        return Facing(said)
    if re.fullmatch(r"[+-]?[0-9]{1,4}(\.[0-9]{1,6})?", said) and abs(float(said)) <= 360.0:
        return Facing(DEGREES, degrees=float(said))
    if match := re.fullmatch(r"dancer ([0-9]{1,5})", said):
        number = int(match[1])
        if not 1 <= number <= dancers:
            raise PersonError(f"facing {words[:60]!r}: there are dancers 1 to {dancers}")
        return Facing(DANCER, dancer=number - 1)
    name = said.removeprefix("group ").strip()
    if name in groups:
        return Facing(GROUP, name=name)
    raise PersonError(f"facing {words[:60]!r} means nothing", f"possible are {_WAYS}")
