"""Licences of packages: labels that are read, corrections, and what does not go with the GPL."""

import tomllib

import pytest

from live.base.errors import PersonError
from tests.places import ROOT

licences = pytest.importorskip("tools.release.licences", reason="license-expression comes with `make test`")


def row(name, version="1.0", **labels):
    told = {f"License-{key.capitalize()}": value for key, value in labels.items()}
    return {"Name": name, "Version": version, **dict.fromkeys(licences_keys(), "UNKNOWN"), **told}


def licences_keys():
    return ("License-Expression", "License-Classifier", "License-Metadata")


@pytest.mark.parametrize(
    ("labels", "expression"),
    [
        ({"expression": "MIT OR Apache-2.0", "classifier": "BSD License"}, "MIT OR Apache-2.0"),
        ({"classifier": "Apache Software License; MIT License"}, "Apache-2.0 AND MIT"),
        ({"classifier": "BSD License", "metadata": "BSD-3-Clause"}, "BSD-3-Clause"),
        ({"metadata": "Copyright (c) 2001"}, ""),
        ({"classifier": "Freely Distributable"}, ""),
        ({}, ""),
    ],
)
def test_label_is_read_from_the_best_place(labels, expression):
    assert licences.read_label(row("a", **labels))[0] == expression


@pytest.mark.parametrize(
    ("expression", "fits"),
    [
        ("MIT", True),
        ("Apache-2.0 WITH LLVM-exception AND BSD-2-Clause", True),
        ("GPL-2.0-only OR MIT", True),
        ("MPL-2.0 AND (Apache-2.0 OR GPL-2.0-only)", True),
        ("GPL-2.0-only", False),
        ("MIT AND BSD-4-Clause", False),
        ("LicenseRef-Proprietary", False),
        ("AGPL-3.0-only", False),
        ("", False),
        ("MIT AND", False),
    ],
)
def test_licences_that_go_with_the_gpl(expression, fits):
    assert licences.is_compatible(expression) == fits


def test_faults_of_all_packages_are_told():
    rows = [row("Fine_One", expression="MIT"), row("old", expression="GPL-2.0-only"), row("vague", metadata="free")]
    with pytest.raises(PersonError) as caught:
        licences.find_licences({"fine-one": "1.0", "old": "1.0", "vague": "1.0", "absent": "2.0"}, rows)
    assert caught.value.faults == (
        "absent 2.0: the licence is unknown (its label: none)",
        "old 1.0: GPL-2.0-only does not go with GPL-3.0-or-later",
        "vague 1.0: the licence is unknown (its label: free)",
    )


def test_corrections_win_and_are_reported():
    rows = [row("LinkPython-extern", "1.3.0", expression="Unlicense"), row("rich", expression="MIT")]
    found = licences.find_licences({"linkpython-extern": "1.3.0", "rich": "1.0"}, rows)
    assert [each.expression for each in found] == ["GPL-2.0-or-later", "MIT"]
    report = licences.licence_report("0.2.0", found)
    assert "| linkpython-extern | 1.3.0 | GPL-2.0-or-later |" in report
    assert "- linkpython-extern (label: Unlicense): " in report
    assert "- rich" not in report


def test_corrections_are_of_locked_packages_and_fit():
    locked = {package["name"] for package in tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))["package"]}
    assert set(licences.CORRECTIONS) <= locked
    assert [name for name, (each, _) in licences.CORRECTIONS.items() if not licences.is_compatible(each)] == []
