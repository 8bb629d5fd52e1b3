"""A sweep that is long enough to be stopped."""

import pytest

from tests.commands import run

LONG = """\
name: long
record: {duration: 8 s}
store: {signals: none}
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min, 0.89 L/min, 2 L/min]
    fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 150]}
"""


@pytest.fixture(scope="session")
def long(tmp_path_factory):
    """A sweep of seconds and of 600 runs, and the bytes of its results where nothing stops it."""
    folder = tmp_path_factory.mktemp("long")
    (folder / "long.yaml").write_text(LONG)
    run("sweep", "long.yaml", "--out", "whole", check=0, cwd=folder)
    return folder / "long.yaml", (folder / "whole" / "long.h5").read_bytes()
