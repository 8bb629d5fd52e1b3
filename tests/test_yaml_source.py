import json
import math

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.settings.yaml_source import dotted, parse_yaml, scalar


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3), ("7e6", 7e6), ("1.", 1.0), (".5", 0.5), ("-2", -2), ("+3", 3), ("12:30", "12:30"),
        ("no", "no"), ("yes", "yes"), ("on", "on"), ("0o17", "0o17"), ("017", 17), ("1_000", "1_000"),
        ("true", True), ("False", False), ("null", None), ("~", None), ("", None), (".inf", math.inf),
        ("2024-01-01", "2024-01-01"), ("551 MPa", "551 MPa"),
    ],
)  # fmt: skip
def test_scalars_follow_yaml_1_2(text, value):
    found = scalar(text)
    assert found == value
    assert type(found) is type(value)


def test_quoted_scalars_stay_texts():
    assert parse_yaml("{a: '1', b: \"true\"}", "f").data == {"a": "1", "b": "true"}


def test_every_part_remembers_its_line():
    source = parse_yaml("a:\n  b: 1\n  c:\n    - 2\n    - 3\n", "f.yaml")
    assert source.origin(("a", "b")) == "f.yaml:2"
    assert source.origin(("a", "c", 1)) == "f.yaml:5"
    assert source.origin(("a", "missing")) == "f.yaml:1"


def test_a_repeated_key_is_a_mistake_that_names_both_lines():
    (mistake,) = parse_yaml("a: 1\nb: 2\na: 3\n", "f.yaml").mistakes
    assert str(mistake) == "f.yaml:3: a: key given twice, first in line 1"


def test_aliases_stand_for_what_they_name():
    assert parse_yaml("a: &x [1, 2]\nb: *x\n", "f").data == {"a": [1, 2], "b": [1, 2]}


@pytest.mark.parametrize(
    "text",
    [
        "a: &x {b: *x}",
        "&x [*x, *x]",
        "[" * 2000,
        "[" * 2000 + "]" * 2000,
        "\n".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}' if i else 'x'] * 10)}]" for i in range(12)),
    ],
    ids=["cycle", "branching cycle", "open brackets", "deep", "billion laughs"],
)
def test_endless_texts_end_in_a_mistake(text):
    source = parse_yaml(text, "f.yaml")
    assert source.data is None
    assert len(source.mistakes) == 1


@given(st.text(max_size=60))
def test_any_text_is_data_or_a_mistake_or_states_nothing(text):
    source = parse_yaml(text, "f.yaml")
    assert source.mistakes or source.data is not None or yaml.safe_load(text) is None


@given(
    st.recursive(
        st.one_of(
            st.booleans(), st.integers(-(10**9), 10**9), st.floats(allow_nan=False, allow_infinity=False)
        ),
        lambda inner: st.one_of(
            st.lists(inner, min_size=1, max_size=3),
            st.dictionaries(st.text("abcdefgh", min_size=1, max_size=4), inner, min_size=1, max_size=3),
        ),
        max_leaves=8,
    )
)
def test_json_is_read_as_it_was_written(data):
    assert parse_yaml(json.dumps(data), "f").data == data


def test_a_path_is_reported_as_dotted_text():
    assert dotted(("sweep", "grid", "fluid.bulk_modulus", 1)) == "sweep.grid.fluid.bulk_modulus[1]"
