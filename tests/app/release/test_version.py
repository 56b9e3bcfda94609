"""Version and changelog of a release, in copies of the project's own files."""

import shutil

import pytest

from live.base.errors import PersonError
from tests.places import ROOT
from tools.release import version

CHANGELOG = "# Changelog\n\n## [Unreleased]\n\n### Added\n- One.\n\n## [0.1.0] - 2026-01-02\n- Older.\n"


@pytest.fixture
def checkout(tmp_path):
    for name in version.CHANGED:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def test_version_is_set_in_all_places_and_nothing_else_changes(checkout):
    before = version.read_version(checkout)
    version.set_version(checkout, "12.3.4rc1")
    assert version.read_version(checkout) == "12.3.4rc1"
    for name, _ in version.PLACES:
        old, new = ((folder / name).read_text(encoding="utf-8").splitlines() for folder in (ROOT, checkout))
        changed = [(a, b) for a, b in zip(old, new, strict=True) if a != b]
        assert [(a.replace(before, "12.3.4rc1"), b) for a, b in changed] == [(b, b) for _, b in changed]
        assert len(changed) == 1


def test_places_that_differ_are_told(checkout):
    (checkout / "live" / "__init__.py").write_text('__version__ = "9.9.9"\n')
    with pytest.raises(PersonError, match=r"different versions: .*live/__init__\.py 9\.9\.9"):
        version.read_version(checkout)
    (checkout / "live" / "__init__.py").write_text("\n")
    with pytest.raises(PersonError, match=r"live/__init__\.py: 0 lines name the version"):
        version.read_version(checkout)


@pytest.mark.parametrize("text", ["0.1.1", "0.2.0", "1.0.0rc1", "0.2.0.post1"])
def test_greater_versions_are_taken(text):
    assert str(version.check_version(text, "0.1.0")) == text


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("0.1.0", "not greater"),
        ("0.1.0rc1", "not greater"),
        ("v0.2.0", "not in the form"),
        ("0.2.0+mine", "not in the form"),
        ("1!0.2", "not in the form"),
        ("next", "not a version"),
        ("--tag", "not a version"),
    ],
)
def test_other_versions_are_refused(text, fault):
    with pytest.raises(PersonError, match=fault):
        version.check_version(text, "0.1.0")


def test_unreleased_entries_get_version_and_date():
    dated = version.date_changelog(CHANGELOG, "0.2.0", 86400 * 366)
    assert dated == CHANGELOG.replace("## [Unreleased]\n", "## [Unreleased]\n\n## [0.2.0] - 1971-01-02\n")
    with pytest.raises(PersonError, match=r"nothing stands below \[Unreleased\]"):
        version.date_changelog(dated, "0.3.0", 0)


def test_changelog_without_heading_is_refused():
    with pytest.raises(PersonError, match="no line"):
        version.unreleased_entries("# Changelog\n")
