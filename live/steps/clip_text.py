"""Clips as text: what a journal needs so that a step whose file has changed, or is gone, can be danced again."""

import base64
import binascii
import io
import zlib
from collections.abc import Sequence
from typing import Final

from live.motion.step_clip import StepClip
from live.steps.clip_cache import read_clips, write_clips

LARGEST: Final = 64_000_000
"""Bytes of clips that a text may hold: a damaged one asks for no more memory."""


def clips_to_text(clips: Sequence[StepClip]) -> str:
    """The clips, bit by bit, as letters; none are an empty text."""
    if not clips:
        return ""
    file = io.BytesIO()
    write_clips(file, clips)
    return base64.b64encode(zlib.compress(file.getvalue(), 6)).decode("ascii")


def clips_from_text(text: str) -> list[StepClip]:
    """The clips that `clips_to_text` wrote; ValueError for anything else."""
    if not text:
        return []
    worker = zlib.decompressobj()
    try:
        data = worker.decompress(base64.b64decode(text, validate=True), LARGEST)
        if not worker.eof:
            raise ValueError("it is cut off or too long")
        return read_clips(io.BytesIO(data))
    except (zlib.error, binascii.Error) as error:
        raise ValueError(f"steps in a text are damaged: {error}") from None
    except Exception as error:  # a broken archive breaks zipfile, numpy, json and our own checks in their own ways
        raise ValueError(f"steps in a text are damaged: {error}") from None
