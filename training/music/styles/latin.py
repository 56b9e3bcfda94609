"""Bossa, samba, salsa, cha-cha, cumbia, merengue, reggaeton, tango, bolero, habanera."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp
from training.music.drums import Drummer, Groove
from training.music.harmony import MINOR, POP, key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony


@style("salsa", "latin", 1.1)
def salsa(rng: Random) -> Plan:
    """Clave, tumbao of congas, montuno of the piano, the bass before the beat."""
    found = key(rng, "major", "minor", "dorian")
    clave = rng.choice(["x..x..x...x.x...", "..x.x...x..x..x.", "x..x...x..x.x..."])
    lanes = {
        "claves": clave,
        "conga2": "......xx......xx",
        "conga": "-.-.--..-.-.--..",
        "mute": "..X.......X.....",
        rng.choice(["cowbell", "timb1", "shaker", "guiro2"]): rng.choice(
            ["X.x.X.x.X.x.X.x.", "X...X...X...X...", "x.xx.xx.x.xx.xx."]
        ),
    }
    seats = [
        Seat("percussion", Percussion(rng, Groove(lanes), 0.06), kit(rng)),
        Seat(
            "bass",
            Bass(rng, ["x..x..x.", "...X..X.", "X..X..X.X..X..X."], "fifth", 30, 1.0),
            program(rng, "bass", "upright"),
        ),
        Seat(
            "comp",
            either(
                rng,
                Comp(rng, ["x.xx.x.xx.xx.x.x", "x.x.xx.x.x.x.xx.", "xx.xx.x.x.xx.xx."], 66, 3, 0.5),
                Arpeggio(rng, 4, (0, 2, 1, 3, 2, 1, 3, 2), 66, 3, gaps=0.2),
            ),
            program(rng, "piano", "piano", "epiano", "nylon"),
        ),
    ]
    if rng.random() < 0.6:
        seats.append(
            Seat(
                "brass",
                Comp(rng, ["x..x......x.....", "....x..x..x.....", ""], 66, 3, 0.5),
                program(rng, "brass", "solo brass"),
            )
        )
    if rng.random() < 0.6:
        seats.append(
            Seat("lead", Melody(rng, 60, 80, 0.6, 0.4), program(rng, "choir", "reeds", "solo brass", "flutes"))
        )
    return Plan(
        rng.uniform(78, 112),
        seats,
        harmony(
            rng,
            found,
            ["I IV V IV", "ii V", "I,IV V,IV", "I V V I"]
            if found.scale == "major"
            else ["i iv V", "i V V i", "i,iv V", "i bVII bVI V"],
        ),
        found,
    )


@style("cha-cha and cumbia", "latin", 1.0)
def cumbia(rng: Random) -> Plan:
    """The scraper's long-short-short; bass on one and two, or one, two-and..."""
    found = key(rng, "major", "minor")
    lanes = {
        "guiro2": "X.ooX.oo" * 2,
        rng.choice(["kick", "conga2", "tom6"]): rng.choice(
            ["X.......X.......", "X...X...X...X...", "X.....x.X.....x."]
        ),
        rng.choice(["rim", "cowbell", "timb1", "conga"]): rng.choice(
            ["..x...x...x...x.", "....X..x....X..x", "x...x...x...x...", "..xx..xx..xx..xx"]
        ),
    }
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), fills=0.4, crash=0.2), kit(rng)),
        Seat(
            "bass",
            Bass(rng, ["X...X.x.", "X..xX.x.", "X.....x.", "X...x.x."], rng.choice(["fifth", "arpeggio"])),
            program(rng, "bass", "upright", "tuba"),
        ),
        Seat(
            "comp",
            Comp(rng, ["..x...x.", "..xx..xx", "x.x.x.x."], 62, 3, 0.4),
            program(rng, "accordion", "piano", "nylon", "electric"),
        ),
        Seat(
            "lead", Melody(rng, 60, 82, 0.6, 0.25), program(rng, "accordion", "flutes", "reeds", "solo brass", "pipes")
        ),
    ]
    return Plan(
        rng.uniform(82, 128),
        seats,
        harmony(
            rng, found, ["I V", "I IV V V", "I V V I"] if found.scale == "major" else ["i V", "i iv V i", "i bVII V V"]
        ),
        found,
    )


@style("merengue and reggaeton", "latin", 1.0)
def merengue(rng: Random) -> Plan:
    found = key(rng, "major", "minor")
    dembow = Groove(
        {
            "kick": "X...X...X...X...",
            rng.choice(["snare", "rim"]): rng.choice(["...X..X....X..X.", "...X..x....X..x."]),
            "hat": rng.choice(["x...x...x...x...", "x.x.x.x.x.x.x.x."]),
        }
    )
    quick = Groove(
        {
            "kick": "X...X...X...X...",
            "guiro": "X.xxX.xxX.xxX.xx",
            "conga": rng.choice(["x...x...xxxxx...", "....x.xx....x.xx"]),
        }
    )
    slow = rng.random() < 0.55
    seats = [
        Seat(
            "drums",
            Drummer(rng, dembow if slow else quick, None, 8, 0.4),
            kit(rng, "808", "electronic", "standard") if slow else kit(rng),
        ),
        Seat(
            "bass",
            Bass(rng, ["X..x..x." * 2, "X...X...", "X..X..X.X..X..X."], "fifth"),
            program(rng, "synth bass", "bass"),
        ),
        Seat(
            "comp",
            either(rng, Comp(rng, ["x..x..x.", "..x...x.", "x.xx.x.x"], 64, 3, 0.5), Arpeggio(rng, 4, voices=3)),
            program(rng, "piano", "accordion", "nylon", "lead", "bells"),
        ),
        Seat("lead", Melody(rng, 62, 82, 0.6, 0.35), program(rng, "lead", "choir", "accordion", "reeds", "brass")),
    ]
    return Plan(
        rng.uniform(82, 106) if slow else rng.uniform(112, 160),
        seats,
        harmony(rng, found, POP if found.scale == "major" else MINOR),
        found,
        timing="machine" if slow else "human",
    )
