"""Pairs: what a TOML file says of recordings of a leader and a follower who were recorded together (H001)."""

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from live.library.recording import FileName, Word
from live.motion.partner.units import BEATS_OF_UNIT

ELSEWHERE: Final = (
    "start_measure", "measures", "beats_per_measure", "leading_foot", "begin_pose", "end_pose", "weight_transfer",
    "direction", "distance_m", "tags", "author", "style", "unstructured", "mirror",
)  # fmt: skip
"""Keys of the same vocabulary that say nothing here: they may stand there."""
Time = Annotated[float, Field(ge=0, le=36_000)]
Hand = Literal["left", "right", "leftHand", "rightHand"]


class Beats(BaseModel):
    """Where the beats lie, counted from the first frame that is kept."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    beat_s: Annotated[float, Field(ge=0.15, le=3)] | None = None
    """Seconds of a beat, in place of `bpm`."""
    first_beat_s: Time | None = None
    """When some first beat of a unit falls [s]."""

    @property
    def period(self) -> float | None:
        """Seconds of a beat, if that is said."""
        return self.beat_s if self.beat_s is not None else None if self.bpm is None else 60.0 / self.bpm


class Side(Beats):
    """One of the two recordings."""

    file: FileName
    name: Word | None = None
    skeleton: FileName | None = None
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """True frame rate where the file's header lies."""
    unit_m: Annotated[float, Field(gt=0, le=10)] | None = None
    up: Literal["Y", "Z"] | None = None
    drop_frames: Annotated[int, Field(ge=0, le=10_000_000)] = 0
    repair: bool = False
    """Whether tracking faults are mended where that is safe (T161)."""

    @model_validator(mode="before")
    @classmethod
    def _pass_over(cls, values: Any) -> Any:
        if isinstance(values, dict):
            return {key: value for key, value in values.items() if key not in ELSEWHERE}
        return values


class Pair(Beats):
    """Two recordings of one take, frame by frame beside each other; without `leader` a walk, which its path leads."""

    leader: Side | None = None
    follower: Side
    name: Word | None = None
    cuts_s: list[Time] | None = None
    """Where units begin and end [s], by hand; in place of beats."""
    holds: list[tuple[Hand, Hand, Time, Time]] = []
    """Hand of the leader, hand of the follower, from, to [s]: who holds what when."""


class PairsFile(BaseModel):
    """A database of examples."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    pair: Annotated[list[Pair], Field(min_length=1, max_length=1000)]
    unit_beats: Annotated[int, Field(ge=1, le=16)] = BEATS_OF_UNIT
    """Beats of a unit."""
    cut: Literal["beats", "steps"] | None = None
    """Where units are cut: at every `unit_beats`th beat, or wherever a foot lands (walks)."""
