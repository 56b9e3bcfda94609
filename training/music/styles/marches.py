"""Marches, polkas, galops, brass bands, drum corps, country two-steps."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Comp, Oompah
from training.music.drums import Drummer, Groove
from training.music.figure import Shadow
from training.music.harmony import CLASSICAL, CLASSICAL_MINOR, MINOR, POP, key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.piece import COMMON, JIG, TWO
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.drums_alone import silent
from training.music.styles.rock import harmony


@style("march", "march", 1.2)
def march(rng: Random) -> Plan:
    """Bass drum on the beats, cymbal with it, snare rolls and flams; trombones off the beat; a melody with a pickup."""
    found = key(rng, "major", "major", "minor")
    metre = rng.choice([TWO, TWO, COMMON, JIG])
    if metre.div == 3:
        lanes = {"kick": "X..X..", "snare": rng.choice(["..xX.x", "x.xx.x", "..x..x"])}
    else:
        lanes = {"kick": "X...X...", "snare": rng.choice(["..x.x.xx", "x.xxx.x.", "..x...x.", "X.xxX.xx"])}
        lanes = {drum: line * (metre.beats // 2) for drum, line in lanes.items()}
    if rng.random() < 0.5:
        lanes["crash"] = lanes["kick"].replace("X", "o")
    melody = Melody(rng, 60, 82, rng.uniform(0.4, 0.7), 0.05, pickup=0.6)
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), fill_every=8, crash=0.5), kit(rng, "standard", "orchestra")),
        Seat("bass", Oompah(rng, low=34, halves=metre.beats == 2, chords=False), program(rng, "tuba")),
        Seat("comp", Oompah(rng, 58, halves=True, bass=False), program(rng, "solo brass", "brass", "reeds")),
        Seat("lead", melody, program(rng, "solo brass", "brass", "reeds", "flutes")),
        Seat("second", Shadow(melody), program(rng, "solo brass", "reeds")),
    ]
    return Plan(
        rng.triangular(92, 132, 116),
        seats,
        harmony(rng, found, CLASSICAL if found.scale == "major" else CLASSICAL_MINOR),
        found,
        metre,
    )


@style("polka", "march", 1.1)
def polka(rng: Random) -> Plan:
    """Bass on the beat, chord off it; people tap the bass."""
    found = key(rng, "major", "major", "minor")
    seats = [
        Seat("comp", Oompah(rng, 60, 38, True), program(rng, "accordion", "piano", "reeds")),
        Seat("bass", Oompah(rng, low=34, halves=True, chords=False), program(rng, "tuba", "upright", "bass")),
        Seat(
            "lead",
            Melody(rng, 62, 86, rng.uniform(0.6, 0.9), 0.05),
            program(rng, "accordion", "reeds", "violin", "solo brass"),
        ),
    ]
    if rng.random() < 0.6:
        seats.append(
            Seat(
                "drums",
                Drummer(
                    rng,
                    Groove(
                        {
                            "kick": "X...X...",
                            "snare": "..X...X.",
                            "hat": rng.choice(["x...x...", "........", "..x...x."]),
                        }
                    ),
                ),
                kit(rng),
            )
        )
    return Plan(
        rng.triangular(96, 148, 118),
        seats,
        harmony(rng, found, [*CLASSICAL, "I I V V", "I V V I"] if found.scale == "major" else CLASSICAL_MINOR),
        found,
        TWO,
    )


@style("brass band", "march", 0.9, held_out=True)
def brass_band(rng: Random) -> Plan:
    """Balkan and New Orleans brass: tuba, off-beats, a snare's second-line sixteenths."""
    found = key(rng, "major", "harmonic", "hijaz", "mixolydian")
    lanes = {
        "kick": rng.choice(["X..x..x.X..x..x.", "X...X...X...X...", "X.......X.......", "X..x..x.....x..."]),
        "snare": rng.choice(["xoxXoxXoxXoxxoXo", "..x...x...x...x.", "x.xx.x.xx.xx.x.x", "....X..x....X.xx"]),
    }
    melody = Melody(rng, 60, 82, rng.uniform(0.5, 0.9), 0.3)
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), fills=0.4), kit(rng, "standard", "room")),
        Seat("bass", Bass(rng, ["X..x..x.", "X...X...", "X.X.X.X.", "X..xX.x."], "arpeggio", 30, 0.7), 58),
        Seat(
            "comp",
            Comp(rng, ["..x...x.", ".x.x.x.x", "..xx..xx"], 58, 3, 0.4),
            program(rng, "solo brass", "brass", wild=0),
        ),
        Seat("lead", melody, program(rng, "solo brass", wild=0)),
        Seat("second", Shadow(melody), program(rng, "solo brass", "reeds", wild=0)),
    ]
    lines = (
        ["i iv i V", "i bII i bVII", "i V V i"]
        if found.scale != "major" and found.scale != "mixolydian"
        else [*CLASSICAL, "I IV I V7"]
    )
    return Plan(rng.uniform(92, 152), seats, harmony(rng, found, lines), found, swing_fine=rng.choice([0.5, 0.58]))


@style("drum corps", "march", 0.6)
def corps(rng: Random) -> Plan:
    """Snares, tenors and bass drums marching alone."""
    found, chords = silent(rng)
    metre = rng.choice([TWO, COMMON, COMMON, JIG])
    count = metre.beats * (6 if metre.div == 3 else 4)
    snare = "".join(rng.choice("Xxxo-" if step % (count // metre.beats) == 0 else "xxo--..") for step in range(count))
    low = "".join(rng.choice("Xxx" if step % (count // metre.beats) == 0 else "....x") for step in range(count))
    groove = Groove({"snare": snare, rng.choice(["kick", "tom6"]): low, "stick": "." * count})
    seats = [Seat("drums", Drummer(rng, groove, fill_every=4, crash=0.3), kit(rng, "orchestra", "standard"))]
    return Plan(rng.uniform(84, 140), seats, chords, found, metre, sections=[("a", 0.6, None), ("b", 0.9, None)])


@style("country", "march", 1.2)
def country(rng: Random) -> Plan:
    """Train beat and two-step: bass root and fifth on one and three, brushes in sixteenths with the off-beat loud."""
    found = key(rng, "major", "mixolydian", "minor")
    train = Groove(
        {
            "kick": "X.......X.......",
            "snare": rng.choice(["oxXoxxXxoxXoxxXx", "xxXxxxXxxxXxxxXx", "....X.......X...", "..X...X...X...X."]),
        }
    )
    seats = [
        Seat("drums", Drummer(rng, train, crash=0.3), kit(rng, "brush", "standard", "room")),
        Seat(
            "bass",
            Oompah(rng, low=33, chords=False) if rng.random() < 0.7 else Bass(rng, ["X...X...", "X...X.xx"], "fifth"),
            program(rng, "upright", "bass"),
        ),
        Seat(
            "comp",
            Comp(rng, ["..x...x.", "x.xxx.xx", "XoxoXoxo", "..xx..xx"], 58, 4, 0.5, 0.01),
            program(rng, "steel", "nylon", "electric", "piano"),
        ),
        Seat(
            "lead",
            Melody(rng, 58, 82, rng.uniform(0.4, 0.9), 0.15),
            program(rng, "violin", "electric", "reeds", "ethnic", "steel", "choir"),
        ),
    ]
    return Plan(
        rng.triangular(82, 168, 112),
        seats,
        harmony(
            rng, found, [*POP[:6], "I I V V", "I IV V I", "I I IV IV V V I I"] if found.scale != "minor" else MINOR
        ),
        found,
        swing=rng.choice([0.5, 0.5, 0.6]),
        drift=0.015,
    )


@style("bodhran and claps", "march", 0.5)
def bodhran(rng: Random) -> Plan:
    """Hand percussion with a whistle or pipe above it."""
    found = key(rng, "major", "dorian", "mixolydian")
    metre = rng.choice([JIG, TWO, COMMON])
    lines = {
        (2, 3): ["X.xX.x", "XoxXox", "X..X.x"],
        (2, 2): ["X.oxX.ox", "XoxoXoxo"],
        (4, 2): ["X.oxX.oxX.oxX.ox", "X..xx.x.X..xx.x."],
    }[(metre.beats, metre.div)]
    seats = [
        Seat(
            "percussion", Percussion(rng, Groove({rng.choice(["tom6", "tom5", "conga2"]): rng.choice(lines)})), kit(rng)
        ),
        Seat("lead", Melody(rng, 66, 88, 0.85, 0.03, 0.03, 0.4), program(rng, "pipes", "violin", "flutes")),
    ]
    return Plan(
        rng.uniform(96, 134),
        seats,
        harmony(
            rng, found, ["I bVII I V", "I IV I V"] if found.scale != "dorian" else ["i bVII i bVII", "i bVII bIII bVII"]
        ),
        found,
        metre,
    )
