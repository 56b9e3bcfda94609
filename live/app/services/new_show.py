"""Folder of a new show, for `live studio`: from a song and a number of dancers, or as a copy of an example."""

import json
import math
import shutil
import statistics
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from live.app.offline.music_map import read_measures
from live.base.errors import PersonError
from live.clock.measure_map import MeasureMap
from live.document.document_store import DocumentStore
from live.document.edit import Edit
from live.library.music_map_file import map_tables
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_search_path import MAIN_FILE, PATCHES, find_patch, find_resource

MAX_DANCERS: Final = 400
STEPS: Final = {4: "steps", 2: "samba/steps", 3: "tap/steps", 5: "contemporary/steps"}
"""The project's steps for each metre, in beats of a measure."""
FAVOURITES: Final = ("groove x2", "side step x2", "samba x2", "kick", "turn", "reach")
"""Steps with which dancers begin, where the show has them."""
GROUPS: Final = (("ember", (0.92, 0.36, 0.14)), ("tide", (0.12, 0.52, 0.72)), ("gold", (0.88, 0.72, 0.36)))
AREA_M2: Final = 4.0
"""Floor for each dancer on a stage that is made for them [m²]."""


def examples() -> list[str]:
    """Return the names of the shows that can be copied."""
    return sorted(["first_show", *(path.parent.name for path in PATCHES.glob(f"*/{MAIN_FILE}"))])


def make_show(
    folder: Path, *, song: Path | None = None, dancers: int | None = None, example: str | None = None
) -> Path:
    """Write the folder of a new show, and return its patch; PersonError, and nothing is written, if that fails."""
    if (song is None) == (example is None):
        raise PersonError(f"{str(folder)[:200]!r}: a new show begins from a song or from an example", "--song song.ogg")
    if not 1 <= (dancers or 12) <= MAX_DANCERS:
        raise PersonError(f"--dancers {dancers}: 1 to {MAX_DANCERS} expected")
    if example is not None and dancers is not None:
        raise PersonError("--dancers belongs to --song", "an example has its own; its groups can be edited")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise PersonError(f"{str(folder)[:200]!r} exists already", "give another name for the new show")
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{folder.name[:40]}-", dir=folder.parent) as place:
            made = Path(place) / "show"
            made.mkdir()
            if song is not None:
                _from_song(made, folder.name, song, dancers or 12)
            else:
                _from_example(made, folder.name, example or "")
            load_show(made / MAIN_FILE).start(begin=False)
            if folder.exists():
                folder.rmdir()
            made.rename(folder)
    except OSError as error:
        raise PersonError(f"{str(folder)[:200]!r} cannot be written: {error.strerror or error}") from None
    return folder / MAIN_FILE


def _from_example(made: Path, name: str, example: str) -> None:
    """Copy an example with all its files that are not the project's own."""
    if example not in examples():
        raise PersonError(f"there is no example {example[:60]!r}", f"there are: {', '.join(examples())}")
    patch = find_patch(example)
    if patch.name == MAIN_FILE:
        shutil.copytree(patch.parent, made, dirs_exist_ok=True, ignore=shutil.ignore_patterns(".*", "*.jsonl"))
    else:
        shutil.copy(patch, made / MAIN_FILE)
    loaded = load_show(patch)
    music = loaded.patch.music.file
    found = None if music is None else find_resource(music, patch)
    if music is not None and found is not None and not (made / music).exists():
        (made / music).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(found, made / music)
    store = DocumentStore(made / MAIN_FILE)
    store.edit(Edit("set", ("name",), _title(name)))
    shutil.rmtree(made / ".history", ignore_errors=True)  # it begins with this


def _from_song(made: Path, name: str, song: Path, dancers: int) -> None:
    """Write a patch with the song's measure lines, groups with steps of its metre, and a first formation."""
    measures = read_measures(song)
    metre = statistics.mode(line.beats for line in measures.lines)
    if metre not in STEPS:
        raise PersonError(
            f"{song.name} is counted in {metre}, and the project has no steps for that",
            f"correct its measures (live music map {song.name} --fix), or begin from an example",
        )
    shutil.copy(song, made / song.name)
    path = made / MAIN_FILE
    path.write_text(_patch_text(name, song.name, measures, metre, dancers, ["*"]), "utf-8")
    steps = _first_steps(load_show(path))
    path.write_text(_patch_text(name, song.name, measures, metre, dancers, steps), "utf-8")


def _first_steps(loaded: LoadedShow) -> list[str]:
    """Return steps that follow each other: those that most people know first, all that connect otherwise."""
    library = loaded.graph.library
    connected = [name for step, name in enumerate(library.steps) if len(loaded.graph.entries(step))]
    known = [words for words in FAVOURITES if words.split(" x")[0] in connected]
    return known or connected


def _patch_text(name: str, song: str, measures: MeasureMap, metre: int, dancers: int, steps: Sequence[str]) -> str:
    width = max(8.0, round(math.sqrt(1.5 * AREA_M2 * dancers), 1))
    depth = round(width / 1.5, 1)
    groups = GROUPS[: 1 if dancers < 4 else 2 if dancers < 9 else 3]
    parts = [
        f"# {_title(name)}: begun from {song}. What every key means: `live docs patch`.\n",
        f"name = {json.dumps(_title(name), ensure_ascii=False)}\nseed = 1\nsteps = {json.dumps(STEPS[metre])}\n"
        f"loop_measures = {len(measures.lines)}          # the music's length: the score comes again with it",
        f"\n[music]\nfile = {json.dumps(song, ensure_ascii=False)}",
    ]
    parts.append("\n" + map_tables(measures).rstrip())
    parts.append(f"\n[clock]\nbpm = {measures.bpm:.2f}\nbeats_per_measure = {metre}")
    parts.append(f"\n[stage]\nwidth = {width}\ndepth = {depth}")
    parts.append(f"\n[camera]\neye = [0.0, {0.3 * width:.1f}, {depth / 2 + 0.8 * width:.1f}]\ntarget = [0.0, 0.9, 0.0]")
    for index, (group, colour) in enumerate(groups):
        count = dancers // len(groups) + (index < dancers % len(groups))
        own = [*steps[index % len(steps) :], *steps[: index % len(steps)]]
        row = (index - (len(groups) - 1) / 2) * -0.55 * depth / max(len(groups) - 1, 1)
        parts.append(
            f'\n[[group]]\nname = "{group}"\ndancers = {count}\ncolour = {list(colour)}\n'
            f"steps = {json.dumps(own, ensure_ascii=False)}\n"
            f'formation = "line"\ncentre = [0.0, {row:.2f}]\nsize = [{0.8 * width:.1f}, 1.0]'
        )
    parts.append(
        '\n# Where they stand when the first four measures are over.\n\n[[formation]]\nname = "opening"\n'
        'shape = "rectangle"\n'
        f'pattern = "grid"\nsize = [{0.8 * width:.1f}, {0.7 * depth:.1f}]'
    )
    parts.append('\n[[segment]]\nmeasure = 1\nmeasures = 4\nformation = "opening"')
    return "\n".join(parts) + "\n"


def _title(name: str) -> str:
    """Return the name of a show in a folder: "my_first piece" is "My first piece"."""
    words = " ".join(name.replace("_", " ").replace("-", " ").split())[:60] or "New show"
    return words[:1].upper() + words[1:]
