"""The beam search over candidate lines: known edges among clutter, from a prediction that is off."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scene import example_rig
from drawn_solid import box_target
from rvdnav.navigator.association import associate
from rvdnav.navigator.candidates import EdgeCandidates
from rvdnav.navigator.edge_model import edge_model
from rvdnav.navigator.geometry import line_of, project_edges, rectified_cameras
from rvdnav.pose import PredictedPose, difference, perturb
from rvdnav.pose.cameras import project_along
from scipy.spatial.transform import Rotation

Scene = tuple[PredictedPose, np.ndarray, list[EdgeCandidates], list[int]]
SIGMA = np.repeat([0.01, np.radians(1.5)], 3)


def scene(seed: int, clutter: int, hidden: int | None = None) -> Scene:
    """A prediction, the true pose, candidates whose lines are the true edges' and random ones beside them, and which is
    the true one; the true line of one edge may be left out.  clutter: random lines an edge."""
    rng = np.random.default_rng(seed)
    cameras = rectified_cameras(example_rig())
    predicted = np.eye(4)
    predicted[:3, :3] = Rotation.from_euler("yz", [25.0, 30.0], degrees=True).as_matrix()
    predicted[:3, 3] = [0.9, 0.0, 0.06]
    true = perturb(predicted, SIGMA * rng.normal(size=6))
    model = edge_model(box_target())
    edges = np.unique(model.visible_pieces(predicted, cameras.centers[0]).edge)
    candidates, right = [], []
    before, _ = project_edges(cameras, 0, predicted, model.edge_points[edges])
    after, _ = project_edges(cameras, 0, true, model.edge_points[edges])
    _, theta, _ = line_of(before)
    for i, edge in enumerate(edges):
        normal = np.array([np.cos(theta[i]), np.sin(theta[i])])
        _, across = project_along(
            cameras, np.zeros(2, int), predicted, model.edge_points[edge], np.tile(normal, (2, 1))
        )
        offsets = rng.uniform(-25.0, 25.0, (clutter + 1, 1)) + rng.normal(0.0, 2.0, (clutter + 1, 2))
        place = int(rng.integers(clutter + 1))
        # Where the true line crosses the normals through the predicted ends.
        rho, angle = (value[0] for value in line_of(after[i : i + 1])[:2])
        n = np.array([np.cos(angle), np.sin(angle)])
        offsets[place] = (rho - before[i] @ n) / (normal @ n) + rng.normal(0.0, 0.3, 2)
        if i == hidden:
            offsets, place = np.delete(offsets, place, axis=0), -1
        support = rng.uniform(0.3, 1.0, len(offsets))
        none = np.zeros(len(offsets))
        candidates.append(EdgeCandidates(0, int(edge), before[i], across, 25.0, none, none, offsets, support))
        right.append(place)
    return PredictedPose(predicted, np.diag(SIGMA**2)), true, candidates, right


@pytest.mark.parametrize(("clutter", "hidden", "least"), [(5, None, 12), (1, 4, 11)], ids=["all there", "one missing"])
def test_the_true_lines_are_found_among_clutter(clutter: int, hidden: int | None, least: int) -> None:
    """Mostly they are likeliest; some clutter fits as well by chance, and then they are among the rest."""
    there = first = 0
    for seed in range(12):
        prediction, true, candidates, right = scene(seed, clutter, hidden)
        found = associate(prediction, candidates, 4)
        assert np.all(np.diff([association.log_likelihood for association in found]) <= 0.0)
        errors = np.array([difference(association.T_world_target, true) for association in found])
        near = (np.linalg.norm(errors[:, :3], axis=1) < 0.012) & (np.linalg.norm(errors[:, 3:], axis=1) < 0.012)
        same = np.array([np.sum(association.chosen == np.array(right)) >= len(right) - 2 for association in found])
        there += bool((near & same).any())
        first += bool((near & same)[0])
    assert there >= least
    assert first >= least - 2


def test_without_lines_the_prediction_stands() -> None:
    prediction, _, _, _ = scene(0, 5)
    (only,) = associate(prediction, [], 4)
    np.testing.assert_allclose(only.T_world_target, prediction.T_world_target)
