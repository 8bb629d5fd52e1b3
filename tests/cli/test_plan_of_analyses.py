"""Plans of sweeps whose runs are analysed in different ways."""

from __future__ import annotations

import pytest

from tests.commands import run


@pytest.mark.parametrize("wavelet", ["wavelet.levels: [4, 5]", "wavelet.phase: [0, 3, all]"])
def test_a_plan_meets_features_of_different_shapes(tmp_path, monkeypatch, wavelet):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mixed.yaml").write_text(
        f"name: mixed\nrecord: {{duration: 4 s}}\nstore: {{signals: none}}\nsweep: {{grid: {{{wavelet}}}}}\n"
    )
    assert "to compute" in run("plan", "mixed.yaml", check=0).stdout
