"""A drummer alone: human grooves with fills and ghosts in many feels; break loops; clicks, claps, single drums."""

from random import Random

from training.music.build import Plan, Seat
from training.music.drums import Drummer, Groove
from training.music.form import Compose
from training.music.harmony import Key, key, progression
from training.music.piece import COMMON, THREE, TWELVE, Feel, Metre
from training.music.programs import kit
from training.music.registry import style
from training.music.styles.rock import HATS, KICKS, backbeat, half_time


def silent(rng: Random) -> tuple[Key, Compose]:
    """Harmony for those who do not need one."""
    found = key(rng, "major")
    return found, lambda label, bars: progression(rng, found, ["I"], bars)


def alone(
    rng: Random,
    groove: Groove,
    bpm: float,
    metre: Metre = COMMON,
    chorus: Groove | None = None,
    swing: float = 0.5,
    kits: tuple[str, ...] = ("standard", "room", "power", "jazz"),
    fine: float = 0.5,
) -> Plan:
    """A plan with one drummer, who plays fills and ghosts and is not a machine."""
    found, chords = silent(rng)
    drummer = Drummer(
        rng,
        groove,
        chorus,
        rng.choice([2, 4, 4, 8]),
        rng.uniform(0.4, 0.95),
        ghosts=rng.choice([0, 0.05, 0.15, 0.25]) if metre.div == 2 else 0,
        free=rng.choice([0.0, 0.2, 0.4, 0.7]),
        drop=rng.uniform(0.02, 0.1),
    )
    feel = Feel(swing, fine, rng.gauss(0, 0.003), rng.uniform(0.003, 0.011), rng.uniform(0.06, 0.2))
    sections = [("verse", 0.5, None), ("chorus", 0.9, None)]
    return Plan(
        bpm,
        [Seat("drums", drummer, kit(rng, *kits), feel=feel)],
        chords,
        found,
        metre,
        sections=sections,
        drift=rng.uniform(0.006, 0.02),
        lengths=(4, 8, 8),
    )


@style("drummer: rock", "drums", 1.8)
def rock_kit(rng: Random) -> Plan:
    half = rng.random() < 0.25
    return alone(
        rng,
        half_time(rng) if half else backbeat(rng),
        rng.triangular(54, 160, 96) if not half else rng.uniform(100, 160),
        chorus=backbeat(rng),
    )


@style("drummer: slow rock", "drums", 1.0)
def slow_kit(rng: Random) -> Plan:
    """Sixteenths or eighths on the hat at 50 to 80."""
    groove = Groove(
        {
            "kick": rng.choice(KICKS),
            "snare": rng.choice(["....X.......X...", "....X..-.-..X..-"]),
            rng.choice(["hat", "hat", "ride"]): rng.choice(HATS),
        }
    )
    return alone(
        rng,
        groove,
        rng.uniform(50, 80),
        chorus=Groove({**groove.lanes, "kick": rng.choice(KICKS)}),
        fine=rng.choice([0.5, 0.5, 0.58]),
    )


@style("drummer: punk", "drums", 0.9)
def punk_kit(rng: Random) -> Plan:
    normal = Groove(
        {
            "kick": rng.choice(["X.......X.x.....", "X.....x.X.......", "X.x.....X......."]),
            "snare": "....X.......X...",
            "hat": rng.choice(["X.x.X.x.X.x.X.x.", "X...X...X...X..."]),
        }
    )
    skank = Groove({"kick": "X...X...X...X...", "snare": "..X...X...X...X.", "hat": "X.x.X.x.X.x.X.x."})
    return alone(rng, normal, rng.uniform(132, 205), chorus=rng.choice([normal, skank]))


@style("drummer: three", "drums", 1.2)
def three_kit(rng: Random) -> Plan:
    groove = Groove(
        {
            "kick": rng.choice(["X...........", "X.....x.....", "X.........x.", "X..x........", "X.x........."]),
            "snare": rng.choice(["....X...X...", "........X...", "....X.......", "......X.....", "....o...X..."]),
            rng.choice(["hat", "hat", "ride"]): rng.choice(
                ["x.x.x.x.x.x.", "X.o.X.o.X.o.", "x...x...x...", "X.oox.oox.oo"]
            ),
        }
    )
    return alone(rng, groove, rng.triangular(70, 190, 108), THREE, swing=rng.choice([0.5, 0.5, 0.62]))


@style("drummer: samba", "drums", 1.0)
def samba_kit(rng: Random) -> Plan:
    """Kick: one, the last sixteenth before two, two...; sixteenths on hat or ride, snare or rim in syncopation."""
    lanes = {
        "kick": rng.choice(["X..xX..xX..xX..x", "x..xX..xx..xX..x"]),
        rng.choice(["hat", "ride", "shaker"]): rng.choice(["XoxxXoxxXoxxXoxx", "xxxxxxxxxxxxxxxx", "X.xxX.xxX.xxX.xx"]),
        "pedal": rng.choice(["..x...x...x...x.", "....x.......x..."]),
        rng.choice(["rim", "snare", "tom3"]): rng.choice(
            ["X..x..x...x.x...", "x.x..x.x.x.xx.x.", "..x.x..x..x..x.x", "X.x.xx.x.x.x.xx."]
        ),
    }
    return alone(
        rng, Groove(lanes), rng.uniform(92, 132), rng.choice([COMMON, COMMON]), kits=("standard", "jazz", "room")
    )


@style("drummer: swing", "drums", 1.0)
def swing_kit(rng: Random) -> Plan:
    metre = rng.choice([COMMON, COMMON, THREE])
    ride, pedal = ("X...X.x.X...X.x.", "....X.......X...") if metre.beats == 4 else ("X...X.x.X...", "....X.......")
    lanes = {"ride": ride, "pedal": pedal}
    if rng.random() < 0.7:
        lanes["snare"] = "".join(rng.choice("......-o.") if step % 2 == 0 else "." for step in range(4 * metre.beats))
    if rng.random() < 0.5:
        lanes["kick"] = "".join(rng.choice("-..") if step % 4 == 0 else "." for step in range(4 * metre.beats))
    return alone(
        rng,
        Groove(lanes, time="ride"),
        rng.triangular(84, 210, 140),
        metre,
        swing=rng.uniform(0.57, 0.68),
        kits=("jazz", "brush", "standard"),
    )


@style("drummer: shuffle", "drums", 0.8)
def shuffle_kit(rng: Random) -> Plan:
    """Shuffles, half-time shuffles, twelve-eight ballads."""
    if rng.random() < 0.5:
        groove = Groove(
            {
                "kick": rng.choice(["X....xX.....", "X.....X.....", "X..X..X..X.."]),
                "snare": rng.choice(["...X.....X..", "...X.....X..", "......X....."]),
                rng.choice(["hat", "ride"]): rng.choice(["XooXooXooXoo", "X.xX.xX.xX.x"]),
            }
        )
        return alone(rng, groove, rng.uniform(50, 140), TWELVE)
    groove = Groove(
        {
            "kick": rng.choice(["X.....x.X.......", "X.......X.......", "X...x...X...x..."]),
            "snare": "....X.......X...",
            "hat": "X.x.X.x.X.x.X.x.",
        }
    )
    return alone(rng, groove, rng.uniform(76, 170), swing=rng.uniform(0.6, 0.68))
