"""The first look shows channels in the units of their files."""

from tests.commands import run

ROWS = "".join(f"{0.01 * n:.2f},{100 + n % 7},{20 + n % 3}\n" for n in range(50))


def inspected(folder, *arguments):
    lines = run("inspect", *arguments, cwd=folder).stdout.splitlines()
    rows = (line.split() for line in lines)
    return {row[0]: row[1:5] for row in rows if len(row) == 6}


def test_channels_are_shown_in_the_unit_of_their_file(tmp_path):
    (tmp_path / "a.csv").write_text(f"time [s],P1 [bar],x [mm]\n{ROWS}")
    channels = inspected(tmp_path, "a.csv")
    assert channels["chamber_1_pressure"] == ["bar", "100", "102.9", "106"]
    assert channels["piston_position"] == ["mm", "20", "20.98", "22"]


def test_si_and_files_of_different_units_are_shown_by_size(tmp_path):
    si = ROWS.replace(",10", ",1000000")
    (tmp_path / "si.csv").write_text(f"time [s],P1 [Pa],x [mm]\n{si}")
    assert inspected(tmp_path, "si.csv")["chamber_1_pressure"][0] == "MPa"
    for name, unit in (("b", "bar"), ("p", "psi")):
        (tmp_path / f"{name}.csv").write_text(f"time [s],P1 [{unit}],x [mm]\n{ROWS}")
    both = "files: '?.csv'\nchannels: {chamber_1_pressure: P1, piston_position: x}\ntime: {column: time}\n"
    (tmp_path / "both.yaml").write_text(both)
    assert inspected(tmp_path, "both.yaml")["chamber_1_pressure"][0] == "MPa"


def test_counts_have_no_unit_to_show(tmp_path):
    (tmp_path / "raw.csv").write_text(f"time [s],P1 [counts],x [mm]\n{ROWS}")
    assert inspected(tmp_path, "raw.csv")["chamber_1_pressure"] == ["counts", "100", "102.9", "106"]
