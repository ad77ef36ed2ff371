from __future__ import annotations

import doctest
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rvdnav.conventions import format_timestamp_s, parse_timestamp_ns, parse_timestamp_s, rigid_transform
from scipy.spatial.transform import Rotation

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "conventions.md"


def test_the_document_holds() -> None:
    results = doctest.testfile(str(DOCUMENT), module_relative=False, encoding="utf-8")
    assert results.attempted > 40
    assert results.failed == 0


@given(st.integers(0, 2**63 - 1))
def test_timestamps_round_trip_exactly(timestamp_ns: int) -> None:
    text = format_timestamp_s(timestamp_ns)
    assert parse_timestamp_s(text) == timestamp_ns
    assert Decimal(text) * 10**9 == timestamp_ns
    assert parse_timestamp_ns(str(timestamp_ns)) == timestamp_ns


@pytest.mark.parametrize(
    ("text", "ns"),
    [
        ("0", 0),
        ("1.", 1_000_000_000),
        ("1.5", 1_500_000_000),
        ("+1.5", 1_500_000_000),
        ("1700000000.1250000004", 1_700_000_000_125_000_000),
        ("1700000000.1250000006", 1_700_000_000_125_000_001),
        ("1.700000000125000001e+09", 1_700_000_000_125_000_001),
        ("12e-9", 12),
        ("1" + "0" * 40 + "e-40", 1_000_000_000),
        ("1e-999", 0),
    ],
)
def test_seconds_in_other_spellings(text: str, ns: int) -> None:
    assert parse_timestamp_s(text) == ns


@pytest.mark.parametrize(
    "text", ["", "nan", "inf", "-1.5", "1_000", "1,5", "0x10", "1e99", "1e9999", "9223372036.9", " 1"]
)
def test_seconds_that_are_none(text: str) -> None:
    with pytest.raises(ValueError, match="timestamp"):
        parse_timestamp_s(text)


@pytest.mark.parametrize("text", ["", "1.0", "-1", "1e9", "٣", str(2**63)])
def test_nanoseconds_that_are_none(text: str) -> None:
    with pytest.raises(ValueError, match="timestamp"):
        parse_timestamp_ns(text)


def transform() -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec([0.3, -0.5, 0.7]).as_matrix()
    T[:3, 3] = (1.0, 2.0, 3.0)
    return T


def test_rounded_transform_is_made_exact() -> None:
    T = rigid_transform(np.round(transform(), 7))
    np.testing.assert_allclose(T, transform(), atol=1e-7)
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-15)
    with pytest.raises(ValueError, match="read-only"):
        T[0, 0] = 1.0


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda T: T @ np.diag([1.0, 1.0, 1.0 + 1e-6, 1.0]), "R Rᵀ differs"),
        (lambda T: T @ np.diag([1.0, 1.0, -1.0, 1.0]), "mirrors"),
        (lambda T: T + np.diag([0.0, 0.0, 0.0, 1.0]), "last row"),
        (lambda T: T.T, "last row"),
        (lambda T: T[:3], "shape"),
        (lambda T: T * np.nan, "not finite"),
    ],
)
def test_transforms_that_are_none(change: object, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        rigid_transform(change(transform()))
