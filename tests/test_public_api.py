"""The public names: few, documented, and enough for a study in a notebook."""

import subprocess
import sys

import numpy as np

import hydrofdi
from hydrofdi.api.sweep import run_sweep
from hydrofdi.report.runs import run_table
from hydrofdi.store import read_experiment
from hydrofdi.transforms.change import percentage_change


def test_the_public_names_are_few_documented_and_there():
    assert len(hydrofdi.__all__) <= 31
    assert set(dir(hydrofdi)) == set(hydrofdi.__all__)
    for name in hydrofdi.__all__:
        assert name == "__version__" or getattr(hydrofdi, name).__doc__


def test_importing_the_package_loads_no_library():
    code = "import sys, hydrofdi; print(sorted({'numpy', 'numba', 'pydantic', 'h5py'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_parts_of_a_study_run_one_by_one(tmp_path):
    experiment = hydrofdi.load_experiment(
        settings=[
            "record.duration=2 s", "store.signals=none",
            "sweep.grid.leakage.internal_coefficient=[1e-8]",
            "sweep.grid.fluid.bulk_modulus=[551 MPa, 689 MPa]",
        ]
    )  # fmt: skip
    summary = run_sweep(experiment, tmp_path / "study")
    assert (summary.planned, summary.failed) == (4, 0)
    data = read_experiment(summary.file)
    table = run_table(data)
    rms = data.columns["detail_rms"]
    delta = percentage_change(rms[data.fixed_baseline[0]], rms[0])
    leaky = table.of(~table.is_sealed & (table["bulk_modulus"] == 551e6))
    np.testing.assert_array_equal(leaky.changes("fixed"), [delta])
