"""The made films of cameras: those to tune on, and those held back.

Nobody tunes on what is held back: other takes, other shows, other people, other rooms and seeds.
"""

import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Final

from bench._camera_dances import ShowPart, Take, Walker, around, crossing_patch, walking_patch
from bench._camera_films import BACK, DARK, WHITE, FilmCase, Person, make_film
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

_REACHED: Final = 2.0
"""How far somebody walks in two measures [m]; the step of travelling is not longer."""


def _turning(steps: tuple[str, str], bpm: float, radius: float) -> str:
    """Two who meet, turn about each other and part: on the other side, there again, on their own side."""
    walkers = []
    for step, side in zip(steps, (-1.0, 1.0), strict=True):
        away, deep = 0.4 * _REACHED * side, 0.2 * side
        walkers.append(
            Walker(step, (away, deep), (
                (2, 2, (*around(side, radius, 0.5), (-away, -deep))),
                (4, 3, (*around(-side, radius, 1.0), (-away, -deep))),
                (7, 2, (*around(-side, radius, 0.5), (away, deep))),
            ))
        )  # fmt: skip
    return walking_patch(walkers, bpm=bpm)


def _behind(steps: tuple[str, str], bpm: float, middle: float, reach: float = 1.0) -> str:
    """One stays; the other goes behind and turns back, goes behind and out beyond, and turns back there again."""
    return walking_patch(
        (
            Walker(steps[0], (middle, 0.45), ()),
            Walker(steps[1], (middle - reach, -0.35), (
                (2, 2, ((middle - 0.05, -0.35), (middle - reach, -0.35))),
                (4, 2, ((middle + reach, -0.35),)),
                (6, 2, ((middle + 0.05, -0.35), (middle + reach, -0.35))),
            )),
        ), bpm=bpm,
    )  # fmt: skip


def _to_and_fro(
    steps: tuple[str, ...], bpm: float, across: tuple[float, ...], deep: tuple[float, ...], measures: int = 1
) -> str:
    """Several who change sides again and again, each in a depth of their own, from x to -x within `measures`."""
    return walking_patch(
        tuple(
            Walker(step, (x, z), tuple(
                (measure, measures, ((-x * (-1.0) ** turn, z),))
                for turn, measure in enumerate(range(2, 14, measures))
            ))
            for step, x, z in zip(steps, across, deep, strict=True)
        ), bpm=bpm,
    )  # fmt: skip


def _leaving(steps: tuple[str, str], bpm: float, out: float, depth: float) -> str:
    """Two who cross, leave the picture, each on the other's side, and come back to cross again, and again."""
    return walking_patch(
        tuple(
            Walker(step, (side * 0.7, -0.5 * side * depth), (
                (2, 3, ((-side * out, -0.5 * side * depth),)),
                (5, 3, ((side * 0.7, -0.5 * side * depth),)),
                (8, 2, ((-side * 0.9, -0.5 * side * depth),)),
            ))
            for step, side in zip(steps, (-1.0, 1.0), strict=True)
        ), bpm=bpm,
    )  # fmt: skip


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
    FilmCase("cross_turning", ShowPart(_turning(("groove", "reach"), 170.0, 0.25), (0, 1), 1.2), 10.0, (BEN, DORA),
             eye=(0.2, 1.4, 5.0), field_of_view_deg=36.0, seed=31),
    FilmCase("cross_behind_alike", ShowPart(_behind(("samba", "groove"), 160.0, 0.1), (0, 1), 1.0), 9.5,
             (CLEO, replace(CLEO, hair="bob", skin=90)), eye=(-0.2, 1.5, 5.6), field_of_view_deg=36.0, seed=32),
    FilmCase("cross_fast", ShowPart(_to_and_fro(("side step", "tap"), 176.0, (-0.58, 0.58), (0.35, -0.35)), (0, 1),
             0.8), 8.0, (EMIL, replace(EMIL, colour=(0.10, 0.12, 0.16), second=(0.05, 0.06, 0.12))),
             eye=(0.0, 1.2, 5.8), light=WHITE, seed=33),
    FilmCase("cross_leaving", ShowPart(_leaving(("reach", "groove"), 190.0, 2.3, 1.0), (0, 1), 1.0), 10.0,
             (ANNA, BEN), eye=(0.2, 1.4, 5.2), field_of_view_deg=30.0, seed=34),
    FilmCase("cross_three", ShowPart(_to_and_fro(("groove", "turn", "side step"), 164.0, (-1.0, 0.0, 1.0),
             (-0.6, 0.6, 0.0), 2), (0, 1, 2), 1.0), 9.0, (DORA, ANNA, replace(ANNA, hair="bald")), eye=(0.0, 2.0, 6.0),
             sensor=PHONE, seed=35),
    FilmCase("cross_four", ShowPart(_to_and_fro(("samba", "reach", "groove", "tap"), 178.0, (-1.2, -0.5, 0.5, 1.2),
             (-0.8, 0.3, -0.3, 0.8), 2), (0, 1, 2, 3), 1.0), 8.0, (EMIL, CLEO, BEN, DORA), eye=(-0.5, 1.9, 6.6),
             size=(960, 540), seed=36),
    FilmCase("cross_deep", ShowPart(_to_and_fro(("turn", "side step"), 152.0, (-0.9, 0.9), (1.0, -1.0), 2), (0, 1),
             1.4), 9.5, (CLEO, DORA), eye=(0.6, 1.1, 5.2), field_of_view_deg=46.0, seed=37, height=1.78),
    FilmCase("cross_salsa", Take(("salsa/60_05.bvh", "salsa/61_05.bvh"), 17.0, 120.0), 9.0, (EMIL, ANNA),
             eye=(0.0, 1.5, 5.8), seed=38),
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
    FilmCase("held_cross_turning", ShowPart(_turning(("kick", "body roll"), 182.0, 0.30), (0, 1), 1.0, seed=7), 9.5,
             (FAYE, IVO), eye=(-0.3, 1.6, 5.4), field_of_view_deg=34.0, sensor=PHONE, seed=131),
    FilmCase("held_cross_behind", ShowPart(_behind(("mambo", "arm wave"), 168.0, -0.1, 1.1), (0, 1), 1.0, seed=8), 9.0,
             (HANA, FAYE), eye=(0.3, 1.3, 5.6), field_of_view_deg=38.0, seed=132, height=1.66),
    FilmCase("held_cross_fast_alike", ShowPart(_to_and_fro(("arm wave", "bow"), 168.0, (-0.55, 0.55), (-0.45, 0.45)),
             (0, 1), 0.9, seed=9), 8.5, (GUS, replace(GUS, hair="bald", skin=150)), eye=(0.2, 1.5, 6.0), seed=133),
    FilmCase("held_cross_leaving", ShowPart(_leaving(("kick", "bow"), 192.0, 2.4, 0.8), (0, 1), 1.1, seed=10), 10.0,
             (IVO, GUS), eye=(-0.2, 1.5, 5.2), field_of_view_deg=31.0, light=WHITE, seed=134, height=1.80),
    FilmCase("held_cross_three", ShowPart(_to_and_fro(("body roll", "kick", "arm wave"), 172.0, (-1.1, 0.1, 1.0),
             (0.5, -0.5, 0.0), 2), (0, 1, 2), 1.0, seed=11), 9.0, (HANA, GUS, FAYE), eye=(0.3, 1.8, 6.2), seed=135),
    FilmCase("held_cross_trio", Take(("group/perfume_aachan.bvh", "group/perfume_kashiyuka.bvh",
             "group/perfume_nocchi.bvh"), 60.0), 9.0, (HANA, FAYE, IVO), eye=(0.0, 1.5, 6.4), seed=136),
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
