"""Tabla, djembe, darbuka, congas, cajon, taiko: cycles with variations; drones and tunes above some."""

from random import Random

from training.music.build import Plan, Seat
from training.music.comping import Pad
from training.music.drums import Groove
from training.music.harmony import key, progression
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.percussion import Loop, Percussion
from training.music.piece import COMMON, TWELVE, Feel, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.drums_alone import silent
from training.music.styles.grammar import Woven
from training.music.styles.strokes import DARBUKA, DJEMBE, TABLA, Strokes, drums_of


@style("tabla", "hand drums", 1.6)
def tabla(rng: Random) -> Plan:
    """Keherwa, dadra, tintal; alone, as an exact loop, with a drone, or with a melody."""
    player, metre = drums_of(rng, TABLA)
    found = key(rng, "major", "bhairav", "dorian", "phrygian", "mixolydian", "lydian")
    loop = rng.random() < 0.45
    seats = [
        Seat(
            "percussion",
            Loop(rng, player, rng.choice([1, 2, 4]), 0.008) if loop else player,
            player.program(),
            feel=Feel(jitter=0.0 if loop else 0.006, touch=0.02 if loop else 0.15),
        )
    ]
    if rng.random() < 0.45:
        seats.append(Seat("pad", Pad(rng, 48, 2, 0.5, rng.random() < 0.5), program(rng, "ethnic", "pad", "pipes"), 0.6))
    if rng.random() < 0.35:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 58, 82, rng.uniform(0.3, 0.8), 0.2),
                program(rng, "ethnic", "flutes", "violin", "accordion"),
            )
        )
    bpm = rng.triangular(66, 180, 104) * (0.8 if metre.div == 3 else 1.0)
    return Plan(
        bpm,
        seats,
        lambda label, bars: progression(rng, found, ["I5"], bars),
        found,
        metre,
        timing="machine" if loop else "human",
        drift=rng.uniform(0.005, 0.02),
        sections=[("a", 0.6, None), ("b", 0.7, None)],
    )


@style("darbuka", "hand drums", 0.9)
def darbuka(rng: Random) -> Plan:
    """Maqsum, saidi, baladi, malfuf, ayub: dum and tek; some with a melody in hijaz."""
    player, metre = drums_of(rng, DARBUKA)
    found = key(rng, "hijaz", "harmonic", "phrygian")
    seats = [Seat("percussion", player, player.program())]
    if rng.random() < 0.4:
        time = "oooooooo" if rng.random() < 0.5 else "X.o.X.o."
        seats.append(
            Seat(
                "drums",
                Percussion(rng, Groove({rng.choice(["tamb", "shaker", "bells"]): time * (metre.beats // 2)})),
                kit(rng),
            )
        )
    if rng.random() < 0.5:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 58, 80, rng.uniform(0.4, 0.9), 0.2),
                program(rng, "ethnic", "reeds", "violin", "accordion", "strings"),
            )
        )
    return Plan(
        rng.triangular(76, 160, 112),
        seats,
        lambda label, bars: progression(rng, found, ["i5", "i5 i5 bII i5"], bars),
        found,
        metre,
    )


@style("djembe", "hand drums", 0.9, held_out=True)
def djembe(rng: Random) -> Plan:
    """West African ensembles: low drums, djembe, a bell; twelve-eight and four."""
    found, chords = silent(rng)
    player, metre = drums_of(rng, DJEMBE)
    second, _ = drums_of(rng, [cycle for cycle in DJEMBE if cycle[2] == metre])
    bell = (
        rng.choice(["X.X.XX.X.X.X", "x.xx.xx.xx.x", "X..X..X..X.."])
        if metre.div == 3
        else rng.choice(["X.x.X.x.X.x.X.x.", "x..x..x...x.x...", "X.xx.xx.X.xx.xx."])
    )
    seats = [
        Seat("percussion", player, player.program()),
        Seat("drums", Percussion(rng, Groove({rng.choice(["cowbell", "agogo1", "block1"]): bell})), kit(rng)),
        Seat("second", second, second.program(), 0.8),
    ]
    return Plan(rng.uniform(84, 150), seats, chords, found, metre, sections=[("a", 0.6, None), ("b", 0.9, None)])


@style("congas and cajon", "hand drums", 0.8)
def congas(rng: Random) -> Plan:
    found, chords = silent(rng)
    lanes = rng.choice(
        [
            {"conga2": "......xx......xx", "conga": "-.-.--..-.-.--..", "mute": "..X.......X....."},
            {
                "kick": rng.choice(["X.......X.x.....", "X.....x.X......."]),
                "rim": "....X..o....X.o.",
                "shaker": "xoxoxoxoxoxoxoxo",
            },
            {"bongo1": "X.x.x.x.X.x.x.x.", "bongo2": "......x.......x."},
        ]
    )
    return Plan(
        rng.uniform(72, 136),
        [Seat("percussion", Percussion(rng, Groove(lanes), 0.07), kit(rng))],
        chords,
        found,
        sections=[("a", 0.6, None)],
    )


@style("taiko", "hand drums", 0.6)
def taiko(rng: Random) -> Plan:
    """Big drums with room; rolls that grow; also film music's drums under low strings."""
    found = key(rng, "minor", "pelog", "phrygian")
    metre = rng.choice([COMMON, COMMON, TWELVE, Metre(3)])
    low = weave(rng, metre, 0.4, 1, 0.8)
    line = ["."] * metre.beats * metre.div
    for at, _ in low:
        line[round(at * metre.div)] = "X"
    line[0] = "X"
    high = "".join(rng.choice(".x.o") for _ in range(metre.beats * metre.div * 2))
    player = Strokes(rng, "".join(line), high, 0.2)
    player.tuned, player.pitches = True, (36, 43, 48)
    seats = [Seat("percussion", player, 116)]
    if rng.random() < 0.5:
        seats.append(Seat("pad", Pad(rng, 44, 3, 0.6), program(rng, "strings", "brass", "choir")))
    if rng.random() < 0.3:
        seats.append(Seat("drums", Woven(rng, metre), kit(rng, "orchestra", "standard")))
    return Plan(
        rng.uniform(66, 150),
        seats,
        lambda label, bars: progression(rng, found, ["i i bVI bVII", "i i i i"], bars),
        found,
        metre,
    )
