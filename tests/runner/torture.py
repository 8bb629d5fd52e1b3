"""Kill a sweep at random moments, go on, and compare the bits with an uninterrupted one.

python -m tests.runner.torture --kills 40 --runs 6000
"""

import argparse
import random
import tempfile
import time
from pathlib import Path

from tests.commands import run, run_json
from tests.runner.processes import kill, nobody_left, session_members, start, workers

CONFIG = """\
name: torture
record: {{duration: 20 s}}
store: {{signals: none}}
sweep:
  grid:
    leakage.internal_coefficient: {{linspace: [0, 3e-8, {leakages}]}}
    fluid.bulk_modulus: {{linspace: [551 MPa, 827 MPa, {moduli}]}}
"""


def torture(folder, n_kill, n_run, seed=0):
    """Returns how often the parent and how often a worker was killed; raises when the bits differ."""
    chance = random.Random(seed)
    config = folder / "torture.yaml"
    moduli = max(2, n_run // 20)
    config.write_text(CONFIG.format(leakages=20, moduli=moduli))
    whole, broken = folder / "whole" / "torture", folder / "broken" / "torture"
    began = time.monotonic()
    run("sweep", config, "--out", whole, check=0, timeout=300)  # in a process, as what is killed
    length = time.monotonic() - began
    kills = {"parent": 0, "worker": 0}
    while sum(kills.values()) < n_kill:
        process = start("sweep", config, "--out", broken, "--retry-failed")
        time.sleep(chance.uniform(0.15, 1.0) * length)
        if chance.random() < 0.5:
            kills["parent"] += kill(process.pid) and process.poll() is None
            process.wait()
        else:
            pids = workers(process.pid)
            kills["worker"] += bool(pids) and kill(chance.choice(pids))
            if chance.random() < 0.5:
                kill(process.pid)
        process.communicate()
        assert nobody_left(process.pid, 10.0), f"left behind: {session_members(process.pid)}"
        if sum(kills.values()) < n_kill and (broken / "torture.h5").exists():
            for path in sorted((broken / "shards").glob("*.h5"))[::2]:
                path.unlink()
            (broken / "torture.h5").unlink()
    run("sweep", config, "--out", broken, "--retry-failed", check=0)
    assert run_json("verify", broken)["sound"]
    assert (whole / "torture.h5").read_bytes() == (broken / "torture.h5").read_bytes(), "the bits differ"
    assert not list(broken.rglob(".*.part")), "half-written files are left"
    return kills


def main():
    parser = argparse.ArgumentParser()
    for name, usual in (("--kills", 40), ("--runs", 6000), ("--seed", 0)):
        parser.add_argument(name, type=int, default=usual)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        kills = torture(Path(folder), asked.kills, asked.runs, asked.seed)
    print(f"killed {kills}, seed {asked.seed}: the experiment file has the same bits")


if __name__ == "__main__":
    main()
