"""A sweep with signals of which a run failed."""

import pytest

from tests.conftest import FAILING, sweep_in


@pytest.fixture(scope="session")
def one_failed(tmp_path_factory):
    """Three runs with their pressures, of which the second diverges; to be read only."""
    return sweep_in(tmp_path_factory.mktemp("one_failed"), FAILING.replace("none", "pressures"))
