"""Chip tunes, game music on FM chips, trance arpeggios, ambient with a pulse."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Arpeggio, Pad
from training.music.drums import Drummer, Groove
from training.music.figure import Figure, Shadow
from training.music.form import layers
from training.music.harmony import MINOR, POP, ROCK, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.percussion import Percussion
from training.music.piece import COMMON, THREE
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.dance import floor
from training.music.styles.rock import backbeat, half_time, harmony


@style("chip tune", "electronic", 1.3)
def chip(rng: Random) -> Plan:
    """Square waves: fast arpeggios, a leaping bass, a tune, noise for drums."""
    found = key(rng, "major", "minor", "dorian", "harmonic")
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    melody = Melody(rng, 64, 90, rng.uniform(0.4, 0.9), 0.2)
    four = metre.beats == 4
    seats = [
        Seat(
            "bass",
            Bass(
                rng,
                ["xxxxxxxx", "XxXxXxXx", "X..xX.x.", "X.xx.xX."] if four else ["xxxxxx", "X.x.x."],
                rng.choice(["octave", "root", "fifth"]),
                legato=0.6,
            ),
            program(rng, "chip", wild=0.1),
        ),
        Seat("lead", melody, program(rng, "chip", wild=0.1)),
        Seat(
            "arpeggio",
            Arpeggio(rng, rng.choice([2, 4, 4, 8]), rng.choice([(0, 1, 2), (0, 1, 2, 1), None]), 66, 3, 0.8),
            program(rng, "chip", wild=0.1),
            0.8,
        ),
    ]
    if rng.random() < 0.3:
        seats.append(Seat("second", Shadow(melody), program(rng, "chip")))
    if rng.random() < 0.75:
        groove = (
            backbeat(rng) if four else Groove({"kick": "X...........", "snare": "....X...X...", "hat": "x.x.x.x.x.x."})
        )
        seats.append(Seat("drums", Drummer(rng, groove, crash=0.2), kit(rng, "electronic", "808", "standard")))
    return Plan(
        rng.triangular(90, 190, 136),
        seats,
        harmony(rng, found, [*POP, *ROCK[:4]] if found.scale == "major" else MINOR),
        found,
        metre,
        timing="machine",
    )


@style("game band", "electronic", 1.8)
def game_band(rng: Random) -> Plan:
    """Shooters' music: sequenced riffs, bass, drums, organ and leads, quantised; half-time, driving or stalking."""
    found = key(rng, "minor", "blues", "dorian", "phrygian")
    metre = rng.choice([COMMON, COMMON, COMMON, COMMON, THREE])
    pattern = weave(rng, metre, rng.uniform(0.4, 0.9), 2, rng.uniform(0.2, 0.8))
    if pattern[0][0] > 0:
        pattern.insert(0, (0.0, 1.0))
    guitar = Figure(
        rng,
        pattern,
        rng.choice([(0, 0, 3, 5, 7, 10), (0, 0, 0, 1, 3, 6), (0, 12, 10, 7)]),
        40,
        power=rng.random() < 0.6,
    )
    grooves = [backbeat(rng), backbeat(rng), half_time(rng), floor(rng)]
    groove = (
        rng.choice(grooves)
        if metre.beats == 4
        else Groove({"kick": "X.....x.....", "snare": "........X...", "hat": "x.x.x.x.x.x."})
    )
    drummer = Drummer(rng, groove, rng.choice([*grooves, None]) if metre.beats == 4 else None)
    seats = [
        Seat("drums", drummer, kit(rng, "standard", "power", "room", "electronic")),
        Seat("comp", guitar, program(rng, "distorted", "electric", "organ", "synth bass")),
        Seat(
            "bass",
            Figure(rng, pattern, (0, 0, 0, 7, 10), 28) if rng.random() < 0.5 else Bass(rng, [], "root", 28),
            program(rng, "bass", "synth bass"),
        ),
    ]
    if rng.random() < 0.6:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 60, 84, rng.uniform(0.2, 0.7), 0.2),
                program(rng, "distorted", "lead", "organ", "strings", "choir"),
            )
        )
    if rng.random() < 0.5:
        seats.append(Seat("pad", Pad(rng, 56, 3), program(rng, "pad", "strings", "choir", "organ"), 0.7))
    return Plan(
        rng.triangular(70, 186, 116),
        seats,
        harmony(rng, found, [*MINOR, "i i bII i", "i i i i", "i bVII i bVI"]),
        found,
        metre,
        timing=rng.choice(["machine", "machine", "human"]),
        drift=0.008,
    )


@style("trance", "electronic", 1.0)
def trance(rng: Random) -> Plan:
    found = key(rng, "minor", "major")
    seats = [
        Seat("drums", Drummer(rng, floor(rng), None, 16, 0.4), kit(rng, "electronic", "808")),
        Seat(
            "bass",
            Bass(rng, [".xxx.xxx.xxx.xxx", "..x...x...x...x.", "..xx..xx..xx..xx"], "root", 30, 0.6),
            program(rng, "synth bass"),
        ),
        Seat("arpeggio", Arpeggio(rng, 4, None, 66, 4, 0.7, gaps=rng.choice([0, 0.15])), program(rng, "lead")),
        Seat("pad", Pad(rng, 62, 4), program(rng, "pad", "strings", "choir")),
        Seat("lead", Melody(rng, 66, 88, 0.5, 0.3), program(rng, "lead", "piano")),
    ]
    return Plan(
        rng.uniform(122, 150),
        seats,
        harmony(rng, found, MINOR if found.scale == "minor" else POP),
        found,
        timing="machine",
        sections=layers(rng, [seat.role for seat in seats]),
        lengths=(8, 8, 16),
    )


@style("ambient", "electronic", 0.9)
def ambient(rng: Random) -> Plan:
    """Pads whose chords change on the downbeat, a slow arpeggio or a heartbeat; the beat is a matter of patience."""
    found = key(rng, "major", "minor", "lydian", "dorian")
    metre = rng.choice([COMMON, COMMON, THREE])
    seats = [
        Seat("pad", Pad(rng, 58, 4), program(rng, "pad", "strings", "choir")),
        Seat(
            "arpeggio",
            Arpeggio(rng, rng.choice([1, 2, 2, 4]), None, 68, 3, 1.5, gaps=rng.choice([0, 0.2])),
            program(rng, "bells", "mallets", "epiano", "harp", "pad", "piano"),
        ),
    ]
    if rng.random() < 0.5:
        seats.append(
            Seat(
                "bass",
                Bass(rng, ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats], "root", 30, 1.0),
                program(rng, "synth bass", "bass"),
            )
        )
    if rng.random() < 0.4:
        lanes = {
            "kick": "X" + "." * (4 * metre.beats - 1),
            rng.choice(["shaker", "hat", "rim"]): rng.choice(["..x.", "x.o.", "x..."]) * metre.beats,
        }
        seats.append(Seat("drums", Percussion(rng, Groove(lanes)), kit(rng, "808", "electronic")))
    return Plan(
        rng.triangular(54, 120, 80),
        seats,
        harmony(rng, found, POP if found.scale in ("major", "lydian") else MINOR),
        found,
        metre,
        timing=rng.choice(["machine", "human"]),
    )
