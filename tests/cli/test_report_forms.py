"""What ``hydrofdi report --format`` takes."""

from tests.commands import run_hydrofdi


def test_an_unknown_form_is_refused_in_one_line(tmp_path):
    done = run_hydrofdi("report", "--format", "pdf", cwd=tmp_path)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
