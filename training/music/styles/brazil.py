"""Bossa nova and samba."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Comp
from training.music.drums import Drummer, Groove
from training.music.harmony import JAZZ, MINOR, POP, key
from training.music.melody import Melody
from training.music.piece import COMMON, TWO
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony


@style("bossa", "latin", 1.1)
def bossa(rng: Random) -> Plan:
    """Kick one, two-and, three, four-and; the rim in a clave of two bars; the guitar in its own syncopation."""
    found = key(rng, "major", "minor")
    clave = rng.choice(["x..x..x...x..x..", "..x.x...x..x..x.", "x..x..x...x.x..."])
    groove = Groove(
        {"kick": "X..xX..x" * 2, "rim": clave, rng.choice(["hat", "shaker", "cabasa"]): "xxxxxxxxxxxxxxxx"}, 2
    )
    seats = [
        Seat("drums", Drummer(rng, groove, fills=0.3, crash=0.3), kit(rng, "standard", "brush", "jazz")),
        Seat("bass", Bass(rng, ["X..xX..x", "X...X...", "X..xX..."], "fifth"), program(rng, "upright", "bass")),
        Seat(
            "comp",
            Comp(rng, ["x..x..x.", "x.x..x.x", ".x..x.x.", "x..x.x.."], 60, 4, 0.7, anticipate=0.3),
            program(rng, "nylon", "epiano", "piano"),
        ),
    ]
    if rng.random() < 0.75:
        seats.append(
            Seat("lead", Melody(rng, 60, 80, 0.4, 0.35), program(rng, "flutes", "reeds", "choir", "nylon", "mallets"))
        )
    return Plan(
        rng.triangular(104, 160, 128),
        seats,
        harmony(rng, found, JAZZ if found.scale == "major" else [*MINOR, "im7 iv7 iim7b5 V7"]),
        found,
        drift=0.012,
    )


@style("samba", "latin", 1.2)
def samba(rng: Random) -> Plan:
    """Surdo low on two, high on one; shaker in sixteenths; tamborim in syncopation."""
    found = key(rng, "major", "minor")
    metre = rng.choice([TWO, TWO, COMMON])
    half = metre.beats // 2
    lanes = {
        rng.choice(["surdo", "kick", "tom6"]): rng.choice(["o...X...", "...xX...", "x..xX..x", "x...X.x."]) * half,
        rng.choice(["shaker", "cabasa", "hat", "tamb"]): rng.choice(["XoxxXoxx", "xxxxxxxx", "XoxXXoxX"]) * half,
        rng.choice(["rim", "block1", "claves", "bongo1"]): rng.choice(
            ["x.x.xx.x.x.x.xx.", "x..x..x.x..x.x..", ".x.x..xx.x.x..x.", "x.xx.x.xx.xx.x.x"]
        )[: 8 * half],
    }
    if rng.random() < 0.5:
        lanes[rng.choice(["agogo1", "cuica1"])] = rng.choice(["x.x..x.xx.x.x.x.", "x..x.x..x..x.x.x"])[: 8 * half]
    seats = [Seat("drums", Drummer(rng, Groove(lanes), fills=0.3, crash=0.2), kit(rng))]
    if rng.random() < 0.75:
        seats += [
            Seat(
                "bass",
                Bass(
                    rng,
                    [{2: "X..xX..x", 4: "X..xX..xX..xX..x"}[metre.beats], {2: "X...X...", 4: "X...X..."}[metre.beats]],
                    "fifth",
                ),
                program(rng, "bass", "upright"),
            ),
            Seat(
                "comp",
                Comp(
                    rng,
                    [line[: 8 * half] for line in ("x.xx.x.xx.xx.x.x", "..x.x..x..x.x..x", ".xx.xx.x.xx.xx.x")],
                    62,
                    4,
                    0.4,
                ),
                program(rng, "nylon", "steel", "piano", "electric"),
            ),
            Seat(
                "lead", Melody(rng, 60, 82, 0.6, 0.4), program(rng, "flutes", "choir", "reeds", "solo brass", "pipes")
            ),
        ]
    return Plan(
        rng.triangular(86, 136, 108),
        seats,
        harmony(rng, found, [*POP, *JAZZ[:3]] if found.scale == "major" else MINOR),
        found,
        metre,
    )
