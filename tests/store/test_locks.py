"""Locks: what is no lock stays as it is, and a full disk is one line."""

import resource

import pytest

from hydrofdi.errors import StoreError
from hydrofdi.store.folder.lock import file_lock
from tests.commands import run


@pytest.mark.parametrize("content", ["", "notes"])
@pytest.mark.parametrize("is_link", [True, False])
def test_a_lock_neither_follows_links_nor_empties_what_is_no_lock(content, is_link, tmp_path):
    lock = victim = tmp_path / ".lock"
    if is_link:
        victim = tmp_path / "victim"
        lock.symlink_to(victim)
    victim.write_text(content)
    if not is_link and not content:
        with file_lock(lock, "in use") as holder:
            assert holder == ""
    else:
        with pytest.raises(StoreError), file_lock(lock, "in use"):
            pass
    assert victim.read_text() == content


def test_a_disk_that_is_full_at_the_start_of_a_sweep_is_one_line(tmp_path):
    def limit_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (10, 10))

    command = ("sweep", "smoke", "--out", "results")
    stopped = run(*command, cwd=tmp_path, check=2, preexec_fn=limit_files)
    assert [line.partition(": ")[0] for line in stopped.stderr.splitlines()].count("hydrofdi") == 1
    assert "Traceback" not in stopped.stderr
    run(*command, cwd=tmp_path, check=0)
