"""Funk and soul."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Comp
from training.music.drums import Drummer, Groove
from training.music.figure import Figure
from training.music.harmony import MINOR, POP, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.piece import COMMON, TWELVE
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.breaks import funk_groove
from training.music.styles.rock import harmony

STABS = [
    "..x...x...x...x.",
    "x..x......x.....",
    "...x..x....x..x.",
    "x.....x...x..x..",
    "....x.......x...",
    "x.xx.x.xx.xx.x.x",
    "",
]


@style("funk", "urban", 1.6)
def funk(rng: Random) -> Plan:
    """Sixteenths; everything begins on the one."""
    found = key(rng, "dorian", "mixolydian", "minor")
    lines = (
        ["i7 i7 i7 i7", "i7 IV7", "i7 i7 IV7 i7", "I7 I7 IV7 I7"]
        if found.scale != "mixolydian"
        else ["I7 I7 I7 I7", "I7 IV7", "I7 bVII"]
    )
    seats = [
        Seat("drums", Drummer(rng, funk_groove(rng), funk_groove(rng), ghosts=rng.choice([0, 0.08])), kit(rng)),
        Seat(
            "bass",
            Figure(
                rng,
                [(0.0, 1.0), *[hit for hit in weave(rng, COMMON, 0.5, 2, 0.2) if hit[0] > 0]],
                (0, 0, 7, 10, 12, 5),
                30,
                1,
                palm=0.5,
            ),
            program(rng, "bass", "synth bass"),
        ),
        Seat("comp", Comp(rng, STABS, 64, 3, 0.35), program(rng, "electric", "epiano", "organ")),
    ]
    if rng.random() < 0.5:
        seats.append(
            Seat(
                "brass",
                Comp(rng, ["x..x............", "......x...x.....", "x.........x.xx..", ""], 66, 3, 0.5),
                program(rng, "brass", "solo brass", "reeds"),
            )
        )
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 60, 80, 0.7, 0.4, 0.3), program(rng, "reeds", "lead", "choir")))
    return Plan(
        rng.triangular(84, 126, 104),
        seats,
        harmony(rng, found, lines),
        found,
        swing_fine=rng.choice([0.5, 0.5, 0.55]),
        drift=0.01,
    )


@style("soul", "urban", 1.0)
def soul(rng: Random) -> Plan:
    """Snare on all four beats, or two and four; tambourine; slow soul in triplets."""
    found = key(rng, "major", "mixolydian", "minor")
    slow = rng.random() < 0.35
    metre = TWELVE if slow else COMMON
    groove = (
        Groove({"kick": "X.....X.....", "snare": "...X.....X..", "hat": "XxxXxxXxxXxx"})
        if slow
        else Groove(
            {
                "kick": rng.choice(["X.....x.X.......", "X...X...X...X...", "X..x..x.X.x....."]),
                "snare": rng.choice(["X...X...X...X...", "....X.......X..."]),
                "hat": "x.x.x.x.x.x.x.x.",
                "tamb": rng.choice(["....X.......X...", "..x...x...x...x."]),
            }
        )
    )
    seats = [
        Seat("drums", Drummer(rng, groove), kit(rng)),
        Seat(
            "bass",
            Bass(rng, ["X..xX..xX..x" if slow else "X.xxX.x.", "X....xX....." if slow else "X..xX.xx"], "arpeggio"),
            program(rng, "bass"),
        ),
        Seat(
            "comp",
            Comp(
                rng,
                ["..x..x..x..x", "XxxXxxXxxXxx"] if slow else ["..x...x.", "x.x.x.x.", "....x.......x..."],
                60,
                3,
                0.5,
            ),
            program(rng, "piano", "electric", "organ"),
        ),
        Seat("lead", Melody(rng, 58, 80, 0.5, 0.3), program(rng, "reeds", "choir", "solo brass", "organ")),
    ]
    lines = MINOR if found.scale == "minor" else POP
    return Plan(
        rng.uniform(50, 80) if slow else rng.triangular(92, 138, 114),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        drift=0.015,
    )
