"""Pose and sizes refined together: exact lines of OpenCV's projections, and the covariance against repeated noise."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from pose_scene import CAMERAS, EDGES, OUTER, exact_lines, pose
from rvdnav.pose import PoseError, difference, perturb, refine_shape, size_derivatives
from rvdnav.trapezoid import Trapezoid

SIGMA_PX, TILT = 0.05, 5e-4
COV = np.diag([SIGMA_PX**2, TILT**2])
# Of the scene's bracket; its inner corners are given to 0.1 mm, so the legs' widths follow from those.
TRUTH = np.array([0.18, 0.09, 0.14, 0.014, 0.014, 0.0])


def exact_scene() -> tuple[np.ndarray, np.ndarray]:
    """A pose and the sizes of the trapezoid whose edges are nearest to the scene's, within 0.1 mm."""
    slope = (OUTER[1, 1] - OUTER[2, 1]) / OUTER[2, 2]
    width = (0.09 - slope * 0.014 - 0.0708) / np.hypot(1.0, slope)
    return pose(), np.array([*TRUTH[:5], width])


def lines_of(T: np.ndarray, sizes: np.ndarray):
    """The true lines, with the edges' own points put in place of the scene's."""
    lines = exact_lines(T, COV)
    assert np.abs(Trapezoid.of(sizes).edge_points - EDGES).max() < 1e-4
    return lines


def test_edge_points_run_as_those_of_the_bracket() -> None:
    shape = Trapezoid(0.2, 0.1, 0.15, 0.015, 0.012, 0.01)
    bracket = shape.bracket(0.006)
    np.testing.assert_allclose(shape.edge_points, bracket.edge_points)
    assert (bracket.long_base, bracket.short_base) == pytest.approx((0.2, 0.1))
    np.testing.assert_allclose(bracket.heights, 0.15)
    np.testing.assert_allclose(bracket.bar_widths, np.array([[0.015] * 2, [0.012] * 2, [0.01] * 2, [0.01] * 2]))
    points, derivatives = Trapezoid.edges_of(shape.sizes)
    moved = shape.sizes + np.array([1e-4, -1e-4, 2e-4, 1e-4, 1e-4, -1e-4])
    expected = Trapezoid.of(moved).edge_points
    np.testing.assert_allclose(points + derivatives @ (moved - shape.sizes), expected, atol=1e-7)


def test_finds_pose_and_sizes_from_afar() -> None:
    T, sizes = exact_scene()
    lines = lines_of(T, sizes)
    start = perturb(T, np.array([0.01, -0.004, 0.003, 0.03, -0.04, 0.02]))
    wrong = sizes * [1.04, 0.95, 1.05, 1.2, 0.85, 1.1]
    fit = refine_shape(start, wrong, Trapezoid.edges_of, lines, CAMERAS)
    assert fit.converged
    assert np.abs(fit.sizes - sizes).max() < 1e-4
    assert np.linalg.norm(difference(fit.T_world_target, T)[:3]) < 1e-4
    assert np.abs(fit.residuals).max() < 0.05


def test_derivatives_by_the_sizes_are_those_of_the_residuals() -> None:
    T, sizes = exact_scene()
    lines = lines_of(T, sizes)
    by_size = size_derivatives(T, sizes, Trapezoid.edges_of, lines, CAMERAS)
    # A longer base moves the lower end P2 of a leg's outer edge, not P3 at its upper end.
    leg = int(np.flatnonzero((lines.camera == 0) & (lines.edge == 4))[0])
    assert np.abs(by_size[leg, 0, 0]) > 100.0
    assert np.abs(by_size[leg, 1, 0]) < 1e-6
    assert by_size.shape == (16, 2, 6)


def test_covariance_is_the_scatter_of_repeated_measurements() -> None:
    T, sizes = exact_scene()
    lines = lines_of(T, sizes)
    # The lines of the trapezoid itself, not of the scene's rounded corners: errors are told from a noiseless fit.
    true = refine_shape(T, sizes, Trapezoid.edges_of, lines, CAMERAS)
    rng = np.random.default_rng(11)
    distances = []
    for _ in range(60):
        noisy = attrs.evolve(
            lines,
            rho=lines.rho + SIGMA_PX * rng.normal(size=len(lines)),
            theta=lines.theta + TILT * rng.normal(size=len(lines)),
        )
        fit = refine_shape(T, sizes, Trapezoid.edges_of, noisy, CAMERAS)
        error = np.concatenate([difference(fit.T_world_target, true.T_world_target), fit.sizes - true.sizes])
        distances.append(error @ np.linalg.solve(fit.covariance, error) / len(error))
    assert 0.5 < np.mean(distances) < 1.5


def test_too_few_lines_determine_nothing() -> None:
    lines = exact_lines(pose(), COV, edges=(0, 1))
    with pytest.raises(PoseError):
        refine_shape(pose(), exact_scene()[1], Trapezoid.edges_of, lines, CAMERAS)
