"""Orchestras and gamelans: film ostinati, fanfares, pizzicato, hymns."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Groove
from training.music.figure import Figure, Shadow
from training.music.harmony import MINOR, POP, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.percussion import Percussion
from training.music.piece import COMMON, JIG, THREE, TWELVE, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony
from training.music.styles.waltz import old_key


@style("film", "orchestral", 1.2)
def film(rng: Random) -> Plan:
    """Ostinato of strings, low brass, drums; a long melody."""
    found = key(rng, "minor", "dorian", "major")
    metre = rng.choice([COMMON, COMMON, THREE, JIG, TWELVE])
    grid = 2 if metre.div == 2 else 1
    ostinato = either(
        rng,
        Arpeggio(rng, metre.div * grid, None, 60, 3, 0.7),
        Figure(rng, weave(rng, metre, 0.8, grid, 0.3), (0, 0, 7, 12, 3, 2), 48, 1),
    )
    seats = [
        Seat("arpeggio", ostinato, program(rng, "strings", "pizzicato", "solo strings", "harp", "piano")),
        Seat(
            "bass",
            Bass(rng, ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats], "root", 28, 1.0),
            program(rng, "strings", "brass", "tuba"),
        ),
        Seat("pad", Pad(rng, 58, 4), program(rng, "brass", "choir", "strings"), 0.8),
        Seat(
            "lead",
            Melody(rng, 60, 84, rng.uniform(0, 0.4), 0.05, 0.08),
            program(rng, "solo brass", "strings", "choir", "flutes", "violin"),
        ),
    ]
    if rng.random() < 0.65:
        line = "X" + "".join(rng.choice("..x.") for _ in range(metre.beats * metre.div - 1))
        lanes = {
            rng.choice(["tom6", "kick", "tom5"]): line,
            rng.choice(["snare", "roll", "tamb"]): "".join(rng.choice("..-ox") for _ in range(metre.beats * metre.div)),
        }
        seats.append(Seat("drums", Percussion(rng, Groove(lanes)), kit(rng, "orchestra", "standard")))
    return Plan(
        rng.triangular(62, 168, 112) * (0.8 if metre.div == 3 else 1),
        seats,
        harmony(rng, found, POP if found.scale == "major" else MINOR),
        found,
        metre,
        timing=rng.choice(["machine", "human", "expressive"]),
        drift=0.025,
    )


@style("symphony", "orchestral", 1.0)
def symphony(rng: Random) -> Plan:
    """Strings, winds, horns in turn; tremolo eighths, chords on one, pizzicato."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, COMMON, THREE, Metre(2), JIG])
    per = metre.div
    melody = Melody(rng, 62, 88, rng.uniform(0.3, 0.8), 0.06, 0.06, 0.5)
    seats = [
        Seat(
            "bass",
            Bass(
                rng,
                ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats, "XX" * metre.beats],
                rng.choice(["root", "fifth", "arpeggio"]),
                33,
                0.8,
            ),
            program(rng, "strings", "pizzicato"),
        ),
        Seat(
            "comp",
            Comp(
                rng,
                [
                    "x" * per * metre.beats,
                    ("." + "x" * (per - 1)) * metre.beats,
                    ("X" + "." * (per - 1)) * metre.beats,
                    "X" + "." * (per * metre.beats - 1),
                ],
                60,
                3,
                0.6,
            ),
            program(rng, "strings", "pizzicato", "reeds"),
        ),
        Seat("lead", melody, program(rng, "strings", "flutes", "reeds", "solo brass")),
        Seat("second", Shadow(melody, rng.choice([-2, -7, 0])), program(rng, "strings", "reeds", "flutes")),
        Seat(
            "brass",
            Comp(rng, [("X" + "." * (per - 1)) * metre.beats, "X" + "." * (per * metre.beats - 1)], 58, 3, 0.5),
            program(rng, "brass", "solo brass"),
        ),
    ]
    if rng.random() < 0.4:
        seats.append(Seat("drums", Bass(rng, ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats], "fifth", 36), 47))
    return Plan(
        rng.triangular(60, 172, 116),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.015, 0.06),
        tight=1.6,
    )


@style("gamelan", "orchestral", 0.6)
def gamelan(rng: Random) -> Plan:
    """Nested cycles: gong on the first, kempul between, balungan on the beats, double and fourfold above."""
    found = key(rng, "pelog", "slendro")
    core = Melody(rng, 55, 72, 0.0, 0.0, 0.0, 0.0, given=[(float(beat), 1.0) for beat in range(4)])
    seats = [
        Seat("lead", core, program(rng, "mallets", "bells")),
        Seat(
            "second",
            Melody(rng, 67, 86, 0.5, 0, 0, 0, given=[(step / 2, 1.0) for step in range(8)]),
            program(rng, "mallets", "bells", "music box"),
            0.8,
        ),
        Seat("bass", Bass(rng, ["X.......", "X...x..."], "root", 36, 2.0), program(rng, "bells", "tuned drums")),
    ]
    if rng.random() < 0.6:
        seats.append(
            Seat(
                "third",
                Melody(rng, 72, 91, 1.0, 0, 0.05, 0, given=[(step / 4, 1.0) for step in range(16)]),
                program(rng, "mallets", "music box"),
                0.7,
            )
        )
    if rng.random() < 0.5:
        seats.append(
            Seat(
                "percussion",
                Percussion(rng, Groove({"conga2": "x.x.xx.xx.x.xx.x", "conga": ".x.x..x..x.x..x."})),
                kit(rng),
            )
        )
    return Plan(
        rng.uniform(54, 132),
        seats,
        harmony(rng, found, ["I5 I5 V5 I5", "I5 IV5 I5 V5"]),
        found,
        timing="human",
        drift=0.02,
    )


@style("hymn", "orchestral", 0.6)
def hymn(rng: Random) -> Plan:
    """Organ or brass and choir, chords on every beat, plain melody."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, COMMON, THREE])
    group = rng.choice(["organ", "brass", "choir", "strings", "accordion"])
    melody = Melody(rng, 62, 78, 0.15, 0.02, 0.02, 0.5, 0.1)
    seats = [
        Seat(
            "comp",
            Comp(rng, ["X." * metre.beats, "X" + "." * (metre.beats * 2 - 1)], 60, 4, 1.0),
            program(rng, group, wild=0.02),
        ),
        Seat("bass", Bass(rng, ["X." * metre.beats], "arpeggio", 36, 1.0), program(rng, group, wild=0.02)),
        Seat("lead", melody, program(rng, group, "choir")),
    ]
    return Plan(
        rng.uniform(62, 116),
        seats,
        harmony(rng, found, lines, 0.3),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.02, 0.07),
        tight=1.5,
    )
