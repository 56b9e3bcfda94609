"""Fabrics: what garments are made of, as numbers of the simulation."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Fabric:
    """A fabric. Particles of a garment have the same mass, so a heavy fabric is one that the air holds back less."""

    drag: float
    """Drag of the air [1/s]: speed through the air that is lost per second, as a share. A sheet falls flat at about
    gravity / drag: thin cloth of 0.1 to 0.3 kg/m2 at 2 to 5 m/s."""
    bend: float
    """Compliance against bending [m/N] of a particle of 1 kg; small is stiff."""
    shear: float
    """Compliance against shearing [m/N] of a particle of 1 kg."""
    gravity: float = 9.81
    """Acceleration downwards [m/s2]; below 9.81 for what air carries."""


FABRICS: Final[dict[str, Fabric]] = {
    "silk": Fabric(drag=2.8, bend=3e-4, shear=1e-4),
    "cotton": Fabric(drag=2.5, bend=6e-5, shear=4e-5),
    "wool": Fabric(drag=1.6, bend=1.5e-5, shear=2e-5),
    "tulle": Fabric(drag=5.0, bend=4e-6, shear=1e-5, gravity=6.0),
}
"""Fabrics of skirts and sleeves by name: flowing silk, cotton, heavy wool, and tulle, which stands off."""
HAIR: Final = Fabric(drag=1.6, bend=2e-5, shear=1e-4)
"""Hair."""
RIBBON: Final = Fabric(drag=2.2, bend=1e-3, shear=3e-5, gravity=7.5)
"""Ribbons of satin."""


def fabric_of(kind: str, name: str) -> Fabric:
    """Return the fabric of a garment of a kind: `cloth`, which is made of the fabric `name`, `hair` or `ribbon`."""
    return {"hair": HAIR, "ribbon": RIBBON}.get(kind) or FABRICS[name]
