"""Break loops, funk drumming, clicks and claps, drawn patterns on drums alone."""

from random import Random

from training.music.build import Plan, Seat
from training.music.drums import Drummer, Groove
from training.music.percussion import Loop, Percussion
from training.music.piece import COMMON, THREE, TWELVE, TWO, Feel, Metre
from training.music.programs import kit
from training.music.registry import style
from training.music.styles.drums_alone import alone, silent
from training.music.styles.grammar import Woven
from training.music.styles.rock import backbeat


@style("drummer: funk", "drums", 1.2)
def funk_kit(rng: Random) -> Plan:
    return alone(rng, funk_groove(rng), rng.triangular(78, 124, 100), fine=rng.choice([0.5, 0.54, 0.6]))


def funk_groove(rng: Random) -> Groove:
    """Sixteenths: kick on one and where it likes, snare on two and four, ghosts between."""
    kick = ["X"] + [rng.choice("....x..x") if step not in (4, 12) else "." for step in range(1, 16)]
    snare = ["-" if rng.random() < 0.25 else "." for _ in range(16)]
    snare[4] = snare[12] = "X"
    if rng.random() < 0.2:
        snare[12], snare[rng.choice([10, 14])] = ".", "X"
    hat = rng.choice(["xoxoxoxoxoxoxoxo", "x.x.x.x.x.x.x.x.", "X.xxX.xxX.xxX.xx", "xxx.xxx.xxx.xx.x"])
    return Groove({"kick": "".join(kick), "snare": "".join(snare), "hat": hat})


def break_groove(rng: Random) -> Groove:
    """A break of two or four bars: kick on one and one-and, snare on two and four, ghosts; the last bar displaced."""
    bars = rng.choice([1, 2, 2, 4])
    lanes: dict[str, str] = {"kick": "", "snare": "", "ride": ""}
    base = rng.choice(
        [
            "X.X.......xx....",
            "X.X.......X.....",
            "X..X......X.....",
            "X.......x.x.....",
            "X......x.xx.....",
            "X.x.....x.x.....",
        ]
    )
    ghosts = rng.choice(
        ["....X..-.-..X..-", "....X..x.x..X..x", "....X..-....X...", "....X.-..-..X.-.", "....X....-..X..-"]
    )
    time = rng.choice(["x.x.x.x.x.x.x.x.", "X.x.X.x.X.x.X.x.", "xoxoxoxoxoxoxoxo"])
    for bar in range(bars):
        last = bars > 1 and bar == bars - 1
        lanes["kick"] += (
            rng.choice(["..X.......X.....", "X.X.......X...X.", "X..X..X...X.....", base]) if last else base
        )
        lanes["snare"] += (
            rng.choice(["....X..-.-....X.", "-..-..X.-...X..X", "....X..X..-.X.X.", ghosts]) if last else ghosts
        )
        lanes["ride"] += time
    return Groove(lanes, bars, "ride")


@style("break loop", "drums", 2.0)
def break_loop(rng: Random) -> Plan:
    """Loops of one to four bars, cut out of a drummer's playing and repeated exactly, at a disc jockey's tempo."""
    found, chords = silent(rng)
    groove = rng.choice([break_groove, break_groove, funk_groove, backbeat])(rng)
    remap = {"ride": rng.choice(["hat", "ride", "open"]), "hat": rng.choice(["hat", "hat", "open", "shaker"])}
    drummer = Drummer(rng, groove, fills=0.1, crash=0.2, remap=remap)
    loop = Loop(rng, drummer, rng.choice([1, 2, 2, 4]), rng.uniform(0.002, 0.02))
    feel = Feel(rng.choice([0.5, 0.5, 0.55]), rng.choice([0.5, 0.54, 0.58]), 0, 0, 0.01)
    bpm = rng.choice([rng.uniform(84, 116), rng.uniform(116, 142), rng.uniform(155, 178)])
    return Plan(
        bpm,
        [Seat("drums", loop, kit(rng, "standard", "room", "power", "jazz"), feel=feel)],
        chords,
        found,
        timing="machine",
        sections=[("loop", 0.6, None)],
    )


@style("click", "drums", 0.5)
def click(rng: Random) -> Plan:
    """Metronomes and claps: every beat, some with the first one marked, or two and four, or with off-beats."""
    found, chords = silent(rng)
    metre = rng.choice([COMMON, COMMON, THREE, TWO])
    first, other = rng.sample(
        ["claves", "block1", "block2", "rim", "clap", "stick", "cowbell", "kick", "hat", "tamb", "bells"], 2
    )
    lanes = {first: "X" + "." * (metre.beats * 2 - 1), other: "x." * metre.beats}
    marked = rng.random() < 0.6
    if not marked:
        lanes.pop(first)
    if rng.random() < 0.3:
        lanes[other] = "xo" * metre.beats
    player = Percussion(rng, Groove(lanes), rng.choice([0, 0, 0.05]))
    return Plan(
        rng.uniform(46, 200),
        [Seat("drums", player, kit(rng))],
        chords,
        found,
        metre,
        timing=rng.choice(["machine", "human"]),
        sections=[("loop", 0.6, None)],
        has_downbeat=marked,
    )


@style("drummer: random", "drums", 1.2)
def random_kit(rng: Random) -> Plan:
    """Drawn patterns, one or two players of drums."""
    found, chords = silent(rng)
    metre = rng.choice([COMMON, COMMON, COMMON, THREE, Metre(2, 3), TWELVE])
    kits = ("standard", "room", "electronic", "808", "jazz", "orchestra")
    bpm = min(210, max(48, rng.gauss(112, 30))) * (0.85 if metre.div == 3 else 1)
    seats = [Seat("drums", Woven(rng, metre, bpm), kit(rng, *kits))]
    if rng.random() < 0.35:
        seats.append(Seat("percussion", Woven(rng, metre, bpm), kit(rng, *kits)))
    return Plan(
        bpm,
        seats,
        chords,
        found,
        metre,
        timing=rng.choice(["machine", "human"]),
        drift=rng.uniform(0.005, 0.02),
        sections=[("a", 0.5, None), ("b", 0.9, None)],
    )
