"""The body in a recording's skeleton: which of its joints are the engine's."""

from dataclasses import dataclass
from typing import Final

_REQUIRED: Final = (
    *(side + joint for side in ("left", "right") for joint in ("UpperLeg", "LowerLeg", "Foot", "UpperArm", "LowerArm")),
    "hips",  # missing if a leg is the root
)


@dataclass(frozen=True, slots=True)
class SourceBody:
    """The joints of a recording that make up its body, as indices into `SourceMotion.names`."""

    joints: dict[str, int | None]
    """For each of the engine's 22 joints the source joint's index, or None."""
    spine: tuple[int, ...]
    """All trunk joints above the hips, bottom up; the last one is the parent of the arms; may be empty."""
    neck: tuple[int, ...]
    """All joints between the trunk and the head, bottom up; may be empty."""
    by_shape: bool = False
    """Whether it was found by its shape, because the names say nothing."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Required engine joints that were not found."""
        return tuple(name for name in _REQUIRED if self.joints[name] is None)

    def joint(self, name: str) -> int:
        """Return the source joint of a required engine joint; raises KeyError if there is none."""
        index = self.joints[name]
        if index is None:
            raise KeyError(name)
        return index
