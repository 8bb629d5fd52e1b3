"""What ``why`` and ``status`` say of analyses and of runs of earlier versions."""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py

from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.shard import content_digest
from tests.commands import run_json
from tests.conftest import sweep_in

_KEPT = Path(__file__).parent.parent / "museum" / "format_4_physics_3" / "kept"


def test_status_says_that_an_earlier_version_stored_the_runs(tmp_path: Path) -> None:
    folder = tmp_path / "kept"
    shutil.copytree(_KEPT, folder)
    (shard,) = (folder / "shards").iterdir()
    with h5py.File(shard, "a") as file:
        file.attrs["physics_version"] = PHYSICS_VERSION - 1
    shard.rename(shard.with_stem(content_digest(shard)))
    assert run_json("status", folder)["earlier"] == 8


def test_collect_says_what_it_built(tmp_path: Path) -> None:
    swept = sweep_in(tmp_path, "name: built\nrecord: {duration: 2 s}\n")
    file = swept.directory / "built.h5"
    file.unlink()
    collected = run_json("collect", swept.directory)
    assert collected == {"file": str(file), "planned": 1, "missing": 0, "failed": 0}
    assert file.exists()
