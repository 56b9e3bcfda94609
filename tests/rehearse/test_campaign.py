"""Campaigns resume where they stopped; harness failures are in the report; every report is readable."""

import json

import pytest

from live.base.errors import PersonError
from live.rehearse.campaign import STATE_FILE, Campaign, Job, report_lines, run_safely


def _job(name, done, **facts):
    def run(folder):
        assert folder.is_dir()
        done.append(name)
        return {"ok": True, "problems": [], "summary": ["12 measures"], **facts}

    return Job(name, run)


def test_completed_run_is_not_repeated(tmp_path):
    done = []
    jobs = [_job("a-0", done), _job("b-0", done)]
    Campaign(tmp_path, {"hours": 1.0}).run(jobs[:1])
    facts = Campaign(tmp_path, {"hours": 1.0}).run(jobs)
    assert done == ["a-0", "b-0"]
    assert facts["ok"]
    assert list(facts["runs"]) == ["a-0", "b-0"]
    assert json.loads((tmp_path / STATE_FILE).read_text())["done"].keys() == {"a-0", "b-0"}


def test_folder_of_another_campaign_is_refused(tmp_path):
    Campaign(tmp_path, {"hours": 1.0}).run([_job("a-0", [])])
    with pytest.raises(PersonError, match="other options"):
        Campaign(tmp_path, {"hours": 2.0})
    (tmp_path / STATE_FILE).write_text("[1")
    with pytest.raises(PersonError, match="not a campaign state"):
        Campaign(tmp_path, {"hours": 1.0})


def test_harness_exception_is_reported_and_campaign_continues(tmp_path):
    def breaks(folder):
        return {}["no such"]

    done = []
    facts = Campaign(tmp_path, {}).run([Job("a-0", breaks), _job("b-0", done)])
    assert done == ["b-0"]
    assert not facts["ok"]
    told = list(report_lines(facts))
    assert told[0].startswith("FAIL a-0")
    assert "the harness itself failed: KeyError" in told[1]
    assert told[-1] == "1 of 2 runs went well"
    json.dumps(facts)


def test_interrupted_campaign_reports_missing_runs(tmp_path):
    def interrupted(folder):
        raise KeyboardInterrupt

    campaign = Campaign(tmp_path, {})
    with pytest.raises(KeyboardInterrupt):
        campaign.run([_job("a-0", []), Job("b-0", interrupted)])
    facts = campaign.report(["a-0", "b-0"])
    assert facts["not_run"] == ["b-0"]
    assert not facts["ok"]
    assert any("not run: b-0" in line for line in report_lines(facts))


def test_long_problems_are_shortened_in_lines_only(tmp_path):
    facts = run_safely(_job("a", [], ok=False, problems=[f"first\n  line {n}" for n in range(30)]), tmp_path / "a")
    report = {"runs": {"a": facts}, "not_run": []}
    told = list(report_lines(report))
    assert told[1].strip() == "first line 0"
    assert "and 22 more" in told[9]
    assert len(facts["problems"]) == 30
