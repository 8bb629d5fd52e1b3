"""The public names: few, documented, and enough for a study in a notebook."""

import subprocess
import sys

import hydrofdi


def test_the_public_names_are_few_documented_and_there():
    assert len(hydrofdi.__all__) <= 31
    assert set(dir(hydrofdi)) == set(hydrofdi.__all__)
    for name in hydrofdi.__all__:
        assert name == "__version__" or getattr(hydrofdi, name).__doc__


def test_importing_the_package_loads_no_library():
    code = "import sys, hydrofdi; print(sorted({'numpy', 'numba', 'pydantic', 'h5py'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
