"""A first line that is no header of columns: refused in a sentence of a readable length."""

import pytest

from tests.commands import run_hydrofdi


@pytest.mark.parametrize("line", ["x " * 500_000, "P1 [bar" * 100_000, ",".join(["a" * 2000] * 500)])
def test_a_huge_first_line_is_refused_in_a_short_sentence(tmp_path, line):
    (tmp_path / "huge.csv").write_text(f"{line}\n1,2,3\n")
    done = run_hydrofdi("inspect", "huge.csv", cwd=tmp_path)
    assert done.returncode == 2
    assert len(done.stderr) < 3000
