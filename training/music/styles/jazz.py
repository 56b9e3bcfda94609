"""Swing, jazz waltz, bossa, blues shuffle, twelve-eight blues."""

from random import Random

from training.music.bass import Bass, Walk
from training.music.build import Plan, Seat, either
from training.music.comping import Comp
from training.music.drums import Drummer, Groove
from training.music.harmony import BLUES, JAZZ, key
from training.music.melody import Melody
from training.music.piece import THREE, TWELVE
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony

SOLO = ("reeds", "solo brass", "flutes", "piano", "mallets", "electric")


@style("swing", "jazz", 1.6)
def swing(rng: Random) -> Plan:
    """Ride ding-ding-a-ding, hat pedal on two and four, walking bass."""
    found = key(rng, "major", "dorian")
    lanes = {
        "ride": rng.choice(["X...X.x.X...X.x.", "X...X.x.X...X.x.", "X...X...X...X.x.", "X.x.X.x.X.x.X.x."]),
        "pedal": "....X.......X...",
    }
    if rng.random() < 0.5:
        lanes["kick"] = rng.choice(["-...-...-...-...", "x.....x.........", "o.......o......."])
    if rng.random() < 0.6:
        lanes["snare"] = rng.choice(["......o.......o.", "..o.......o.....", "......-...-....."])
    drummer = Drummer(rng, Groove(lanes, time="ride"), None, 8, 0.5, 0.3, drop=0.08)
    seats = [
        Seat("drums", drummer, kit(rng, "jazz", "brush", "standard")),
        Seat("bass", Walk(rng), program(rng, "upright", "bass")),
        Seat(
            "comp",
            Comp(rng, ["x..x....", ".x.....x", "...x.x..", "x.....x.", "..x....x", ""], 60, 4, 0.5, anticipate=0.15),
            program(rng, "piano", "electric", "organ"),
        ),
    ]
    seats.append(Seat("lead", Melody(rng, 58, 84, 0.6, 0.35, 0.2), program(rng, *SOLO)))
    fast = rng.random() < 0.35
    return Plan(
        rng.uniform(160, 215) if fast else rng.triangular(90, 170, 130),
        seats,
        harmony(rng, found, JAZZ + BLUES[:2], 0.1),
        found,
        swing=rng.uniform(0.58, 0.68) if not fast else rng.uniform(0.54, 0.62),
        drift=0.015,
    )


@style("jazz waltz", "jazz", 0.8, held_out=True)
def jazz_waltz(rng: Random) -> Plan:
    found = key(rng, "major", "dorian")
    groove = Groove(
        {
            "ride": rng.choice(["X...X.x.X...", "X...X...X.x.", "X..x...x...."]),
            "pedal": "....X.......",
            "kick": rng.choice(["x...........", "x.....x....."]),
        },
        time="ride",
    )
    seats = [
        Seat("drums", Drummer(rng, groove, None, 8, 0.5, 0.3, drop=0.08), kit(rng, "jazz", "brush")),
        Seat("bass", either(rng, Walk(rng, skips=0.05), Bass(rng, ["X.....", "X...x.", "X..x.."], "fifth", 33)), 32),
        Seat(
            "comp",
            Comp(rng, ["..x.x.", "...x..", "x..x..", "..x..x"], 60, 4, 0.6),
            program(rng, "piano", "electric", "epiano"),
        ),
        Seat("lead", Melody(rng, 58, 84, 0.5, 0.25, 0.2), program(rng, *SOLO)),
    ]
    return Plan(
        rng.triangular(90, 200, 145),
        seats,
        harmony(rng, found, JAZZ, 0.05),
        found,
        THREE,
        swing=rng.uniform(0.56, 0.67),
        drift=0.015,
    )


@style("blues shuffle", "jazz", 1.4)
def shuffle(rng: Random) -> Plan:
    found = key(rng, "blues", "mixolydian")
    groove = Groove(
        {
            "kick": rng.choice(["X.......X.......", "X.....x.X.......", "X...x...X...x..."]),
            "snare": "....X.......X...",
            rng.choice(["hat", "ride"]): "X.x.X.x.X.x.X.x.",
        }
    )
    seats = [
        Seat("drums", Drummer(rng, groove, None, 4, 0.5), kit(rng)),
        Seat(
            "bass",
            either(rng, Walk(rng, skips=0.3), Bass(rng, ["X.x.X.x.", "xxxxxxxx", "X..xX..x"], "arpeggio")),
            program(rng, "bass", "upright"),
        ),
        Seat(
            "comp",
            Comp(rng, ["xxxxxxxx", "X..xX..x", "..x...x.", "..x..xx."], 52, 3, 0.6),
            program(rng, "electric", "piano", "organ"),
        ),
        Seat("lead", Melody(rng, 57, 80, 0.5, 0.3, 0.2), program(rng, "electric", "distorted", "reeds", "piano")),
    ]
    return Plan(
        rng.triangular(72, 176, 118),
        seats,
        harmony(rng, found, BLUES),
        found,
        swing=rng.uniform(0.6, 0.69),
        lengths=(12, 12, 24),
        drift=0.015,
    )


@style("slow twelve-eight", "jazz", 1.2)
def twelve(rng: Random) -> Plan:
    """Slow blues and doo-wop: triplets on hat and piano, snare on two and four."""
    found = key(rng, "major", "blues")
    lines = BLUES if found.scale == "blues" or rng.random() < 0.4 else ["I vi IV V", "I vi ii V7", "I iii IV V7"]
    groove = Groove(
        {
            "kick": rng.choice(["X.....X.....", "X....xX.....", "X.....X....x", "X..x..X..x.."]),
            "snare": "...X.....X..",
            rng.choice(["hat", "ride"]): rng.choice(["XooXooXooXoo", "xxxxxxxxxxxx", "X.xX.xX.xX.x"]),
        }
    )
    seats = [
        Seat("drums", Drummer(rng, groove, None, 4), kit(rng)),
        Seat(
            "bass",
            Bass(
                rng, ["X..X..X..X..", "X....xX....x", "X..x.xX..x.x", "X.xX.xX.xX.x"], rng.choice(["root", "arpeggio"])
            ),
            program(rng, "bass", "upright"),
        ),
        Seat(
            "comp",
            either(rng, Comp(rng, ["XooXooXooXoo", "xxxxxxxxxxxx"], 62, 3, 0.7), broken(rng)),
            program(rng, "piano", "electric", "organ"),
        ),
        Seat("lead", Melody(rng, 58, 82, 0.4, 0.15, 0.15), program(rng, *SOLO)),
    ]
    return Plan(rng.triangular(46, 112, 66), seats, harmony(rng, found, lines), found, TWELVE, drift=0.015)


def broken(rng: Random) -> Comp:
    """Chords in the rhythm of a shuffle."""
    return Comp(rng, ["X.xX.xX.xX.x", "X..X..X..X.."], 60, 3, 0.9, strum=0.03)
