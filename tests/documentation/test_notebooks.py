"""The notebooks run, show what they promise, and are kept without outputs."""

import nbformat
import pytest
from nbclient import NotebookClient

from tests.documentation.pages import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


@pytest.fixture(params=NOTEBOOKS, ids=lambda file: file.stem)
def notebook(request):
    return nbformat.read(request.param, as_version=4)


def test_it_is_kept_without_outputs(notebook):
    nbformat.validate(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert not cell.outputs
            assert cell.execution_count is None


def test_its_cells_are_python(notebook):
    for cell in notebook.cells:
        if cell.cell_type == "code":
            compile(cell.source, "cell", "exec")


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_it_runs_in_an_empty_folder_and_shows_tables_and_figures(notebook, tmp_path):
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    shown = {kind for output in outputs for kind in output.get("data", {})}
    assert {"image/png", "text/plain"} <= shown
    assert not [output for output in outputs if output.output_type == "stream" and output.name == "stderr"]
