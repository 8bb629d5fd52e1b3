"""A reader who follows a page sees what the page shows."""

import ast
import re

import nbformat
import pytest
from nbclient import NotebookClient

from hydrofdi.quality.doubts import DOUBTS, REMEDIES
from tests.commands import run
from tests.documentation.pages import ROOT, blocks, compare, follow

DOCS = ROOT / "docs"
LONG = {
    "my-actuator.md", "my-csv.md", "monitor-a-machine.md", "what-can-i-detect.md",
    "another-oil-as-a-shift.md", "compare-two-sensors.md", "write-a-report.md",
}  # fmt: skip
PAGES = sorted([*DOCS.glob("tutorials/*.md"), *DOCS.glob("how-to/*.md")])
PAGES = [page for page in PAGES if page.name != "index.md"]


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[pytest.mark.long] if page.name in LONG else []) for page in PAGES],
    ids=lambda page: page.stem,
)
def test_a_page_can_be_followed(page, tmp_path):
    follow(page, tmp_path)


def test_every_command_and_option_of_the_pages_exists():
    helps: dict[str, str] = {}
    for page in PAGES:
        for block in blocks(page):
            if block.language != "sh":
                continue
            for command, rest in re.findall(
                r"hydrofdi ([a-z]+)([^|;&#>\n]*)", block.text.replace("\\\n", " ")
            ):
                if command not in helps:
                    helps[command] = run(command, "--help", check=0).stdout
                for option in re.findall(r" (--[a-z-]+)", rest):
                    assert option in helps[command], f"{page.name}: hydrofdi {command} {option}"


@pytest.mark.parametrize(
    "shown",
    ["a 3 b", "…\na 3 b", "a …\nc\n", "a 3\nc", "c\na 3 b\n…", "a 3 b\nc\nd"],
)
def test_output_that_is_not_printed_is_noticed(shown):
    with pytest.raises(AssertionError, match=r"page\.md"):
        compare(shown, "a 3 b\nx\nc\n\n", "page.md")


@pytest.mark.parametrize("shown", ["a 3 b\nx\nc", "a … b\n…\nc", "…", "…\nx\n…"])
def test_output_may_be_shortened(shown):
    compare(shown, "a 3   b\nx\nc\n\n", "page.md")


PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
HEADINGS = re.findall(r"^### (.*)$", PAGE, re.MULTILINE)
WORDS = {word for heading in HEADINGS for word in re.findall(r"`([a-z_]+)`", heading)}


@pytest.fixture(scope="module")
def said():
    """All texts in the source, those of f-strings with … for each value."""
    texts = []
    for file in (ROOT / "hydrofdi").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                texts.append("".join(getattr(part, "value", "…") if isinstance(part, ast.Constant) else "…"
                                     for part in node.values))  # fmt: skip
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                texts.append(node.value.replace("{}", "…"))
    return texts


def test_every_verdict_and_every_failure_has_a_heading():
    assert {*DOUBTS, *REMEDIES} - {"error"} <= WORDS


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
