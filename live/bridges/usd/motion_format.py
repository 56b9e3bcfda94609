"""The declaration of USD as a format: .usdc is binary, .usda is text."""

from typing import Final

from live.base.errors import PersonError
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.motion_format import MotionFile, MotionFormat
from live.motion.formats.source_motion import SourceMotion
from live.motion.formats.stage_motion import StageFiles, StageMotion


def _refuse(file: MotionFile) -> SourceMotion:
    raise MotionFileError(file.name, None, "USD files are not read", "export glTF 2.0 (.glb) with its animation")


def _write(motion: StageMotion, suffix: str) -> StageFiles:
    try:
        from live.bridges.usd.usd_writer import write_usd  # usd-core is optional
    except ImportError:
        raise PersonError(
            f"{suffix} files need the package usd-core", "pip install 'choreographics-live[usd]'"
        ) from None
    return {"": write_usd(motion, suffix)}


FORMAT: Final = MotionFormat(
    "USD",
    (".usd", ".usda", ".usdc", ".usdz"),
    _refuse,
    "written only: all dancers of a show, with usd-core",
    begins=(b"PXR-USDC", b"#USDA"),
    readable=False,
    write_stage=_write,
    stage_suffixes=(".usdc", ".usda"),
)
