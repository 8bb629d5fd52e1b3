"""Whatever a source holds: records, or one line that says what is wrong."""

import contextlib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.api.records.simulated import SimulatedRecords
from hydrofdi.api.records.sources import open_source
from hydrofdi.errors import HydrofdiError
from hydrofdi.records.overview import look_at

MUSEUM = (Path(__file__).parents[1] / "museum" / "format_4_physics_3" / "pressures.h5").read_bytes()
EXPERIMENT = (Path(__file__).parents[2] / "configs" / "table3.yaml").read_bytes()
SUFFIXES = st.sampled_from([".csv", ".yaml", ".h5", ".txt", ".mat", ".npz", ".parquet", ".gz", ""])
WORDS = ["p1 [bar]", "time [s]", "files", "name"]
PIECES = ["a", ":", " ", "\n", "{", "]", "1", ",", ";", "-", "\t", "&x", *WORDS]


@st.composite
def contents(draw):
    """Random bytes, words of tables and YAML, and files that are cut off or have wrong bytes in them."""
    whole = draw(st.sampled_from([MUSEUM, EXPERIMENT]))
    cut = whole[: draw(st.integers(0, len(whole)))]
    flipped = bytearray(whole)
    for place in draw(st.lists(st.integers(0, len(whole) - 1), max_size=20)):
        flipped[place] ^= draw(st.integers(1, 255))
    words = "".join(draw(st.lists(st.sampled_from(PIECES), max_size=60))).encode()
    return draw(
        st.sampled_from([cut, bytes(flipped), words, draw(st.binary(max_size=300)), MUSEUM[:8] + words])
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("contents")


@settings(max_examples=150)
@given(content=contents(), suffix=SUFFIXES, frequency=st.sampled_from([None, 100.0]))
def test_no_content_is_a_fault(folder, content, suffix, frequency):
    path = folder / f"source{suffix}"
    path.write_bytes(content)
    with contextlib.suppress(HydrofdiError):
        source = open_source(path, sampling_frequency=frequency)
        if not isinstance(source, SimulatedRecords):
            look_at([source])
