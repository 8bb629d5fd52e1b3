"""Small experiments of every kind, swept once."""

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
    folders = {name: tmp_path_factory.mktemp(name) for name in ("modes", "many", "study", "delays")}
    sweeps = {
        "modes": sweep_in(folders["modes"], MODES),
        "many": sweep_in(folders["many"], MANY),
        "study": swept(folders["study"], REPOSITORY / "configs" / "detectability-smoke.yaml"),
        "delays": swept(folders["delays"], REPOSITORY / "configs" / "delays" / "smoke.yaml"),
    }
    return {name: make_report(read_results(sweep.directory)) for name, sweep in sweeps.items()}
