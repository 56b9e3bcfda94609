"""Libraries of recordings for the locomotion bench, as a person writes them: folders of recordings and TOML files."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from bench._locomotion_scenes import PATCH
from bench._motion_clips import SALSA, SOLO, WALK_BPM, WALKS
from live.library.motion_file import read_motion
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.retarget.body_tracks import body_tracks
from live.show.loader import LoadedShow, load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES

ROUTINE: Final = tuple(f"group/perfume_{who}.bvh" for who in ("aachan", "kashiyuka", "nocchi"))
MODERN: Final = tuple(name for name in SOLO if "modern05" in name)
RECORDED: Final[Mapping[str, tuple[str, ...]]] = {"salsa": SALSA, "modern": MODERN, "walks": WALKS, "routine": ROUTINE}
"""The recordings of each library, in the folder with test data."""
SALSA_MEASURES: Final = 2
"""A basic of salsa takes two measures; the other recordings are taken as streams of single measures."""


@dataclass(frozen=True, slots=True)
class Part:
    """The part of a recording from `start` on [s], `seconds` long (None: all)."""

    file: str
    start: float = 0.0
    seconds: float | None = None


def write_library(shared: Path, step: str, parts: Iterable[Part], folder: Path) -> None:
    """Write a library of steps called `step` from recordings of shared/mocap into `folder`, which must be new."""
    folder.mkdir(parents=True)
    for number, part in enumerate(parts):
        source = shared / "mocap" / part.file
        (folder / f"{number}{source.suffix}").symlink_to(source.resolve())
        rows = _entries(shared / "mocap", step, part, f"{number}{source.suffix}")
        text = "".join("[[step]]\n" + "".join(f"{k} = {json.dumps(v)}\n" for k, v in row.items()) for row in rows)
        (folder / f"{number}.toml").write_text(text, encoding="utf-8")


def load_library(folder: Path) -> LoadedShow:
    """Load the scenes' patch with a folder of steps in place of its own, as `--steps` does."""
    return load_from_patch(parse_patch(PATCH, "locomotion"), PATCHES / "locomotion.toml", recordings=folder)


def _entries(mocap: Path, step: str, part: Part, name: str) -> list[dict[str, Any]]:
    index = {row["file"]: row for row in json.loads((mocap / "index.json").read_text(encoding="utf-8"))}
    beats = {
        file: row
        for row in json.loads((mocap / "beats_estimated.json").read_text(encoding="utf-8"))
        for file in row["files"]
    }
    fps = index.get(part.file, {}).get("true_fps")
    motion = read_motion(mocap / part.file)
    tracks = body_tracks(motion, fps=fps)
    drop = find_recording_start(tracks).drop_frames
    heard = beats.get(part.file, {})
    four = heard.get("four_beats_s")
    bpm = 240.0 / four if four else WALK_BPM.get(part.file) or heard.get("bpm") or 120.0
    base: dict[str, Any] = {"file": name, "name": step, "drop_frames": drop, "repair": True, "bpm": round(bpm, 3)}
    base |= {"fps": fps} if fps else {}
    base |= {"first_beat_s": part.start + heard.get("phase_of_4beats_s", 0.0), "mirror": True}
    whole = (motion.frame_count - drop - 1) / (fps or motion.header_fps)
    end = min(whole, part.start + (part.seconds or whole))
    measures = int((end - base["first_beat_s"]) * bpm / 240.0)
    if step != "salsa":
        return [base | {"unstructured": True, "measures": measures}]
    return [
        base | {"start_measure": 1 + start, "measures": SALSA_MEASURES}
        for start in range(0, measures - SALSA_MEASURES + 1, SALSA_MEASURES)
    ]
