"""`live couple`: its table, its report, its notation, its film, and the page to set labels."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np
import pytest

from live.app.services.label_page import LABEL_PATH, MAX_BYTES, LabelDesk, open_desk
from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.cli.steps.couple import compare, notation
from live.control.web.studio_server import StudioServer
from live.library.partner_pairs import read_pairs
from live.library.pattern_labels import read_labels
from live.motion.formats.bvh_writer import write_bvh
from tests.cli.command import run_live
from tests.motion.partner.test_answer import random_dance_clip

KEY = "a-key-of-the-tests-4711"
NAMES = ("a_follower", "b_follower", "c_follower")


@pytest.fixture(name="pairs", scope="module")
def _pairs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three takes: the first two are the same dance, so that one is answered rightly from the other."""
    folder = tmp_path_factory.mktemp("couples")
    lines = []
    for name, seed, style in (("a", 61, "soft"), ("b", 61, ""), ("c", 63, "hard")):
        for side, more in (("leader", 0), ("follower", 1)):
            (folder / f"{name}_{side}.bvh").write_text(write_bvh(random_dance_clip(seed + more, 500), rate=30.0))
        lines.append(
            f'[[pair]]\nleader = {{ file = "{name}_leader.bvh", bpm = 164, first_beat_s = 0.3 }}\n'
            f'follower = {{ file = "{name}_follower.bvh" }}\n' + (f'style = "{style}"\n' if style else "")
        )
    (folder / "pairs.toml").write_text("\n".join(lines))
    return folder / "pairs.toml"


def labels_text(takes: tuple[str, ...], names: tuple[str, ...]) -> str:
    return "".join(
        f'[[pattern]]\ntake = "{take}"\nfrom_s = {0.3 + 2.9 * n}\nto_s = {3.2 + 2.9 * n}\nlabel = "{name}"\n'
        for take in takes
        for n, name in enumerate(names)
    )


def test_a_take_whose_double_is_known_is_answered_and_compared(pairs: Path, tmp_path: Path) -> None:
    report, score = tmp_path / "report.json", tmp_path / "score.txt"
    done = run_live(
        "couple", "compare", str(pairs), "--take", "a_follower", "--report", str(report), "--notation", str(score)
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "No labels of a person" in done.stdout
    (told,) = json.loads(report.read_text())["takes"]
    assert told["joint_m"] < 0.12
    assert told["stance"]["share"] > 0.9
    assert not told["labelled"]
    assert told["units_with_the_same_label"] is None
    lines = score.read_text().splitlines()
    assert lines[0] == "# a_follower, the answer"
    assert {line.split()[-1].split("/")[0] for line in lines[4:-3]} == {"b_follower"}


@pytest.mark.long
def test_labels_of_a_person_are_compared(pairs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The double has the same labels, so units agree; with other labels they do not."""
    labels, report = tmp_path / "labels.toml", tmp_path / "report.json"
    for other, share in ((("x", "y"), 1.0), (("y", "x"), 0.0)):
        labels.write_text(labels_text(("a_follower",), ("x", "y")) + labels_text(("b_follower",), other))
        compare(pairs, take="1", labels=labels, report=report)
        printed = capsys.readouterr().out
        assert "No labels" not in printed
        assert "patterns (labels of a person)" in printed
        (told,) = json.loads(report.read_text())["takes"]
        assert told["labelled"]
        assert [one["real"] for one in told["patterns"]] == ["x", "y"]
        assert told["pattern_count"]["share"] == share
        assert told["units_with_the_same_label"]["share"] == pytest.approx(share, abs=0.3)


@pytest.mark.long
def test_a_style_leaves_others_out(pairs: Path, tmp_path: Path) -> None:
    assert [one.name for one in read_pairs(pairs).units.examples] == list(NAMES)
    soft, hard = read_pairs(pairs, style="Soft"), read_pairs(pairs, style="hard")
    assert [one.name for one in soft.units.examples] == ["a_follower", "b_follower"]
    assert [one.name for one in hard.units.examples] == ["b_follower", "c_follower"]
    assert [pair.style for pair in hard.pairs_file.pair] == [None, "hard"]
    with pytest.raises(PersonError, match="line 1: pair: no pair has the style 'x'; there are: hard, soft"):
        read_pairs(pairs, style="x")
    report = tmp_path / "report.json"
    compare(pairs, take="b_follower", style="hard", report=report)
    assert json.loads(report.read_text())["takes"][0]["joint_m"] > 0.2  # its double is left out


@pytest.mark.long
def test_notation_of_recorded_couples(pairs: Path, tmp_path: Path) -> None:
    out, report = tmp_path / "out.txt", tmp_path / "out.json"
    notation(pairs, out=out, report=report)
    told = json.loads(report.read_text())
    assert [one["take"] for one in told] == list(NAMES)
    assert [one["count"] for one in told[0]["counts"]][:9] == [*range(1, 9), 1]
    assert len(out.read_text().splitlines()) == sum(len(one["counts"]) + 2 for one in told) + 2
    notation(pairs, take="a_follower", first=3, report=report)
    assert [one["count"] for one in json.loads(report.read_text())[0]["counts"]][:4] == [7, 8, 1, 2]


@pytest.mark.long
def test_what_cannot_be_compared_is_refused(pairs: Path, tmp_path: Path) -> None:
    def refused(words: str, **options: Any) -> None:
        with pytest.raises(PersonError, match=words):
            compare(**({"pairs": pairs} | options))

    refused("there is no such take.*there are|--take 'x'", take="x")
    refused("--take '9'", take="9")
    refused("a film shows one take", film=tmp_path / "f.mp4")
    refused("ends in .mp4", film=tmp_path / "f.avi", take="1")
    refused("--first", first=0)
    refused("cannot read the labels", labels=tmp_path / "none.toml")
    refused("no such|cannot read", pairs=tmp_path / "none.toml")
    lone = pairs.parent / "lone.toml"
    lone.write_text(pairs.read_text().split("[[pair]]")[1].join(["[[pair]]", ""]))
    refused("one pair", pairs=lone)


@pytest.mark.long
@pytest.mark.gl
def test_a_film_shows_the_answer_over_the_couple(pairs: Path, tmp_path: Path) -> None:
    import av

    film = tmp_path / "couple.mp4"
    compare(pairs, take="a_follower", film=film, size="160x96", fps=1.0)
    with av.open(str(film)) as opened:
        pictures = [frame.to_ndarray(format="rgb24") for frame in opened.decode(video=0)]
    assert 7 <= len(pictures) <= 9
    assert all(picture.std() > 3.0 for picture in pictures)
    assert not np.array_equal(pictures[2], pictures[5])


def served(desk: LabelDesk, ask: Callable[[aiohttp.ClientSession, str], Awaitable[None]]) -> None:
    async def take(text: str) -> list[str | bytes]:
        return desk.answer(text)

    async def run() -> None:
        with listening_socket(("127.0.0.1", 0), 16, resumes=False) as listening:
            end: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            server = StudioServer(listening, KEY, desk.facts, LABEL_PATH, take, max_bytes=MAX_BYTES)
            task = asyncio.ensure_future(server.run_until(end))
            async with aiohttp.ClientSession() as client:
                await ask(client, f"http://127.0.0.1:{listening.getsockname()[1]}")
            end.set_result(None)
            await asyncio.wait_for(task, 30)

    asyncio.run(asyncio.wait_for(run(), 60))


def test_the_page_gets_motion_and_saves_labels(pairs: Path, tmp_path: Path) -> None:
    labels = tmp_path / "new.labels.toml"
    desk = open_desk(pairs, labels)
    pattern = {"take": "a_follower", "from_s": 0.3, "to_s": 3.2, "label": "x"}

    async def ask(client: aiohttp.ClientSession, at: str) -> None:
        async with client.get(f"{at}/surface.json", headers={"Authorization": f"Bearer {KEY}"}) as answer:
            facts = (await answer.json())["label"]
        assert [one["name"] for one in facts["takes"]] == list(NAMES)
        assert len(facts["takes"][0]["beats"]) > 8
        for headers, path, status in (({}, LABEL_PATH, 401), ({"Origin": "http://evil.example"}, "/surface.json", 403)):
            async with client.get(at + path, headers=headers) as answer:
                assert answer.status == status
        async with client.ws_connect(at + LABEL_PATH, protocols=("live.operator", f"live.key.{KEY}")) as page:
            await page.send_str('{"take": "b_follower"}')
            told = await page.receive_json()
            data = await page.receive_bytes()
            joints = np.frombuffer(data, "<i2").reshape(told["samples"], told["dancers"], 22, 3)
            hips = joints[:, :, 0, (0, 2)] / 1000.0
            assert np.ptp(hips, axis=(0, 1)) == pytest.approx((told["width"], told["depth"]), abs=2e-3)
            assert hips.max(axis=(0, 1)) == pytest.approx(-hips.min(axis=(0, 1)), abs=2e-3)  # in the middle
            for text in ("", "{", "[" * 2000, "5", '{"take": 5}', '{"take": "x"}', '{"save": []}',
                         '{"save": {"pattern": [5]}, "revision": 0}', '{"save": {}, "revision": true}'):  # fmt: skip
                await page.send_str(text)
                assert (await page.receive_json())["kind"] in ("refused", "changed"), text
            assert not labels.exists()
            await page.send_json({"save": {"labels": ["x", "y"], "pattern": [pattern]}, "revision": 0})
            told = await page.receive_json()
            assert (told["kind"], told["revision"]) == ("saved", 1)
            await page.send_json({"save": {"labels": [], "pattern": []}, "revision": 0})  # a page that has seen less
            told = await page.receive_json()
            assert (told["kind"], told["pattern"], told["revision"]) == ("changed", [pattern], 1)

    served(desk, ask)
    found = read_labels(labels)
    assert found.labels == ("x", "y")
    assert [one.model_dump() for one in found.patterns] == [pattern]
    assert open_desk(pairs, labels).labels == found


@pytest.mark.long
def test_labels_of_a_double_are_suggested_and_none_without_labels(pairs: Path, tmp_path: Path) -> None:
    labels = tmp_path / "x.labels.toml"

    def suggested(take: str) -> dict[str, Any]:
        (text,) = open_desk(pairs, labels).answer(json.dumps({"suggest": take}))
        told: dict[str, Any] = json.loads(text)
        return told

    assert suggested("a_follower")["kind"] == "refused"
    labels.write_text(labels_text(("b_follower",), ("x", "y")))
    before = labels.read_text()
    spans = suggested("a_follower")["spans"]
    at = {round(0.5 * (one["from"] + one["to"]), 1): one["label"] for one in spans}
    assert all(label == ("x" if time < 3.2 else "y") for time, label in at.items() if time < 6.1)
    assert len(at) > 5
    assert labels.read_text() == before  # nothing but a person labels
    assert suggested("b_follower")["kind"] == "refused"
    assert suggested("nobody")["kind"] == "refused"


def test_pairs_that_cannot_be_labelled_are_refused(pairs: Path, tmp_path: Path) -> None:
    twice = pairs.parent / "twice.toml"
    one = pairs.read_text().split("[[pair]]")[1]
    twice.write_text(f"[[pair]]{one}[[pair]]{one}")
    with pytest.raises(PersonError, match="two pairs are called 'a_follower'"):
        open_desk(twice, None)
    still = tmp_path / "x.labels.toml"
    still.write_text(labels_text(("nobody",), ("x",)))
    with pytest.raises(PersonError, match="there is no take 'nobody'"):
        open_desk(pairs, still)
