"""Faults that a reader meets, counted and listed: what is asked for once, named for nobody, or left without a type.

    python -m tools.faults [PATH ...]       every fault of the files below the paths; the packages by default

`Any` in the signature of a public function; constants after a file's first function, which begin a second topic, and
a file whose docstring names two; numbers with a name that are used once; private helpers of few lines with one caller.
"""

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from tools.house import anys

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("geometry", "solvers", "wirewear")
SHORT = 7  #: Lines of a helper that its one caller may as well say itself.

#: Where no statement can stand.
_INSIDE = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp, ast.Lambda, ast.BoolOp, ast.IfExp)

Fault = tuple[str, Path, int, str]  #: Its kind, where it is, and what it is called.


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def faults(files: Iterable[Path]) -> list[Fault]:
    """All faults of files, which are read together: who uses a name may stand in another one, or in a test."""
    files = list(files)
    used = Counter(name for file in {*files, *files_below(ROOT / "tests")} for name in _names(_tree(file)))
    return [fault for file in files for fault in (*_anys(file), *_topics(file), *_once(file, used))]


def _names(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name, ctx=ast.Load()) | ast.Attribute(attr=name):
                yield name
            case ast.Constant(value=str(text)) if re.fullmatch(r"[\w.:]+", text):
                yield from re.split(r"[.:]", text)


def _anys(file: Path) -> Iterator[Fault]:
    yield from (("Any", file, one.lineno, f"{name}: {ast.unparse(one)}") for name, one in anys(file))


def _topics(file: Path) -> Iterator[Fault]:
    tree = _tree(file)
    if ";" in (ast.get_docstring(tree) or "").split("\n\n")[0]:
        yield "two topics in a docstring", file, 1, file.stem
    defined: set[str] = set()
    for node in tree.body:
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.AsyncFunctionDef(name=name):
                defined.add(name)
            case (
                ast.Assign(targets=[ast.Name(id=name)], value=value)
                | ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value)
            ) if defined and name.isupper() | name.lstrip("_").isupper():
                if not defined & {inner.id for inner in ast.walk(value) if isinstance(inner, ast.Name)}:
                    yield "constant after functions", file, node.lineno, name
                defined.add(name)
            case _:
                pass


def _outside(tree: ast.AST, inside: tuple[type[ast.AST], ...]) -> Iterator[ast.AST]:
    """All nodes that do not stand inside some kinds of expressions."""
    yield tree
    for node in ast.iter_child_nodes(tree):
        if not isinstance(node, inside):
            yield from _outside(node, inside)


def _once(file: Path, used: Counter[str]) -> Iterator[Fault]:
    for node in _tree(file).body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Constant(value=int() | float())):
                if used[name] == 1:
                    yield "constant used once", file, node.lineno, name
            case ast.FunctionDef(name=name, decorator_list=[]) if name.startswith("_") and used[name] == 1:
                body = node.body[1:] if ast.get_docstring(node) else node.body
                short = body and 1 + int(body[-1].end_lineno or 0) - node.lineno <= SHORT
                # What is kept by a decorator, handed over by its name, or returns early, has to be a function, and what
                # takes statements where only an expression can stand: in a comprehension, or after "and" or "if".
                called = any(
                    isinstance(one, ast.Call) and isinstance(one.func, ast.Name) and one.func.id == name
                    for one in _outside(_tree(file), _INSIDE if len(body) > 1 else ())
                )
                at_its_end = [one for one in ast.walk(node) if isinstance(one, ast.Return)] in ([], body[-1:])
                if short and called and at_its_end:
                    yield "short helper of one caller", file, node.lineno, name
            case _:
                pass


def files_below(*paths: Path) -> list[Path]:
    """The Python files of these files and folders."""
    return [file for path in paths for file in (sorted(path.rglob("*.py")) if path.is_dir() else [path])]


def main() -> None:
    """List the faults of the files below the paths that are asked for, and count those of all packages."""
    found = faults(files_below(*(ROOT / name for name in PACKAGES)))
    asked = set(files_below(*(Path(one).resolve() for one in sys.argv[1:]))) if sys.argv[1:] else None
    for kind, file, line, name in found:
        if asked is None or file in asked:
            print(f"{file.relative_to(ROOT)}:{line}: {kind}: {name}")
    print(dict(Counter(kind for kind, *_ in found)))


if __name__ == "__main__":
    main()
