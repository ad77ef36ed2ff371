"""The binding: what goes into the core and comes out, held against the rig's Python model and plain arithmetic."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from rvdnav.core import LIBRARY_PATH, SEEN_EDGE, WINDOW, Core, unpack_edges
from rvdnav.core.library import ffi, lib, load
from rvdnav.errors import CoreError
from rvdnav.pose import triangulate
from rvdnav.sequence import open_sequence

STARTS = [0, 4, 2, 6]  # the outer edges that start in P1, P2, P3, P4: l1, l3, l2, l4
EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"


@pytest.fixture(scope="module")
def sequence():
    return open_sequence(EXAMPLE)


@pytest.fixture(scope="module")
def frame(sequence):
    """A frame at about 0.9 m."""
    return list(sequence)[12]


@pytest.fixture(scope="module")
def core(sequence):
    return Core(sequence.rig, sequence.target)


@pytest.fixture(scope="module")
def edges(sequence, frame):
    """The eight edges' true ends (8, 2, 3) in W."""
    T = sequence.truth.at(frame.timestamp_ns)
    return sequence.target.bracket.edge_points @ T[:3, :3].T + T[:3, 3]


def true_windows(rig, camera, edges):
    """Windows around the edges' exact projection."""
    ends = rig.project_rect(camera, edges)
    windows = np.zeros(len(edges), WINDOW)
    for i, (a, b) in enumerate(ends):
        dx, dy = b - a
        theta = np.arctan2(dx, -dy)
        theta = (theta + np.pi / 4) % np.pi - np.pi / 4
        normal = np.array([np.cos(theta), np.sin(theta)])
        along = np.array([-normal[1], normal[0]])
        t = sorted((along @ a, along @ b))
        windows[i] = (i, 0, normal @ a, theta, 3.0, 0.03, t[0], t[1])
    return windows


def test_smoothing_is_the_binomial(core, frame):
    image = frame.left.pixels
    padded = np.pad(image.astype(int), 1, mode="edge")
    h, w = image.shape
    rows = sum(k * padded[i : i + h] for i, k in enumerate((1, 2, 1)))
    expected = (sum(k * rows[:, i : i + w] for i, k in enumerate((1, 2, 1))) + 8) >> 4
    assert np.array_equal(core.smooth(0, image), expected)


def test_an_image_with_a_stride_is_the_same_image(core, frame):
    image = frame.left.pixels
    wide = np.full((image.shape[0], image.shape[1] + 9), 255, np.uint8)
    wide[:, : image.shape[1]] = image
    expected = core.smooth(0, image)
    assert np.array_equal(core.smooth(0, wide[:, : image.shape[1]]), expected)
    assert np.array_equal(core.smooth(0, np.asfortranarray(image)), expected)


def test_edge_bits_unpack_to_pixels():
    bits = np.array([[0b1, 0x80000000, 0b10]], np.uint32)
    mask = unpack_edges(bits, 70)
    assert mask.shape == (1, 70)
    assert list(np.flatnonzero(mask[0])) == [0, 63, 65]


def test_edgels_lie_where_the_lens_puts_them(core, sequence, frame):
    bits, direction = core.detect_edges(1, core.smooth(1, frame.right.pixels))
    bits = core.thin(1, core.filter_edges(1, bits))
    edgels = core.rectify_edges(1, bits, direction)
    v, u = np.nonzero(unpack_edges(bits, core.width))
    assert len(edgels) == len(u) > 5000
    exact = sequence.rig.raw_to_rect(1, np.column_stack([u, v]).astype(float))
    measured = np.column_stack([edgels["x_q5"], edgels["y_q5"]]) / 32
    assert np.abs(measured - exact).max() < 0.05


def test_stages_in_a_row_are_the_frame_call(core, frame):
    """Counts of the frame call equal those of the stages called one by one."""
    result = core.process(frame.left.pixels, frame.right.pixels)
    for camera, (image, view) in enumerate(zip((frame.left, frame.right), result.views, strict=True)):
        bits, direction = core.detect_edges(camera, core.smooth(camera, image.pixels))
        bits = core.thin(camera, core.filter_edges(camera, bits))
        edgels = core.rectify_edges(camera, bits, direction)
        peaks = core.hough_peaks(core.hough_vote(edgels))[: core.config.max_peaks]
        segments = core.extract_segments(camera, edgels, peaks)[: core.config.max_segments]
        bars = core.find_bars(camera, segments)[: core.config.max_bars]
        assert view.edge_count == len(edgels)
        assert view.peak_count == len(peaks)
        assert view.segment_count == len(segments)
        assert view.bar_count == len(bars)


def test_the_bracket_is_acquired(core, sequence, frame):
    result = core.process(frame.left.pixels, frame.right.pixels)
    T = sequence.truth.at(frame.timestamp_ns)
    assert result.bracket.found
    assert np.linalg.norm(result.bracket.T_world_target[:3, 3] - T[:3, 3]) < 0.02
    assert np.allclose(result.bracket.T_world_target[:3, :3], T[:3, :3], atol=0.05)
    assert result.stage_ns.keys() == result.views[0].stage_ns.keys() >= {"smooth", "hough", "epipolar"}
    assert result.views[0].stage_ns["hough"] > 0


def test_windows_track_the_lines(core, sequence, frame, edges):
    windows = [true_windows(sequence.rig, camera, edges) for camera in (0, 1)]
    result = core.process(frame.left.pixels, frame.right.pixels, *windows)
    assert result.bracket is None
    for camera, view in enumerate(result.views):
        lines = view.lines[view.line_found]
        assert len(lines) >= 6
        expected = windows[camera][view.line_found]
        assert np.abs(lines["rho"] - expected["rho"]).max() < 1.5
        assert view.apexes.shape == (8, 2)
        ends = sequence.rig.project_rect(camera, edges[STARTS, 0])
        found = view.apex_found[:4]
        assert np.all(np.linalg.norm(view.apexes[:4] - ends, axis=1)[found] < 3.0)
    found = result.apex_found[:4]
    points = edges[STARTS, 0][found]
    assert np.linalg.norm(result.apexes_W[:4][found] - points, axis=1).max(initial=0.0) < 0.02


def test_windows_may_be_tuples(core, sequence, frame, edges):
    windows = [true_windows(sequence.rig, camera, edges) for camera in (0, 1)]
    a = core.process(frame.left.pixels, frame.right.pixels, *windows)
    b = core.process(frame.left.pixels, frame.right.pixels, *([tuple(w) for w in side] for side in windows))
    assert a.views[0].lines.tobytes() == b.views[0].lines.tobytes()


def test_one_image_gives_one_view(core, frame):
    result = core.process(None, frame.right.pixels)
    assert result.views[0] is None
    assert result.views[1].edge_count > 0


def test_edge_samples_lie_on_the_true_edges(core, sequence, frame, edges):
    for camera, image in enumerate((frame.left, frame.right)):
        ends = sequence.rig.project_rect(camera, edges)
        model = ends.reshape(8, 4)
        samples = core.measure_edges(camera, image.pixels, model, 0, half_width=4.0, step=2.0)
        assert set(samples["edge"]) == set(range(8))
        assert np.median(np.abs(samples["offset"])) < 0.3
        a, b = ends[samples["edge"], 0], ends[samples["edge"], 1]
        foot = a + samples["fraction"][:, None] * (b - a)
        normal = np.column_stack([samples["nx"], samples["ny"]])
        found = np.column_stack([samples["x"], samples["y"]])
        assert np.allclose(found, foot + samples["offset"][:, None] * normal, atol=1e-9)
        assert np.allclose(np.sum(normal * (b - a), axis=1), 0.0, atol=1e-6)


def test_seen_edges_are_measured_where_the_rig_projects_them(core, sequence, frame, edges):
    """As by measure_edges between the ends that the rig's Python model gives, both views in one call."""
    rig, images = sequence.rig, (frame.left.pixels, frame.right.pixels)
    offset = np.linspace(-1.0, 1.0, 32).reshape(2, 8, 2)
    seen = np.zeros(16, SEEN_EDGE)
    seen["camera"], seen["blur"], seen["offset"] = np.repeat([0, 1], 8), 0.8, offset.reshape(16, 2)
    for camera in (0, 1):
        seen["ends"][8 * camera :][:8] = (edges - rig.T_world_cam[camera][:3, 3]) @ rig.R_world_rect
    found, coverage = core.sample_edges(images, seen, 2.5)
    assert coverage["placed"].all()
    for camera, image in enumerate(images):
        ends = rig.project_rect(camera, edges)
        span = ends[:, 1] - ends[:, 0]
        normal = np.column_stack([-span[:, 1], span[:, 0]]) / np.linalg.norm(span, axis=1)[:, None]
        ends += offset[camera][:, :, None] * normal[:, None]
        span = ends[:, 1] - ends[:, 0]
        length = np.linalg.norm(span, axis=1)
        margin = (3.0 / length)[:, None] * span
        step = max(1.0, float(length.max()) / 80.0)
        model = np.concatenate([ends[:, 0] + margin, ends[:, 1] - margin], axis=1)
        expected = core.measure_edges(camera, image, model, 0, 2.5, step, blur_sigma=0.8)
        own = found[found["edge"] // 8 == camera]
        assert np.array_equal(own["edge"] % 8, expected["edge"])
        for name in ("fraction", "x", "y", "sigma"):
            np.testing.assert_allclose(own[name], expected[name], atol=1e-7)
        fraction = (np.arange(80) + 0.5) / 80
        middles = model[:, None, :2] + fraction[:, None] * (model[:, None, 2:] - model[:, None, :2])
        on_image = rig.on_image(rig.rect_to_raw(camera, middles)).mean(axis=1)
        profiles = coverage["profiles"][8 * camera :][:8]
        assert np.allclose(profiles, on_image * ((length - 6.0) / step).astype(int), atol=2.0)
    short = core.sample_edges(images, seen, 2.5, shortest=1e3)
    assert len(short[0]) == 0
    assert not short[1]["placed"].any()


def test_triangulation_is_the_papers(core, sequence):
    p_W = np.array([[1.2, 0.05, 0.1], [0.4, -0.1, 0.0], [0.8, 0.0, 0.06]])
    rig = sequence.rig
    left, right = (rig.project_rect(camera, p_W) for camera in (0, 1))
    assert np.allclose(core.triangulate(left, right), p_W, atol=1e-9)
    noisy = left + np.array([[0.3, -0.2], [0.1, 0.4], [-0.2, 0.1]])
    expected = triangulate(rig.projection_matrix(0), rig.projection_matrix(1), noisy, right)
    assert np.allclose(core.triangulate(noisy, right), expected, atol=1e-9)
    assert core.triangulate(np.empty((0, 2)), np.empty((0, 2))).shape == (0, 3)


def test_correlation_finds_points_of_the_bars(core, sequence, frame, edges):
    """Points on the face of l1, which crosses the rows; l3 and l4 run along them and look alike everywhere."""
    start, end = edges[:2].mean(axis=0)
    points = start + np.linspace(0.4, 0.9, 6)[:, None] * (end - start)
    left, right = (sequence.rig.project_rect(camera, points) for camera in (0, 1))
    matches = core.correlate(frame.left.pixels, frame.right.pixels, left)
    assert np.array_equal(matches["x"], left[:, 0])
    accepted = matches["accepted"] != 0
    assert accepted.sum() >= 5
    disparity = (left - right)[:, 0]
    assert np.abs(matches["disparity"] - disparity)[accepted].max() < 0.3


def test_work_limits_are_reported(sequence, frame):
    limits = {"edgels": {"max_edgels": 1000}, "peaks": {"max_peaks": 10}, "segments": {"max_segments": 20}}
    for name, setting in limits.items():
        result = Core(sequence.rig, sequence.target, **setting).process(frame.left.pixels, frame.right.pixels)
        assert name in result.views[0].limits
        assert name in result.limits


def test_what_follows_from_the_rig_is_in_the_settings_in_use(sequence):
    core = Core(sequence.rig)
    corners = [(u, v) for u in (0.0, core.width - 1.0) for v in (0.0, core.height - 1.0)]
    reach = max(np.linalg.norm(sequence.rig.raw_to_rect(camera, corners), axis=1).max() for camera in (0, 1))
    assert 2 * reach < core.config.hough_rho_bins < 2 * reach + 50
    assert core.config.max_edgels == 65536


def test_too_few_cells_over_rho_are_a_limit(sequence, frame):
    assert "rho" not in Core(sequence.rig).process(frame.left.pixels, None).limits
    assert "rho" in Core(sequence.rig, hough_rho_bins=512).process(frame.left.pixels, None).limits


def test_a_target_set_in_place_is_as_one_given_at_first(core, sequence, frame):
    images = frame.left.pixels, frame.right.pixels
    changed = Core(sequence.rig)
    assert not changed.process(*images).bracket.found
    changed.set_target(sequence.target)
    found = changed.process(*images).bracket
    assert np.array_equal(found.T_world_target, core.process(*images).bracket.T_world_target)
    changed.set_target(None)
    assert not changed.process(*images).bracket.found


def test_instruction_sets_agree(sequence, frame):
    scalar = Core(sequence.rig, sequence.target, isa="scalar")
    best = Core(sequence.rig, sequence.target)
    assert scalar.isa == "scalar"
    for camera, image in enumerate((frame.left, frame.right)):
        smoothed = scalar.smooth(camera, image.pixels)
        assert np.array_equal(best.smooth(camera, image.pixels), smoothed)
        for a, b in zip(scalar.detect_edges(camera, smoothed), best.detect_edges(camera, smoothed), strict=True):
            assert np.array_equal(a, b)


def test_the_environment_forces_an_instruction_set(sequence, monkeypatch):
    monkeypatch.setenv("RVDNAV_FORCE_ISA", "scalar")
    assert Core(sequence.rig).isa == "scalar"
    monkeypatch.setenv("RVDNAV_FORCE_ISA", "mmx")
    with pytest.raises(CoreError, match="instruction set") as caught:
        Core(sequence.rig)
    assert caught.value.status == lib.RVDNAV_ERROR_ISA


def test_bad_settings_are_refused_by_name(sequence):
    with pytest.raises(TypeError, match="hough_bins"):
        Core(sequence.rig, hough_bins=3)
    with pytest.raises(TypeError, match="mmx"):
        Core(sequence.rig, isa="mmx")
    with pytest.raises(ValueError, match="range_max = 1 is not above range_min = 2"):
        Core(sequence.rig, range_min=2.0, range_max=1.0)
    for setting, message in {
        "range_min": (1e-300, "range_min = 1e-300 is not a number from 0.001 to 10000.0"),
        "max_edgels": (2**40, "max_edgels = 1099511627776 is not a whole number from 0 to 4194304"),
        "max_peaks": (1.5, "max_peaks = 1.5 is not a whole number from 1 to 16384"),
        "blur_sigma": (np.nan, "blur_sigma = nan is not a number from 0.1 to 10.0"),
        "edge_floor": ("six", "edge_floor = 'six' is not a whole number from 1 to 255"),
    }.items():
        with pytest.raises(ValueError, match=re.escape(message[1])):
            Core(sequence.rig, **{setting: message[0]})


def test_bad_arrays_are_refused(core, frame):
    image = frame.left.pixels
    with pytest.raises(CoreError, match="size or stride"):
        core.process(image[:-1], None)
    with pytest.raises(ValueError, match="8-bit grey"):
        core.process(image.astype(np.float32), None)
    with pytest.raises(ValueError, match="8-bit grey"):
        core.smooth(0, np.dstack([image] * 3))
    with pytest.raises(CoreError):
        core.process(None, None)
    with pytest.raises(ValueError, match="uint32"):
        core.thin(0, np.zeros((3, 3), np.uint32))
    with pytest.raises(ValueError, match="shape"):
        core.triangulate(np.zeros((2, 3)), np.zeros((2, 2)))


def test_results_do_not_change_under_the_next_frame(core, frame):
    first = core.process(frame.left.pixels, frame.right.pixels)
    kept = first.views[0].lines.copy()
    core.process(frame.right.pixels, frame.left.pixels)
    assert first.views[0].lines.tobytes() == kept.tobytes()


def test_another_library_is_not_loaded(tmp_path, monkeypatch):
    other = tmp_path / "librvdnav.so"
    other.write_bytes(b"not a library")
    with pytest.raises(ImportError, match="cannot load"):
        load(other)
    shutil.copyfile(LIBRARY_PATH, other)
    assert load(other)[0] is ffi
    monkeypatch.setattr("rvdnav.core.library._struct_names", lambda _: ["rvdnav_rig", "int32_t"])
    with pytest.raises(ImportError, match="int32_t"):
        load(other)
