"""Tango and bolero."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Comp
from training.music.drums import Groove
from training.music.figure import Shadow
from training.music.harmony import JAZZ, MINOR, POP, key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.piece import COMMON, TWO
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony


@style("tango", "latin", 1.0, held_out=True)
def tango(rng: Random) -> Plan:
    """Marcato in four, or the habanera's dotted figure; no drums; strings and accordion, rubato."""
    found = key(rng, "minor", "harmonic")
    marcato = rng.random() < 0.6
    metre = COMMON if marcato else TWO
    line = rng.choice(["X...X...X...X...", "X.....x.X...x..."]) if marcato else rng.choice(["X..xX.x.", "X..xx.x."])
    melody = Melody(rng, 62, 84, 0.6, 0.3, pickup=0.6)
    seats = [
        Seat("bass", Bass(rng, [line], "root", 36, 0.5), program(rng, "upright", "piano", "accordion")),
        Seat("comp", Comp(rng, [line], 58, 3, 0.4), program(rng, "piano", "accordion")),
        Seat("lead", melody, program(rng, "violin", "accordion")),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("second", Shadow(melody), program(rng, "violin", "strings")))
    return Plan(
        rng.uniform(108, 134) if marcato else rng.uniform(54, 74),
        seats,
        harmony(rng, found, ["i V V i", "i iv V i", "i i V V", "iv i V i"]),
        found,
        metre,
        timing="expressive",
        drift=0.04,
    )


@style("bolero", "latin", 0.7)
def bolero(rng: Random) -> Plan:
    """Slow, bongos in eighths, maracas, romantic lead: tapped at the quarter."""
    found = key(rng, "major", "minor")
    lanes = {
        "bongo1": "X.x.x.x.X.x.x.x.",
        "bongo2": "......x.......x.",
        rng.choice(["shaker", "cabasa"]): "x.xxx.xxx.xxx.xx",
        "conga2": "......xx......xx",
    }
    seats = [
        Seat("percussion", Percussion(rng, Groove(lanes)), kit(rng)),
        Seat("bass", Bass(rng, ["X...X.X.", "X...x.x.", "X...X..."], "arpeggio"), program(rng, "upright", "bass")),
        Seat("comp", Comp(rng, ["x.x.x.x.", "..x.x.x.", "xoxoxoxo"], 60, 4, 0.6), program(rng, "nylon", "piano")),
        Seat(
            "lead",
            Melody(rng, 60, 80, 0.4, 0.25, pickup=0.6),
            program(rng, "solo brass", "violin", "choir", "nylon", "reeds"),
        ),
    ]
    return Plan(
        rng.uniform(66, 112), seats, harmony(rng, found, [*POP, *JAZZ[:3]] if found.scale == "major" else MINOR), found
    )
