"""Fabrics: what garments are made of, as numbers of the simulation."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Fabric:
    """A fabric. Particles of a garment have the same mass, so a heavy fabric is one that the air holds back less."""

    drag: float
    """Drag of the air [1/s]: speed through the air that is lost per second, as a share."""
    bend: float
    """Compliance against bending [m/N] of a particle of 1 kg; small is stiff."""
    shear: float
    """Compliance against shearing [m/N] of a particle of 1 kg."""
    gravity: float = 9.81
    """Acceleration downwards [m/s2]; below 9.81 for what air carries."""
    facing: float = 0.0
    """Drag of the air across the surface [1/m], which grows with the square of the speed: half the density of air times
    a plate's drag coefficient, 1.2, over the mass per area: 0.72 / (kg/m2)."""


FABRICS: Final[dict[str, Fabric]] = {
    "silk": Fabric(drag=2.4, bend=3e-4, shear=1e-4, facing=7.2),
    "cotton": Fabric(drag=2.2, bend=6e-5, shear=4e-5, facing=4.8),
    "wool": Fabric(drag=1.5, bend=1.5e-5, shear=2e-5, facing=2.1),
    "tulle": Fabric(drag=3.0, bend=4e-6, shear=1e-5, gravity=6.0, facing=7.2),
}
"""Fabrics of skirts and sleeves by name: flowing silk, cotton, heavy wool, and tulle, which stands off."""
HAIR: Final = Fabric(drag=1.6, bend=2e-5, shear=1e-4)
"""Hair."""
RIBBON: Final = Fabric(drag=2.2, bend=1e-3, shear=3e-5, gravity=7.5)
"""Ribbons of satin."""


def fabric_of(kind: str, name: str) -> Fabric:
    """Return the fabric of a garment of a kind: `cloth`, which is made of the fabric `name`, `hair` or `ribbon`."""
    return {"hair": HAIR, "ribbon": RIBBON}.get(kind) or FABRICS[name]
