"""A partner on the stage: `[[partner]]`."""

from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from live.show.patch.section_base import Amiss, Name, Section, Share

LONG: Final = 0.4
"""For how long [s] hands are near that count as held, where the patch does not say."""
Who = Annotated[str, Field(min_length=1, max_length=400)]


class PartnerSection(Section):
    """`[[partner]]`: dancers who answer a leader, live, as the followers of examples have answered theirs."""

    name: Name
    """What the two are called by `/dance/partner/...`, and by signals `unit:...`."""
    leader: Who
    """Who leads: a group, or groups, attributes and numbers as in `ember & 1`; any dancer, one of live motion, too.
    `path`: nobody; each follower walks along the way of her own agent, by examples of walks."""
    follower: Who
    """Who answers, likewise: as many as lead, in their order, or all of them one leader."""
    examples: Annotated[str, Field(min_length=1, max_length=1000)] | None = None
    """A TOML file of pairs (docs/partner.md), looked up in the patch's folder, then in the project's patches; left out:
    the steps of the show, each followed by the one that goes along with it best."""
    steps: Annotated[tuple[Annotated[str, Field(min_length=1, max_length=100)], ...], Field(max_length=100)] = ()
    """Which of the show's steps, where there are no `examples`; left out: all, and `walk` along a way."""
    on: bool = True
    """Whether they begin at once."""
    amount: Share = 1.0
    """How far the answer is in: 0 her own steps, 1 all answer."""
    stretch: Annotated[float, Field(ge=0, le=0.4)] = 0.15
    """How much earlier or later than the beat a unit may begin or end at most [s]."""
    window: Annotated[float, Field(ge=0, le=0.4)] = 0.04
    """How much earlier or later it may do so at first [s]; `/dance/partner/stretch` changes it."""
    place: Literal["with", "own"] | None = None
    """Where the answer is danced: `with` the leader, as in the examples, or each follower at her `own` place, from
    where she goes as the answer goes; left out: with the leader by who has one of her own."""
    unit_beats: Annotated[int, Field(ge=1, le=16)] = 2
    """Beats of a unit of the show's steps; a file of pairs says its own."""
    hands: Share = 1.0
    """How far hands are held where those of the examples are: 0 as they are danced, 1 held, as far as arms reach."""
    hold_distance: Annotated[float, Field(ge=0.02, le=1)] | None = None
    """Where a pair says no `holds`: hands count as held whose palms are within this of each other in the examples [m];
    left out: only what is written down is held."""
    hold_time: Annotated[float, Field(ge=0.05, le=60)] | None = None
    """For how long they must be so near [s], 0.4 if left out; a hold lasts until they are half as far again apart."""

    @model_validator(mode="after")
    def _somebody_to_hold(self) -> Self:
        if self.hold_distance is None and self.hold_time is not None:
            raise Amiss("hold_time without hold_distance: no holds are looked for; say how near hands are", "hold_time")
        if self.hold_distance is not None and (self.by_path or self.place == "own"):
            why = "who is led by her own way" if self.by_path else 'who dances at her own place (place = "own")'
            raise Amiss(f"{why} holds nobody's hands; leave hold_distance out", "hold_distance")
        return self

    @property
    def near(self) -> tuple[float, float] | None:
        """How near [m] for how long [s] hands are that count as held, None where nothing is looked for."""
        return None if self.hold_distance is None else (self.hold_distance, self.hold_time or LONG)

    @property
    def by_path(self) -> bool:
        """Whether nobody leads but each follower's own way."""
        return self.leader.strip().casefold() == "path"
