"""What ``hydrofdi report --format`` takes."""

import pytest

from tests.commands import run_hydrofdi


@pytest.mark.parametrize(("form", "hint"), [("html", "; --html writes a page"), ("pdf", "")])
def test_an_unknown_form_is_refused_in_a_plain_sentence(form, hint, tmp_path):
    done = run_hydrofdi("report", "--format", form, cwd=tmp_path)
    assert done.returncode == 2
    forms = "text, markdown, csv, latex, json"
    assert done.stderr == f"hydrofdi: --format: '{form}' is none of the forms {forms}{hint}\n"
