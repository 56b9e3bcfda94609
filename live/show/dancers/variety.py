"""Variety: what may be varied in the dancing of one group, and what a patch says of it (T051-T060)."""

from dataclasses import dataclass, fields, replace

from live.show.patch.motion import MotionSection
from live.show.patch.patch import Patch


@dataclass(frozen=True, slots=True)
class Variety:
    """What may be varied, for one group; the live controls `/dance/motion/...` set the same fields."""

    warp_beats: float = 0.0
    """Largest time warp [beats] (A_max of T055)."""
    warp_sequence: float = 0.0
    """1: the warp runs over the whole sequence (T056), 0: it ends with each measure (T055)."""
    larger: float = 0.0
    """By how much everybody's upper body moves more than recorded, all alike."""
    amplitude: float = 0.0
    """R_max: how much larger or smaller the upper body moves (T058)."""
    amplitude_sequence: float = 0.0
    """1: the amplitude changes slowly over the sequence (T059), 0: anew for each measure (T060)."""
    mix: float = 0.0
    """How far another take of the same step is mixed into the whole body at most (T045)."""
    arms: float = 0.0
    """Share of the dancers whose upper body is that of another take (T044)."""
    head: float = 0.0
    """How far heads turn to the public (T123-T125)."""
    lock: float = 1.0
    """1: feet that carry stay where they are, and no sole goes below the floor; 0: as the clips have it."""
    on_support: float = 1.0
    """1: dancers turn on the foot that carries (T048-T050), 0: evenly over the measure."""
    face_average: float = 0.0
    """1: a measure's average heading is brought to where the dancer should face (T122), 0: that at its end."""

    obedience: float = 0.5
    """0: steps are danced faithfully, 1: dancers are carried to where the group wants them as far as legs reach."""
    texture: float = 0.0
    """How far upper bodies are those of recorded dancers, chosen live by what legs do (P024); 0: as in the steps."""
    mirror: float = 0.0
    """-1: steps as they were made, 1: their mirror images where there are any, 0: both (T042)."""

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """The fields, in order."""
        return tuple(field.name for field in fields(cls))


def variety_of(section: MotionSection) -> Variety:
    """What a patch says."""
    return Variety(
        warp_beats=section.warp_beats,
        warp_sequence=float(section.warp_over == "sequence"),
        larger=section.larger,
        amplitude=section.amplitude,
        amplitude_sequence=float(section.amplitude_over == "sequence"),
        mix=section.mix,
        arms=section.arms,
        head=section.head,
        texture=section.texture,
        lock=float(section.foot_lock),
        on_support=float(section.turn_on == "support"),
        face_average=float(section.face == "average"),
        mirror={"both": 0.0, "never": -1.0, "only": 1.0}[section.mirror],
    )


def varieties_of(patch: Patch) -> list[Variety]:
    """What a patch says of each group; a group that mirrors another one dances mirror images, and that one none."""
    varieties = [variety_of(patch.motion_of(section)) for section in patch.group]
    for index, section in enumerate(patch.group):
        obedience = patch.locomotion.obedience if section.obedience is None else section.obedience
        varieties[index] = replace(varieties[index], obedience=obedience)
    names = [section.name for section in patch.group]
    for index, section in enumerate(patch.group):
        if section.like is None or not section.mirrored:
            continue
        varieties[index] = replace(varieties[index], mirror=1.0)
        leader = names.index(section.like)
        if varieties[leader].mirror == 0.0:
            varieties[leader] = replace(varieties[leader], mirror=-1.0)
    return varieties
