"""The report: what its figures show, that it stands alone, and that it is reproducible."""

import base64
import hashlib
import json
import re
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
from rvdnav.evaluation import evaluate
from rvdnav.report import draw_picture, edge_mask, notable_frames, provenance, write_report
from rvdnav.report.health import stage_figure, timeline_figure
from rvdnav.report.lost import lost_table
from rvdnav.report.motion import error_figures, pose_figures
from rvdnav.report.verdict import run_verdict
from rvdnav.rig import load_rig
from rvdnav.sequence import Frame, Image, open_sequence
from rvdnav.solution import Mode, Reason, Solution, State
from rvdnav.target import load_target
from solutions import SIGMAS, a_run, transform, true_poses

START = 1_700_000_000_000_000_000
TIMES = [START + 125_000_000 * i for i in range(9)]


def traces(figures, name):
    """Those of that name, by figure."""
    return [trace for figure in figures for trace in figure.data if trace.name == name]


def test_the_pose_figures_show_published_true_and_predicted_poses():
    run = a_run(TIMES)
    truth = true_poses(TIMES)
    titles, figures = zip(*pose_figures(run, truth), strict=True)
    assert titles == ("x_W, m", "φ, °", "y_W, m", "θ, °", "z_W, m", "ψ, °")
    x_true, x_measured, x_predicted = (
        traces(figures, name)[0] for name in ("true", "measured", "predicted (not published)")
    )
    np.testing.assert_allclose(x_true.x, 0.125 * np.arange(9), atol=1e-9)
    np.testing.assert_allclose(x_true.y, 1.4 - 0.04 * np.arange(9))
    np.testing.assert_array_equal(np.isfinite(x_measured.y), [s.published for s in run])
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(x_predicted.y)), [5])
    phi = traces(figures, "measured")[1]
    assert phi.y[3] == pytest.approx(np.degrees(run[3].euler.phi))
    _, untrue = zip(*pose_figures(run, None), strict=True)
    assert not traces(untrue, "true")


def test_the_band_is_three_sigma_and_breaks_where_nothing_was_published():
    run, truth = a_run(TIMES), true_poses(TIMES)
    evaluation = evaluate(run, truth)
    titles, figures = zip(*error_figures(run, truth), strict=True)
    assert titles == ("δx_W, mm", "about x_W, °", "δy_W, mm", "about y_W, °", "δz_W, mm", "about z_W, °")
    bands = traces(figures, "± 3σ")
    scaled = np.concatenate([3e3 * SIGMAS[:3], np.degrees(3 * SIGMAS[3:])])[[0, 3, 1, 4, 2, 5]]
    assert [max(y for y in band.y if y is not None) for band in bands] == pytest.approx(scaled)
    assert list(bands[0].y).count(None) == 2  # frames 1-4 and 6-8
    errors = traces(figures, "measured − true")
    shown = [np.array(trace.y)[np.isfinite(trace.y)] for trace in errors]
    np.testing.assert_allclose(shown[2], 1e3 * evaluation.components[:, 1])
    np.testing.assert_allclose(shown[5], np.degrees(evaluation.components[:, 5]))
    _, unjudged = zip(*error_figures(run, None), strict=True)
    assert not traces(unjudged, "measured − true")


def test_a_coasting_target_has_a_band_of_its_own_that_does_not_flatten_the_others():
    run, truth = a_run(TIMES), true_poses(TIMES)
    coasting = next(i for i, s in enumerate(run) if s.state is State.COASTING)
    run[coasting] = attrs.evolve(run[coasting], covariance=np.diag(np.full(6, 0.04)))
    _, figures = zip(*error_figures(run, truth), strict=True)
    band, measured = (traces(figures, name)[0] for name in ("± 3σ, coasting", "± 3σ"))
    assert [y for y in band.y if y is not None] == pytest.approx([600.0, -600.0])
    predicted = traces(figures, "predicted − true")[0]
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(predicted.y)), [coasting])
    largest = max(y for y in measured.y if y is not None)
    assert largest < figures[0].layout.yaxis.range[1] < 2.0 * largest


def test_the_timeline_shows_every_frame_in_its_state():
    run = a_run(TIMES)
    shown = {trace.name: len(trace.x) for trace in timeline_figure(run).data}
    assert shown == {"SEARCHING": 1, "TRACKING, STEREO": 7, "COASTING": 1}
    coasting = traces([timeline_figure(run)], "COASTING")[0]
    assert coasting.customdata[0] == "<br>LEFT_UNUSABLE<br>TOO_FEW_LINES"


def test_stage_bars_are_medians_without_the_total():
    bars = stage_figure(a_run(TIMES)).data[0]
    assert list(bars.y) == ["edges", "refine"]
    assert list(bars.x) == pytest.approx([2.0, 8.0])


def write(path, run, truth=None, pictures=()):
    evaluation = None if truth is None else evaluate(run, truth)
    write_report(path, "a <run>", run, truth=truth, evaluation=evaluation, pictures=pictures)
    return path.read_text(encoding="utf-8")


def test_the_page_needs_no_more_than_the_library_beside_it_and_has_every_part(tmp_path):
    body = write(tmp_path / "report.html", a_run(TIMES), true_poses(TIMES))
    assert re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)([^"']*)""", body) == ["plotly.min.js"]
    assert "plotly.js v" in (tmp_path / "plotly.min.js").read_text(encoding="utf-8")[:200]
    assert "a &lt;run&gt;" in body
    for part in ("Errors by range", "Position and attitude", "Errors and 3σ band", "State", "Time per stage"):
        assert f"<h2>{part}</h2>" in body
    assert "77.8 %" in body  # 7 of 9
    assert "100.0 fps" in body


def test_the_page_works_without_truth_and_without_any_pose(tmp_path):
    body = write(tmp_path / "a.html", a_run(TIMES))
    assert "Uncertainty (3σ)" in body
    assert "Errors by range" not in body
    lost = [Solution(timestamp_ns=START, state=State.LOST)]
    assert "0.0 %" in write(tmp_path / "b.html", lost)


def test_lost_targets_are_listed_with_their_black_boxes(tmp_path):
    run = a_run(TIMES)
    refused = {"state": State.COASTING, "reasons": {Reason.LEFT_UNUSABLE}}
    run[6] = Solution(timestamp_ns=TIMES[6], predicted_T_world_target=np.eye(4), **refused)
    run[7] = Solution(timestamp_ns=TIMES[7], state=State.LOST, reasons={Reason.NO_TARGET})
    body = lost_table(run, {TIMES[7]: "blackbox/7"})
    assert re.findall("<td>(.*?)</td>", body) == [
        "0.875 s",
        "0.375 s",
        "3",
        "LEFT_UNUSABLE, NO_TARGET, TOO_FEW_LINES",
        '<a href="blackbox/7/">blackbox/7</a>',
    ]
    assert "<td>–</td>" in lost_table(run, {})
    assert lost_table(run[:7], {}) == ""
    write_report(tmp_path / "a.html", "x", run, truth=None, evaluation=None, black_boxes={TIMES[7]: "blackbox/7"})
    assert body in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_two_runs_give_the_same_page(tmp_path):
    first, second = (write(tmp_path / f"{i}.html", a_run(TIMES), true_poses(TIMES)) for i in range(2))
    assert first == second


def test_the_range_table_shows_the_evaluation(tmp_path):
    run, truth = a_run(TIMES), true_poses(TIMES)
    evaluation = evaluate(run, truth)
    body = write(tmp_path / "report.html", run, truth)
    cells = re.findall(r"<td>([^<]*)</td>", body)
    at = cells.index("all")
    position = evaluation.overall.position_m
    assert cells[at + 1 : at + 4] == ["9", "77.8 %", f"{position.median * 1e3:.3f}"]


def test_figures_are_valid_json_in_the_page(tmp_path):
    body = write(tmp_path / "report.html", a_run(TIMES), true_poses(TIMES))
    for name in ("pose-0", "pose-5", "errors-0", "timeline", "stages"):
        data = re.search(rf'Plotly\.newPlot\(\s*"figure-{name}",\s*(\[.*?\]),\s*\{{', body, re.DOTALL)
        assert json.loads(data.group(1))


def test_the_verdict_begins_with_what_is_worst():
    run, truth = a_run(TIMES), true_poses(TIMES)
    whole = [s for s in run if s.published]
    assert run_verdict(whole, evaluate(whole, truth)).level == "good"
    assert run_verdict(whole, None).text == "Every frame has a pose."
    some = run_verdict(run, evaluate(run, truth))
    assert some.level == "fair"
    assert some.text.startswith("7 of 9 frames have a pose, and the target was never lost. Refused: ")
    run[5] = Solution(timestamp_ns=TIMES[5], state=State.LOST, reasons={Reason.NO_TARGET, Reason.MOTION})
    assert run_verdict(run, None).text.startswith("The target was lost once at 0.625 s; 7 of 9 frames have a pose.")
    assert "NO_TARGET (1)" in run_verdict(run, None).text
    wrong = run_verdict(whole, evaluate(whole, Shifted(truth)))
    assert wrong.level == "bad"
    assert wrong.text.startswith("7 of 7 published poses are wrong.")
    assert run_verdict(run[5:6], None).text.startswith("No pose was published in 1 frames.")


class Shifted:
    """True poses that lie 50 mm beside the given ones."""

    def __init__(self, truth):
        self._truth = truth

    def at(self, timestamp_ns):
        T = self._truth.at(timestamp_ns).copy()
        T[1, 3] += 0.05
        return T


def test_the_frames_shown_are_the_worst_and_the_refused_ones():
    run, truth = a_run(TIMES), true_poses(TIMES)
    evaluation = evaluate(run, truth)
    shown = notable_frames(run, evaluation)
    published = [i for i, s in enumerate(run) if s.published]
    worst = published[int(evaluation.position_m.argmax())]
    assert shown[worst] == f"largest error, {1e3 * evaluation.position_m.max():.2f} mm"
    assert {published[0], published[-1], worst} | {i for i, s in enumerate(run) if not s.published} == set(shown)
    assert list(shown) == sorted(shown)
    assert "largest σ" in " ".join(notable_frames(run, None).values())
    blind = [Solution(timestamp_ns=ns, state=State.SEARCHING, reasons={Reason.NO_TARGET}) for ns in TIMES]
    assert notable_frames(blind, None) == {0: "refused, as 8 more"}


def test_a_report_says_what_made_it(make_sequence, tmp_path):
    folder = make_sequence()
    facts = dict(provenance(["run", "some where", "--set", "max_speed=2"], folder))
    assert facts["command"] == "rvdnav run 'some where' --set max_speed=2"
    digest = hashlib.sha256((folder / "target.yaml").read_bytes()).hexdigest()
    assert facts["target.yaml"] == f"SHA-256 {digest}"
    run = a_run(TIMES)
    write_report(tmp_path / "a.html", "x", run, truth=None, evaluation=None, facts=list(facts.items()))
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert digest in page
    assert "some where" in page


@pytest.fixture
def scene(make_sequence):
    folder = make_sequence()
    return load_rig(folder), load_target(folder / "target.yaml")


def no_edges(camera, image):
    return np.zeros(image.shape, bool)


def published(T, view_lines):
    return Solution(
        timestamp_ns=START,
        state=State.TRACKING,
        mode=Mode.STEREO,
        T_world_target=T,
        covariance=np.eye(6) * 1e-6,
        view_lines=view_lines,
    )


def decoded(picture):
    encoded = base64.b64decode(picture.uri.removeprefix("data:image/jpeg;base64,"))
    return cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR).astype(int)


@pytest.mark.parametrize("camera", [0, 1])
def test_the_target_is_drawn_where_the_camera_sees_it(scene, camera):
    rig, target = scene
    T = transform([0.6, 0.0, 0.0])
    image = Image(pixels=np.zeros((58, 70), np.uint8), timestamp_ns=START)
    frame = Frame(START, image if camera == 0 else None, image)
    canvas = decoded(draw_picture(frame, published(T, {}), rig, target, no_edges))
    green = (canvas[:, :, 1] > 90) & (canvas[:, :, 2] < 140)
    # cv2.projectPoints as the independent camera; the picture is enlarged twice.
    T_cam_world = np.linalg.inv(rig.T_world_cam[camera])
    model = rig.cameras[camera]
    edge = target.bracket.edge_points[0]
    points = np.linspace(edge[0], edge[1], 9)[1:-1] @ T[:3, :3].T + T[:3, 3]
    seen, _ = cv2.projectPoints(
        points, cv2.Rodrigues(T_cam_world[:3, :3])[0], T_cam_world[:3, 3], model.K, np.asarray(model.distortion)
    )
    at = np.round((seen[:, 0] + 0.5) * 2 - 0.5).astype(int)
    inside = (at >= 1).all(axis=1) & (at[:, 0] < 138) & (at[:, 1] < 114)
    assert inside.sum() >= 3
    for u, v in at[inside]:
        assert green[v - 1 : v + 2, u - 1 : u + 2].any()
    assert green.mean() < 0.25


def test_edges_and_lines_are_drawn_and_the_image_is_kept(scene):
    rig, target = scene
    pixels = np.full((58, 70), 100, np.uint8)
    frame = Frame(START, Image(pixels=pixels, timestamp_ns=START), None)
    edges = np.zeros((58, 70), bool)
    edges[50, 10:60] = True
    segment = [[-15.0, -10.0, 15.0, -10.0]]
    seen = []
    picture = draw_picture(
        frame, published(transform([0.6, 0, 0]), {0: segment}), rig, target, lambda c, i: seen.append(c) or edges
    )
    canvas = decoded(picture)
    assert seen == [0]
    assert canvas.shape == (116, 140, 3)
    row = canvas[101, 30:110]
    assert (row[:, 0] > row[:, 2] + 60).all()  # bluish
    u, v = np.round((rig.rect_to_raw(0, np.array([0.0, -10.0])) + 0.5) * 2 - 0.5).astype(int)
    patch = canvas[v - 1 : v + 2, u]
    assert (patch[:, 2] > patch[:, 0] + 60).any()  # yellowish
    assert canvas[112, 2] == pytest.approx([80, 80, 80], abs=6)


def test_a_frame_without_images_gives_no_picture(scene):
    rig, target = scene
    lost = Solution(timestamp_ns=START, state=State.LOST)
    assert draw_picture(Frame(START, None, None), lost, rig, target, no_edges) is None
    image = Image(pixels=np.zeros((58, 70), np.uint8), timestamp_ns=START)
    assert draw_picture(Frame(START, None, image), lost, rig, target, no_edges).camera == 1


def test_the_edges_are_those_of_the_core():
    core_module = pytest.importorskip("rvdnav.core")
    sequence = open_sequence(Path(__file__).resolve().parents[2] / "examples" / "approach")
    core = core_module.Core(sequence.rig, sequence.target)
    image = np.full((576, 704), 40, np.uint8)
    image[200:300, 150:450] = 180
    mask = edge_mask(core, 1, image)
    assert mask.shape == image.shape
    rows, columns = np.nonzero(mask)
    on_outline = (np.minimum(abs(rows - 199.5), abs(rows - 299.5)) < 2) | (
        np.minimum(abs(columns - 149.5), abs(columns - 449.5)) < 2
    )
    assert on_outline.all()
    assert 700 < mask.sum() < 900  # single-pixel, all around: 800
