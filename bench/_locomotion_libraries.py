"""Libraries of recordings for the locomotion bench: salsa, modern dance, walks and one routine of ../shared/mocap."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from bench._motion_clips import SOLO, WALKS, Material, recordings
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.step_library import build_library
from live.library.step_folder import load_folder
from live.motion.mirror import mirror_step
from live.motion.step_clip import StepClip
from live.show.loader import RECORDING_THRESHOLDS_M, adapt_to_recordings, with_connected_steps
from live.show.patch.patch import Patch

ROUTINE: Final = tuple(f"group/perfume_{who}.bvh" for who in ("aachan", "kashiyuka", "nocchi"))
SALSA: Final = tuple(f"salsa/{who}_0{take}.bvh" for take in range(1, 8) for who in (60, 61))
MODERN: Final = tuple(name for name in SOLO if "modern05" in name)
RECORDED: Final[Mapping[str, tuple[str, ...]]] = {"salsa": SALSA, "modern": MODERN, "walks": WALKS, "routine": ROUTINE}
