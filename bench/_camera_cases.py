"""The made films of cameras: those to tune on, and those held back.

Nobody tunes on what is held back: other takes, other shows, other people, other rooms and seeds.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Final

from bench._camera_dances import ShowPart, Take, crossing_patch
from bench._camera_films import BACK, DARK, FilmCase, Person, make_film
from bench._camera_sensor import Sensor
from live.base.set_geometry import SetItem

ANNA: Final = Person("woman", "trousers", (0.55, 0.08, 0.10), (0.05, 0.06, 0.12), 175, "bob", 60, "sneakers")
BEN: Final = Person("man", "jacket", (0.10, 0.16, 0.30), (0.20, 0.20, 0.22), 120, "crop", 20, "sneakers")
CLEO: Final = Person("slim", "unitard", (0.08, 0.35, 0.28), (0.06, 0.20, 0.18), 60, "ponytail", 10, "ballet")
DORA: Final = Person("dancer", "leotard", (0.06, 0.06, 0.08), (0.30, 0.30, 0.32), 215, "bun", 120, "barefoot")
EMIL: Final = Person("strong", "trousers", (0.60, 0.55, 0.45), (0.25, 0.16, 0.10), 200, "curls", 90, "boots")
FAYE: Final = Person("older woman", "trousers", (0.30, 0.12, 0.35), (0.40, 0.38, 0.34), 190, "bob", 210, "pumps")
GUS: Final = Person("older man", "jacket", (0.32, 0.28, 0.22), (0.08, 0.08, 0.09), 90, "crop", 230, "boots")
HANA: Final = Person("round", "unitard", (0.70, 0.45, 0.10), (0.35, 0.20, 0.06), 150, "braid", 15, "sneakers")
IVO: Final = Person("man", "bare", (0.15, 0.30, 0.50), (0.10, 0.10, 0.10), 30, "bald", 0, "barefoot")

PHONE: Final = Sensor(shutter_s=1 / 120, readout_s=0.018, electrons=5000.0, kilobits=2500.0)
NIGHT: Final = Sensor(
    shutter_s=1 / 32, readout_s=0.012, moments=4, electrons=160.0, read_noise=4.0, exposure=1.3, kilobits=900.0
)
"""A webcam that has to look long in the dark, and still is noisy."""

TUNING: Final = (
    FilmCase("modern_front", Take(("solo/modern05/05_13.bvh",), 0.0, 180.0), 7.0, (ANNA,), eye=(0.0, 1.4, 5.6),
             seed=11),
    FilmCase("groove_webcam", ShowPart("first_show.toml", (0,), 4.0), 8.0, (BEN,), eye=(0.3, 1.2, 4.6), seed=12),
    FilmCase("salsa_couple", Take(("salsa/60_01.bvh", "salsa/61_01.bvh"), 6.0), 8.0, (BEN, ANNA),
             eye=(0.0, 1.5, 6.0), size=(960, 540), field_of_view_deg=36.0, sensor=PHONE, seed=13),
    FilmCase("crossing_costumes", ShowPart(crossing_patch(("groove", "side step"), bpm=112, dancers=2, width=2.6,
             depth=0.9), (0, 1), 0.0), 10.0, (ANNA, CLEO), eye=(0.0, 1.5, 6.2), seed=14),
    FilmCase("crossing_alike", ShowPart(crossing_patch(("samba", "groove"), bpm=104, dancers=2, width=2.4,
             depth=1.1), (0, 1), 2.0), 7.5, (ANNA, replace(ANNA, hair="crop")), eye=(0.0, 1.6, 6.2), seed=15),
    FilmCase("dark_hiphop", ShowPart("hiphop/show.toml", (1,), 3.0, bpm=98.0), 6.0, (EMIL,), eye=(-0.6, 1.3, 5.2),
             light=DARK, sensor=NIGHT, seed=16),
    FilmCase("back_light", Take(("salsa/61_03.bvh",), 9.0, 20.0), 6.0, (DORA,), eye=(0.0, 1.1, 5.0),
             light=BACK, height=1.62, seed=17),
    FilmCase("behind_boxes", ShowPart("house/show.toml", (0,), 5.0), 6.0, (EMIL,), eye=(0.0, 1.5, 6.0),
             items=(SetItem("box", (0.55, 1.5), (0.5, 0.7, 0.4), colour=(0.25, 0.16, 0.10)),), seed=18, height=1.82),
    FilmCase("side_high", ShowPart("release/show.toml", (0,), 6.0), 6.0, (CLEO,), eye=(4.2, 2.4, 3.2),
             size=(960, 540), sensor=PHONE, seed=19),
    FilmCase("four_dancers", ShowPart(crossing_patch(("groove", "side step", "samba", "reach"), bpm=116, dancers=4,
             width=3.4, depth=1.2), (0, 1, 2, 3), 1.5), 6.5, (ANNA, BEN, CLEO, EMIL), eye=(0.0, 1.8, 7.0),
             size=(960, 540), sensor=PHONE, seed=20),
    FilmCase("jumps", ShowPart(
        'name = "Jumps"\n[clock]\nbpm = 108\n[[group]]\nname = "a"\ndancers = 1\n'
        'steps = ["jump", "reach", "body roll", "jump"]\n', (0,), 0.0), 8.0, (DORA,),
        eye=(0.0, 1.3, 6.0), seed=21),
)  # fmt: skip
"""To tune on."""

HELD: Final = (
    FilmCase("held_indian", Take(("solo/indian94/indian_06.bvh",), 5.0, 25.0), 7.0, (FAYE,), eye=(0.4, 1.5, 5.8),
             size=(960, 540), sensor=PHONE, seed=101),
    FilmCase("held_waltz", ShowPart("waltz/show.toml", (2,), 6.0, seed=9), 6.0, (GUS,), eye=(-0.5, 1.3, 5.0),
             seed=102),
    FilmCase("held_couple", Take(("group/perfume_kashiyuka.bvh", "group/perfume_nocchi.bvh"), 48.0, -40.0), 7.0,
             (GUS, FAYE), eye=(0.2, 1.7, 6.2), size=(960, 540), field_of_view_deg=36.0, seed=103),
    FilmCase("held_crossing", ShowPart(crossing_patch(("kick", "mambo"), bpm=122, dancers=2, width=2.8, depth=0.8),
             (0, 1), 1.5, seed=5), 7.0, (HANA, IVO), eye=(0.3, 1.4, 6.4), seed=104),
    FilmCase("held_crossing_alike", ShowPart(crossing_patch(("arm wave", "kick"), bpm=96, dancers=2, width=2.4,
             depth=1.0), (0, 1), 2.5, seed=6), 8.0, (HANA, HANA), eye=(-0.3, 1.5, 6.2), seed=105),
    FilmCase("held_dark", ShowPart("lindy/show.toml", (1,), 4.0, seed=3), 6.0, (IVO,), eye=(0.5, 1.2, 5.2),
             light=DARK, sensor=replace(NIGHT, electrons=200.0), seed=106),
    FilmCase("held_back_light", Take(("solo/indian94/indian_13.bvh",), 4.0), 6.0, (HANA,), eye=(0.0, 1.3, 5.2),
             light=BACK, height=1.58, seed=107),
    FilmCase("held_boxes", Take(("group/perfume_aachan.bvh",), 20.0), 6.0, (FAYE,), eye=(0.0, 1.4, 6.0),
             items=(SetItem("cylinder", (-0.4, 1.6), (0.4, 0.8, 0.4), colour=(0.10, 0.14, 0.10)),), seed=108,
             height=1.76),
    FilmCase("held_side", ShowPart("samba/show.toml", (3,), 5.0, seed=4), 6.0, (HANA,), eye=(-4.4, 1.9, 2.8),
             sensor=PHONE, seed=109),
    FilmCase("held_three", Take(("group/perfume_aachan.bvh", "group/perfume_kashiyuka.bvh", "group/perfume_nocchi.bvh"),
             30.0), 7.0, (FAYE, GUS, HANA), eye=(0.0, 1.7, 6.6), size=(960, 540), sensor=PHONE, seed=110),
    FilmCase("held_jumps", ShowPart(
        'name = "Held jumps"\nseed = 3\n[clock]\nbpm = 118\n[[group]]\nname = "a"\ndancers = 1\n'
        'steps = ["reach", "jump", "side step", "kick", "jump", "body roll"]\n', (0,), 0.0), 10.0, (IVO,),
        eye=(-0.4, 1.5, 6.2), height=1.84, seed=111),
)  # fmt: skip
"""Held back: never tuned on."""


def _again(cases: tuple[FilmCase, ...], **eyes: tuple[float, float, float]) -> tuple[tuple[FilmCase, FilmCase], ...]:
    """Return cases by their names, each with one that a second camera films, at the place given for it."""
    by_name = {case.name: case for case in cases}
    return tuple(
        (by_name[name], replace(by_name[name], name=f"{name}_b", eye=eye, seed=by_name[name].seed + 500))
        for name, eye in eyes.items()
    )


TUNING_PAIRS: Final = _again(TUNING, modern_front=(4.2, 1.7, 3.9), salsa_couple=(-4.4, 1.8, 4.2))
HELD_PAIRS: Final = _again(HELD, held_indian=(-4.1, 1.6, 4.3), held_waltz=(4.0, 1.8, 3.6), held_couple=(4.6, 1.9, 4.2))
"""Dances that two cameras film."""


def make_films(cases: tuple[FilmCase, ...], folder: Path, shared: Path | None) -> None:
    """Make films of cases in `folder`, and print what each took."""
    folder.mkdir(parents=True, exist_ok=True)
    for case in cases:
        begun, used = time.perf_counter(), time.process_time()
        truth = make_film(case, folder, shared)
        took, busy = time.perf_counter() - begun, time.process_time() - used
        words = (
            "left out, its recordings are not there" if truth is None else f"{took:.0f} s, {busy:.0f} s of processor"
        )
        print(f"{case.name}: {case.seconds:g} s of {case.size[0]} x {case.size[1]}: {words}", flush=True)


if __name__ == "__main__":
    which, pairs = (HELD, HELD_PAIRS) if sys.argv[2] == "held" else (TUNING, TUNING_PAIRS)
    by_name = {one.name: one for one in (*which, *(second for _, second in pairs))}
    make_films(tuple(by_name[name] for name in sys.argv[4:] or by_name), Path(sys.argv[1]), Path(sys.argv[3]))
