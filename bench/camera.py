"""A camera sees dancers: joints, feet, places, who is who, on made films; what it costs and how late it is.

No real person was filmed. The films are made by the project's renderer and then spoilt as a sensor and a codec do.
"""

import os
import tempfile
import time
from pathlib import Path
from typing import Any, Final

import numpy as np
import psutil

from bench._camera_cases import HELD, HELD_PAIRS, TUNING, TUNING_PAIRS
from bench._camera_films import FilmCase, FilmTruth, load_truth, make_film
from bench._camera_runs import Seen, see_film, see_films
from bench._camera_scores import (
    IdentityScore,
    Score,
    contact_score,
    find_crossings,
    foot_contacts,
    identities,
    identity_score,
    joint_error,
    motion_clip,
    pose_joints,
    root_error,
    tempo_error,
    true_clip,
)
from bench._show_alive import last_line, playing, until
from live.cli.bench import Row
from live.clock.time_source import SystemClock
from live.control.camera.camera_plan import MODULE, CameraPlan
from live.control.camera.model_files import model_folder
from live.control.events.event_json import register_events
from live.control.helper_process import HelperProcess

LIVE_DELAY: Final = 0.06
"""Delay [s] that is predicted away."""
LIVE_SECONDS: Final = 12.0
SHOW_SECONDS: Final = 40.0
"""How long the show plays before its frames are looked at [s]."""
FILMS_VARIABLE: Final = "LIVE_CAMERA_FILMS"
"""Environment variable: a folder where made films stay, so that they are made once."""
_BAD_LIGHT: Final = ("dark", "back_light", "boxes")
"""Words in the names of films in bad light, or with hidden bodies."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Films held back; with `full` also those by which the method was tuned. Making them takes minutes."""
    if model_folder() is None:
        return [Row("a camera sees dancers", None, "", note="needs the pose models: live camera models")]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(os.environ.get(FILMS_VARIABLE) or scratch)
        rows = _quality_rows("held back", HELD, folder / "held", shared)
        rows += _pair_rows("held back", HELD_PAIRS, folder / "held", shared)
        if full:
            rows += _quality_rows("tuned", TUNING, folder, shared)
            rows += _pair_rows("tuned", TUNING_PAIRS, folder, shared)
        return rows + _live_rows(folder, shared) + _show_rows(folder, shared)


def _film(case: FilmCase, folder: Path, shared: Path | None) -> FilmTruth | None:
    """Return a made film, from the folder if it is there."""
    folder.mkdir(parents=True, exist_ok=True)
    there = folder / f"{case.name}.npz"
    return load_truth(there) if there.is_file() else make_film(case, folder, shared)


class _Total:
    """Figures of several films."""

    def __init__(self) -> None:
        self.joint: list[float] = []
        self.scaled: list[float] = []
        self.predicted: list[float] = []
        self.root: list[float] = []
        self.tempo: list[float] = []
        self.found: list[float] = []
        self.feet = Score(0, 0, 0)
        self.crossings = self.kept = 0
        self.cpu: list[float] = []

    def add(self, truth: FilmTruth, seen: Seen, late: Seen | None) -> None:
        """Add a film. `late`: the same, predicted."""
        who = identities(seen.people(), truth.hips)
        for dancer in range(truth.joints.shape[1]):
            hips, rotation = _of_dancer(seen, who[:, dancer])
            error = joint_error(pose_joints(hips, rotation), truth.joints[:, dancer])
            self.joint.append(error.mean)
            self.scaled.append(error.scaled)
            self.found.append(error.found)
            self.root.append(root_error(hips, truth.hips[:, dancer]).mean)
            there = np.isfinite(hips[:, 0])
            if there.mean() > 0.5:
                first = int(np.argmax(there))
                filled_hips, filled = _filled(hips[first:]), _filled(rotation[first:])
                contact = foot_contacts(pose_joints(filled_hips, filled), truth.fps)
                self.feet += contact_score(contact[there[first:]], truth.contact[first:, dancer][there[first:]])
                found = motion_clip("found", filled_hips, filled, truth.fps)
                tempo = tempo_error(found, true_clip(truth, dancer))
                if tempo is not None:
                    self.tempo.append(tempo.octave_error)
            if late is not None:
                shift = round(LIVE_DELAY * truth.fps)
                hips, rotation = _of_dancer(late, who[:, dancer])
                ahead = joint_error(pose_joints(hips[:-shift], rotation[:-shift]), truth.joints[shift:, dancer])
                self.predicted.append(ahead.mean)
        crossings = find_crossings(truth)
        kept: IdentityScore = identity_score(who, crossings, truth.fps)
        self.crossings, self.kept = self.crossings + kept.crossings, self.kept + kept.kept
        self.cpu.append(seen.cpu_ms / truth.joints.shape[1])


def _of_dancer(seen: Seen, who: Any) -> tuple[Any, Any]:
    """Return hips (F, 3) and rotations (F, J, 4) of the person whom a dancer was taken for, frame by frame."""
    frames = np.arange(len(who))
    there = who >= 0
    hips = np.where(there[:, None], seen.hips[frames, np.maximum(who, 0)], np.nan)
    rotation = np.where(there[:, None, None], seen.rotation[frames, np.maximum(who, 0)], np.nan)
    return hips, rotation


def _filled(values: Any) -> Any:
    """Return values with gaps held."""
    there = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    index = np.maximum.accumulate(np.where(there, np.arange(len(values)), 0))
    return values[index]


def _quality_rows(name: str, cases: tuple[FilmCase, ...], folder: Path, shared: Path | None) -> list[Row]:
    good, bad = _Total(), _Total()
    left_out = 0
    for case in cases:
        truth = _film(case, folder, shared)
        if truth is None:
            left_out += 1
            continue
        hard = any(word in case.name for word in _BAD_LIGHT)
        (bad if hard else good).add(truth, see_film(truth), None if hard else see_film(truth, delay=LIVE_DELAY))
    note = f"{left_out} films left out: no recordings" if left_out else ""
    kept = good.kept / good.crossings if good.crossings else None
    return [
        Row(f"{name}: joints from the truth, hips laid on each other, mean", _cm(good.joint), "cm", 6.0, note=note),
        Row(f"{name}: the same, at the body's true size", _cm(good.scaled), "cm"),
        Row(f"{name}: the same unscaled, {1e3 * LIVE_DELAY:.0f} ms predicted", _cm(good.predicted), "cm"),
        Row(f"{name}: the same in bad light or half hidden", _cm(bad.joint), "cm"),
        Row(f"{name}: contacts of feet, F1", good.feet.f1, "", 0.85, "at least"),
        Row(f"{name}: kinematic tempo, mean deviation", _percent(good.tempo), "%", 3.0),
        Row(f"{name}: hips on the floor, by four marks, mean", _cm(good.root), "cm", 15.0),
        Row(f"{name}: crossings after which both keep their names", kept, "", 0.95, "at least",
            note=f"{good.kept} of {good.crossings}"),
        Row(f"{name}: share of pictures in which a dancer is seen, good light", float(np.mean(good.found)), ""),
        Row(f"{name}: the same in bad light or half hidden", float(np.mean(bad.found)) if bad.found else None, ""),
        Row(f"{name}: processor time of a picture, for each dancer", float(np.median(good.cpu)), "ms"),
    ]  # fmt: skip


def _pair_rows(name: str, pairs: tuple[tuple[FilmCase, FilmCase], ...], folder: Path, shared: Path | None) -> list[Row]:
    """Dances that two cameras film, seen by both and by the first alone."""
    one, both = _Total(), _Total()
    for pair in pairs:
        films = [truth for case in pair if (truth := _film(case, folder, shared)) is not None]
        if len(films) == len(pair):
            one.add(films[0], see_film(films[0]), None)
            both.add(films[0], see_films(films), None)
    return [
        Row(f"{name}, two cameras: joints from the truth, hips laid on each other, mean", _cm(both.joint), "cm", 6.0,
            peers={"the first alone [cm]": _cm(one.joint) or 0.0}),
        Row(f"{name}, two cameras: hips on the floor, mean", _cm(both.root), "cm", 15.0,
            peers={"the first alone [cm]": _cm(one.root) or 0.0}),
    ]  # fmt: skip


def _cm(values: list[float]) -> float | None:
    return 100.0 * float(np.nanmean(values)) if values else None


def _percent(values: list[float]) -> float | None:
    return 100.0 * float(np.nanmean(values)) if values else None


def _live_rows(folder: Path, shared: Path | None) -> list[Row]:
    """The camera process with a film in real time: cores and delay."""
    truth = _film(TUNING[1], folder, shared)
    assert truth is not None  # a show of the project's own
    register_events()  # both ends of the channel encode events
    clock = SystemClock()
    camera = CameraPlan(name="film", kind="film", place=str(truth.film))
    plan = {"cameras": [camera.as_packet()], "model": "full", "performers": ["anna"], "most": 1, "half": None}
    received = 0

    def take(events: object) -> None:
        nonlocal received
        received += len(events)  # type: ignore[arg-type]

    process = HelperProcess(MODULE, clock, plan, lambda: None, on_packet=take)
    process.start()
    try:
        deadline = clock.now() + 60.0
        while not received and clock.now() < deadline:
            process.frame()
            time.sleep(1 / 60)
        assert process.pid is not None
        child = psutil.Process(process.pid)
        begin, spent, first = clock.now(), sum(child.cpu_times()[:2]), received
        while clock.now() - begin < LIVE_SECONDS:
            process.frame()
            time.sleep(1 / 60)
        wall, cpu = clock.now() - begin, sum(child.cpu_times()[:2]) - spent
        facts = process.status()["cameras"][0]
        rate = (received - first) / wall
    finally:
        process.stop()
    load = f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores, {rate:.1f} poses a second"
    return [
        Row("one dancer at 30 pictures a second: cores of the camera process", cpu / wall * 30.0 / max(rate, 1e-3), "",
            1.2, note=load),
        Row("from the picture to the pose sent, median", facts.get("delay_ms"), "ms", 60.0, note=load),
        Row("the same, 95 %", facts.get("delay_95_ms"), "ms", 90.0, note=load),
    ]  # fmt: skip


def _show_rows(folder: Path, shared: Path | None) -> list[Row]:
    """Frames of the default show with a camera, and without one before and after."""
    truth = _film(TUNING[1], folder, shared)
    assert truth is not None  # a show of the project's own
    played = [_played(options) for options in ((), ("--camera", str(truth.film)), ())]
    load = f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; the processor draws"
    rows = []
    for kind, name in (("frame_ms", "the show's frame"), ("cpu_ms", "the frame's processor time")):
        before, own, after = (float(each[kind]["p99"]) for each in played)
        rows.append(Row(f"{name} with a camera over that without, p99", 2.0 * own / (before + after), "", 1.05,
                        note=load, peers={"with [ms]": own, "before [ms]": before, "after [ms]": after}))  # fmt: skip
    return rows


def _played(options: tuple[str, ...]) -> dict[str, Any]:
    """Return the status of the default show after `SHOW_SECONDS`."""
    with tempfile.TemporaryDirectory() as scratch:
        status = Path(scratch) / "status"
        with playing(status, *options):
            until(lambda: last_line(status).get("time", 0.0) > SHOW_SECONDS, "the show to play")
            return last_line(status)
