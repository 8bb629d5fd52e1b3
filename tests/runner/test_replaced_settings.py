"""A sweep says that a folder showed other settings until now."""

from __future__ import annotations

from pathlib import Path

from tests.commands import run

STUDY = {"name": "press", "record": {"duration": "2 s"}}
TEXT = "name: press\nrecord: {duration: 2 s}\n"
SHOWED = "showed an experiment with another "


def sweep(folder: Path, *settings: str) -> str:
    options = [word for setting in settings for word in ("--set", setting)]
    return run("sweep", "press.yaml", "--engine", "in-process", *options, cwd=folder).stderr


def test_it_names_the_settings_that_differ_from_those_shown_until_now(tmp_path) -> None:
    (tmp_path / "press.yaml").write_text(TEXT)
    assert SHOWED not in sweep(tmp_path)
    assert SHOWED not in sweep(tmp_path)
    assert f"{SHOWED}supply.pressure, and now shows this one" in sweep(tmp_path, "supply.pressure=160 bar")
    assert SHOWED not in sweep(tmp_path, "supply.pressure=16 MPa")
    back = sweep(tmp_path)
    assert f"{SHOWED}supply.pressure, and now shows this one; earlier runs are kept" in back
    assert "0 computed, 1 stored before" in back
    assert SHOWED not in sweep(tmp_path)
