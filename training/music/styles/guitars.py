"""Guitars without a band: strummed and picked."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Arpeggio, Comp
from training.music.drums import Groove
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.piece import COMMON, THREE, TWELVE, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.ballads import pop_key
from training.music.styles.rock import STRUM, harmony


@style("strummed guitar", "ballad", 1.4)
def strummed(rng: Random) -> Plan:
    """One guitar strummed, with or without a voice; strong down-strokes on the beats."""
    found, lines = pop_key(rng)
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    lines_of = STRUM if metre.beats == 4 else ["X.x.x.", "X.xoxo", "X.xxxx", "XoxoXo"]
    guitar = Comp(rng, lines_of, 57, rng.choice([4, 5]), 0.9, rng.uniform(0.005, 0.03), level=0.7)
    seats = [Seat("comp", guitar, program(rng, "steel", "nylon", "electric", wild=0))]
    if rng.random() < 0.75:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 57, 79, rng.uniform(0.3, 0.6), 0.25, pickup=0.6),
                program(rng, "choir", "reeds", "flutes", "violin", "pipes"),
            )
        )
    if rng.random() < 0.3:
        line = "....x.......x..." if metre.beats == 4 else "....x...x..."
        seats.append(
            Seat("percussion", Percussion(rng, Groove({rng.choice(["clap", "tamb", "shaker"]): line})), kit(rng))
        )
    return Plan(
        rng.triangular(66, 152, 104),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        drift=rng.uniform(0.01, 0.03),
        swing=rng.choice([0.5, 0.5, 0.5, 0.62]),
        swing_fine=rng.choice([0.5, 0.5, 0.58]),
    )


@style("picked guitar", "ballad", 1.3)
def picked(rng: Random) -> Plan:
    """Finger-picking and arpeggio ballads: thumb on the beats, fingers between."""
    found, lines = pop_key(rng)
    metre = rng.choice([COMMON, COMMON, THREE, Metre(2, 3), TWELVE])
    rate = 3 if metre.div == 3 else rng.choice([2, 2, 4])
    shapes = (
        [(0, 2, 3, 2), (0, 3, 1, 2), (0, 1, 2, 3, 4, 3, 2, 1), (0, 2, 1, 3), (0, 4, 2, 3), None]
        if rate != 3
        else [(0, 1, 2), (0, 2, 1), (0, 1, 2, 3, 2, 1), None]
    )
    guitar = program(rng, "nylon", "steel", "electric", "harp", wild=0.1)
    seats = [Seat("arpeggio", Arpeggio(rng, rate, rng.choice(shapes), 56, 4, 2.0), guitar)]
    if rng.random() < 0.7:
        seats.append(
            Seat(
                "bass",
                Bass(
                    rng, [{4: "X...X...", 3: "X.....", 2: "X.X."}[metre.beats]], rng.choice(["root", "fifth"]), 36, 1.0
                ),
                guitar,
            )
        )
    if rng.random() < 0.6:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 60, 82, 0.3, 0.15, pickup=0.5),
                program(rng, "flutes", "violin", "choir", "reeds", "nylon"),
            )
        )
    low, high = (56, 110) if rate != 4 else (46, 92)
    return Plan(
        rng.uniform(low, high),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        timing=rng.choice(["human", "expressive"]),
        drift=rng.uniform(0.01, 0.05),
    )
