"""Formations of `live formation`: the spec in a file or in short notation, the report, and the drawing."""

import json
import tomllib
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.paths import straight_paths
from live.agents.formations.formation import Formation, formation_of
from live.agents.formations.formation_notation import parse_formation
from live.agents.formations.formation_spec import FormationSpec, spec_from_table
from live.agents.formations.stage_fit import StageFit
from live.agents.formations.svg_import import svg_file_paths
from live.app.option_values import check_writable
from live.app.pictures.formation_picture import draw_formation
from live.base.errors import PersonError
from live.base.toml import error_line, toml_remedy
from live.library.whole_file import write_atomically

MAX_FILE_BYTES: Final = 2_000_000
DEFAULT_DANCERS: Final = 24


def read_spec(text: str) -> FormationSpec:
    """Return the spec in a file or in short notation; raise PersonError if there is none."""
    if text.startswith("svg:"):
        path = Path(text.removeprefix("svg:"))
        table = {"shape": "path", "path": list(svg_file_paths(_read(path), str(path))), "name": path.stem[:64]}
        return spec_from_table(table, str(path))
    _, _, wanted = text.partition(".toml:") if ".toml:" in text else text.partition(".json:")
    path = Path(text) if not wanted else Path(text[: -len(wanted) - 1])
    if path.suffix.lower() in (".toml", ".json"):
        return spec_from_table(_formation_table(path, wanted), str(path))
    if path.suffix.lower() == ".svg":
        return read_spec(f"svg:{text}")
    return parse_formation(text)


def _formation_table(path: Path, wanted: str) -> dict[str, Any]:
    """Return a formation's table in a file: the top level, [formation], or one of several [[formation]] by name."""
    text = _read(path)
    try:
        content = tomllib.loads(text) if path.suffix.lower() == ".toml" else json.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = error_line(str(error), text)
        raise PersonError(f"{path}, line {line}: {error}", toml_remedy(str(error), text, line)) from None
    except (ValueError, RecursionError) as error:
        raise PersonError(f"{path}: not JSON: {str(error)[:100]}") from None
    if not isinstance(content, dict):
        raise PersonError(f"{path}: a table expected", 'such as {"shape": "star"}')
    found = content.get("formation", content)
    if isinstance(found, dict):
        return found
    tables = [each for each in found if isinstance(each, dict)] if isinstance(found, list) else []
    names = [str(each.get("name", "")) for each in tables]
    if not tables:
        raise PersonError(f"{path}: no formation in it", 'such as [[formation]] name = "gate" shape = "arc"')
    if wanted:
        if wanted not in names:
            raise PersonError(f"{path}: no formation is called {wanted!r}; there are: {', '.join(names)}")
        return tables[names.index(wanted)]
    if len(tables) > 1:
        raise PersonError(f"{path}: has {len(tables)} formations", f"name one: {path}:{names[0]}")
    return tables[0]


def _read(path: Path) -> str:
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise PersonError(f"{path}: larger than {MAX_FILE_BYTES // 1_000_000} MB")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise PersonError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise PersonError(f"{path}: not a text in UTF-8") from None


def default_count(spec: FormationSpec) -> int:
    """Return the number of dancers for which the spec has slots."""
    if spec.count is None and spec.density is None and spec.spacing is None:
        return DEFAULT_DANCERS
    return len(formation_of(spec, 0, 0).slots)


def write_svg(
    to: Path,
    made: Formation,
    floor: tuple[float, float],
    fit: StageFit,
    before: Formation | None,
    slot: npt.NDArray[np.int32] | None,
    spec: str,
) -> None:
    """Draw the formation, and the paths into it, to an SVG file; raise PersonError if it cannot be written."""
    if to.suffix.lower() != ".svg":
        raise PersonError(f"--svg {to}: a name that ends in .svg expected", f"--svg {to.stem or 'formation'}.svg")
    check_writable(to, "--svg")
    ways: Any = ()
    if before is not None and slot is not None:
        goes = slot >= 0
        ways = straight_paths(before.slots[goes], made.slots[slot[goes]])
    lines = describe(made, fit, floor, None)
    text = draw_formation(
        made, floor, paths=ways, outside=fit.outside, title=made.name or spec, under="\n".join(lines[:2])
    )
    write_atomically(text.encode(), to, "--svg")


def describe(made: Formation, fit: StageFit, floor: tuple[float, float], svg: Path | None) -> list[str]:
    """Return the report as lines: size, least distance, warnings, the drawing."""
    low_x, low_z, high_x, high_z = made.extent()
    lines = [f"{len(made.slots)} places on {high_x - low_x:.1f} x {high_z - low_z:.1f} m"]
    if len(made.slots) > 1:
        lines[0] += f", neighbours at least {made.min_distance:.2f} m apart"
    if not fit.fits:
        size = f"{floor[0]:g} x {floor[1]:g} m"
        lines.append(f"warning: {len(fit.outside)} places are not on the stage of {size}: {fit.remedy}")
    lines += [f"warning: {each}" for each in made.warnings]
    if svg is not None:
        lines.append(f"{svg}: drawn")
    return lines


def report_json(
    made: Formation,
    fit: StageFit,
    floor: tuple[float, float],
    before: Formation | None,
    slot: npt.NDArray[np.int32] | None,
) -> dict[str, Any]:
    """Return the report: points [x, z] in metres, headings in radians, sections from 1 (null: none), slots from 1."""
    report: dict[str, Any] = {
        "name": made.name,
        "slots": [[round(float(x), 6), round(float(z), 6)] for x, z in made.slots],
        "heading": [round(float(each), 6) for each in made.heading],
        "section": [int(each) + 1 if each >= 0 else None for each in made.section],
        "soloist": [bool(each) for each in made.soloist],
        "min_distance_m": round(made.min_distance, 6) if len(made.slots) > 1 else None,
        "waiting": made.unplaced_dancers,
        "empty": made.empty_places,
        "stage": list(floor),
        "fits": fit.fits,
        "outside": [each + 1 for each in fit.outside],
        "remedy": fit.remedy or None,
        "warnings": list(made.warnings),
    }
    if before is not None and slot is not None:
        goes = slot >= 0
        length = np.hypot(*(before.slots[goes] - made.slots[slot[goes]]).T)
        report["from"] = {
            "slots": [[round(float(x), 6), round(float(z), 6)] for x, z in before.slots],
            "to": [int(each) + 1 if each >= 0 else None for each in slot],
            "longest_m": round(float(length.max(initial=0.0)), 6),
            "total_m": round(float(length.sum()), 6),
        }
    return report
