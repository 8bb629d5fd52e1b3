from collections.abc import Callable

import pytest

from hydrofdi.config import RunParameters, load_experiment

Parameters = Callable[..., RunParameters]


@pytest.fixture(scope="session")
def parameters() -> Parameters:
    """The nominal actuator over 2 s, with settings."""

    def build(*settings: str) -> RunParameters:
        return load_experiment(None, ["record.duration=2 s", *settings]).nominal_parameters

    return build
