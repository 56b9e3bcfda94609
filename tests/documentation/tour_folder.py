"""The folder in which the tour of all commands takes place: shows, songs, recordings and lists as pages name them."""

import json
import math
import shutil
import subprocess
import sys
import wave
from pathlib import Path
from typing import Final

import mido
import numpy as np

from tests.documentation.snippets import snippets
from tests.places import ROOT

RATE: Final = 48000
SHOW: Final = """
name = "my show"
seed = 3
[clock]
bpm = 124
[[section]]
name = "verse"
measures = 64
[[group]]
name = "ember"
dancers = 6
steps = ["groove", "walk", "samba"]
formation = "circle"
[[group]]
name = "mist"
dancers = 3
steps = ["groove"]
[[formation]]
name = "gate"
shape = "arc"
size = [5.0, 3.0]
[[segment]]
measure = 4
measures = 2
group = "ember"
formation = "gate"
[[segment]]
measure = 9
measures = 2
group = "mist"
formation = "line"
[[segment]]
measure = 13
measures = 2
group = "ember"
formation = "star"
"""
CLAPS: Final = "stamp and clap x12"
VARIED: Final = ", ".join(2 * ["walk x2, grapevine, samba x2, side step x2, mambo, turn, groove x2, kick, reach, jump"])
HEART: Final = (
    '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 30 C-60 -20 -20 -60 0 -30 C20 -60 60 -20 0 30 Z"/></svg>'
)
PAIRS: Final = '[[pair]]\nleader = "leader.bvh"\nfollower = "real.bvh"\nbpm = 124\nfirst_beat_s = 0.0\n'


def live(folder: Path, *arguments: str) -> None:
    """Run a command that makes a part of the folder."""
    subprocess.run([sys.executable, "-m", "live", *arguments], cwd=folder, check=True, capture_output=True)


def _write_song(path: Path, seconds: float = 20.0) -> None:
    """Write clicks and a bass at 124 bpm."""
    times = np.arange(int(seconds * RATE)) / RATE
    beat = times * 124 / 60
    within = (beat % 1) * 60 / 124
    loud = np.where(beat.astype(int) % 4 == 0, 0.9, 0.5)
    sound = loud * np.exp(-60 * within) * np.sin(2 * math.pi * 1200 * within) + 0.2 * np.sin(2 * math.pi * 55 * times)
    with wave.open(str(path.with_suffix(".wav")), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.clip(sound, -1, 1) * 32000).astype("<i2").tobytes())


def _write_midi(path: Path) -> None:
    song = mido.MidiFile()
    track = mido.MidiTrack()
    track.append(mido.MetaMessage("set_tempo", tempo=mido.bpm2tempo(124)))
    for beat in range(32):
        track.append(mido.Message("note_on", note=60 + beat % 4, velocity=90, time=0))
        track.append(mido.Message("note_off", note=60 + beat % 4, time=480))
    song.tracks.append(track)
    song.save(path)


def make_tour_folder(folder: Path) -> None:
    """Fill the folder."""
    (folder / "my_show").mkdir(parents=True)
    (folder / "my_show" / "show.toml").write_text(SHOW)
    (folder / "my_show.toml").write_text(SHOW)
    (folder / "show.toml").write_text(SHOW)
    shutil.copytree(folder / "my_show", folder / "my show")
    (folder / "gate.toml").write_text('shape = "arc"\nsize = [5.0, 3.0]\n')
    (folder / "heart.svg").write_text(HEART)
    (folder / "score.txt").write_text("side step, samba x2\n*\n")
    (folder / "path.csv").write_text("".join(f"{t / 10:.1f},{t / 20:.2f},0.0\n" for t in range(60)))
    (folder / "fixes.json").write_text(json.dumps([{"do": "half"}, {"do": "double"}]))
    for name, page in (("edits", "document"), ("scenario", "simulate")):
        (folder / f"{name}.json").write_text(_blocks("json", f"how-to/programs/{page}.md")[0])
    _write_look(folder / "my_look")
    _write_midi(folder / "song.mid")
    for name in ("song", "new"):
        _write_song(folder / name)
        wav = folder / f"{name}.wav"
        _convert(wav, folder / f"{name}.ogg")
    shutil.copy(folder / "new.ogg", folder / "my_show")
    live(folder, "dance", str(ROOT / "patches/folk/steps"), "--sequence", CLAPS, "--bpm", "124", "--out", "take_3.bvh")
    live(folder, "dance", "sketches", "--sequence", VARIED, "--bpm", "124", "--out", "rehearsal.bvh")
    for source, names in (("take_3", ("take_7", "real", "walk")), ("rehearsal", ("a", "b", "c", "leader"))):
        for name in names:
            shutil.copy(folder / f"{source}.bvh", folder / f"{name}.bvh")
    (folder / "salsa.toml").write_text(PAIRS)
    (folder / "walks.toml").write_text(PAIRS)
    for steps in ("my_steps", "my_show/steps"):
        shutil.copytree(ROOT / "patches/steps", folder / steps)
    (folder / "mocap").mkdir()
    shutil.copy(folder / "take_3.bvh", folder / "mocap")
    live(folder, "render", "my_show", "--out", "other.csv", "--seconds", "66", "--fps", "5", "--journal", "night.jsonl")
    shutil.copy(folder / "night.jsonl", folder / "other.jsonl")


def _blocks(language: str, page: str) -> list[str]:
    """Return the code blocks of a language on a page."""
    return [each.text for each in snippets(language) if each.page.endswith(page)]


def _write_look(folder: Path) -> None:
    """Write the show of the visual artists' tutorial without its character, whose file a command of the page makes.

    Step 4 of the tutorial replaces the groups of the first.
    """
    begin, *more, _ = _blocks("toml", "tutorials/visual-artist.md")
    (folder / "passes").mkdir(parents=True)
    (folder / "show.toml").write_text("\n".join([begin[: begin.index("[[group]]")], *more]))
    (folder / "passes" / "water.glsl").write_text(_blocks("glsl", "tutorials/visual-artist.md")[0])


def _convert(source: Path, target: Path) -> None:
    import av

    with av.open(str(source)) as read, av.open(str(target), "w") as write:
        out = write.add_stream("libopus", rate=RATE)
        for frame in read.decode(audio=0):
            frame.pts = None
            for packet in out.encode(frame):
                write.mux(packet)
        for packet in out.encode(None):
            write.mux(packet)
