"""Reading sketched steps: a folder of step files to step clips, kept in a cache."""

from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.library.clip_cache import ClipCache
from live.library.plain_file import read_plain
from live.motion.step_clip import StepClip

MAX_STEP_BYTES: Final = 200_000
CACHE: Final = ClipCache("steps", kept=8)
"""One for each of the last sets of steps, whichever checkout they were in."""


class StepsError(PersonError):
    """Steps that cannot be read; the message names the file, and line and field where there is one."""


def load_steps(folder: Path) -> list[StepClip]:
    """All steps of `folder` (*.toml), in the order of their file names; StepsError if one is wrong or none is there."""
    texts: dict[str, str] = {}
    for path in sorted(folder.glob("*.toml")):
        try:
            data = read_plain(path, MAX_STEP_BYTES)
            if len(data) > MAX_STEP_BYTES:
                raise StepsError(f"{path}: a step has at most {MAX_STEP_BYTES} bytes")
            texts[str(path)] = data.decode("utf-8")
        except OSError as error:
            raise StepsError(f"cannot read the step {path}: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise StepsError(f"{path}: not a text in UTF-8 (byte {error.start})") from None
    if not texts:
        raise StepsError(f"no steps in {folder}", "put step files (*.toml) there, like those in patches/steps")
    return sketched_steps(texts)


def sketched_steps(texts: dict[str, str]) -> list[StepClip]:
    """The steps written in the `texts` of files; StepsError if one is wrong."""
    sources = (part for name, text in texts.items() for part in (Path(name).name.encode(), text.encode()))
    return CACHE.clips(sources, lambda: _build(texts))


def _build(texts: dict[str, str]) -> list[StepClip]:
    from live.motion.sketch.sketch_clips import step_clips
    from live.motion.sketch.sketch_file import SketchError, parse_sketch

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
