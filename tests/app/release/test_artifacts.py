"""Checks of built files, with small files that are as `uv build` makes them."""

import io
import json
import subprocess
import tarfile
import zipfile

import pytest

from live.base.errors import PersonError
from tools.release import artifacts

TRACKED = ["README.md", "live/a.py", "live/bridges/b/test_b.py", "live/site.py", "patches/p.toml", "tests/test_a.py"]
METADATA = (
    "Metadata-Version: 2.4\nName: choreographics-live\nVersion: {version}\nLicense-Expression: GPL-3.0-or-later\n"
)


def make_wheel(folder, files, metadata=METADATA):
    path = folder / "choreographics_live-0.2.0-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as wheel:
        for name in files:
            wheel.writestr(name, "x")
        wheel.writestr("choreographics_live-0.2.0.dist-info/METADATA", metadata.format(version="0.2.0"))
    return path


def make_sdist(folder, files):
    path = folder / "choreographics_live-0.2.0.tar.gz"
    contents = dict.fromkeys(files, "x") | {"PKG-INFO": METADATA.format(version="0.2.0")}
    with tarfile.open(path, "w:gz") as sdist:
        for name, text in contents.items():
            info = tarfile.TarInfo(f"choreographics_live-0.2.0/{name}")
            info.size = len(text)
            sdist.addfile(info, io.BytesIO(text.encode()))
    return path


def test_wheel_holds_the_program_and_its_patches_and_no_tests():
    assert artifacts.wheel_files(TRACKED) == {"live/a.py", "live/site.py", "live/patches/p.toml"}


def test_complete_files_pass_and_the_built_site_is_welcome(tmp_path):
    wanted = artifacts.wheel_files(TRACKED)
    wheel = make_wheel(tmp_path, [*wanted, *artifacts.SITE, "live/site/tutorials/first.html"])
    artifacts.check_files(wheel, wanted, artifacts.list_wheel(wheel))
    sdist = make_sdist(tmp_path, [*TRACKED, *artifacts.SITE])
    artifacts.check_files(sdist, set(TRACKED), artifacts.list_sdist(sdist))
    for path in (wheel, sdist):
        artifacts.check_metadata(path, "0.2.0")
    artifacts.check_wheel_size(wheel)


@pytest.mark.parametrize(
    ("files", "fault"),
    [
        (["live/a.py", "live/site.py"], r"lacks: live/patches/p\.toml"),
        (["live/a.py", "live/site.py", "live/patches/p.toml", "secret"], "has foreign files: secret"),
        ([], "lacks: live/a.py, live/patches/p.toml, live/site.py"),
    ],
)
def test_missing_and_foreign_files_are_named(tmp_path, files, fault):
    wheel = make_wheel(tmp_path, [*files, *artifacts.SITE])
    with pytest.raises(PersonError, match=fault):
        artifacts.check_files(wheel, artifacts.wheel_files(TRACKED), artifacts.list_wheel(wheel))


@pytest.mark.parametrize("missing", sorted(artifacts.SITE))
def test_packages_without_documentation_are_refused(tmp_path, missing):
    wanted = artifacts.wheel_files(TRACKED)
    wheel = make_wheel(tmp_path, [*wanted, *artifacts.SITE - {missing}])
    with pytest.raises(PersonError, match=f"lacks: {missing}"):
        artifacts.check_files(wheel, wanted, artifacts.list_wheel(wheel))


@pytest.mark.parametrize(
    ("metadata", "fault"),
    [
        (METADATA, "of version 0.2.0, not 0.3.0"),
        (METADATA.replace("GPL-3.0-or-later", "GNU GPL"), "license"),
        ("Name: choreographics-live\n", "not a valid metadata version"),
    ],
)
def test_faulty_metadata_is_told(tmp_path, metadata, fault):
    with pytest.raises(PersonError, match=fault):
        artifacts.check_metadata(make_wheel(tmp_path, [], metadata), "0.3.0")


def test_large_wheel_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(artifacts, "WHEEL_LIMIT", 100)
    with pytest.raises(PersonError, match="MB at most"):
        artifacts.check_wheel_size(make_wheel(tmp_path, ["live/a.py"]))


def test_checksums_are_those_of_sha256sum(tmp_path):
    for name in ("b.whl", "a.tar.gz"):
        (tmp_path / name).write_text(name)
    (tmp_path / ".gitignore").write_text("*")
    sums = artifacts.write_sums(tmp_path)
    assert [line.split()[1] for line in sums.read_text().splitlines()] == ["a.tar.gz", "b.whl"]
    subprocess.run(["sha256sum", "--check", "--strict", "--quiet", sums.name], cwd=tmp_path, check=True)
    assert artifacts.write_sums(tmp_path).read_text().count("\n") == 2


def test_list_of_parts_is_the_same_each_time():
    parts = [
        {"name": "numpy", "version": "2.4"},
        {"name": "numpy", "version": "2.5"},
        {"name": "rich", "version": "15"},
    ]
    made = [
        artifacts.steady_sbom(
            json.dumps(
                {
                    "bomFormat": "CycloneDX",
                    "serialNumber": serial,
                    "metadata": {"timestamp": serial},
                    "components": parts,
                }
            ),
            86400,
        )
        for serial in ("urn:uuid:1", "urn:uuid:2")
    ]
    assert made[0] == made[1]
    assert made[0]["metadata"]["timestamp"] == "1970-01-02T00:00:00+00:00"
    assert artifacts.sbom_packages(made[0]) == {"numpy": "2.4", "rich": "15"}
    with pytest.raises(PersonError, match="no list of parts"):
        artifacts.steady_sbom("{}", 0)
