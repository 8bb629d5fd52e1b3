"""docs/measured.md and the schema say what is so."""

import gzip
import json
import re
import subprocess
import sys

import numpy as np

from hydrofdi.records.measured.columns import NAMES
from hydrofdi.records.measured.source import measured_source
from tests.commands import run
from tests.conftest import REPOSITORY
from tests.records.measuring import P1, SUPPLY, described

PAGE = (REPOSITORY / "docs" / "measured.md").read_text(encoding="utf-8")


def test_the_example_of_the_page_reads_a_file_as_it_says(tmp_path):
    example, *_ = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
    time = np.arange(9000)
    voltage = np.where(time // 1000 % 4 < 2, 2, -2)
    columns = [time, 100 + time % 7, 90 + time % 5, 4 + time % 2, -0.05 * (time % 4000), voltage]
    rows = "\n".join(
        ";".join(f"{value:g}".replace(".", ",") for value in row) for row in np.transpose(columns)
    )
    folder = tmp_path / "runs" / "unit 7"
    folder.mkdir(parents=True)
    header = "t [ms];P1 [bar];P2;I_s [mA];x;u\n"
    (folder / "sealed 3.csv.gz").write_bytes(gzip.compress((header + rows).encode()))
    batch = next(measured_source(described(tmp_path, example)).batches(labels=True))
    assert batch.record_ids[0] == "runs/unit 7/sealed 3.csv.gz#1"
    assert (batch.groups[0].split(",")[0], batch.labels[0]) == ("7", "sealed")
    assert batch.n_time == 2000
    assert 100e5 <= batch[P1].min() <= batch[P1].max() <= 106e5
    np.testing.assert_allclose(np.unique(batch[SUPPLY]), [0.0, 15.625e5], atol=1e-6)


def test_the_page_names_every_remark():
    package = REPOSITORY / "hydrofdi" / "records" / "measured"
    sources = "".join(file.read_text(encoding="utf-8") for file in package.rglob("*.py"))
    kinds = set(re.findall(r'kind="(\w+)"', sources)) | {"clipped", "saturated"}
    assert len(kinds) > 10
    assert {kind for kind in kinds if f"`{kind}`" not in PAGE} == set()


def test_the_page_lists_the_names_that_plain_files_are_read_by():
    for channel, names in NAMES.items():
        assert f"| `{channel}` | {names} |" in PAGE


def test_the_kept_schemas_and_pages_are_those_of_the_models():
    generator = REPOSITORY / "docs" / "generate_configuration.py"
    subprocess.run([sys.executable, str(generator), "--check"], check=True)
    kept = json.loads((REPOSITORY / "configs" / "measured-schema.json").read_text())
    assert kept == json.loads(run("schema", "measured", check=0).stdout)
    assert kept["properties"]["channels"]["propertyNames"]
