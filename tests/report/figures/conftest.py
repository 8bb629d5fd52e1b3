"""Small experiments of every kind, swept once."""

from types import SimpleNamespace

import pytest

from hydrofdi.papers import make_report
from hydrofdi.store.results import read_results
from tests.conftest import REPOSITORY, sweep_in, swept

MODES = """\
name: modes
paper: maddahi2015
record: {duration: 4 s}
wavelet: {phase: all}
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min, 0.89 L/min, 2 L/min]
    fluid.bulk_modulus: [400 MPa, 551 MPa, 689 MPa, 800 MPa, 1400 MPa]
"""

MANY = """\
name: many
record: {duration: 1 s}
store: {signals: none}
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.1 L/min, 0.5 L/min, 2 L/min]
    friction.viscous: [40 N*s/m, 50 N*s/m, 60 N*s/m]
    supply.pressure: {linspace: [15 MPa, 19 MPa, 15]}
"""


@pytest.fixture(scope="session")
def reports(tmp_path_factory):
    """Reports by name."""

    def read(sweep: SimpleNamespace):
        return make_report(read_results(sweep.directory))

    def made(text):
        return read(sweep_in(tmp_path_factory.mktemp("figures"), text))

    def ready(name):
        return read(swept(tmp_path_factory.mktemp("figures"), REPOSITORY / "configs" / f"{name}.yaml"))

    return {
        "modes": made(MODES),
        "many": made(MANY),
        "study": ready("detectability-smoke"),
        "delays": ready("delays/smoke"),
    }
