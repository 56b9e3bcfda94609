"""Reading sketched steps: a folder of step files to step clips, with a cache that follows the files and the code."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from live.base.errors import PersonError
from live.base.jit import cache_directory
from live.motion.clip import Clip
from live.motion.step_clip import StepClip

MAX_STEP_BYTES = 200_000
KEPT_CACHES = 8
"""Caches kept: one for each of the last sets of steps, whichever checkout they were in."""


class StepsError(PersonError):
    """Steps that cannot be read; the message names the file, and line and field where there is one."""


def load_steps(folder: Path) -> list[StepClip]:
    """All steps of `folder` (*.toml), in the order of their file names; StepsError if one is wrong or none is there."""
    texts: dict[str, str] = {}
    for path in sorted(folder.glob("*.toml")):
        try:
            if path.stat().st_size > MAX_STEP_BYTES:
                raise StepsError(f"{path}: a step has at most {MAX_STEP_BYTES} bytes")
            texts[str(path)] = path.read_bytes().decode("utf-8")
        except OSError as error:
            raise StepsError(f"cannot read the step {path}: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise StepsError(f"{path}: not a text in UTF-8 (byte {error.start})") from None
    if not texts:
        raise StepsError(f"no steps in {folder}", "put step files (*.toml) there, like those in patches/steps")
    cache = _cache_path(texts)
    clips = _read_cache(cache)
    if clips is None:
        clips = _build(texts)
        _write_cache(cache, clips)
    return clips


def _build(texts: dict[str, str]) -> list[StepClip]:
    from live.motion.sketch import SketchError, parse_sketch
    from live.motion.sketch_clip import step_clips

    clips: list[StepClip] = []
    owner: dict[str, str] = {}
    for file, text in texts.items():
        try:
            sketch = parse_sketch(text, file)
            if sketch.name in owner:
                raise StepsError(f"{file}: the step {sketch.name!r} is already in {owner[sketch.name]}")
            owner[sketch.name] = file
            clips += step_clips(sketch)
        except SketchError as error:
            raise StepsError(str(error)) from None
    return clips


def _cache_path(texts: dict[str, str]) -> Path:
    """Named after the texts and the code that turns them into clips."""
    digest = hashlib.sha256()
    for name, text in texts.items():
        digest.update(Path(name).name.encode() + b"\0" + text.encode() + b"\0")
    for source in sorted((Path(__file__).resolve().parents[1] / "motion").glob("*.py")):
        digest.update(source.read_bytes())
    return cache_directory().parent / f"steps-{digest.hexdigest()[:16]}.npz"


def _write_cache(path: Path, clips: list[StepClip]) -> None:
    """Best effort: without it the next start takes longer, nothing else."""
    rows: list[dict[str, Any]] = [
        {
            "name": c.clip.name,
            "samples": c.clip.sample_count,
            "sample_rate": c.clip.sample_rate,
            "step": {
                key: getattr(c, key)
                for key in (
                    "step", "first", "samples_per_measure", "measures", "beats_per_measure", "bpm", "direction",
                    "mirrored",
                )
            },
        }
        for c in clips
    ]  # fmt: skip
    unfinished = path.with_suffix(f".{os.getpid()}.tmp")
    try:
        with unfinished.open("wb") as file:
            np.savez(
                file,
                root=np.concatenate([c.clip.root_position for c in clips]),
                rotation=np.concatenate([c.clip.rotation for c in clips]),
                contact=np.concatenate([c.clip.contact for c in clips]),
                rows=np.frombuffer(json.dumps(rows).encode(), np.uint8),
            )
        unfinished.replace(path)
        caches = sorted(path.parent.glob("steps-*.npz"), key=lambda cache: cache.stat().st_mtime, reverse=True)
        for old in caches[KEPT_CACHES:]:
            old.unlink(missing_ok=True)
    except OSError:
        unfinished.unlink(missing_ok=True)


def _read_cache(path: Path) -> list[StepClip] | None:
    """The clips kept at `path`, None if they are not there or not readable."""
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as data:
            root, rotation, contact = data["root"], data["rotation"], data["contact"]
            rows = json.loads(data["rows"].tobytes())
        clips, at = [], 0
        for row in rows:
            end = at + row["samples"]
            clip = Clip(row["name"], root[at:end], rotation[at:end], row["sample_rate"], contact[at:end])
            clips.append(StepClip(clip=clip, **row["step"]))
            at = end
    except (OSError, ValueError, KeyError, TypeError, EOFError):
        return None
    return clips
