"""Funk, soul, hip hop, trap, drum and bass, garage, big beat."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Drummer, Groove
from training.music.form import layers
from training.music.harmony import JAZZ, MINOR, POP, key
from training.music.melody import Melody
from training.music.percussion import Loop
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.breaks import break_groove
from training.music.styles.rock import harmony
from training.music.styles.soul import STABS


@style("hip hop", "urban", 1.6)
def hip_hop(rng: Random) -> Plan:
    """Boom bap: a loop with swung sixteenths, a bass, a sample of keys."""
    found = key(rng, "minor", "dorian", "major")
    kick = ["X"] + [rng.choice("...x...x") if step not in (4, 12) else "." for step in range(1, 16)]
    groove = Groove(
        {
            "kick": "".join(kick),
            rng.choice(["snare", "clap"]): "....X.......X...",
            "hat": rng.choice(["x.x.x.x.x.x.x.x.", "xoxoxoxoxoxoxoxo", "x.xxx.x.x.x.x.xx"]),
        }
    )
    drummer = Drummer(rng, groove, fills=0.3, crash=0.2)
    seats = [
        Seat(
            "drums",
            Loop(rng, drummer, 2, 0.01) if rng.random() < 0.6 else drummer,
            kit(rng, "standard", "room", "808", "power"),
        ),
        Seat(
            "bass",
            Bass(rng, ["X.....x...x.....", "X..x......x..x..", "X.......x.......", ""], "root", legato=0.8),
            program(rng, "bass", "synth bass"),
        ),
        Seat(
            "comp",
            either(
                rng,
                Comp(rng, [*STABS, "x.......x.......", "x..............."], 62, 4, 0.9),
                Arpeggio(rng, rng.choice([2, 4]), voices=4),
            ),
            program(rng, "epiano", "piano", "strings", "bells", "nylon", "harp"),
        ),
    ]
    if rng.random() < 0.4:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 60, 82, 0.6, 0.4, 0.3),
                program(rng, "lead", "flutes", "reeds", "choir", "solo brass"),
            )
        )
    return Plan(
        rng.triangular(72, 112, 90),
        seats,
        harmony(rng, found, (POP if found.scale == "major" else MINOR) + JAZZ[:3]),
        found,
        timing="machine",
        swing_fine=rng.choice([0.5, 0.56, 0.6, 0.64]),
        sections=layers(rng, [seat.role for seat in seats]),
    )


@style("trap", "urban", 0.8, held_out=True)
def trap(rng: Random) -> Plan:
    """Snare on two and four of a slow bar, rolling hats in thirty-seconds and triplets, a long bass drum."""
    found = key(rng, "minor", "phrygian", "harmonic")
    roll = rng.choice(["xxxxxxxxxxxxxxxx" * 2, "x.x.x.x.x.x.x.x." + "x.x.x.x.xxxxxxxx", "x.x.x.x.x.xxxxxx" * 2])
    kick = ["X"] + [rng.choice("....x..") for _ in range(15)]
    groove = Groove({"kick": "".join(kick), rng.choice(["clap", "snare"]): "....X.......X...", "hat": roll})
    seats = [
        Seat("drums", Drummer(rng, groove, fills=0.2, crash=0.2), kit(rng, "808", "electronic")),
        Seat(
            "bass",
            Bass(rng, ["X.........x.....", "X.....x.........", "X..x......x....."], "root", 26, 1.0),
            program(rng, "synth bass"),
        ),
        Seat(
            "comp",
            either(rng, Arpeggio(rng, 4, voices=3, gaps=0.3), Pad(rng), Comp(rng, ["x.......", "x..x..x."], 66, 3)),
            program(rng, "bells", "piano", "strings", "flutes", "choir"),
        ),
        Seat("lead", Melody(rng, 64, 84, 0.5, 0.3), program(rng, "bells", "flutes", "lead")),
    ]
    return Plan(
        rng.uniform(58, 84),
        seats,
        harmony(rng, found, MINOR),
        found,
        timing="machine",
        sections=layers(rng, [seat.role for seat in seats]),
    )


@style("drum and bass", "urban", 1.4)
def drum_and_bass(rng: Random) -> Plan:
    found = key(rng, "minor", "dorian")
    plain = Groove(
        {
            "kick": rng.choice(["X.........X.....", "X..X......X.....", "X.X.......x.x..."]),
            "snare": rng.choice(["....X.......X...", "....X..-.-..X..-"]),
            "hat": rng.choice(["x.x.x.x.x.x.x.x.", "xoxoxoxoxoxoxoxo"]),
        }
    )
    drummer = Drummer(rng, rng.choice([plain, break_groove(rng)]), rng.choice([None, break_groove(rng)]), 8, 0.4)
    seats = [
        Seat(
            "drums",
            Loop(rng, drummer, 4, 0.006) if rng.random() < 0.5 else drummer,
            kit(rng, "standard", "power", "electronic"),
        ),
        Seat(
            "bass",
            Bass(rng, ["X.......", "X..x..x.", "X.....x...x.....", "X...............", "..x.x..x"], "root", 28, 0.95),
            program(rng, "synth bass"),
        ),
        Seat("pad", Pad(rng, 62, again=rng.random() < 0.5), program(rng, "pad", "strings", "epiano")),
    ]
    if rng.random() < 0.6:
        seats.append(Seat("lead", Melody(rng, 60, 84, 0.4, 0.3, 0.2), program(rng, "lead", "reeds", "bells", "choir")))
    return Plan(
        rng.uniform(156, 180),
        seats,
        harmony(rng, found, MINOR),
        found,
        timing="machine",
        sections=layers(rng, [seat.role for seat in seats]),
    )


@style("garage", "urban", 1.0)
def garage(rng: Random) -> Plan:
    """Two-step, big beat, breakbeat: broken kicks with a backbeat at dancing tempo."""
    found = key(rng, "minor", "dorian", "major")
    two_step = Groove(
        {
            "kick": rng.choice(["X.........x.....", "X..x......X..x..", "X.....x...X....."]),
            rng.choice(["snare", "clap"]): "....X.......X...",
            rng.choice(["hat", "open"]): rng.choice(["..x...x...x...x.", "..x..xx...x..xx."]),
            "shaker": "xoxoxoxoxoxoxoxo",
        }
    )
    seats = [
        Seat(
            "drums",
            Drummer(rng, rng.choice([two_step, break_groove(rng)]), None, 8, 0.4),
            kit(rng, "electronic", "808", "power", "standard"),
        ),
        Seat(
            "bass",
            Bass(
                rng,
                ["X..x..x.", "..x..x..", "X.....x...x..x..", "X..x..x.x..x..x."],
                rng.choice(["root", "octave"]),
                30,
                0.7,
            ),
            program(rng, "synth bass", "bass"),
        ),
        Seat("comp", Comp(rng, STABS, 62, 4, 0.5), program(rng, "organ", "epiano", "piano", "lead")),
    ]
    return Plan(
        rng.uniform(104, 138),
        seats,
        harmony(rng, found, POP if found.scale == "major" else MINOR),
        found,
        timing="machine",
        swing_fine=rng.choice([0.5, 0.58, 0.63]),
        sections=layers(rng, [seat.role for seat in seats]),
    )
