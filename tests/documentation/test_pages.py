"""A reader who follows a page sees what the page shows."""

import re

import nbformat
import pytest
from nbclient import NotebookClient

from hydrofdi.quality.doubts import DOUBTS, REMEDIES
from tests.commands import run
from tests.documentation.pages import ROOT, blocks, follow

DOCS = ROOT / "docs"
SHORT = {"columns-to-channels.md", "resume-a-sweep.md", "units.md"}
PAGES = sorted([*DOCS.glob("tutorials/*.md"), *DOCS.glob("how-to/*.md")])
PAGES = [page for page in PAGES if page.name != "index.md"]


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[] if page.name in SHORT else [pytest.mark.long]) for page in PAGES],
    ids=lambda page: page.stem,
)
def test_a_page_can_be_followed(page, tmp_path):
    follow(page, tmp_path)


def test_every_command_and_option_of_the_pages_exists():
    helps = {}
    texts = [block.text for page in PAGES for block in blocks(page) if block.language == "sh"]
    text = "\n".join(texts).replace("\\\n", " ")
    for command, rest in re.findall(r"hydrofdi ([a-z]+)([^|;&#>\n]*)", text):
        if command not in helps:
            helps[command] = run(command, "--help", check=0).stdout
        for option in re.findall(r" (--[a-z-]+)", rest):
            assert option in helps[command], f"hydrofdi {command} {option}"


def test_every_verdict_and_every_failure_has_a_heading():
    page = (DOCS / "troubleshooting.md").read_text(encoding="utf-8")
    headings = "\n".join(re.findall(r"^### (.*)$", page, re.MULTILINE))
    assert {*DOUBTS, *REMEDIES} - {"error"} <= {*re.findall(r"`([a-z_]+)`", headings)}


@pytest.mark.parametrize(
    "file", sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")), ids=lambda file: file.stem
)
class TestNotebook:
    def test_it_is_kept_without_outputs_and_its_cells_are_python(self, file):
        notebook = nbformat.read(file, as_version=4)
        nbformat.validate(notebook)
        for cell in notebook.cells:
            if cell.cell_type == "code":
                assert (cell.outputs, cell.execution_count) == ([], None)
                compile(cell.source, "cell", "exec")

    @pytest.mark.long
    @pytest.mark.filterwarnings("default")
    def test_it_runs_in_an_empty_folder_and_shows_tables_and_figures(self, file, tmp_path):
        notebook = nbformat.read(file, as_version=4)
        NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
        outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
        shown = {kind for output in outputs for kind in output.get("data", {})}
        assert {"image/png", "text/plain"} <= shown
        assert not [each for each in outputs if each.output_type == "stream" and each.name == "stderr"]
