"""Reggae (one drop, rockers, steppers), dub, ska."""

from random import Random

from training.music.bass import Bass, Walk
from training.music.build import Plan, Seat, either
from training.music.comping import Comp
from training.music.drums import Drummer, Groove
from training.music.figure import Figure
from training.music.harmony import MINOR, POP, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.piece import COMMON
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony

LINES = ["I IV", "I IV I V", "I ii", "I V vi IV", "I I IV V"]
SAD = ["i iv", "i bVII", "i iv i V", "i bVI", *MINOR[:3]]


@style("reggae", "reggae", 1.5)
def reggae(rng: Random) -> Plan:
    """The chord on every off-beat; kick and rim together on two and four (no kick on one), or a kick on every beat."""
    found = key(rng)
    drop = {
        "kick": "....X.......X...",
        rng.choice(["rim", "snare"]): "....X.......X...",
        "hat": rng.choice(["x.x.x.x.x.x.x.x.", "xoxoxoxoxoxoxoxo", "x.xxx.xxx.xxx.xx"]),
    }
    steppers = {**drop, "kick": "X...X...X...X..."}
    rockers = {**drop, "kick": "X.....x.X......."}
    groove = Groove(rng.choice([drop, drop, drop, steppers, rockers]))
    bass = Figure(
        rng,
        [(0.0, 1.0), *[hit for hit in weave(rng, COMMON, 0.45, 1, 0.3) if hit[0] > 0]],
        (0, 0, 3, 4, 7, 12) if found.scale == "major" else (0, 0, 3, 7, 10),
        30,
        palm=0.8,
    )
    seats = [
        Seat("drums", Drummer(rng, groove, fill_every=4, ride=0.2), kit(rng)),
        Seat(
            "bass",
            either(rng, bass, Bass(rng, ["X.xxX.x.", "..xxX.x.", "X..xx.x.", "....X.xx"], "arpeggio", 28)),
            program(rng, "bass"),
        ),
        Seat(
            "comp",
            Comp(rng, ["..x...x...x...x.", "..xx..xx..xx..xx", "..X...X...X...X."], 60, 3, 0.3),
            program(rng, "electric", "organ", "piano"),
        ),
    ]
    if rng.random() < 0.5:
        seats.append(
            Seat(
                "comp2",
                Comp(rng, [".xx..xx..xx..xx.", "..xo..xo..xo..xo", "..x...x...x...x."], 60, 3, 0.35),
                program(rng, "organ"),
                0.7,
            )
        )
    if rng.random() < 0.7:
        seats.append(
            Seat("lead", Melody(rng, 58, 80, 0.5, 0.3), program(rng, "choir", "reeds", "solo brass", "lead", "flutes"))
        )
    return Plan(
        rng.triangular(60, 98, 74),
        seats,
        harmony(rng, found, LINES if found.scale == "major" else SAD),
        found,
        swing_fine=rng.choice([0.5, 0.58, 0.64]),
        drift=0.01,
    )


@style("ska", "reggae", 0.9)
def ska(rng: Random) -> Plan:
    """Fast: guitar on the off-beats, walking bass, snare and kick on two and four, brass riffs."""
    found = key(rng, "major", "major", "minor")
    groove = Groove(
        {
            "kick": rng.choice(["....X.......X...", "X...X...X...X...", "X.......X......."]),
            "snare": "....X.......X...",
            "hat": rng.choice(["x.x.x.x.x.x.x.x.", "..x...x...x...x."]),
        }
    )
    seats = [
        Seat("drums", Drummer(rng, groove), kit(rng)),
        Seat(
            "bass",
            either(rng, Walk(rng, skips=0), Bass(rng, ["X.x.X.x.", "xxxxxxxx"], "arpeggio")),
            program(rng, "bass"),
        ),
        Seat("comp", Comp(rng, ["..X...X...X...X."], 62, 3, 0.3), program(rng, "electric", "organ", "piano")),
        Seat(
            "brass",
            either(
                rng, Comp(rng, ["X..x..x.........", "x.x...x.x.......", ""], 66, 3, 0.5), Melody(rng, 60, 79, 0.5, 0.3)
            ),
            program(rng, "brass", "solo brass", "reeds"),
        ),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 58, 80, 0.5, 0.2), program(rng, "choir", "reeds", "lead")))
    return Plan(
        rng.triangular(104, 176, 128),
        seats,
        harmony(rng, found, POP if found.scale == "major" else MINOR),
        found,
        drift=0.015,
        swing=rng.choice([0.5, 0.5, 0.58]),
    )
