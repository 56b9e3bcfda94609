"""Textured versions of sketched steps, kept beside their sketches: `walk.textured` beside `walk.toml`.

Such a file holds whole clips, to the bit, for the motion capture they were made of may be gone; and which text of the
sketch they are of. A sketch that was changed since dances without them until they are made again.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.library.clip_text import clips_from_text, clips_to_text
from live.motion.mirror import mirror_step
from live.motion.step_clip import StepClip

ENDING: Final = ".textured"
MAX_BYTES: Final = 100_000_000


def textured_beside(sketch: Path) -> Path:
    """Where the textured versions of the sketch in this file are kept."""
    return sketch.with_suffix(ENDING)


def textured_text(clips: Sequence[StepClip], sketch: str, facts: Mapping[str, Any]) -> str:
    """What such a file holds: a line of JSON with `facts` for people, and a line with the clips.

    `clips` are the versions as made; those of steps that are mirrored come mirrored when they are read.
    """
    header = {"sketch": _digest(sketch), "clips": [clip.clip.name for clip in clips], **facts}
    return json.dumps(header, ensure_ascii=False) + "\n" + clips_to_text(clips) + "\n"


def read_textured(sketches: Mapping[str, str]) -> list[StepClip]:
    """The textured versions that lie beside `sketches`, texts by file name; those of changed sketches are left out.

    PersonError that names a file which cannot be read, and what to do.
    """
    found: list[StepClip] = []
    for name, text in sketches.items():
        path = textured_beside(Path(name))
        if path.is_file():
            header, clips = _read(path)
            if header.get("sketch") == _digest(text):
                found += clips
                if header.get("mirror") is True:
                    found += [mirror_step(clip) for clip in clips]
    return found


def stale_textures(sketches: Mapping[str, str]) -> list[Path]:
    """Files of textured versions whose sketch has been changed since."""
    paths = [(textured_beside(Path(name)), text) for name, text in sketches.items()]
    return [path for path, text in paths if path.is_file() and _read(path)[0].get("sketch") != _digest(text)]


def _read(path: Path) -> tuple[dict[str, Any], list[StepClip]]:
    remedy = "make it again: live steps enrich --with DIR; or remove it"
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PersonError(f"{path}: more than {MAX_BYTES} bytes", remedy)
        first, _, rest = path.read_bytes().decode("ascii", "surrogateescape").partition("\n")
        header = json.loads(first.encode("ascii", "surrogateescape"))
        if not isinstance(header, dict):
            raise ValueError("no header")
        return header, clips_from_text(rest.strip())
    except OSError as error:
        raise PersonError(f"{path}: cannot be read: {error.strerror}", remedy) from None
    except (ValueError, RecursionError):
        raise PersonError(f"{path}: it holds no textured steps", remedy) from None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
