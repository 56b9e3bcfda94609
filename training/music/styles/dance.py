"""Dance floor: disco, house, techno, trance, and its breakdowns without drums."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Drummer, Groove
from training.music.form import layers
from training.music.harmony import JAZZ, MINOR, POP, key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony

FOUR = "X...X...X...X..."


def floor(rng: Random) -> Groove:
    """Kick on every beat, open hat between, clap or snare on two and four."""
    lanes = {"kick": rng.choice([FOUR, FOUR, FOUR, "X...X...X...X..x", "X...X...X..xX..."])}
    lanes[rng.choice(["clap", "snare", "clap", "snare2"])] = rng.choice(
        ["....X.......X...", "....X.......X...", "....X.......X..-", "................"]
    )
    lanes[rng.choice(["open", "open", "hat"])] = rng.choice(
        ["..X...X...X...X.", "..x...x...x...x.", "..x...x...x...xx"]
    )
    if rng.random() < 0.6:
        lanes["hat"] = rng.choice(["xoxoxoxoxoxoxoxo", "x.oox.oox.oox.oo", "..o...o...o...o.", "o.xoo.xoo.xoo.xo"])
    if rng.random() < 0.3:
        lanes[rng.choice(["shaker", "tamb", "cabasa"])] = rng.choice(
            ["oxXxoxXxoxXxoxXx", "o.x.o.x.o.x.o.x.", "xoxoxoxoxoxoxoxo"]
        )
    return Groove(lanes)


@style("house", "dance", 2.0)
def house(rng: Random) -> Plan:
    found = key(rng, "minor", "dorian", "major")
    lines = {"major": POP + JAZZ}.get(found.scale, [*MINOR, "i i i i", "im7 iv7", "i bVII", "i i bVI bVII"])
    seats = [
        Seat(
            "drums",
            Drummer(rng, floor(rng), floor(rng) if rng.random() < 0.3 else None, 8, 0.4, 0.5),
            kit(rng, "electronic", "808", "power", "standard"),
        ),
        Seat(
            "bass",
            Bass(
                rng,
                [
                    "..x...x...x...x.",
                    "x..x..x.",
                    "..xx..xx..xx..xx",
                    "xxxxxxxx",
                    "X..x..x...x.x...",
                    ".xxx.xxx.xxx.xxx",
                ],
                rng.choice(["root", "octave", "arpeggio"]),
                legato=0.6,
            ),
            program(rng, "synth bass", "bass"),
        ),
        Seat(
            "comp",
            Comp(
                rng,
                ["..x...x...x...x.", "X..x..x...x..x..", "x..x..x.....x...", "...x..x....x..x."],
                62,
                rng.choice([3, 4]),
                0.4,
            ),
            program(rng, "piano", "epiano", "organ", "lead", "pad"),
        ),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("pad", Pad(rng, 62), program(rng, "strings", "pad", "choir"), 0.7))
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 64, 86, 0.6, 0.4, 0.25), program(rng, "lead", "piano", "reeds")))
    return Plan(
        rng.triangular(112, 136, 124),
        seats,
        harmony(rng, found, lines),
        found,
        timing="machine",
        sections=layers(rng, [seat.role for seat in seats]),
        swing_fine=rng.choice([0.5, 0.5, 0.55, 0.6]),
    )


@style("techno", "dance", 1.5)
def techno(rng: Random) -> Plan:
    found = key(rng, "minor", "phrygian", "minor pentatonic")
    noise = {
        drum: "".join(rng.choice("..xo-") for _ in range(rng.choice([16, 16, 12, 6, 32])))
        for drum in rng.sample(["rim", "block1", "tom5", "cowbell", "claves", "conga", "shaker"], 2)
    }
    seats = [
        Seat("drums", Drummer(rng, floor(rng), None, 16, 0.3, 0.4), kit(rng, "electronic", "808")),
        Seat(
            "percussion",
            Percussion(
                rng,
                Groove(
                    {name: line for name, line in noise.items() if len(line) % 4 == 0} or {"rim": "..x...x...x..x.."}
                ),
            ),
            kit(rng, "808"),
        ),
        Seat(
            "bass",
            Bass(
                rng,
                ["xxxxxxxxxxxxxxxx", ".xxx.xxx.xxx.xxx", "..x...x...x...x.", "..xx..xx..xx..xx"],
                "root",
                legato=0.5,
            ),
            program(rng, "synth bass"),
        ),
        Seat(
            "arpeggio",
            Arpeggio(rng, 4, voices=rng.choice([2, 3, 4]), gaps=rng.choice([0, 0, 0.2]), hold=0.6),
            program(rng, "lead", "bells"),
        ),
    ]
    if rng.random() < 0.6:
        seats.append(Seat("pad", Pad(rng, 60, again=rng.random() < 0.5), program(rng, "pad", "strings")))
    return Plan(
        rng.triangular(120, 150, 132),
        seats,
        harmony(rng, found, ["i i i i", "i bVII i bVI", "i bII", *MINOR]),
        found,
        timing="machine",
        sections=layers(rng, [seat.role for seat in seats]),
        lengths=(8, 8, 16),
    )


@style("disco", "dance", 1.3, held_out=True)
def disco(rng: Random) -> Plan:
    found = key(rng)
    groove = Groove(
        {
            "kick": FOUR,
            "snare": "....X.......X...",
            "open": "..X...X...X...X.",
            "hat": rng.choice(["x...x...x...x...", "xo..xo..xo..xo.."]),
        }
    )
    seats = [
        Seat("drums", Drummer(rng, groove), kit(rng)),
        Seat(
            "bass",
            Bass(rng, ["xxxxxxxx", "X.xxX.xx", "X..xX.xx", "XxXxXxXx"], "octave", legato=0.7),
            program(rng, "bass", "synth bass"),
        ),
        Seat(
            "comp",
            Comp(rng, ["..xx..xx..xx..xx", "xxoxxxoxxxoxxxox", "..x...x...x...x.", "X.xx.x.xX.xx.x.x"], 62, 4, 0.4),
            program(rng, "electric", "epiano", "piano"),
        ),
        Seat("pad", Pad(rng, 66), program(rng, "strings"), 0.75),
        Seat("lead", Melody(rng, 62, 86, 0.6, 0.3), program(rng, "strings", "brass", "choir", "flutes", "lead")),
    ]
    return Plan(
        rng.triangular(104, 134, 118),
        seats,
        harmony(rng, found, POP + JAZZ if found.scale == "major" else MINOR),
        found,
        timing=rng.choice(["machine", "human"]),
        drift=0.008,
    )
