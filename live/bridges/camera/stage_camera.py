"""`[[stage_camera]]` of a venue: the cameras that look at the stage."""

from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from live.show.patch.section_base import Name, Section

MOST_CAMERAS: Final = 4
ANY, OFF = "any", "off"
"""Sources: the first camera, and none."""

Coordinate = Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=-1, le=2, allow_inf_nan=False)]
Mark = tuple[Coordinate, Coordinate, Share, Share]
Corner = tuple[Share, Share]


class StageCamera(Section):
    """`[[stage_camera]]`: a camera that looks at the stage and sees performers; see `live docs stage-camera`."""

    name: Name
    """Its name in the status."""
    source: Annotated[str, Field(min_length=1, max_length=500)] = ANY
    """The camera: its number or name, a film, an `rtsp://` address, or `any` for the first one."""
    turn_deg: Literal[0, 90, 180, 270] = 0
    """How far its pictures have to be turned, counter-clockwise, to be upright."""
    marks: Annotated[tuple[Mark, ...], Field(max_length=32)] = ()
    """Marks on the floor: x and z on the stage [m], and the place in the upright picture (shares of its width from the
    left, of its height from the top); four or more, around a convex shape. `live calibrate camera` writes them."""
    screen: Annotated[tuple[Corner, ...], Field(max_length=4)] = ()
    """Where the camera sees the projected picture: its upper left, upper right, lower right, lower left corner, in
    shares of the camera's picture. Drawn dancers there are not taken for people."""
    silhouette: bool = False
    """Whether the silhouettes of those whom it sees are published on this machine, as `shm:camera-NAME`."""

    @model_validator(mode="after")
    def _counts_fit(self) -> "StageCamera":
        if 0 < len(self.marks) < 4:
            raise ValueError(f"stage camera {self.name!r}: {len(self.marks)} marks: four or more are needed")
        if len(self.screen) not in (0, 4):
            raise ValueError(f"stage camera {self.name!r}: {len(self.screen)} corners of the screen: four are needed")
        return self


class CameraTables(Section):
    """The table of a venue that this bridge reads."""

    stage_camera: Annotated[tuple[StageCamera, ...], Field(max_length=MOST_CAMERAS)] = ()
