"""Licences of the locked packages that a show needs, and whether they go with GPL-3.0-or-later.

Labels are read by pip-licenses from the packages that are installed: an SPDX expression, classifiers, or a free text.
What a package says wrongly, vaguely or not at all is put right in the table below, with the reason.
"""

import json
import subprocess
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from license_expression import ExpressionError, LicenseWithExceptionSymbol, Licensing
from packaging.utils import canonicalize_name

from live.base.errors import PersonError

CORRECTIONS: Final[Mapping[str, tuple[str, str]]] = {
    "aubio-ledfx": (
        "GPL-3.0-or-later",
        "its two labels differ; aubio's sources say version 3 or any later. So the whole is GPL-3.0-or-later",
    ),
    "av": (
        "BSD-3-Clause AND GPL-3.0-or-later",
        "the label is that of the binding; its wheels hold FFmpeg with x264 and x265 (GPL-2.0-or-later) and OpenCORE"
        " (Apache-2.0), together GPL-3.0-or-later",
    ),
    "colorama": ("BSD-3-Clause", "needed on Windows only, so not read here; its licence file says so"),
    "linkpython-extern": (
        "GPL-2.0-or-later",
        "the label is that of the binding; its wheels hold Ableton Link, which is GPL-2.0-or-later",
    ),
    "numba": ("BSD-2-Clause", "the label is BSD; its licence file has two clauses"),
    "numpy": (
        "BSD-3-Clause AND 0BSD AND MIT AND Zlib AND CC0-1.0 AND LGPL-2.1-or-later"
        " AND GPL-3.0-or-later WITH GCC-exception-3.1",
        "the label leaves out the libraries of GCC in its wheels",
    ),
    "python-osc": ("Unlicense", "the label is the text of the licence"),
    "python-rtmidi": ("MIT", "the label is the text of the licence; not on every system, so not always read here"),
    "reportlab": (
        "BSD-3-Clause",
        "the label is BSD; its licence file has three clauses; fonts beside its code have licences of their own, and "
        "sheets embed Bitstream Vera",
    ),
    "scipy": (
        "BSD-3-Clause AND LGPL-2.1-or-later AND GPL-3.0-or-later WITH GCC-exception-3.1",
        "the label is BSD; its licence file has three clauses and names the libraries of GCC in its wheels",
    ),
    "segno": ("BSD-3-Clause", "the label is BSD; its licence file has three clauses"),
    "shapely": ("BSD-3-Clause AND LGPL-2.1-or-later", "the label leaves out the library GEOS in its wheels"),
    "usd-core": (
        "Apache-2.0",
        "LicenseRef-TOST-1.0 is Apache-2.0 with its section 6 (trademarks) worded anew; only with the extra `usd`",
    ),
}
"""Package: its licence as an SPDX expression, and why it is not the label."""

COMPATIBLE: Final = frozenset(
    (
        *("0BSD", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "CC0-1.0", "ISC", "MIT", "MIT-0", "MIT-CMU", "MPL-2.0"),
        *("PSF-2.0", "Python-2.0.1", "Unlicense", "Zlib"),
        *("GPL-2.0-or-later", "GPL-3.0-only", "GPL-3.0-or-later"),
        *("LGPL-2.1-only", "LGPL-2.1-or-later", "LGPL-3.0-only", "LGPL-3.0-or-later"),
    )
)
"""Licences under which code may be part of a whole that is GPL-3.0-or-later (after the list of gnu.org)."""

_CLASSIFIERS: Final = {
    "Apache Software License": "Apache-2.0",
    "GNU General Public License v3 or later (GPLv3+)": "GPL-3.0-or-later",
    "ISC License (ISCL)": "ISC",
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
    "The Unlicense (Unlicense)": "Unlicense",
    "Zero-Clause BSD (0BSD)": "0BSD",
}
_SPDX: Final = Licensing()


@dataclass(frozen=True, slots=True)
class Licence:
    """Licence of a package: SPDX expression, label of the package (may be empty), reason of a correction."""

    package: str
    version: str
    expression: str
    label: str
    reason: str


def read_label(row: Mapping[str, str]) -> tuple[str, str]:
    """Return the SPDX expression ("" if none is to be had) and the label of a row of pip-licenses."""
    told = {key: row.get(f"License-{key}", "UNKNOWN") for key in ("Expression", "Classifier", "Metadata")}
    label = next((text for text in told.values() if text != "UNKNOWN"), "")
    if told["Expression"] != "UNKNOWN":
        return told["Expression"], label
    classifiers = told["Classifier"].split("; ")
    if all(each in _CLASSIFIERS for each in classifiers):
        return " AND ".join(_CLASSIFIERS[each] for each in classifiers), label
    return (told["Metadata"] if told["Metadata"] in COMPATIBLE else ""), label


def is_compatible(expression: str) -> bool:
    """Return whether code under an SPDX expression may be part of a whole that is GPL-3.0-or-later.

    An exception only permits more. Of licences joined by OR one is enough.
    """
    try:
        parsed = _SPDX.parse(expression)
    except ExpressionError:
        return False
    if parsed is None:
        return False
    values = {}
    for symbol in parsed.symbols:
        base = symbol.license_symbol if isinstance(symbol, LicenseWithExceptionSymbol) else symbol
        values[symbol] = _SPDX.TRUE if base.key in COMPATIBLE else _SPDX.FALSE
    return bool(parsed.subs(values, simplify=True) == _SPDX.TRUE)


def find_licences(packages: Mapping[str, str], rows: Iterable[Mapping[str, str]]) -> list[Licence]:
    """Return the licence of each package (name and version); PersonError if one is unknown or does not go together."""
    labels = {canonicalize_name(row["Name"]): (row["Version"], *read_label(row)) for row in rows}
    found, faults = [], []
    for name, locked in sorted(packages.items()):
        version, expression, label = labels.get(canonicalize_name(name), (locked, "", ""))
        expression, reason = CORRECTIONS.get(name, (expression, ""))
        if not expression:
            faults.append(f"{name} {version}: the licence is unknown (its label: {label[:60] or 'none'})")
        elif not is_compatible(expression):
            faults.append(f"{name} {version}: {expression} does not go with GPL-3.0-or-later")
        found.append(Licence(name, version, expression, " ".join(label.split())[:60], reason))
    if faults:
        raise PersonError(
            "; ".join(faults),
            "leave the package out, or put the licence right in tools/release/licences.py, with the reason",
            faults=tuple(faults),
        )
    return found


def ask_pip_licenses(python: Path) -> list[dict[str, Any]]:
    """Return the rows of pip-licenses for all packages that an interpreter has."""
    command = [str(python.with_name("pip-licenses")), "--from=all", "--with-system", "--format=json"]
    return list(json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout))


def licence_report(version: str, licences: Iterable[Licence]) -> str:
    """Return the report as Markdown."""
    rows, notes = [], []
    for each in licences:
        rows.append(f"| {each.package} | {each.version} | {each.expression} |")
        if each.reason:
            notes.append(f"- {each.package} (label: {each.label or 'none'}): {each.reason}.")
    return "\n".join(
        (
            f"# Licences of ChoreoGraphics Live {version}",
            "",
            "ChoreoGraphics Live is GPL-3.0-or-later. It needs these packages, each under a licence that goes with it.",
            "Every package has the text of its licence in its own `.dist-info` folder.",
            "",
            "| package | version | licence |",
            "|---|---|---|",
            *rows,
            "",
            "Labels of packages that are put right here:",
            "",
            *notes,
            "",
        )
    )
