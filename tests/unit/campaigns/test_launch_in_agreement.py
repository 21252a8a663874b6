"""What jobs answer of a campaign's folder."""

from __future__ import annotations

from pathlib import Path

from rigctl.model.computing import agreement_job
from simulators.challenge.campaign import run_campaign
from simulators.challenge.folder import write_folder
from simulators.challenge.nature import Nature


def asked(folder: Path) -> dict[str, object]:
    return {"campaign": "nylon", "folder": str(folder), "with": []}


def silent(_text: str, _share: float | None) -> None:
    """Say nothing of how far the work is."""


def test_an_agreement_begins_with_the_launch(tmp_path: Path) -> None:
    write_folder(tmp_path / "nylon", run_campaign(Nature(), 5, shots=16))
    found = agreement_job(asked(tmp_path / "nylon"), silent)
    assert found["stages"][0]["stage"] == "launch"
    assert found["launch_left_out"] is None


def test_without_settings_the_launch_is_left_out_and_the_answer_says_why(tmp_path: Path) -> None:
    folder = tmp_path / "nylon"
    write_folder(folder, run_campaign(Nature(), 5, shots=16))
    head, *rows = (folder / "shots.csv").read_text(encoding="utf-8").splitlines()
    kept = head.split(",").index("time") + 1
    lines = [",".join(line.split(",")[:kept]) for line in (head, *rows)]
    (folder / "shots.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = agreement_job(asked(folder), silent)
    assert "launch" not in {stage["stage"] for stage in found["stages"]}
    assert "settings" in found["launch_left_out"]
