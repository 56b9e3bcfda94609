"""Chorales and chamber music."""

from random import Random

from training.music.bass import Bass, Walk
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp, Pad
from training.music.figure import Shadow
from training.music.harmony import key
from training.music.melody import Melody
from training.music.piece import COMMON, JIG, THREE, TWO
from training.music.programs import program
from training.music.registry import style
from training.music.styles.rock import harmony
from training.music.styles.waltz import old_key

CHORALE = ["I,V,vi,IV I,IV,V,I", "I,I,IV,V I,vi,ii,V I,V,vi,iii IV,I,V,I", "I,V,I,IV V,vi,V,V"]


CHORALE_MINOR = ["i,V,i,iv i,iv,V,i", "i,bVII,bVI,V i,iv,V,V", "i,i,iv,V bVI,iv,V,i"]


@style("chorale", "classical", 0.8)
def chorale(rng: Random) -> Plan:
    """Four voices, a chord on every beat, a fermata at the end of each line."""
    found = key(rng, "major", "harmonic")
    group = rng.choice(["organ", "choir", "brass", "strings", "solo brass", "reeds"])
    instrument = program(rng, group, wild=0.02)
    seats = [
        Seat("pad", Pad(rng, 58, 3, 0.6), instrument),
        Seat("bass", Walk(rng, 36, 0.0), instrument, 0.9),
        Seat("lead", Melody(rng, 66, 79, 0.1, 0.0, 0.0, 0.5, 0.05), instrument),
    ]
    return Plan(
        rng.uniform(54, 104),
        seats,
        harmony(rng, found, CHORALE if found.scale == "major" else CHORALE_MINOR),
        found,
        COMMON,
        timing="expressive",
        drift=rng.uniform(0.04, 0.15),
        tight=1.5,
    )


@style("quartet", "classical", 1.0)
def quartet(rng: Random) -> Plan:
    """Strings or winds: repeated eighths inside, bass on the beats, a tune on top."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, COMMON, THREE, TWO, JIG])
    group = rng.choice(
        [
            ("solo strings", "strings"),
            ("reeds", "reeds"),
            ("flutes", "reeds"),
            ("strings", "strings"),
            ("solo brass", "brass"),
        ]
    )
    unit = 3 if metre.div == 3 else 2
    inner = either(
        rng,
        Comp(
            rng,
            [
                "x" * unit * metre.beats,
                "." + "x" * (unit * metre.beats - 1),
                ("." + "x" * (unit - 1)) * metre.beats,
            ],
            60,
            2,
            0.7,
        ),
        Arpeggio(rng, unit if unit == 3 else rng.choice([2, 4]), None, 60, 3),
    )
    melody = Melody(rng, 66, 88, rng.uniform(0.3, 0.8), 0.05, 0.08, 0.5)
    seats = [
        Seat(
            "bass",
            Bass(
                rng,
                ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats],
                rng.choice(["root", "fifth", "arpeggio"]),
                36,
            ),
            program(rng, group[1]),
        ),
        Seat("comp", inner, program(rng, group[1]), 0.8),
        Seat("lead", melody, program(rng, group[0], "violin")),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("second", Shadow(melody), program(rng, group[0]), 0.8))
    return Plan(
        rng.triangular(60, 160, 112),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.015, 0.06),
        tight=1.4,
    )
