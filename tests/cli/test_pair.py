"""`live pair` between two machines, and errors of --lead and --standby without pairing."""

import io
import os
import re
import subprocess
import sys
from pathlib import Path

from tests.cli.command import run_live
from tests.supervisor.made_machines import machine, pair_folders


def test_two_machines_are_paired_by_phrase_listed_and_forgotten(tmp_path: Path, monkeypatch):
    shown = subprocess.Popen(
        [sys.executable, "-m", "live", "pair", "--on", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True,
        env={**os.environ, "LIVE_CONFIG_DIR": str(tmp_path / "left")},
    )  # fmt: skip
    try:
        assert shown.stdout is not None
        first, second = shown.stdout.readline(), shown.stdout.readline()
        phrase = re.fullmatch(r"the phrase: (\w{5}-\w{5}-\w{5})\n", first)
        port = re.search(r"ADDRESS:(\d+)$", second)
        assert phrase is not None
        assert port is not None
        there = f"127.0.0.1:{port[1]}"
        right = str(tmp_path / "right")
        monkeypatch.setattr(sys, "stdin", io.StringIO("babab-babab-babab\n"))
        wrong = run_live("pair", there, LIVE_CONFIG_DIR=right)
        assert wrong.returncode == 2
        assert "the phrase is wrong" in wrong.stderr
        monkeypatch.setattr(sys, "stdin", io.StringIO(f"{phrase[1].upper()}\n"))
        done = run_live("pair", there, LIVE_CONFIG_DIR=right)
        assert done.returncode == 0, done.stderr
        assert "paired with" in done.stdout
        rest = shown.stdout.read()
        assert shown.wait(20) == 0
        assert "paired with" in rest
        assert "wrong phrases were entered" in rest
    finally:
        shown.kill()
        shown.wait()
        if shown.stdout is not None:
            shown.stdout.close()
    (peer,) = machine(tmp_path / "right")[1].read()
    assert peer.certificate == machine(tmp_path / "left")[0].certificate
    listed = run_live("pair", "--list", LIVE_CONFIG_DIR=right)
    assert f"{peer.name}: {peer.fingerprint[:16]}, valid until 20" in listed.stdout
    assert run_live("pair", "--forget", "../x", LIVE_CONFIG_DIR=right).returncode == 2
    assert run_live("pair", "--forget", peer.name, LIVE_CONFIG_DIR=right).returncode == 0
    assert "no paired machines" in run_live("pair", "--list", LIVE_CONFIG_DIR=right).stdout


def test_unpaired_machine_refuses_remote_lead_and_standby(tmp_path: Path):
    for option, place in (("--lead", "0.0.0.0:9020"), ("--standby", "192.0.2.1:9020"), ("--lead", "[::]:9020")):
        done = run_live("play", "--headless", option, place, LIVE_CONFIG_DIR=str(tmp_path / "one"))
        assert done.returncode == 2
        assert "not paired with another one" in done.stderr
        assert "live pair" in done.stderr


def test_keys_readable_by_others_are_refused_before_show(tmp_path: Path):
    pair_folders(tmp_path / "one", tmp_path / "two")
    (tmp_path / "one" / "network" / "identity.pem").chmod(0o644)
    done = run_live("play", "--headless", "--lead", "9020", LIVE_CONFIG_DIR=str(tmp_path / "one"))
    assert done.returncode == 2
    assert "not this user's alone (mode 644)" in done.stderr
    assert "chmod 600" in done.stderr


def test_combined_pair_options_are_refused():
    done = run_live("pair", "somewhere", "--list")
    assert done.returncode == 2
    assert "at a time" in done.stderr
