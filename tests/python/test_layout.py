"""The parts of the package import downward only, as CONTRIBUTING.md draws them; the fuzzing reaches all of the ABI."""

from __future__ import annotations

import ast
import itertools
import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python" / "rvdnav"


def parts_imported(file: Path) -> set[str]:
    """First names below rvdnav that a module imports from, also within its functions."""
    imports = [node for node in ast.walk(ast.parse(file.read_text("utf-8"))) if isinstance(node, ast.ImportFrom)]
    names = [(node.module or "").split(".") for node in imports]
    return {name[1] for name in names if name[0] == "rvdnav" and len(name) > 1}


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """Each part's name and the parts that it imports from."""
    graph: dict[str, set[str]] = {}
    for file in PACKAGE.rglob("*.py"):
        part = file.relative_to(PACKAGE).parts[0].removesuffix(".py")
        graph.setdefault(part, set()).update(parts_imported(file) - {part})
    return graph


def test_parts_import_in_no_circle(imports: dict[str, set[str]]) -> None:
    assert imports["navigator"] >= {"core", "pose"}
    TopologicalSorter(imports).prepare()  # raises CycleError


def test_parts_import_downward_as_documented(imports: dict[str, set[str]]) -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8").partition("Parts import downward only:")[2]
    drawn = "".join(itertools.takewhile(lambda line: line.startswith("    "), text.strip("\n").splitlines()))
    floors = [set(re.findall(r"\w+", floor)) for floor in drawn.split("→")]
    assert set.union(*floors) <= imports.keys()
    for upper, lower in itertools.combinations(floors, 2):
        for part in lower:
            assert not imports[part] & upper, part


def test_the_fuzzing_harness_calls_every_function_of_the_abi() -> None:
    header = (ROOT / "include" / "rvdnav" / "rvdnav.h").read_text("utf-8")
    functions = set(re.findall(r"^RVDNAV_API [\w *]*?\*? ?(rvdnav_\w+)\(", header, re.MULTILINE))
    assert len(functions) > 30
    calls = "".join(file.read_text("utf-8") for file in (ROOT / "tests" / "fuzz").glob("*.cpp"))
    assert functions <= set(re.findall(r"\b(rvdnav_\w+)", calls))
