"""The error budget: its linear parts against exact images, its calibration against OpenCV, its whole against draws."""

from __future__ import annotations

import math

import attrs
import cv2
import numpy as np
import pytest
from drawn_scene import bracket_target, example_rig, wide_rig
from drawn_solid import box_target
from rvdnav import Rig
from rvdnav.budget import Assumptions, Design, cell, check, improvement, parse_requirement, pose_budget, sweep
from rvdnav.budget.board_calibration import CORNER_SIGMA_PX, board_calibration_covariance, board_views
from rvdnav.budget.causes import CALIBRATION, DIMENSIONS, DISPLACEMENT, NOISE, SIDES, TIMING, residual_errors
from rvdnav.budget.levers import changes
from rvdnav.budget.lines import expected_lines, shared_corners
from rvdnav.budget.monte_carlo import Errors, ErrorSource, measured_lines
from rvdnav.errors import InputError
from rvdnav.navigator.edge_model import edge_model
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.pose import PoseError, line_residuals

BRACKET = edge_model(bracket_target())
BOX = edge_model(box_target())


def design(rig: Rig | None = None, **assumptions: float) -> Design:
    return Design(wide_rig() if rig is None else rig, BRACKET, Assumptions(**assumptions))


def one_camera() -> Rig:
    return Rig(wide_rig().cameras[:1], [np.eye(4)])


class Scene:
    """A design at a pose."""

    def __init__(self, known: Design) -> None:
        self.design = known
        self.T = known.pose_at(0.5, math.radians(20.0), 0.7)
        self.expected = expected_lines(known, self.T)
        edges, lines = len(known.model), len(self.expected.lines)
        self.nothing = Errors(np.zeros(22), np.zeros((edges, 2, 3)), np.zeros(6), np.zeros((lines, 9)))
        self.causes = residual_errors(known, self.T, self.expected)

    def residuals(self, **errors: np.ndarray) -> np.ndarray:
        """Of the lines that such errors lead to, at the true pose."""
        drawn = attrs.evolve(self.nothing, **errors)
        believed = self.design.rig.perturbed(drawn.calibration)
        lines = measured_lines(self.design, self.T, self.expected, drawn, believed)
        return line_residuals(self.T, lines, rectified_cameras(believed))[0].ravel()


@pytest.fixture(scope="module", params=["bracket", "box"])
def scene(request: pytest.FixtureRequest) -> Scene:
    known = design(speed=0.3, turn_rate=0.2, timing=1e-3)
    return Scene(known if request.param == "bracket" else attrs.evolve(known, model=BOX, edges=range(len(BOX))))


def test_without_errors_the_true_lines_are_found(scene: Scene) -> None:
    np.testing.assert_allclose(scene.residuals(), 0.0, atol=1e-8)


def test_calibration_changes_the_residuals_as_the_images_say(scene: Scene) -> None:
    covariance = np.asarray(scene.design.rig.calibration_covariance)
    derivatives = scene.design.calibration.residual_derivatives(scene.T, scene.expected.lines).reshape(-1, 22)
    F = scene.causes[CALIBRATION]
    np.testing.assert_allclose(derivatives @ covariance @ derivatives.T, F @ F.T, atol=1e-9)
    for draw in np.random.default_rng(2).multivariate_normal(np.zeros(22), 1e-4 * covariance, 4):
        np.testing.assert_allclose(derivatives @ draw, scene.residuals(calibration=draw), atol=2e-4)


def test_corners_that_differ_change_the_residuals_as_the_images_say(scene: Scene) -> None:
    z = 0.1 * np.random.default_rng(3).standard_normal((8, 3))
    corners = scene.design.assumptions.dimensions * z[shared_corners(scene.design.model.edge_points)]
    # F is for the file's corners minus the true ones, which is the same in distribution.
    expected = -scene.causes[DIMENSIONS] @ z.ravel()
    assert np.abs(expected).max() > 0.005
    np.testing.assert_allclose(expected, scene.residuals(corners=corners), atol=2e-4)


def test_motion_between_the_exposures_changes_the_residuals_of_the_right_view(scene: Scene) -> None:
    z = np.array([0.3, -0.5, 0.4, 0.2, 0.6, -0.7])
    scale = scene.design.assumptions.timing * np.repeat([0.3, 0.2], 3) / math.sqrt(3.0)
    found = scene.residuals(motion=scale * z)
    np.testing.assert_allclose(-scene.causes[TIMING] @ z, found, atol=3e-4)
    left = np.repeat(scene.expected.lines.camera == 0, 2)
    assert np.abs(found[left]).max() < 1e-8
    assert np.abs(found[~left]).max() > 0.01


def test_lines_are_displaced_by_what_their_causes_say(scene: Scene) -> None:
    rng = np.random.default_rng(4)
    stated = sum(scene.causes[name] @ scene.causes[name].T for name in (NOISE, DISPLACEMENT, SIDES))
    source = ErrorSource.at(scene.design, scene.T, scene.expected)
    draws = np.array([source.draw(rng).across for _ in range(2000)])
    span = scene.expected.span
    place = span[:, :1] + (np.arange(9) + 0.5) / 9 * (span[:, 1:] - span[:, :1])
    drawn = np.empty((2000, len(span), 2))
    for k in range(len(span)):
        slope, offset = np.polyfit(place[k], draws[:, k].T, 1)
        drawn[:, k] = np.column_stack([offset, offset + slope])  # at the line's ends
    deviations = drawn.reshape(2000, -1).std(axis=0)
    np.testing.assert_allclose(deviations, np.sqrt(np.diagonal(stated)), rtol=0.08)


def test_of_a_box_the_edges_in_sight_are_measured() -> None:
    known = attrs.evolve(design(), model=BOX, edges=range(12))
    lines = expected_lines(known, known.pose_at(0.8, 0.0, 0.0)).lines
    # Head-on the front hides all but its own four edges, at least from a camera midway.
    assert {0, 1, 2, 3} <= set(lines.edge.tolist())
    assert not {4, 6} & set(lines.edge.tolist())
    turned = expected_lines(known, known.pose_at(0.8, math.radians(40.0), 0.8)).lines
    assert len(set(turned.edge.tolist())) == 9  # a corner of the box: three faces
    assert not (turned.shift_sigma > 0.0).any()
    assert cell(known, 0.8, math.radians(40.0)) is not None


def test_the_budget_agrees_with_poses_from_drawn_errors() -> None:
    # The standard deviations of 800 draws are known to 2.5 %.
    result = check(design(example_rig()), 0.6, math.radians(15.0), samples=800, seed=3)
    np.testing.assert_allclose(result.ratios, 1.0, atol=0.1)
    assert result.agrees
    assert not attrs.evolve(result, drawn=result.drawn * [1.0, 1.0, 1.0, 1.0, 1.0, 1.2]).agrees


def test_causes_add_up_and_scale() -> None:
    designs = [design(noise=noise, displacement=0.2) for noise in (1.0, 2.0)]
    small, large = (pose_budget(known, known.pose_at(0.5, 0.3, 0.7)) for known in designs)
    np.testing.assert_allclose(small.total, sum(small.causes.values()))
    # The displacement gives the lines their weights in both, so that nothing else changes.
    ratio = np.diagonal(large.causes[NOISE]) / np.diagonal(small.causes[NOISE])
    np.testing.assert_allclose(ratio, 4.0, rtol=0.05)
    # Knowing some of the parameters never makes the calibration worse.
    for rest in small.without.values():
        assert np.linalg.eigvalsh(small.causes[CALIBRATION] - rest)[0] > -1e-12


@pytest.mark.parametrize("rig", [wide_rig(), one_camera()], ids=["stereo", "one camera"])
def test_the_target_stands_where_it_should(rig: Rig) -> None:
    known = design(rig)
    forward = rig.R_world_rect[:, 2]
    for angle, azimuth in ((0.0, 0.0), (0.6, 0.0), (0.6, 2.0)):
        pose = known.pose_at(0.7, angle, azimuth)
        assert np.linalg.norm(pose[:3, 3]) == pytest.approx(0.7)
        assert pose[:3, 0] @ forward == pytest.approx(math.cos(angle))
        middle = pose[:3, :3] @ known.model.edge_points.reshape(-1, 3).mean(axis=0) + pose[:3, 3]
        offset = middle - known.cameras.centers.mean(axis=0)
        np.testing.assert_allclose(offset, (offset @ forward) * forward, atol=1e-12)
    assert cell(known, 0.7, 0.0) is not None


def test_other_designs() -> None:
    known = design()
    rays = np.random.default_rng(5).uniform(-0.3, 0.3, (20, 2))
    longer = known.with_focal_length(2.0).rig
    for before, after in zip(known.rig.cameras, longer.cameras, strict=True):
        one = before.project(np.column_stack([rays, np.ones(20)]))
        np.testing.assert_allclose(after.project(np.column_stack([0.5 * rays, np.ones(20)])), one, atol=1e-9)
    assert known.with_baseline(1.5).rig.baseline == pytest.approx(1.5 * known.rig.baseline)
    totals = {change.name: change.cell.total for change in changes(known, 1.0, 0.0) if change.cell is not None}
    assert len(totals) == 8
    own = totals["as it is"]
    for better in ("twice the focal length", "twice the baseline"):
        assert totals[better].attitude < own.attitude
    for worse in ("half the focal length", "half of every line", "outer edges alone", "left camera alone"):
        assert totals[worse].attitude > own.attitude


def test_a_target_that_is_not_in_view_has_no_budget() -> None:
    known = design()
    with pytest.raises(PoseError, match="too short"):
        known.pose_at(0.01, 0.0, 0.0)
    table = sweep(known, [0.01, 0.6], [0.0])
    assert table.cells[0][0] is None
    assert table.cells[1][0] is not None


def test_what_must_improve() -> None:
    known = design()
    found = cell(known, 1.2, 0.0)
    assert found is not None
    result = improvement(known, found, parse_requirement(f"{0.85 * found.total.position * 1e3}mm"))
    assert not result.met
    assert result.factor == pytest.approx(0.85)
    required = (0.85 * result.total) ** 2
    assert sum(part.share for part in result.parts) == pytest.approx(1.0)
    for part in result.parts:
        others = result.total**2 - part.sigma**2
        if part.factor is None:
            assert others >= required
        else:
            assert others + (part.factor * part.sigma) ** 2 == pytest.approx(required)
    names, factor = result.fewest
    variance = sum(part.sigma**2 * (factor**2 if part.name in names else 1.0) for part in result.parts)
    assert variance == pytest.approx(required)
    assert result.focal_length is not None
    longer = cell(known.with_focal_length(result.focal_length), 1.2, 0.0)
    assert longer is not None
    assert 0.95 * required < longer.total.position**2 <= required


def test_a_requirement_that_is_met_leaves_room() -> None:
    known = design()
    found = cell(known, 0.5, 0.0)
    assert found is not None
    result = improvement(known, found, parse_requirement("3 deg"))
    assert result.met
    assert result.baseline is None
    assert all(part.factor is not None and part.factor > 1.0 for part in result.parts)


@pytest.mark.parametrize(
    ("text", "value", "is_position"),
    [("1mm", 1e-3, True), ("0.5 m", 0.5, True), ("20um", 2e-5, True), ("2e-1deg", math.radians(0.2), False)],
)
def test_requirements(text: str, value: float, is_position: bool) -> None:
    found = parse_requirement(text)
    assert found.value == pytest.approx(value)
    assert found.is_position is is_position


@pytest.mark.parametrize("text", ["", "1", "mm", "1 inch", "-1mm", "0mm", "1..2mm", "1e999mm", "nan mm"])
def test_requirements_that_are_none(text: str) -> None:
    with pytest.raises(InputError, match="--require"):
        parse_requirement(text)


def test_a_board_calibration_errs_as_opencv_says() -> None:
    rig = one_camera()
    camera = rig.cameras[0]
    views = board_views(rig)
    flat = np.stack(np.meshgrid(np.arange(9), np.arange(6), [0.0]), axis=-1).reshape(-1, 3).astype(np.float32) * 0.025
    rng = np.random.default_rng(7)
    objects, images = [], []
    for corners in views:
        uv = camera.project(corners)
        seen = ((uv > 0) & (uv < [camera.width - 1, camera.height - 1])).all(axis=1)
        objects.append(flat[seen])
        images.append((uv[seen] + CORNER_SIGMA_PX * rng.standard_normal((seen.sum(), 2))).astype(np.float32))
    size = (camera.width, camera.height)
    guess = camera.K.copy(), np.append(camera.distortion, 0.0)
    flags = cv2.CALIB_FIX_K3 | cv2.CALIB_USE_INTRINSIC_GUESS
    deviations = cv2.calibrateCameraExtended(objects, images, size, *guess, flags=flags)[5].ravel()[:8]
    np.testing.assert_allclose(np.sqrt(np.diagonal(board_calibration_covariance(rig))), deviations, rtol=0.1)
