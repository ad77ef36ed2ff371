"""The solution's invariants and its JSON form."""

import json

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rvdnav.corrections import Corrections, ParameterCorrection, PointCorrection
from rvdnav.errors import InputError
from rvdnav.solution import LearnedDimensions, LineResidual, Mode, Reason, Solution, State
from scipy.spatial.transform import Rotation


def pose(rotation_vector=(0.1, -0.2, 0.3), position=(1.0, 0.02, -0.03)):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(rotation_vector).as_matrix()
    T[:3, 3] = position
    return T


def tracked(**changes):
    values = {
        "timestamp_ns": 1_700_000_000_125_000_001,
        "state": State.TRACKING,
        "mode": Mode.STEREO,
        "T_world_target": pose(),
        "covariance": np.diag([1e-8, 1e-9, 1e-9, 1e-6, 1e-6, 1e-6]),
    }
    return Solution(**{**values, **changes})


CORRECTIONS = Corrections(
    {"cam0.fx": ParameterCorrection(-0.3, 0.4, 1.3)},
    {"P1": PointCorrection((1e-4, 0.0, -2e-4), (1e-4, 2e-4, 3e-4), 3e-4)},
    calibration_scale=0.7,
    target_scale=2.1,
    calibration_distance=0.5,
    target_distance=3.5,
    frames=4,
)


@given(
    rotation=arrays(float, 3, elements=st.floats(-3, 3)),
    position=arrays(float, 3, elements=st.floats(-2, 2)),
    reasons=st.frozensets(st.sampled_from(list(Reason))),
    timestamp_ns=st.integers(0, 2**63 - 1),
)
def test_json_round_trip_is_exact(rotation, position, reasons, timestamp_ns):
    solution = tracked(
        timestamp_ns=timestamp_ns,
        T_world_target=pose(rotation, position),
        predicted_T_world_target=pose(),
        smoothed_T_world_target=pose((0, 0, 1)),
        reasons=reasons,
        dimensions=LearnedDimensions({"long_base": 0.18}, {"long_base": 1e-4}, 3, known=True),
        corrections=CORRECTIONS,
        sigma0=0.93,
        line_residuals=(LineResidual(1, "l1_outer", True, 31, 0.04, -0.01), LineResidual(0, "l2_inner", False, 0)),
        view_lines={1: [[0.1, 2, 3, 4]], 0: np.zeros((2, 4))},
        stage_times={"smooth": 0.001, "total": 0.02},
    )
    again = Solution.from_json(json.loads(json.dumps(solution.to_json(), allow_nan=False)))
    assert again == solution
    assert again.stage_times == solution.stage_times


@pytest.mark.parametrize("sigmas", [{"long_base": 0.0}, {"long_base": np.nan}, {"height": 1e-4}])
def test_learnt_dimensions_that_are_none(sigmas):
    with pytest.raises(ValueError, match=r"not positive|names"):
        LearnedDimensions({"long_base": 0.18}, sigmas, 3, known=True)


def test_corrections_that_are_none():
    for parameter in ((np.nan, 1.0, 1.0), (0.0, 0.0, 1.0), (0.0, 1.0, -1.0)):
        with pytest.raises(ValueError, match=r"not finite|not positive"):
            ParameterCorrection(*parameter)
    with pytest.raises(ValueError, match="not positive"):
        attrs.evolve(CORRECTIONS, calibration_scale=0.0)
    with pytest.raises(ValueError, match="published"):
        Solution(timestamp_ns=1, state=State.SEARCHING, corrections=CORRECTIONS)
    good = tracked(corrections=CORRECTIONS).to_json()
    for broken in (
        {"frames": "4"},
        {"points": {"P1": {"value": [0, 0], "sigma": [1, 1, 1], "stated": 1}}},
        {"more": 1},
    ):
        with pytest.raises(InputError):
            Solution.from_json({**good, "corrections": {**good["corrections"], **broken}})


def test_json_differs_where_the_solution_differs():
    assert tracked() != tracked(T_world_target=pose(position=(1.0, 0.02, -0.0300001)))
    assert tracked() == tracked(stage_times={"total": 1.0})  # wall times are no result


def test_json_keeps_reasons_in_order_and_wall_times_last():
    data = tracked(reasons={Reason.RESIDUALS, Reason.AMBIGUOUS, Reason.LIMIT}).to_json()
    assert data["reasons"] == ["AMBIGUOUS", "LIMIT", "RESIDUALS"]
    assert list(data)[-1] == "stage_times_s"


def test_euler_is_that_of_the_published_pose():
    # Equation (9) with theta = psi = 0 gives R23 = sin(phi).
    T = np.eye(4)
    T[1:3, 1:3] = [[np.cos(0.2), np.sin(0.2)], [-np.sin(0.2), np.cos(0.2)]]
    np.testing.assert_allclose(tracked(T_world_target=T).euler, (0.2, 0.0, 0.0), atol=1e-15)
    coasting = Solution(timestamp_ns=0, state=State.COASTING, predicted_T_world_target=T)
    assert coasting.euler is None
    assert not coasting.published


@pytest.mark.parametrize(
    "changes",
    [
        {"state": State.COASTING},
        {"state": State.SEARCHING, "mode": None},
        {"T_world_target": None},
        {"mode": None},
        {"covariance": None},
        {"T_world_target": np.diag([1.0, 1.0, -1.0, 1.0])},
        {"T_world_target": 2 * np.eye(4)},
        {"T_world_target": pose(position=(np.nan, 0, 0))},
        {"T_world_target": np.eye(3)},
        {"covariance": np.triu(np.ones((6, 6)))},
        {"covariance": np.diag([1, 1, 1, 1, 1, 0])},
        {"covariance": np.eye(6) - 0.5},
        {"sigma0": float("inf")},
    ],
)
def test_contradictions_are_refused(changes):
    with pytest.raises(ValueError, match=r"."):
        tracked(**changes)


def test_a_covariance_belongs_to_a_pose():
    with pytest.raises(ValueError, match="pose that it belongs to"):
        Solution(timestamp_ns=0, state=State.LOST, covariance=np.eye(6))


def test_the_arrays_are_copies_that_cannot_be_changed():
    T = pose()
    solution = tracked(T_world_target=T)
    T[0, 3] = 9.0
    assert solution.T_world_target[0, 3] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        solution.T_world_target[0, 3] = 2.0


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"state": "HAPPY"}, "HAPPY"),
        ({"reasons": ["WEATHER"]}, "WEATHER"),
        ({"T_world_target": [[1, 2], [3, 4]]}, "shape"),
        ({"line_residuals": [{"camera": 0}]}, "edge"),
        ({"view_lines": 3}, "not a solution"),
        ({"timestamp_ns": None}, "not a solution"),
    ],
)
def test_damaged_json_names_the_fault(change, fault):
    with pytest.raises(InputError, match=fault):
        Solution.from_json({**tracked().to_json(), **change})
    with pytest.raises(InputError):
        Solution.from_json([])


def test_every_reason_has_its_own_description():
    assert len({reason.description for reason in Reason}) == len(Reason)
    assert all("\n" not in reason.description for reason in Reason)
