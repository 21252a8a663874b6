"""The documentation against the program: commands are run as written, tables are compared."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import cv2
import pytest

from tests.invoked import rigctl
from tests.ready import ready

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
TUTORIAL = DOCS / "tutorials" / "first-shot.md"
ANALYSE = DOCS / "how-to" / "analyse-frames.md"
FILM = DOCS / "how-to" / "film-a-ball.md"
REAL_RIG = DOCS / "how-to" / "real-rig.md"
KEYS = DOCS / "how-to" / "keys-and-remote-access.md"
KEEPING = DOCS / "how-to" / "keep-a-campaign.md"
SWEEPS = DOCS / "how-to" / "run-a-sweep.md"
LESSONS = sorted([*DOCS.glob("tutorials/*.md"), *DOCS.glob("how-to/*.md")])
PAGES = sorted([*ROOT.glob("*.md"), *DOCS.rglob("*.md")])

RUN, BESIDE, BY_HAND = "run", "beside", "by-hand"
"""Run in order; run in a terminal of its own until the end; needs a clone or a real rig."""

PYTHON = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PORT_AS_WRITTEN = "8486"
ENDS_WITHIN_S = 120.0
LASTS_AT_MOST_S = 480.0
MANY = 3
"""Commands of the model for which it is worth to have it loaded before."""

needs_shell = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in ("bash", "curl")),
    reason="the commands of the documentation need bash and curl",
)


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block of shell commands: how it is marked, its line in the page, its text."""

    kind: str
    line: int
    text: str


def blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    return [
        Block(match[1].removeprefix("sh").strip(), text.count("\n", 0, match.start()) + 1, match[2])
        for match in FENCE.finditer(text)
        if match[1].split()[:1] == ["sh"]
    ]


def perform(page: Path, folder: Path) -> str:
    """Run a page in `folder` as its reader would, on any free port; return what it printed.

    A block that is marked `beside` keeps its terminal to the end; the blocks after it are run in
    a fresh one.
    """
    (folder / "config").symlink_to(ROOT / "config")
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    environment.pop("RIGCTL_KEY", None)
    asked = sum(block.text.count("rigctl model ") for block in blocks(page) if block.kind == RUN)
    first = f"{ready()}:" if asked >= MANY else ""
    at_once = {**environment, "PATH": first + environment["PATH"]}
    port, script, said = PORT_AS_WRITTEN, "", ""
    with ExitStack() as terminals:
        for block in blocks(page):
            text = block.text.replace(PORT_AS_WRITTEN, port)
            if block.kind == RUN:
                script += f"block={block.line}\n{text}"
            elif block.kind == BESIDE:
                said += run(script, page, folder, at_once)
                script = ""
                text = text.replace("rigctl serve", "rigctl serve --port 0")
                first = terminals.enter_context(terminal(text, folder, environment))
                if told := re.search(r"http://127\.0\.0\.1:(\d+)", first):
                    port = told[1]
        return said + run(script, page, folder, at_once)


def run(script: str, page: Path, folder: Path, environment: dict[str, str]) -> str:
    """Run commands until one fails; return what they printed."""
    stop = "set -Eeuo pipefail\ntrap 'echo \"the block at line $block fails\" >&2' ERR\n"
    done = subprocess.run(
        ["bash", "-c", stop + script],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=LASTS_AT_MOST_S,
        check=False,
    )
    assert done.returncode == 0, f"{page.name}: {done.stdout}{done.stderr}"
    return done.stdout


@contextmanager
def terminal(text: str, folder: Path, environment: dict[str, str]) -> Iterator[str]:
    """Run commands beside the others for the length of a `with` block; give their first line."""
    process = subprocess.Popen(
        ["bash", "-euc", text],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    try:
        first = process.stdout.readline()
        assert first, f"nothing came of {text!r}"
        yield first
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        try:
            process.communicate(timeout=ENDS_WITHIN_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate(timeout=ENDS_WITHIN_S)
            raise


def fires(folder: Path) -> int:
    """Return how often the simulated laboratory fired, by its own count."""
    return len((folder / "data/laboratory/truth/fires.jsonl").read_text().splitlines())


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_the_tutorial_fires_two_shots_and_shows_a_frame_with_its_outlines(tmp_path: Path) -> None:
    said = perform(TUTORIAL, tmp_path)
    assert fires(tmp_path) == 2
    answers = [json.loads(line) for line in said.splitlines() if line.startswith('{"shot":')]
    first = next(line for line in said.splitlines() if re.fullmatch(r"\d{8}-\d{6}", line))
    assert answers == [{"shot": first, "state": "stored"}]
    assert "restitution e" in said
    assert said.rstrip().endswith("idle")
    picture = cv2.imread(str(tmp_path / "contact.png"), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    assert picture.shape == (3 * 192, 3 * 240, 3)
    assert (picture[..., 0] != picture[..., 2]).any()


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_to_analysis_measures_a_campaign_and_reads_a_refusal(tmp_path: Path) -> None:
    said = perform(ANALYSE, tmp_path)
    assert "not a whole NPY file" in said.splitlines()[-1]
    shots = json.loads((tmp_path / "results.json").read_text())["shots"]
    assert [shot["status"] for shot in shots] == ["measured", "refused"]
    assert len((tmp_path / "measured" / "contacts.csv").read_text().splitlines()) == 2
    assert cv2.imread(str(tmp_path / "pictures" / "0001.png")) is not None


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_the_commissioning_of_a_real_rig_can_be_rehearsed(tmp_path: Path) -> None:
    said = perform(REAL_RIG, tmp_path)
    assert json.loads((tmp_path / "stopped.json").read_text())["state"] == "estop"
    assert said.count('"state":"idle"') == 2
    assert json.loads((tmp_path / "shot.json").read_text())["settings"]["delay_us"] == 5000
    assert fires(tmp_path) == 1


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_a_stop_and_the_way_out_of_it_can_be_rehearsed(tmp_path: Path) -> None:
    said = perform(DOCS / "how-to" / "recover.md", tmp_path)
    assert [line.split(": ")[1] for line in said.splitlines()] == ["estop", "idle"]


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_the_numbers_of_a_service_can_be_read_as_its_guide_says(tmp_path: Path) -> None:
    said = perform(DOCS / "how-to" / "run-as-a-service.md", tmp_path)
    assert 'rigctl_state{state="idle"} 1.0' in said


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_to_sweeps_starts_pauses_resumes_and_ends_them(tmp_path: Path) -> None:
    said = perform(SWEEPS, tmp_path)
    for state in ("completed", "paused", "running", "aborted"):
        assert re.search(rf"^sweep \d{{8}}-s\d{{4}}: {state}", said, re.MULTILINE), state
    assert 4 + 2 <= fires(tmp_path) <= 4 + 27 + 8


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_to_keeping_a_campaign_hands_one_on_and_back(tmp_path: Path) -> None:
    said = perform(KEEPING, tmp_path)
    assert "campaign nylon, thesis: 1 of 1 shots measured" in said
    assert "verified" in said.splitlines()[-1]
    assert (tmp_path / "nylon-exported" / "poses.csv").exists()
    assert fires(tmp_path) == 1


@pytest.mark.long
@needs_shell
def test_the_guide_to_keys_gives_each_caller_its_own(tmp_path: Path) -> None:
    said = perform(KEYS, tmp_path)
    assert '"state":"idle"' in said
    assert "anna: operate, sweep; never expires" in said
    assert re.search(r"^dashboard: revoked at 20", said, re.MULTILINE)
    assert (tmp_path / "dashboard.key").read_text().strip() not in said


@needs_shell
@pytest.mark.long
@pytest.mark.timeout(600)
def test_the_guide_to_the_apparatus_records_a_disk_and_drops_a_sphere(tmp_path: Path) -> None:
    said = perform(DOCS / "how-to" / "apparatus-of-the-thesis.md", tmp_path)
    assert "A frame's angle is good to 0.00" in said
    assert "analysed: 0 and 0 kPa" in said


@pytest.mark.long
@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_to_tapes_numbers_pictures_of_a_playback_and_measures_the_shot(
    tmp_path: Path,
) -> None:
    said = perform(DOCS / "how-to" / "digitise-a-tape.md", tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text())["numbers"]
    shown = sorted({number for pair in truth for number in pair})
    note = json.loads((tmp_path / "shots" / "0001.json").read_text())
    assert note["sequence"] == shown
    assert f"lost: {', '.join(map(str, note['lost']))}" in said
    assert re.search(r"^ +1 .* 0\.7\d+\(", said, re.MULTILINE)


@pytest.mark.parametrize("page", LESSONS, ids=lambda page: page.stem)
def test_every_shell_block_of_a_lesson_says_whether_it_is_run(page: Path) -> None:
    found = blocks(page)
    assert RUN in {block.kind for block in found} <= {RUN, BESIDE, BY_HAND}
    for block in found:
        subprocess.run(["bash", "-n", "-c", block.text], check=True, timeout=ENDS_WITHIN_S)


def test_every_target_of_make_that_a_page_names_is_there() -> None:
    there = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for page in PAGES:
        assert set(re.findall(r"`?make ([a-z]+)\b", page_commands(page))) <= there, page


def page_commands(page: Path) -> str:
    """Return the fenced blocks and the code within the lines of a page."""
    text = page.read_text(encoding="utf-8")
    return "\n".join([match[0] for match in FENCE.finditer(text)] + re.findall(r"`[^`\n]+`", text))


def test_every_option_of_the_analysis_is_explained() -> None:
    done = rigctl("analyse", "--help")
    options = set(re.findall(r"^ +(--[a-z-]+)", done.stdout, re.MULTILINE)) - {"--help"}
    assert options
    explained = page_commands(ANALYSE) + page_commands(FILM)
    assert options <= set(re.findall(r"--[a-z-]+", explained))


def anchor(heading: str) -> str:
    words = re.sub(r"[^\w\- ]", "", heading.strip().lower())
    return words.replace(" ", "-")


def anchors(page: Path) -> set[str]:
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    return {anchor(line) for line in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page: Path) -> None:
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" in target:
            continue
        path, _, place = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        assert there.exists(), f"{target} is not there"
        assert not place or place in anchors(there), f"{target} has no such heading"
