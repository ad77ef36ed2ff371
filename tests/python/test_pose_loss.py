"""The robust losses where nothing is left to weigh."""

import numpy as np
import pytest
from rvdnav.pose import PoseError
from rvdnav.pose.loss import EFFICIENT_K, response


@pytest.mark.parametrize(("loss", "length"), [("tukey", 100.0), ("huber", np.inf)])
def test_measurements_without_weight_determine_no_pose(loss, length):
    with pytest.raises(PoseError, match="no measurement agrees"):
        response(np.full(8, length), loss, EFFICIENT_K[loss], 1.0)


def test_most_of_the_weight_answers_to_a_shift():
    """Of normal residuals 95 % for both losses."""
    norms = np.hypot(*np.random.default_rng(1).normal(size=(2, 100_000)))
    for loss in ("tukey", "huber"):
        assert 0.6 < response(norms, loss, EFFICIENT_K[loss], 1.0) < 1.0
