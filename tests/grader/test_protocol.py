"""Only plain data crosses, and nothing too big, too deep or of another kind."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest

from grader import protocol
from grader.protocol import Decoder, ProtocolError, encode
from uavlab.types import State, StateRate


def _through(value, *, widen=True):
    return Decoder(widen=widen).value(json.loads(json.dumps(encode(value, []))))


@pytest.mark.parametrize(
    "value", [None, True, 3, -2.5, float("inf"), "text", [1, [2.0]], (1, "a"), {"a": 1}]
)
def test_plain_values_cross_unchanged(value):
    assert _through(value) == value


def test_floats_and_arrays_cross_to_the_last_bit():
    value = np.random.default_rng(1).normal(size=(3, 4))
    assert np.array_equal(_through(value), value)
    assert _through(float(value[0, 0])) == value[0, 0]


def test_records_cross_as_their_own_kind():
    rate = StateRate(np.ones(3), np.zeros(3), np.eye(3), np.ones(3))
    got = _through(rate)
    assert type(got) is StateRate
    assert np.array_equal(got.R_dot, np.eye(3))


def test_a_record_with_too_few_fields_is_a_tuple():
    assert type(Decoder(widen=True).value({"n": ["State", [1.0]]})) is tuple


def test_the_judge_s_side_gets_plain_float64():
    class Mine(np.ndarray):
        pass

    got = _through(np.arange(3, dtype=np.int32).view(Mine))
    assert type(got) is np.ndarray
    assert got.dtype == np.float64


@pytest.mark.parametrize(
    "value", [object(), np.array([None]), np.zeros(2, complex), {1, 2}, lambda: 0, b"x"]
)
def test_anything_else_is_refused_where_it_starts(value):
    with pytest.raises(TypeError):
        encode(value, [])


def _nested(depth: int) -> object:
    return {"l": [_nested(depth - 1)]} if depth else 1


ONE = base64.b64encode(np.ones(1).tobytes()).decode()


@pytest.mark.parametrize(
    "data",
    [
        {"a": ["|O", [1], ONE]},
        {"a": ["<f8", [2], ONE]},
        {"a": ["<f8", [-1], ONE]},
        {"a": ["<f8", [True], ONE]},
        {"a": ["<f8", [2**60, 2**60], ""]},
        {"a": ["<f8", [1] * 9, ONE]},
        {"a": ["<f8", [1], "%%%"]},
        {"a": ["<f8", [1], 7]},
        {"a": [["<f8"], [1], ONE]},
        {"a": None},
        {"n": ["Path", ["/etc"]]},
        {"n": [["State"], []]},
        {"n": "State"},
        {"d": [1]},
        {"l": 1},
        {"__reduce__": []},
        {"l": [], "t": []},
        [1],
        "x" * 10_000,
        10**40,
        _nested(50),
        {"l": [1] * 60_000},
    ],
)
def test_a_hostile_value_is_refused(data):
    with pytest.raises(ProtocolError):
        Decoder(widen=True).value(data)


@pytest.mark.parametrize(
    "body", [b"", b"[1]", b"{", b"\xff", b"[" * 200_000, b'{"a": ' + b"9" * 9_999 + b"}"]
)
def test_a_hostile_frame_is_refused(body):
    with pytest.raises(ProtocolError):
        protocol.unpack(body)


@pytest.mark.parametrize("header", [b"\0\0\0\0", b"\xff\xff\xff\xff"])
def test_a_frame_of_a_hostile_length_is_refused(header):
    with pytest.raises(ProtocolError):
        protocol.length(header)


def test_arrays_are_listed_in_the_order_in_which_they_were_met():
    state = State(np.zeros(3), np.ones(3), np.eye(3), np.full(3, 2.0))
    met: list[np.ndarray] = []
    data = encode((state, np.full(2, 7.0)), met)
    decoder = Decoder(widen=False)
    decoder.value(data)
    assert [a.tobytes() for a, _ in decoder.arrays] == [a.tobytes() for a in met]
    assert all(a.flags.writeable for a, _ in decoder.arrays)
