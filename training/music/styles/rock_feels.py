"""More of the band: ballads, punk, rock in three, pop made on a computer."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Drummer, Groove
from training.music.form import layers
from training.music.harmony import MINOR, POP, key
from training.music.melody import Melody
from training.music.piece import THREE
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import KICKS, backbeat, harmony, rock_harmony


@style("rock ballad", "band", 2.6)
def rock_ballad(rng: Random) -> Plan:
    """Slow, with eighth or sixteenth hats: everybody doubles it."""
    found, chords = rock_harmony(rng)
    hats = rng.choice(["x.x.x.x.x.x.x.x.", "xoxoxoxoxoxoxoxo", "XoxoXoxoXoxoXoxo", "x...x...x...x..."])
    verse = Groove({"kick": rng.choice(KICKS), "snare": "....X.......X...", "hat": hats})
    verse2 = Groove({"kick": rng.choice(KICKS), "rim": "....X.......X...", "hat": hats})
    drummer = Drummer(rng, rng.choice([verse, verse2]), Groove({**verse.lanes, "kick": rng.choice(KICKS)}))
    seats = [
        Seat("drums", drummer, kit(rng)),
        Seat(
            "bass",
            Bass(rng, ["X.......", "X...X...", "X..xX...", "X..xX.xx", "X.....x."], "root"),
            program(rng, "bass"),
        ),
        Seat(
            "comp",
            Arpeggio(rng, rng.choice([2, 2, 4, 4, 3]), voices=rng.choice([3, 4])),
            program(rng, "piano", "nylon", "steel", "electric"),
            0.9,
        ),
    ]
    if rng.random() < 0.7:
        seats.append(Seat("pad", Pad(rng, 62), program(rng, "strings", "pad", "organ", "choir"), 0.7))
    if rng.random() < 0.7:
        seats.append(
            Seat("lead", Melody(rng, 60, 82, 0.5, 0.25), program(rng, "lead", "reeds", "choir", "distorted", "flutes"))
        )
    return Plan(rng.triangular(52, 92, 70), seats, chords, found)


@style("punk", "band", 1.8)
def punk(rng: Random) -> Plan:
    """Fast: the snare on two and four of a fast bar, or on every off-beat (d-beat, skank)."""
    found, chords = rock_harmony(rng)
    skank = Groove({"kick": "X...X...X...X...", "snare": "..X...X...X...X.", "hat": "X.x.X.x.X.x.X.x."})
    normal = Groove(
        {
            "kick": rng.choice(["X.......X.x.....", "X.....x.X.......", "X.......X......."]),
            "snare": "....X.......X...",
            "hat": rng.choice(["X.x.X.x.X.x.X.x.", "X...X...X...X..."]),
        }
    )
    polka = Groove({"kick": "X...X...X...X...", "snare": "..X...X...X...X.", "ride": "X...X...X...X..."})
    fast = rng.random() < 0.5
    drummer = Drummer(rng, normal if fast else skank, rng.choice([normal, skank, polka]), rng.choice([4, 8]))
    drummer.chorus = drummer.chorus if fast is False else normal
    bpm = rng.uniform(150, 212) if fast else rng.uniform(128, 190)
    seats = [
        Seat("drums", drummer, kit(rng)),
        Seat("bass", Bass(rng, ["xxxxxxxx", "XxXxXxXx", "X.X.X.X."], "root"), 34),
        Seat("comp", Comp(rng, ["xxxxxxxx", "X.xxX.xx", "X.......", "XxxxXxxx"], 52, 3, 0.9), rng.choice([29, 30, 30])),
    ]
    if rng.random() < 0.6:
        seats.append(Seat("lead", Melody(rng, 60, 80, 0.4, 0.15), program(rng, "distorted", "lead", "choir", "reeds")))
    return Plan(bpm, seats, chords, found, drift=0.02)


@style("rock in three", "band", 1.3)
def rock_three(rng: Random) -> Plan:
    found, chords = rock_harmony(rng)
    hats = rng.choice(["x.x.x.x.x.x.", "X.o.X.o.X.o.", "x...x...x...", "xoxoxoxoxoxo"])
    snare = rng.choice(["....X...X...", "........X...", "....X.......", "....X...X...", "......X....."])
    drummer = Drummer(
        rng,
        Groove(
            {
                "kick": rng.choice(["X...........", "X.....x.....", "X.........x.", "X..x........"]),
                "snare": snare,
                "hat": hats,
            }
        ),
    )
    seats = [
        Seat("drums", drummer, kit(rng)),
        Seat(
            "bass",
            Bass(rng, ["X.....", "X...x.", "X.x.x.", "XxxxxX", "X..x.."], rng.choice(["root", "fifth", "arpeggio"])),
            program(rng, "bass"),
        ),
        Seat(
            "comp",
            either(
                rng,
                Comp(rng, ["X.x.x.", "X.....", "..x.x.", "X.xxxx"], 57),
                Arpeggio(rng, 2, voices=4),
                Arpeggio(rng, 4, voices=4),
            ),
            program(rng, "electric", "steel", "piano"),
        ),
        Seat(
            "lead",
            Melody(rng, 60, 82, rng.uniform(0.2, 0.6), 0.1),
            program(rng, "lead", "reeds", "flutes", "choir", "distorted"),
        ),
    ]
    return Plan(rng.triangular(82, 185, 118), seats, chords, found, THREE, drift=0.015)


@style("pop loop", "band", 1.5)
def pop_loop(rng: Random) -> Plan:
    """Pop made on a computer: layers over one loop, a machine's tempo."""
    found = key(rng)
    seats = [
        Seat("drums", Drummer(rng, backbeat(rng), None, 8, 0.5), kit(rng, "electronic", "808", "power")),
        Seat("clap", Drummer(rng, Groove({"clap": "....X.......X..."}), fills=0, crash=0), kit(rng, "808")),
        Seat(
            "bass",
            Bass(rng, ["X..x..x.", "xxxxxxxx", "X.....x.", "..x...x."], rng.choice(["root", "octave"])),
            program(rng, "synth bass", "bass"),
        ),
        Seat(
            "comp",
            Comp(rng, ["X..x..x.", "..x...x.", "X.......", "x.x.x.x."], 62),
            program(rng, "epiano", "piano", "pad", "lead"),
        ),
        Seat(
            "arpeggio",
            Arpeggio(rng, rng.choice([2, 4]), voices=4),
            program(rng, "lead", "bells", "mallets", "electric"),
        ),
        Seat("lead", Melody(rng, 62, 84, 0.5, 0.3), program(rng, "lead", "choir", "flutes")),
    ]
    return Plan(
        rng.triangular(76, 136, 106),
        seats,
        harmony(rng, found, POP + MINOR if found.scale == "minor" else POP),
        found,
        timing="machine",
        sections=layers(rng, [seat.role for seat in seats]),
    )
