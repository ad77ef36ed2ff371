"""The README's example runs, and the settings in docs/algorithm.md have the defaults that it states."""

from __future__ import annotations

import math
import re
from pathlib import Path

import attrs
import pytest
import typer
from rvdnav.campaign import load_plan
from rvdnav.cli.app import app
from rvdnav.core.config import make_config
from rvdnav.faults import FAULT_NAMES, STRENGTHS
from rvdnav.navigator import NavigatorSettings

ROOT = Path(__file__).resolve().parents[2]
ALGORITHM = (ROOT / "docs" / "algorithm.md").read_text(encoding="utf-8")
CORE_ALONE = {"struct_size", "isa", "clock", "clock_user"}


def test_the_example_in_the_readme_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 1
    monkeypatch.chdir(ROOT)
    exec(compile(blocks[0], "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert printed.count("TRACKING") == 24


def stated_defaults() -> dict[str, float]:
    """Setting -> default, degrees turned into radians, from the rows of the tables."""
    rows = re.findall(r"`([a-z_0-9]+)` \| ([0-9.]+)(°?) \|", ALGORITHM)
    return {name: math.radians(float(value)) if degree else float(value) for name, value, degree in rows}


def test_the_documented_settings_are_all_there_with_their_defaults() -> None:
    config = make_config()
    actual = {name: getattr(config, name) for name in dir(config) if name not in CORE_ALONE}
    actual |= attrs.asdict(NavigatorSettings())
    assert stated_defaults() == pytest.approx(actual)


@pytest.mark.parametrize("mean", [0, 40, 59, 80, 120, 160, 200, 255])
def test_the_table_of_thresholds_follows_the_formula(mean: int) -> None:
    rows = [row.split("|")[2:-1] for row in ALGORITHM.splitlines() if row.startswith(("| local mean", "| threshold,"))]
    table = dict(zip(map(int, rows[0]), map(float, rows[1]), strict=True))
    config = make_config()
    weber, knee = config.edge_weber_q8 / 256, config.edge_knee
    expected = max(config.edge_floor, weber * min(mean, knee) + weber / 4 * max(mean - knee, 0))
    assert table[mean] == pytest.approx(expected, abs=0.051)


DOCUMENTS = ["README.md", "CONTRIBUTING.md", *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("name", DOCUMENTS)
def test_links_between_documents_lead_somewhere(name: str) -> None:
    document = ROOT / name
    links = re.findall(r"\]\(([^)#:]+)\)", document.read_text(encoding="utf-8"))
    for link in links:
        assert (document.parent / link).exists(), link


def test_the_readme_names_every_document_and_every_command() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for name in DOCUMENTS[1:]:
        assert f"]({name})" in readme
    listed = set(re.findall(r"^    rvdnav ([a-z]+)", readme, re.MULTILINE))
    assert listed == set(typer.main.get_command(app).commands)


def test_the_example_of_a_campaign_can_be_run() -> None:
    plan = load_plan(ROOT / "examples" / "campaign.yaml")
    assert len(plan.trials) == 7


def test_every_fault_is_measured_in_the_table() -> None:
    table = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8").partition("## Measured")[2]
    rows = re.findall(r"^\| ([a-z0-9_.]+) \| (approach|sunlit) \|", table, re.MULTILINE)
    measured = [fault for fault in FAULT_NAMES if fault not in STRENGTHS]
    assert rows == [(fault, sequence) for fault in measured for sequence in ("approach", "sunlit")]


def test_the_envelope_is_measured_in_the_table() -> None:
    page = (ROOT / "docs" / "envelope.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([a-z_]+)(?:=([-0-9.,]+))? \| (\w+) \| \d+ % of \d+ \|", page, re.MULTILINE)
    sequences = [name for fault, _, name in rows if fault == "none"]
    assert len(sequences) >= 2
    assert [name for _, _, name in rows] == sequences * (len(rows) // len(sequences))
    both_sides = {re.sub("_(left|right)$", "", name) for name in STRENGTHS}
    assert {fault for fault, strength, _ in rows if strength} == both_sides


def test_every_fault_with_a_strength_is_documented() -> None:
    page = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    cells = re.findall(r"^\| (`.*?`) \|", page, re.MULTILINE)
    described = {name for cell in cells for name in re.findall("`(.*?)`", cell)}
    assert {re.sub("_(left|right)$", "", name) for name in STRENGTHS} <= described


def test_files_named_in_the_algorithm_exist() -> None:
    headings = [line for line in ALGORITHM.splitlines() if line.startswith("## ") and "`" in line]
    names = [name for line in headings for name in re.findall(r"`([^`]+)`", line)]
    folder = ROOT
    for name in names:
        candidates = [ROOT / name, ROOT / "python" / "rvdnav" / name, folder / name]
        found = [path for path in candidates if path.exists()]
        assert found, name
        folder = found[0].parent
    assert len(names) > 15
