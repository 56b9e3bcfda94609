"""Trackers of a patch."""

from typing import Annotated

from pydantic import Field

from live.show.patch.section_base import Name, Section

AXES = r"^-?[xyz] -?[xyz]$"


class PsnSection(Section):
    """`[psn]`: trackers that come in by PosiStageNet (`live play PATCH --psn 236.10.10.10:56565`). One with the name,
    or the number, of a `[[mocap]]` is that performer; see [mocap.md](mocap.md)."""

    axes: Annotated[str, Field(pattern=AXES)] = "x z"
    """Which of the tracking system's axes go to the right as the audience sees it, and towards the audience: `x z`,
    `x -z`, `-y x`."""
    others: bool = True
    """Whether dancers go around trackers that are nobody of the patch, as around real dancers."""
    trackers: Annotated[tuple[Name, ...], Field(max_length=128)] = ()
    """The trackers that there are, by name or number: a `[[mocap]]` whose `tracker` is none of them is refused, so that
    a slip of the pen is found before the show. Left out: any."""

    def on_floor(self, place: tuple[float, float, float]) -> tuple[float, float]:
        """Where on the floor that is, x, z [m]."""
        right, front = (
            (-1.0 if axis.startswith("-") else 1.0) * place["xyz".index(axis[-1])] for axis in self.axes.split()
        )
        return right, front
