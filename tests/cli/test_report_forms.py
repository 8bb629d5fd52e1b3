"""What ``hydrofdi report --format`` takes."""

from tests.commands import run_hydrofdi


def test_an_unknown_form_is_refused_in_a_plain_sentence(tmp_path):
    done = run_hydrofdi("report", "--format", "pdf", cwd=tmp_path)
    assert done.returncode == 2
    forms = "text, markdown, csv, json, html"
    assert done.stderr == f"hydrofdi: --format: 'pdf' is not one of the formats {forms}\n"
