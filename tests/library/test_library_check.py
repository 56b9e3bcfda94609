"""The library check reports errors and doubtful values with file, line and field."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.library.library_check import Finding, check_connections, check_folder, step_warnings
from live.library.recordings import RecordingReader
from live.motion.editing.facing import turn_clip
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, column, dance_values, still

ONE = 'file = "dance.bvh"\nname = "sway"\nbpm = 120\nfirst_beat_s = 2.5\nplant_feet = false\n'  # the made bodies skate


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    path = tmp_path / "steps"
    path.mkdir()
    (path / "dance.bvh").write_text(body_bvh(upright_dance()))
    (path / "dance.toml").write_text(ONE)
    return path


def upright_dance() -> np.ndarray:
    """The made dance with the feet below the hips."""
    values = dance_values(601)
    for joint in ("Hips", "LeftUpLeg", "RightUpLeg"):
        for axis in "ZX":
            values[:, column(joint, axis)] = 0.0
    for side in ("Left", "Right"):
        values[:, column(side + "UpLeg", "X")] = -0.5 * values[:, column(side + "Leg", "X")]
    return values


def finding_texts(findings: list[Finding]) -> list[str]:
    return [f"{finding.kind}: {finding.problem}" for finding in findings]


def test_valid_folder_has_no_findings(folder: Path) -> None:
    checked = check_folder(folder)
    assert finding_texts(checked.findings) == []
    assert [step.step for step in checked.steps] == ["sway"]


@mostly_long(
    ("line", "words"),
    [
        ('direction = "long back"', "line 6: direction: 'long back', but it travels "),
        ("distance_m = 5.0", "line 6: distance_m: 5, but 0."),
        ("weight_transfer = true", "line 6: weight_transfer: true, but leading_foot is not given"),
    ],
    quick=[0, 1],
)
def test_given_values_are_compared_with_measured_values(folder: Path, line: str, words: str) -> None:
    (folder / "dance.toml").write_text(ONE + line + "\n")
    (finding,) = finding_texts(check_folder(folder).findings)
    assert finding.startswith("doubtful: ")
    assert words in finding


@pytest.mark.long
def test_correct_values_give_no_findings(folder: Path) -> None:
    (step,) = check_folder(folder).steps
    direction = step.direction.replace("short", "long")  # how long is long is for the choreographer to say
    (folder / "dance.toml").write_text(ONE + f'direction = "{direction}"\ndistance_m = {step.distance_m + 0.05:.3f}\n')
    assert finding_texts(check_folder(folder).findings) == []


def test_missing_lead_in_is_reported(folder: Path) -> None:
    (folder / "dance.toml").write_text(ONE.replace("2.5", "0.1"))
    findings = finding_texts(check_folder(folder).findings)
    assert any("line 4: first_beat_s: the recording begins 0.10 s before the step" in finding for finding in findings)


def test_a_body_that_leans_as_if_it_fell_is_reported(folder: Path) -> None:
    values = upright_dance()
    values[:, column("Hips", "X")] += 15.0
    (folder / "dance.bvh").write_text(body_bvh(values))
    (finding,) = [text for text in finding_texts(check_folder(folder).findings) if "beside the feet" in text]
    assert "half of the time the hips are more than 0.18 m beside the feet: the body leans" in finding


def test_step_without_foot_contact_is_reported(folder: Path) -> None:
    checked = check_folder(folder)
    entry, step = checked.entries[0], checked.steps[0]
    assert step_warnings(entry, step) == []
    flying = replace(step, clip=replace(step.clip, contact=np.zeros_like(step.clip.contact)))
    assert [field for field, words in step_warnings(entry, flying) if "no foot touches" in words] == ["file"]
    hopping = flying.clip.contact.copy()
    hopping[int(step.first) + 5 : int(step.first) + 10] = True
    (doubt,) = step_warnings(entry, replace(step, clip=replace(step.clip, contact=hopping)))
    assert doubt == ("file", "a foot is on the floor in 4 % of this step only; check the floor, unit_m and up")


def test_step_with_back_to_audience_is_reported(folder: Path) -> None:
    checked = check_folder(folder)
    entry, step = checked.entries[0], checked.steps[0]
    back = turn_clip(step.clip, math.radians(170.0))
    (doubt,) = step_warnings(entry, replace(step, clip=back))
    assert doubt[0] == "start_measure"
    assert "the back is to the audience" in doubt[1]
    assert step_warnings(entry, replace(step, clip=turn_clip(step.clip, math.radians(90.0)))) == []


@pytest.mark.parametrize(("at", "field", "words"), [(0, "start_measure", "begins"), (-1, "measures", "ends")])
def test_a_t_pose_at_either_end_is_reported(folder: Path, at: int, field: str, words: str) -> None:
    """A second of the rest pose, whose arms are level, at the beginning or the end of the step."""
    checked = check_folder(folder)
    entry, step = checked.entries[0], checked.steps[0]
    rotation, root = step.clip.rotation.copy(), step.clip.root_position.copy()
    first, last = math.ceil(step.first), int(step.first + step.measures * step.samples_per_measure)
    second = round(step.clip.sample_rate)
    still = slice(first, first + second) if at == 0 else slice(last + 1 - second, last + 1)
    rotation[still], root[still] = [1.0, 0.0, 0.0, 0.0], root[still.start]
    (doubt,) = step_warnings(entry, replace(step, clip=replace(step.clip, rotation=rotation, root_position=root)))
    assert doubt[0] == field
    assert f"it {words} with 1.0 s of standing with the arms stretched out" in doubt[1]
    rotation = rotation.copy()  # clips make theirs read-only
    rotation[still.start + second // 2] = step.clip.rotation[first + second]  # arms that move are no calibration
    assert step_warnings(entry, replace(step, clip=replace(step.clip, rotation=rotation, root_position=root))) == []


def test_guess_is_reported_until_confirmed(folder: Path) -> None:
    toml = folder / "dance.toml"
    toml.write_text(ONE.replace("= 120", "= 120 # guess: confirm").replace("= 2.5", "= 2.5 #guess: confirm"))
    bpm, first = finding_texts(check_folder(folder).findings)
    assert "dance.toml, line 3: bpm: 120 is a guess; " in bpm
    assert "dance.toml, line 4: first_beat_s: 2.5 is a guess; " in first
    toml.write_text(ONE.replace('"sway"', '"guess: confirm"').replace("= 120", "= 120 # counted"))
    assert finding_texts(check_folder(folder).findings) == []


@pytest.mark.long
def test_unusable_files_are_reported_and_others_are_checked(folder: Path) -> None:
    (folder / "a.toml").write_text('[[step]]\nfile = "gone.bvh"\nname = "a"\nbpm = 120\nfirst_beat_s = 0\n')
    (folder / "b.toml").write_text(ONE + "measures = 40\n")
    (folder / "c.toml").write_text("name = \n")
    (folder / "d.toml").write_text('name = "d"\n[pelvis]\n"1" = "sideways 4"\n')
    checked = check_folder(folder)
    assert [finding.kind for finding in checked.findings] == ["wrong"] * 4
    lines = "\n".join(finding_texts(checked.findings))
    for words in (
        "a.toml, line 2: step.1.file: ",
        "b.toml, line 6: measures: ",
        "c.toml, line 1: not valid TOML",
        "d.toml, line 3: ",
    ):
        assert words in lines
    assert [step.step for step in checked.steps] == ["sway"]


def write_glitch(folder: Path, frame: int) -> None:
    values = dance_values(601)
    values[frame : frame + 2, 0] += 60.0
    values[frame : frame + 2, column("LeftUpLeg", "X")] += 70.0
    (folder / "dance.bvh").write_text(body_bvh(values))


@pytest.mark.long
def test_glitch_is_reported_only_inside_step(folder: Path) -> None:
    write_glitch(folder, 200)  # 3.33 s, inside the step that lasts from 2.5 to 4.5 s
    findings = finding_texts(check_folder(folder).findings)
    assert any("line 1: file: frame" in finding and "write repair = true" in finding for finding in findings)
    write_glitch(folder, 400)
    assert not any("frame" in finding for finding in finding_texts(check_folder(folder).findings))


@pytest.mark.long
def test_repair_removes_glitch_and_keeps_other_motion(folder: Path) -> None:
    clean = check_folder(folder).steps[0].clip
    write_glitch(folder, 200)
    faulty = check_folder(folder).steps[0].clip
    (folder / "dance.toml").write_text(ONE + "repair = true\n")
    checked = check_folder(folder)
    mended = checked.steps[0].clip

    def off(clip: object) -> float:
        return float(np.abs(clip.root_position - clean.root_position).max())  # type: ignore[attr-defined]

    assert off(faulty) > 0.3
    assert off(mended) < 0.1
    assert not any("frame" in finding for finding in finding_texts(checked.findings))
    assert RecordingReader().glitches(checked.entries[0]) == []


def test_unmatched_begin_and_end_poses_are_reported(folder: Path) -> None:
    (folder / "dance.toml").write_text(ONE + 'end_pose = "plie"\nbegin_pose = "plié"\n')
    checked = check_folder(folder)
    findings = finding_texts(check_connections([checked], folder, threshold=2.0))
    assert any("line 6: end_pose: no step begins in 'plie'; there are: 'plié'" in finding for finding in findings)
    assert any("line 7: begin_pose: no step ends in 'plié'; there are: 'plie'" in finding for finding in findings)


def test_steps_without_transition_are_reported(folder: Path) -> None:
    (folder / "dance.bvh").write_text(body_bvh(dance_values(601)))
    checked = check_folder(folder)
    (finding,) = finding_texts(check_connections([checked], folder, threshold=0.02))
    assert "no step of sway leads to another within 0.02 m" in finding
    assert finding_texts(check_connections([checked], folder, threshold=2.0)) == []


def stepping_body(bpm: float) -> np.ndarray:
    """Channel values of a body that steps from foot to foot at `bpm`, 20 s at 60 frames/s."""
    values = still(1201)
    beat = np.arange(1201) / 60.0 * bpm / 60.0
    for side, phase in (("Left", 0.0), ("Right", 1.0)):
        lift = np.maximum(np.sin(np.pi * (beat + phase)), 0.0) * (1.0 + 0.3 * ((beat // 4) % 2))
        values[:, column(side + "UpLeg", "X")] = -45.0 * lift
        values[:, column(side + "Leg", "X")] = 75.0 * lift
        values[:, column(side + "Foot", "X")] = -30.0 * lift
    values[:, 0] = 5.0 * np.cos(np.pi * beat)
    return values


@mostly_long(("written", "doubted"), [(120.0, False), (60.0, False), (240.0, False), (107.0, True)], quick=[3])
def test_tempo_that_contradicts_footsteps_is_reported(folder: Path, written: float, doubted: bool) -> None:
    (folder / "dance.bvh").write_text(body_bvh(stepping_body(120.0)))
    (folder / "dance.toml").write_text(ONE.replace("120", f"{written:g}"))
    findings = [finding for finding in finding_texts(check_folder(folder).findings) if ": bpm: " in finding]
    assert bool(findings) == doubted
    if doubted:
        assert "line 3: bpm: 107, but the feet give" in findings[0]
