"""Every reader of files with every kind of damage: a value or one printable line, in bounded time and memory."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from mutations import LARGE, SAME, WHOLE, damaged, mutated
from readers import Reader, make_readers
from rvdnav.cli.app import execute
from rvdnav.rig import load_rig

NAMES = (
    *("camchain", "rig", "target", "scenario", "plan", "csv", "tum", "solutions", "poses"),
    *("sensor", "box memory", "box frames"),
    *("box solutions", "box digests", "opencv yaml", "opencv xml", "opencv json", "list xml", "list yaml"),
    *("image png", "image jpg", "image tif", "image bmp", "image pgm", "image deep.png", "image deep.tif"),
    *("image deep.pgm", "image colour.png", "image colour.jpg", "image colour.tif", "image plain.pgm"),
)
TEXTS = tuple(name for name in NAMES if not name.startswith("image"))
CASES = Path(__file__).resolve().parents[2].parent / "shared" / "cases" / "fuzz"
"""Files that were at fault once, in a checkout that has them beside it."""


@pytest.fixture(scope="module")
def readers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Reader]:
    made = make_readers(tmp_path_factory.mktemp("readers"))
    assert set(made) == set(NAMES)
    return made


@pytest.mark.parametrize("name", NAMES)
def test_the_good_file_is_read(readers: dict[str, Reader], name: str) -> None:
    assert readers[name].outcome(readers[name].good) == ""


@pytest.mark.parametrize("kind", SAME)
@pytest.mark.parametrize("name", TEXTS)
def test_what_editors_do_to_a_text_changes_nothing(readers: dict[str, Reader], name: str, kind: str) -> None:
    assert readers[name].outcome(SAME[kind](readers[name].good)) == ""


@pytest.mark.parametrize("name", ["camchain", "rig", "target", "scenario", "plan"])
def test_opencv_s_header_is_read(readers: dict[str, Reader], name: str) -> None:
    assert readers[name].outcome(b"%YAML:1.0\n---\n" + readers[name].good) == ""


@pytest.mark.parametrize("name", NAMES)
def test_contents_of_something_else(readers: dict[str, Reader], name: str) -> None:
    for kind, data in WHOLE.items():
        message = readers[name].outcome(data)
        assert message or (name in ("tum", "box digests") and kind in ("empty", "newline")), kind


@pytest.mark.parametrize("name", ["camchain", "csv", "tum", "solutions", "box memory", "image plain.pgm"])
def test_contents_of_the_largest_size(readers: dict[str, Reader], name: str) -> None:
    for kind, data in LARGE.items():
        assert readers[name].outcome(data) or (name, kind) == ("tum", "too large"), kind  # comments alone


@pytest.mark.parametrize("name", NAMES)
def test_damage_of_every_kind(readers: dict[str, Reader], name: str) -> None:
    kinds = list(damaged(readers[name].good))
    if name.startswith("box"):  # where each takes a tenth of a second
        kinds = kinds[::4]
    refused = sum(readers[name].outcome(data) != "" for _, data in kinds)
    assert refused > len(kinds) // 10


@pytest.mark.parametrize("name", NAMES)
def test_random_damage(readers: dict[str, Reader], name: str) -> None:
    rng = random.Random(name)
    for _ in range(5 if name.startswith("box") else 40):
        readers[name].outcome(mutated(readers[name].good, rng))


@pytest.mark.parametrize("name", NAMES)
def test_a_pipe_a_device_and_a_folder_are_no_files(readers: dict[str, Reader], name: str) -> None:
    reader = readers[name]
    path = reader.folder / reader.file
    makers = (os.mkfifo, lambda place: place.symlink_to("/dev/zero"), os.mkdir, lambda place: place.symlink_to(place))
    for make in makers:
        path.unlink(missing_ok=True)
        make(path)
        if name not in ("box memory", "box frames", "box solutions") or path.is_file():  # no digest of these
            assert reader.outcome_now()
        path.rmdir() if path.is_dir() else path.unlink()


@pytest.mark.parametrize(
    ("name", "old", "new", "meant"),
    [
        ("camchain", "cam1:", "cma1:", "cam1"),
        ("camchain", "T_cn_cnm1:", "T_cn_cmn1:", "T_cn_cnm1"),
        ("camchain", "distortion_coeffs:", "distortion_coefs:", "distortion_coeffs"),
        ("rig", "T_world_cam1:", "T_wolrd_cam1:", "T_world_cam1"),
        ("target", "bars:", "bras:", "bars"),
        ("target", "bar_thickness:", "bar_thicknes:", "bar_thickness"),
        ("target", "outer:", "otuer:", "outer"),
        ("scenario", "lights:", "light:", "lights"),
        ("scenario", "end:", "ends:", "end"),
        ("plan", "seeds:", "seed:", "seeds"),
        ("plan", "count:", "counts:", "count"),
    ],
)
def test_a_mistyped_key_is_named(readers: dict[str, Reader], name: str, old: str, new: str, meant: str) -> None:
    good = readers[name].good
    assert old.encode() in good
    message = readers[name].outcome(good.replace(old.encode(), new.encode(), 1))
    assert f"is not known; did you mean {meant}?" in message


def test_keys_of_others_in_a_camchain_are_told(tmp_path: Path, readers: dict[str, Reader]) -> None:
    good = readers["camchain"].good.decode()
    for more in ("cam_overlaps: [1]", "timeshift_cam_imu: 0.002", "colour: grey"):
        good = good.replace("cam1:\n", f"cam1:\n  {more}\n")
    (tmp_path / "camchain.yaml").write_text(good)
    notices: list[str] = []
    load_rig(tmp_path, notices)
    assert notices == ["camchain.yaml: cam1.colour is not known and not read"]


@pytest.mark.parametrize("path", sorted(CASES.glob("py_*")), ids=lambda path: path.name)
def test_files_that_were_at_fault_once(readers: dict[str, Reader], path: Path) -> None:
    kind = path.name.split("_")[1:-1]
    name = {"opencv": "opencv yaml", "list": "list xml"}.get(kind[0], " ".join(kind))
    readers[name].outcome(path.read_bytes())


@pytest.mark.parametrize("file", ["list_segv.raw", "opencv_double_free.raw"])
@pytest.mark.parametrize("name", ["opencv xml", "list xml"])
def test_files_that_crashed_opencv_once(readers: dict[str, Reader], file: str, name: str) -> None:
    if not (CASES / file).exists():
        pytest.skip("no such file beside this checkout")
    assert readers[name].outcome((CASES / file).read_bytes())


def test_the_harness_runs() -> None:
    script = Path(__file__).resolve().parents[1] / "fuzz" / "loaders.py"
    done = subprocess.run(
        [sys.executable, script, "0.03", "1"], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith(" files, 0 findings\n")


@pytest.mark.parametrize(
    "words",
    [
        *(["run"], ["budget"], ["replay"], ["simulate"], ["campaign"], ["evaluate", "examples/approach"]),
        *(["calibrate", "--board", "7x5", "--square", "30mm"], ["experiment", "paper", "--run"], ["reconstruct"]),
    ],
    ids=lambda words: words[0],
)
@pytest.mark.parametrize("name", ["x" * 5000, "nowhere\x1b]0;x\x07"])
def test_a_name_that_can_be_no_file_s(
    words: list[str], name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = [] if words[0] in ("replay", "evaluate") else ["--out", str(tmp_path / "out.ply")]
    assert execute([*words, name, *out]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.isprintable()
    assert len(line) < 450
