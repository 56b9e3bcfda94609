"""Dance tunes: jigs, slip jigs, reels, hornpipes, airs, klezmer, with and without accompaniment."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Comp, Oompah, Pad
from training.music.drums import Drummer, Groove
from training.music.figure import Shadow
from training.music.harmony import Key, key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.piece import COMMON, JIG, TWO, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony

FIDDLES = ("violin", "flutes", "pipes", "accordion", "ethnic", "reeds", "nylon")
TUNES = {
    "major": ["I IV I V", "I I V V I I V I", "I V I V I IV I,V I", "I IV V I", "I vi IV V"],
    "mixolydian": ["I bVII I bVII", "I I bVII V", "I bVII IV I"],
    "dorian": ["i bVII i bVII", "i i bVII i", "i bVII bIII bVII", "i bVII i v"],
    "minor": ["i bVII bVI bVII", "i bVII i v", "i bVI bVII i"],
}


def tune_key(rng: Random) -> tuple[Key, list[str]]:
    """A mode of fiddle music and chords for it."""
    found = key(rng, "major", "major", "mixolydian", "dorian", "minor")
    return found, TUNES[found.scale]


def tune(rng: Random, pace: float, low: int = 62) -> Melody:
    """A fiddle's line: runs of short notes, a longer one at the end of a phrase, hardly a rest."""
    return Melody(
        rng,
        low,
        low + rng.choice([17, 20, 24]),
        pace,
        0.02,
        rng.choice([0.0, 0.02, 0.05]),
        rng.uniform(0.3, 0.7),
        0.3,
        silence=0.0,
        repeat=rng.uniform(0.5, 0.85),
        ornaments=rng.choice([0.0, 0.05, 0.12]),
    )


def party(rng: Random, melody: Melody, metre: Metre) -> list[Seat]:
    """One to four players of a session."""
    seats = [Seat("lead", melody, program(rng, *FIDDLES))]
    if rng.random() < 0.35:
        seats.append(Seat("second", Shadow(melody, rng.choice([0, 0, -2, -7])), program(rng, *FIDDLES), 0.8))
    if rng.random() < 0.6:
        lines = {3: ["X.xX.x", "X..X.x", "X..X..", "XxxXxx", "..x..x"], 2: ["X.x.", "x.xx", "..x.", "xxxx"]}[metre.div]
        per = 2 if metre.beats % 2 == 0 else 3
        if per == 3:
            lines = ["X.xX.xX.x", "X..X..X..", "XxxXxxXxx"] if metre.div == 3 else ["X.x.x.", "X...x.", "..x.x."]
        comp = Comp(
            rng, [line * (metre.beats // per) for line in lines], 56, rng.choice([3, 4]), 0.6, rng.choice([0, 0.02])
        )
        seats.append(
            Seat(
                "comp",
                either(rng, comp, Oompah(rng, 58, 40, True)),
                program(rng, "steel", "nylon", "piano", "accordion"),
            )
        )
    if rng.random() < 0.4:
        line = (
            {2: "X.X.", 3: "X..X..X..", 4: "X..X..X..X.."}[metre.beats]
            if metre.div == 3 and metre.beats != 2
            else {2: "X.X.", 3: "X.....", 4: "X...X..."}[metre.beats]
        )
        seats.append(
            Seat("bass", Bass(rng, [line], rng.choice(["root", "fifth"])), program(rng, "upright", "bass", "piano"))
        )
    draw = rng.random()
    if draw < 0.25:
        lanes = {"tom6": ("XoxXox" if metre.div == 3 else "XoxoXoxo")[: 6 if metre.div == 3 else 8]}
        if metre.beats in (2, 4):
            lanes = {"tom6": lanes["tom6"] * (metre.beats // 2)}
            seats.append(Seat("percussion", Percussion(rng, Groove(lanes)), kit(rng)))
    elif draw < 0.4 and metre.beats == 4:
        seats.append(
            Seat("drums", Drummer(rng, Groove({"kick": "X...X...X...X...", "snare": "..x...x...x...x."})), kit(rng))
        )
    elif draw < 0.5 and metre.div == 3 and metre.beats == 2:
        seats.append(
            Seat("drums", Drummer(rng, Groove({"kick": "X.....", "snare": "...X..", "hat": "XoxXox"})), kit(rng))
        )
    if rng.random() < 0.2:
        seats.append(Seat("pad", Pad(rng, 50, 2, again=False), program(rng, "pipes", "accordion", "strings"), 0.6))
    return seats


@style("jig", "folk", 2.0)
def jig(rng: Random) -> Plan:
    """Six eighths, two beats a bar; groups of three eighths or a quarter and an eighth."""
    found, lines = tune_key(rng)
    return Plan(
        rng.triangular(88, 138, 114),
        party(rng, tune(rng, rng.uniform(0.6, 1.0)), JIG),
        harmony(rng, found, lines),
        found,
        JIG,
        lengths=(8, 8, 16),
        drift=rng.uniform(0.006, 0.02),
    )


@style("slip jig", "folk", 0.4)
def slip_jig(rng: Random) -> Plan:
    """Nine eighths, three beats a bar."""
    found, lines = tune_key(rng)
    metre = Metre(3, 3)
    return Plan(
        rng.uniform(96, 140),
        party(rng, tune(rng, rng.uniform(0.5, 0.9)), metre),
        harmony(rng, found, lines),
        found,
        metre,
        lengths=(8, 8),
    )


@style("reel", "folk", 1.2)
def reel(rng: Random) -> Plan:
    """Running notes, four to a beat; two beats a bar (or four)."""
    found, lines = tune_key(rng)
    metre = rng.choice([TWO, COMMON])
    melody = tune(rng, 0.9)
    return Plan(
        rng.uniform(88, 126),
        party(rng, melody, metre),
        harmony(rng, found, lines),
        found,
        metre,
        lengths=(8, 8, 16),
        drift=0.012,
    )


@style("hornpipe", "folk", 0.6)
def hornpipe(rng: Random) -> Plan:
    """Dotted eighths in four."""
    found, lines = tune_key(rng)
    return Plan(
        rng.uniform(112, 176),
        party(rng, tune(rng, 0.35), COMMON),
        harmony(rng, found, lines),
        found,
        COMMON,
        swing=rng.uniform(0.6, 0.7),
        lengths=(8, 8),
    )
