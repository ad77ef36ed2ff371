"""Values as JSON and back: the same bits, and nothing that isn't ours."""

from __future__ import annotations

import json
from decimal import Decimal
from typing import Any

import attrs
import numpy as np
import pytest
from drawn_scene import bracket_target, wide_rig
from hypothesis import given
from hypothesis import strategies as st
from rvdnav.blackbox import exact
from rvdnav.navigator.knowledge import Learned
from rvdnav.navigator.memory import Memory
from rvdnav.pose import FilterState
from rvdnav.solution import Mode, State


def round_trip(value: Any) -> Any:
    return exact.from_json(json.loads(json.dumps(exact.to_json(value), allow_nan=False)))


def assert_same_bits(a: Any, b: Any) -> None:
    assert type(a) is type(b)
    if isinstance(a, np.ndarray | np.generic):
        assert (a.dtype, a.shape, a.tobytes("A")) == (b.dtype, b.shape, b.tobytes("A"))
        assert a.flags.f_contiguous == b.flags.f_contiguous
    elif isinstance(a, float):
        assert a.hex() == b.hex()
    elif attrs.has(type(a)):
        for field in attrs.fields(type(a)):
            assert_same_bits(getattr(a, field.name), getattr(b, field.name))
    elif isinstance(a, dict):
        assert list(a) == list(b)
        for key in a:
            assert_same_bits(a[key], b[key])
    elif isinstance(a, tuple | list):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            assert_same_bits(x, y)
    else:
        assert a == b


@given(st.floats(allow_nan=False))
def test_every_number_in_every_place(number: float) -> None:
    array = np.array([[number, -number]])
    assert_same_bits(round_trip({"a": (number, [array])}), {"a": (number, [array])})


@pytest.mark.parametrize(
    "value",
    [
        None,
        True,
        -(2**70),
        "ρ",
        b"\x00\xff",
        (1, [2.5, ()], {"x": None, 3: -0.0}),
        frozenset({Mode.STEREO, Mode.MONO_LEFT}),
        State.COASTING,
        np.float64(0.1),
        np.array([np.nan, np.inf]),
        np.float32(0.1),
        np.int64(7),
        np.bool_(True),
        np.zeros((0, 6)),
        np.arange(6, dtype=np.uint8).reshape(2, 3),
        np.array([True, False]),
        np.array(1.5),
        np.asfortranarray(np.random.default_rng(1).normal(size=(4, 3))),
        wide_rig(),
        bracket_target(),
    ],
    ids=repr,
)
def test_round_trip(value: Any) -> None:
    assert_same_bits(round_trip(value), value)


def test_a_memory_with_every_part() -> None:
    rng = np.random.default_rng(2)
    state = FilterState(2**62 + 1, rng.normal(size=(4, 4)), rng.normal(size=6), rng.normal(size=(12, 12)).T)
    taught = Learned(rng.normal(size=(5, 5)), rng.normal(size=5), rng.random(4), 7)
    memory = attrs.evolve(
        Memory.blank(2, 8, 5),
        learned=taught,
        filter_state=state,
        image_digests=(b"left", None),
        held_odds=float(rng.normal()),
    )
    assert_same_bits(round_trip(memory), memory)


def test_converters_are_passed_by() -> None:
    """A rig frees its rotations from rounding; what it holds must come back as it is."""
    rig = wide_rig()
    rough = rig.T_world_cam[0].copy()
    rough[0, 0] = np.nextafter(rough[0, 0], 2.0)
    object.__setattr__(rig, "T_world_cam", (rough, rig.T_world_cam[1]))
    assert_same_bits(round_trip(rig).T_world_cam[0], rough)


@attrs.frozen
class Foreign:
    x: int = 1


@pytest.mark.parametrize("value", [Foreign(), Decimal(1), object(), np.array(["a"]), np.longdouble(1), 1j])
def test_what_cannot_be_recorded(value: Any) -> None:
    with pytest.raises(TypeError, match="cannot be recorded"):
        exact.to_json([value])


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        ({}, "not a recorded value"),
        ({"class": "os:PathLike", "fields": {}}, "is no class that is recorded"),
        ({"class": "rvdnav.nowhere:X", "fields": {}}, "is no class that is recorded"),
        ({"class": "rvdnav.solution:TOTAL", "fields": {}}, "is no class that is recorded"),
        ({"class": "rvdnav.faults.fault:Fault", "fields": {}}, "is no class that is recorded"),
        ({"class": "rvdnav.solution:Acquisition", "fields": {"score": 1.0}}, "has other fields now"),
        ({"class": "rvdnav.solution:Acquisition"}, "not a recorded class"),
        ({"enum": "rvdnav.solution:State", "member": "ASLEEP"}, "not a recorded enum"),
        ({"enum": "rvdnav.solution:Acquisition", "member": "score"}, "is no enumeration"),
        ({"array": "float64", "shape": [3], "order": "C", "values": [1.0]}, "reshape"),
        ({"array": "object", "shape": [1], "order": "C", "values": [1.0]}, "none of ours"),
        ({"array": "float64", "shape": [1], "values": [1.0]}, "not a recorded array"),
        ({"bytes": "xy"}, "hexadecimal"),
        ({"dict": [[1]]}, "unpack"),
    ],
)
def test_what_cannot_be_read(data: Any, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        exact.from_json(data)
