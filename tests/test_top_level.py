"""What the repository holds at its top; results of commands do not belong there."""

import shutil
import subprocess

import pytest

from tests.conftest import REPOSITORY

EXPECTED = {
    ".ci", ".gitignore", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "Makefile", "README.md", "benchmarks",
    "configs", "constraints.txt", "docs", "hydrofdi", "pyproject.toml", "results", "tests",
}  # fmt: skip


@pytest.mark.skipif(not (REPOSITORY / ".git").exists() or shutil.which("git") is None, reason="no clone")
def test_nothing_but_the_project_is_at_its_top():
    listed = subprocess.run(["git", "ls-files"], cwd=REPOSITORY, capture_output=True, text=True, check=True)
    assert {name.partition("/")[0] for name in listed.stdout.splitlines()} == EXPECTED
