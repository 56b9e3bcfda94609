"""Enriching: textured versions of sketched steps, from any motion capture (P022).

Textured versions of sketched steps, kept beside their sketches: `walk.textured` beside `walk.toml`.

Such a file holds whole clips, to the bit, for the motion capture they were made of may be gone; and which text of the
sketch they are of. A sketch that was changed since dances without them until they are made again.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from live.base.errors import PersonError
from live.library.clip_text import clips_from_text, clips_to_text
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_step
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.foot_constraints import tied
from live.motion.texture.frequency_bands import sample_clip
from live.motion.texture.texture_corpus import Material, material_of
from live.motion.texture.texture_settings import UPPER, Wish
from live.motion.texture.texture_synthesis import textured

Upper = Literal["auto", "make", "texture"]
"""What becomes of upper bodies: made of the recordings alone, textured, or whatever fits the sketch."""
RAISED_M: Final = 0.45
"""A sketch that raises a hand so far over the hips (to the shoulders) means its arms..."""
BENT: Final = np.radians(15.0)
"""... and one whose ribs lean so far to and fro means its trunk: there recordings give the finest detail alone."""
STYLE: Final = "textured"
"""The style of textured versions, with their number where there are several."""

_HANDS: Final = (SKELETON.index("leftHand"), SKELETON.index("rightHand"))


@dataclass(frozen=True, slots=True, eq=False)
class Enriched:
    """The textured versions of one step."""

    clips: tuple[StepClip, ...]
    distance: float
    """How far matches were off [rad], root mean square, the mean of all."""
    free: float
    """Share of the joins that were none in the data either."""
    made: bool
    """Whether upper bodies were made anew; else textured."""
    kept: float
    """Share of the texture that is left at measure lines, the mean of all."""


def material_for(recordings: Sequence[Clip], steps: Sequence[StepClip]) -> Material:
    """The recordings, cut up so that all of these steps can be textured."""
    return material_of(recordings, [sample_clip(step.clip) for step in steps])


def means_upper(step: StepClip) -> bool:
    """Whether the sketch's upper body is what the step is about, so that it must not be made anew."""
    part = slice(int(step.first), int(np.ceil(step.first + step.measures * step.samples_per_measure)))
    rotation = step.clip.rotation[part].astype(np.float64)
    rotation[:, 0] = (1.0, 0.0, 0.0, 0.0)
    position, world = forward_kinematics(np.zeros((len(rotation), 3)), rotation)
    up = quaternion.rotate(world[:, SKELETON.index("upperChest")], np.array((0.0, 1.0, 0.0)))
    bent = np.arccos(np.clip(up @ quaternion.unit(up.mean(axis=0)), -1.0, 1.0))
    return bool(position[:, _HANDS, 1].max() > RAISED_M or bent.max() > BENT)


def enrich(steps: Sequence[StepClip], material: Material, wish: Wish, upper: Upper = "auto") -> Enriched:
    """Textured versions of the variations `steps` of one step (mirrored ones are passed over), path by path.

    What is said of a variation is said of its textured versions: they are takes of the same step. PersonError where
    nothing of the recordings fits.
    """
    clips: list[StepClip] = []
    distances: list[float] = []
    free: list[float] = []
    kept: list[float] = []
    made = upper == "make" or (upper == "auto" and not means_upper(steps[0]))
    if not made:
        # what the arms are about is faster than legs: only the first band does not take it away
        wish = replace(wish, synthesize=(), texture=tuple(sorted({*wish.texture, *UPPER})), bands=(wish.bands[0],) * 2)
    for step in steps:
        if step.mirrored:
            continue
        for number, one in enumerate(textured(step.clip, material, wish), start=1):
            clip, left = tied(step, one.clip)
            name = f"{step.clip.name}, {STYLE} {number}"
            style = " ".join(word for word in (step.style, STYLE, str(number)) if word)
            clips.append(replace(step, clip=replace(clip, name=name), style=style))
            distances.append(one.distance)
            free.append(one.free / max(1, one.parts.count - 1))
            kept += left
    if not clips:
        raise PersonError("no variation of the step can be textured", "give other recordings")
    return Enriched(tuple(clips), _mean(distances), _mean(free), made, _mean(kept))


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


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
