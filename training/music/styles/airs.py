"""Slow airs and klezmer."""

from random import Random

from training.music.build import Plan, Seat, either
from training.music.comping import Comp, Oompah, Pad
from training.music.drums import Drummer, Groove
from training.music.harmony import key
from training.music.melody import Melody
from training.music.piece import COMMON, JIG, THREE, TWELVE, TWO
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.folk import FIDDLES, tune_key
from training.music.styles.rock import harmony


@style("air", "folk", 0.7)
def air(rng: Random) -> Plan:
    """Slow songs on pipe, fiddle, harp: in three, four, or six."""
    found, lines = tune_key(rng)
    metre = rng.choice([THREE, COMMON, JIG, TWELVE])
    melody = Melody(rng, 60, 82, rng.uniform(0.3, 0.6), 0.05, 0.06, 0.6)
    seats = [Seat("lead", melody, program(rng, *FIDDLES))]
    if rng.random() < 0.8:
        seats.append(
            Seat(
                "comp",
                either(rng, Pad(rng, 56, 3), Comp(rng, ["X." * metre.beats], 58, 4, 1.0, 0.06)),
                program(rng, "harp", "nylon", "strings", "accordion", "piano"),
            )
        )
    return Plan(
        rng.uniform(52, 100) * (0.8 if metre.div == 3 else 1),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.03, 0.1),
    )


@style("klezmer", "folk", 0.7, held_out=True)
def klezmer(rng: Random) -> Plan:
    """Freygish tunes with oom-pah; slow or fast."""
    found = key(rng, "hijaz", "harmonic")
    lines = (
        ["I I iv I", "I bII I bvii", "i i V i", "i iv V i"]
        if found.scale == "harmonic"
        else ["I I bII I", "I bII bvii I", "I iv bvii I"]
    )
    metre = rng.choice([TWO, COMMON])
    seats = [
        Seat(
            "lead", Melody(rng, 62, 86, rng.uniform(0.5, 0.9), 0.15, 0.05), program(rng, "reeds", "violin", "accordion")
        ),
        Seat("comp", Oompah(rng, 60, 40, True), program(rng, "accordion", "piano", "nylon")),
        Seat("bass", Oompah(rng, low=34, halves=True, chords=False), program(rng, "tuba", "upright")),
    ]
    if rng.random() < 0.5:
        seats.append(
            Seat(
                "drums",
                Drummer(
                    rng,
                    Groove(
                        {"kick": "X..xX...", "snare": "..x..xx."}
                        if metre.beats == 2
                        else {"kick": "X..xX...X..xX...", "snare": "..x..xx...x..xx."}
                    ),
                ),
                kit(rng),
            )
        )
    return Plan(rng.uniform(84, 148), seats, harmony(rng, found, lines), found, metre, drift=0.02)
