"""Ways of dancers over the stage as a table (CSV) or as JSON: where the hips are at each frame, and where they face."""

import csv
import io
import json
from typing import Final

import numpy as np

from live.motion.formats.file_error import MotionFileError
from live.motion.formats.motion_format import MotionFile, MotionFormat
from live.motion.formats.source_motion import SourceMotion
from live.motion.formats.stage_motion import StageFiles, StageMotion

COLUMNS: Final = ("time_s", "measure", "beat", "dancer", "group", "present", "x_m", "z_m", "heading_deg")
"""Columns of the table. x to the right as the audience sees it, z towards the audience, from the middle of the stage;
heading 0 faces the audience, positive towards +x."""


def write_ways_csv(motion: StageMotion) -> bytes:
    """Return a table with a row for each dancer at each frame, ordered by time (UTF-8, RFC 4180)."""
    text = io.StringIO()
    rows = csv.writer(text)
    rows.writerow(COLUMNS)
    ways = [(motion.hips(n).tolist(), np.degrees(motion.heading(n)).tolist()) for n in range(len(motion.dancers))]
    for sample in range(motion.sample_count):
        time = round(motion.begin + sample / motion.sample_rate, 6)
        when = time, int(motion.measure[sample]), round(float(motion.beat[sample]), 4)
        for dancer, (hips, heading) in zip(motion.dancers, ways, strict=True):
            (x, z), faces = hips[sample], heading[sample]
            there = int(dancer.present[sample])
            rows.writerow([*when, dancer.name, dancer.group, there, f"{x:.4f}", f"{z:.4f}", f"{faces:.2f}"])
    return text.getvalue().encode()


def write_ways_json(motion: StageMotion) -> bytes:
    """Return the same as one JSON object: times once, then the ways of each dancer, then the show's formations."""
    document = {
        "show": motion.name,
        "frames_per_second": motion.sample_rate,
        "begin_s": motion.begin,
        "measure": motion.measure.astype(int).tolist(),
        "beat": np.round(motion.beat, 4).tolist(),
        "dancers": [
            {
                "name": dancer.name,
                "group": dancer.group,
                "present": dancer.present.astype(int).tolist(),
                "x_m": _rounded(motion.hips(number)[:, 0], 4),
                "z_m": _rounded(motion.hips(number)[:, 1], 4),
                "heading_deg": _rounded(np.degrees(motion.heading(number)), 2),
            }
            for number, dancer in enumerate(motion.dancers)
        ],
        "formations": [
            {
                "name": formation.name,
                "x_m": _rounded(formation.places[:, 0], 4),
                "z_m": _rounded(formation.places[:, 1], 4),
                "heading_deg": _rounded(np.degrees(formation.heading), 2),
            }
            for formation in motion.formations
        ],
    }
    return (json.dumps(document, separators=(",", ":"), ensure_ascii=False) + "\n").encode()


def _rounded(values: np.ndarray, digits: int) -> list[float]:
    return [round(value, digits) for value in values.astype(np.float64).tolist()]


def _refuse(file: MotionFile) -> SourceMotion:
    raise MotionFileError(file.name, None, "ways of dancers are not read as motion", "give a motion file")


def _write(motion: StageMotion, suffix: str) -> StageFiles:
    return {"": write_ways_csv(motion) if suffix == ".csv" else write_ways_json(motion)}


WAYS: Final = MotionFormat(
    "ways",
    (),
    _refuse,
    "written only: where the dancers of a show are on the floor",
    readable=False,
    write_stage=_write,
    stage_suffixes=(".csv", ".json"),
)
