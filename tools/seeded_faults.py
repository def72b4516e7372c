"""How many seeded faults the tests catch: those of every commit, and all of them.

    python -m pip install --constraint constraints.txt coverage
    python -m tools.seeded_faults record runs/faults                    which test runs which line, in an hour or more
    python -m tools.seeded_faults seed runs/faults --count 200          faults one at a time, in a copy of the tree

A fault is a sign, a factor, an index, a comparison, a body or a bound of a loop that is another. Tests that run its
line decide, those that run least first. What tests of every commit let pass is given to slow ones too. Lines of
compiled functions count as run where a line that names the function is. faults.jsonl holds a row for each fault.
"""

import ast
import json
import os
import random
import re
import shutil
import sqlite3
import subprocess
import sys
from argparse import ArgumentParser
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("geometry", "solvers", "wirewear")
COPIED = (*PACKAGES, "studies", "tests", "tools", "docs", "pyproject.toml", "README.md", "Makefile", "mkdocs.yml")
MOST_TESTS, SECONDS = 80, 600

_SIGNS = {ast.Add: ast.Sub, ast.Sub: ast.Add}
_FACTORS = {ast.Mult: ast.Div, ast.Div: ast.Mult}
_TURNED = {ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE}
_BODIES = (("upper", "lower"), ("moving", "fixed"), ("primary", "secondary"), ("first", "second"))
_SILENT = (ast.JoinedStr, ast.Raise, ast.AnnAssign, ast.Import, ast.ImportFrom)


class Fault(NamedTuple):
    """One change of one line."""

    file: str
    line: int
    column: int
    end: int
    kind: str
    text: str


def _other_body(name: str) -> str:
    """The name of the same of the other body, or nothing."""
    others = [(one, other) for pair in _BODIES for one, other in (pair, pair[::-1]) if one in name.split("_")]
    return name.replace(*others[0]) if others else ""


def _changed(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """The kinds of fault that a node can have, each with the node that stands in its place."""
    match node:
        case ast.BinOp(left=left, op=op, right=right):
            for kind, others in (("sign", _SIGNS), ("factor", _FACTORS)):
                if type(op) in others:
                    yield kind, ast.BinOp(left, others[type(op)](), right)
        case ast.UnaryOp(op=ast.USub(), operand=ast.Name() | ast.Call() | ast.Attribute() as operand):
            yield "sign", operand
        case ast.Constant(value=float(value)) if value:
            yield "factor", ast.Constant(2 * value)
        case ast.Subscript(value=value, slice=ast.Constant(value=int(place)), ctx=ast.Load()):
            yield "index", ast.Subscript(value, ast.Constant(1 if place == 0 else 0), ast.Load())
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _TURNED:
            yield "comparison", ast.Compare(left, [_TURNED[type(op)]()], [right])
        case ast.Call(func=ast.Name("range"), args=[*before, last], keywords=[]) if len(before) < 2:
            yield "off by one", ast.Call(node.func, [*before, ast.BinOp(last, ast.Sub(), ast.Constant(1))], [])
        case ast.Name(id=name) | ast.Attribute(attr=name) if isinstance(node.ctx, ast.Load) and _other_body(name):
            other = _other_body(name)
            yield "body", ast.Name(other) if isinstance(node, ast.Name) else ast.Attribute(node.value, other)


def faults_of(file: Path) -> Iterator[Fault]:
    """Every fault that a file can be given within a line."""

    def walk(node: ast.AST) -> Iterator[ast.AST]:
        yield node
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, _SILENT):
                yield from walk(child)

    text = file.read_text(encoding="utf-8")
    for node in walk(ast.parse(text)):
        for kind, other in _changed(node):
            if kind == "body" and not re.search(rf"\b{ast.unparse(other).rpartition('.')[2]}\b", text):
                continue
            if isinstance(node, ast.expr) and node.lineno == node.end_lineno and node.end_col_offset is not None:
                where = node.lineno, node.col_offset, node.end_col_offset
                yield Fault(file.relative_to(ROOT).as_posix(), *where, kind, f"({ast.unparse(other)})")


class Record:
    """Which test runs which line."""

    def __init__(self, folder: Path) -> None:
        """Read all that the processes of a session have left."""
        self.tests: dict[tuple[str, int], set[str]] = defaultdict(set)
        self.slow: set[str] = set()
        for path in folder.glob("slow.*"):
            self.slow |= set(path.read_text(encoding="utf-8").splitlines())
        for path in folder.glob("lines.*"):
            with sqlite3.connect(path) as data:
                rows = data.execute(
                    "SELECT path, context, numbits FROM line_bits JOIN file ON file.id = file_id"
                    " JOIN context ON context.id = context_id WHERE context LIKE 'tests/%'"
                )
                for file, test, bits in rows:
                    for byte, value in enumerate(bits):
                        for bit in range(8):
                            if value >> bit & 1:
                                self.tests[file, 8 * byte + bit].add(test)
        self.breadth = Counter(test for tests in self.tests.values() for test in tests)

    def of(self, fault: Fault) -> list[str]:
        """Tests that run a line, those that run least first."""
        found = self.tests.get((fault.file, fault.line)) or self._of_function(fault.file, fault.line, 3)
        return sorted(found, key=lambda test: (self.breadth[test], test))

    def _of_function(self, file: str, line: int, depth: int) -> set[str]:
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        within = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
        names = [node.name for node in within if node.lineno <= line <= (node.end_lineno or 0) and node.decorator_list]
        found: set[str] = set()
        if names and depth:
            for path in sorted((ROOT / Path(file).parts[0]).rglob("*.py")):
                for number, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                    if re.search(rf"(?<!def )\b{names[-1]}\(", text):
                        where = path.relative_to(ROOT).as_posix()
                        found |= self.tests.get((where, number)) or self._of_function(where, number, depth - 1)
        return found


def _fails(tree: Path, tests: list[str]) -> bool:
    """Whether one of these tests fails there, or does not come to its end."""
    environment = {**os.environ, "PYTHONPATH": str(tree), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-x", "--all", "-p", "no:cacheprovider", *tests[:MOST_TESTS]]
    try:
        done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return True
    return done.returncode == 1


def seed(folder: Path, count: int, number: int) -> None:
    """Seed faults where tests run, as many of each kind, and write who catches them."""
    record, tree, draw = Record(folder), folder / "tree", random.Random(number)
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        if not (tree / name).exists():
            tree.mkdir(parents=True, exist_ok=True)
            copy(ROOT / name, tree / name)
    kinds = defaultdict(list)
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*.py")):
            for fault in faults_of(file):
                kinds[fault.kind].append(fault)
    for place in range(count):
        faults = kinds[sorted(kinds)[place % len(kinds)]]
        fault = draw.choice(faults)
        while not (tests := record.of(fault)):
            fault = draw.choice(faults)
        path = tree / fault.file
        sound = (ROOT / fault.file).read_text(encoding="utf-8")
        lines = sound.splitlines(keepends=True)
        line = lines[fault.line - 1].encode()
        lines[fault.line - 1] = (line[: fault.column] + fault.text.encode() + line[fault.end :]).decode()
        path.write_text("".join(lines), encoding="utf-8")
        soon = [test for test in tests if test not in record.slow]
        late = [test for test in tests if test in record.slow]
        short = bool(soon) and _fails(tree, soon)
        row = fault._asdict() | {"tests": len(soon), "slow": len(late), "short": short}
        row["long"] = short or (bool(late) and _fails(tree, late))
        path.write_text(sound, encoding="utf-8")
        with (folder / "faults.jsonl").open("a", encoding="utf-8") as log:
            log.write(json.dumps(row) + "\n")
        print(row, flush=True)
    rows = [json.loads(row) for row in (folder / "faults.jsonl").read_text(encoding="utf-8").splitlines()]
    print(f"{len(rows)} faults: {sum(r['short'] for r in rows)} are caught by the short tests,", end=" ")
    print(f"{sum(r['long'] for r in rows)} by all")


if os.environ.get("RECORDED_IN"):  # a plug-in of pytest within `record`
    import coverage

    _lines = coverage.Coverage(
        f"{os.environ['RECORDED_IN']}/lines.{os.getpid()}",
        source=[str(ROOT / name) for name in PACKAGES],
        messages=False,
    )
    _lines.set_option("run:relative_files", True)
    _lines.set_option("run:disable_warnings", ["no-data-collected"])
    _lines.start()

    def pytest_runtest_setup(item: pytest.Item) -> None:
        """Lines are this test's from here on."""
        _lines.switch_context(item.nodeid)
        if item.get_closest_marker("slow"):
            with Path(os.environ["RECORDED_IN"], f"slow.{os.getpid()}").open("a", encoding="utf-8") as log:
                log.write(f"{item.nodeid}\n")

    def pytest_sessionfinish() -> None:
        """Keep them."""
        _lines.stop()
        _lines.save()


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("what", choices=("record", "seed"))
    parser.add_argument("folder", type=lambda text: Path(text).resolve())
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("tests", nargs="*", help="what pytest is given besides, after --")
    asked = parser.parse_args()
    if asked.what == "seed":
        seed(asked.folder, asked.count, asked.seed)
    else:
        asked.folder.mkdir(parents=True, exist_ok=True)
        recorded = [sys.executable, "-m", "pytest", "-p", "tools.seeded_faults", "--all", *asked.tests]
        sys.exit(subprocess.run(recorded, env={**os.environ, "RECORDED_IN": str(asked.folder)}, check=False).returncode)
