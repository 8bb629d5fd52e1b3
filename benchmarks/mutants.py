"""How many small faults do the tests find? Put single faults into rooms and run the tests of each room.

::

    python benchmarks/mutants.py [--each 70] [--seed 1] [ROOM ...]

A fault swaps a comparison, an arithmetic operator, or 'and' and 'or', negates a condition, or adds one to a
number. The tests run on a copy of the repository. Prints the faults that no test finds, and a count for each
room (hours).
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TESTS = {
    "evaluation": ["tests/evaluation", "tests/studies", "tests/report/detection"],
    "store": ["tests/store", "tests/identity", "tests/runner", "tests/api"],
    "indicators/estimation": ["tests/estimation", "tests/indicators", "tests/detectors"],
}
LEFT_OUT = (".venv", ".git", "site", "__pycache__", "_gallery")
SWAPPED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Add: ast.Sub,
    ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


def places(tree):
    """Nodes of the functions that can have a fault, always in the same order."""
    for function in [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]:
        for node in (node for part in function.body for node in ast.walk(part)):
            operator = getattr(node, "op", getattr(node, "ops", [None])[0])
            is_number = isinstance(node, ast.Constant) and type(node.value) in (int, float)
            if is_number or type(operator) in SWAPPED or isinstance(node, ast.If | ast.IfExp):
                yield node


def with_fault(source, index):
    """(line, text before, text after, source) of the fault at one place."""
    tree = ast.parse(source)
    node = list(places(tree))[index]
    before = ast.unparse(node).partition("\n")[0]
    if isinstance(node, ast.Constant):
        node.value += 1
    elif isinstance(node, ast.Compare):
        node.ops[0] = SWAPPED[type(node.ops[0])]()
    elif isinstance(node, ast.If | ast.IfExp):
        node.test = ast.UnaryOp(ast.Not(), node.test)
    else:
        node.op = SWAPPED[type(node.op)]()
    return node.lineno, before, ast.unparse(node).partition("\n")[0], ast.unparse(tree)


def is_found(copy, tests):
    """Whether a test fails, or does not end."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not long", *tests]
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, timeout=900)
    except subprocess.TimeoutExpired:
        return True
    return done.returncode != 0


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("rooms", nargs="*", default=list(TESTS), metavar="ROOM")
    parser.add_argument("--each", type=int, default=70)
    parser.add_argument("--seed", type=int, default=1)
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(*LEFT_OUT))
        for room in wanted.rooms:
            if is_found(copy, TESTS[room]):
                sys.exit(f"{room}: its tests fail without a fault")
            files = sorted((copy / "hydrofdi" / room).rglob("*.py"))
            faults = [(file, k) for file in files for k, _ in enumerate(places(ast.parse(file.read_text())))]
            chosen = random.Random(wanted.seed).sample(faults, min(wanted.each, len(faults)))
            n_found = 0
            for file, index in chosen:
                source = file.read_text()
                line, before, after, faulty = with_fault(source, index)
                file.write_text(faulty)
                found = is_found(copy, TESTS[room])
                file.write_text(source)
                n_found += found
                if not found:
                    print(f"{file.relative_to(copy)}:{line}: {before}  →  {after}", flush=True)
            print(f"{room}: {n_found} of {len(chosen)} faults found, of {len(faults)} possible", flush=True)


if __name__ == "__main__":
    main()
