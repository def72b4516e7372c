"""How the house stands: files, lines, rooms, arrows between rooms, circles among files, longest file and function.

    python tools/house.py [TREE ...]

prints a column of figures for each tree of this repository, the present one without arguments: unpack another version
with `git archive VERSION | tar x -C FOLDER` to set it beside. Imports inside functions and those for typing alone count
as any other. A room is a folder at the root of wirewear/ with all that it holds, or a
module there.
"""

import ast
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from statistics import median

Graph = dict[str, set[str]]

CODE = ("geometry", "solvers", "wirewear", "studies")


@cache
def nodes_of(file: Path) -> tuple[ast.AST, ...]:
    """All that a file says, read once."""
    return tuple(ast.walk(ast.parse(file.read_text(encoding="utf-8"), filename=str(file))))


def modules_of(root: Path, package: str = "wirewear") -> dict[str, Path]:
    """Dotted names of the modules of a package under a tree, with their files."""
    found = {}
    for file in sorted((root / package).rglob("*.py")):
        parts = file.relative_to(root).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imports_among(modules: Mapping[str, Path]) -> Graph:
    """For each module those of the same mapping that it imports, wherever in the file that stands."""
    return {
        name: {target for target in _imported(name, file, modules) if target != name} for name, file in modules.items()
    }


def _imported(name: str, file: Path, modules: Mapping[str, Path]) -> Iterator[str]:
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    for node in nodes_of(file):
        match node:
            case ast.Import(names=names):
                yield from (alias.name for alias in names if alias.name in modules)
            case ast.ImportFrom(names=names):
                above = package.rsplit(".", node.level - 1)[0] if node.level else ""
                base = ".".join(filter(None, (above, node.module)))
                # `from package import module` is an import of the module.
                wanted = (f"{base}.{alias.name}" for alias in names)
                yield from (full if full in modules else base for full in wanted if full in modules or base in modules)
            case ast.Call(
                func=ast.Name(id="import_module" | "__import__") | ast.Attribute(attr="import_module"),
                args=[ast.Constant(value=str(called)), *_],
            ) if called in modules:
                yield called
            case ast.Call(func=ast.Name(id="elsewhere"), args=[ast.Constant(value=str(place))]):
                yield place.partition(":")[0]


def circles(graph: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Sets of nodes that all reach one another, of two or more, largest first (Tarjan, 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in graph.get(node, ()):
            if other not in index:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == index[node]:
            cut = stack.index(node)
            component = sorted(stack[cut:])
            del stack[cut:]
            if len(component) > 1:
                found.append(component)

    for node in graph:
        if node not in index:
            visit(node)
    return sorted(found, key=len, reverse=True)


def room_of(name: str) -> str:
    """The folder at the root in which a module stands, or the module itself there."""
    return ".".join(name.split(".")[:2])


def rooms_among(modules: Mapping[str, Path]) -> Graph:
    """For each room those whose modules it imports; what the package offers of its rooms is no arrow."""
    rooms: Graph = {room_of(name): set() for name in modules}
    for name, targets in imports_among(modules).items():
        if "." in name:
            rooms[room_of(name)] |= {room_of(target) for target in targets} - {room_of(name)}
    return rooms


#: Names of kinds, and classes and questions that distinguish one kind of contact from another.
_NAMES = {"crossed-wires", "line-contact"}
_KINDS = {
    "ExperimentRecord", "JointStudy", "JointTables", "LineRecord", "LineRecordTables", "LineStates", "LineStudy",
    "LineTables", "PointRecordTables", "Study", "is_line_record",
}  # fmt: skip
_LENGTHS = {"length_mm", "per_mm", "length_um"}  #: What only a line contact has, or has above 0.
_PAIRS = {"WIRES", "BODIES"}  #: Names of the bodies of one kind.
#: Where kinds are described, and where plane and space are distinguished: meshes, runs, surrogate, pictures.
_MAY_ASK = {"kinds", "surrogate", "simulation", "pictures", "verification", "test"}


def branches_on_kinds(files: Iterable[Path]) -> int:
    """How often code asks which kind of contact it has before it, by whatever word."""
    return len(questions(files))


def questions(files: Iterable[Path]) -> list[tuple[Path, int]]:
    """Files and lines that ask for the kind of contact."""
    return sorted((file, getattr(node, "lineno", 0)) for file in files for node in nodes_of(file) if _asks(node))


def _asks(node: ast.AST) -> bool:
    asked: list[ast.AST] = []
    match node:
        case ast.Call(func=ast.Name(id="isinstance" | "issubclass"), args=[_, kinds]):
            return bool({name.id for name in ast.walk(kinds) if isinstance(name, ast.Name)} & _KINDS)
        case ast.Compare(left=left, comparators=others):
            asked = [left]
            if any(map(_is_word_of_a_kind, (left, *others))):
                return True
        case ast.BoolOp(values=values) | ast.comprehension(ifs=values):
            asked = [*values]
        case ast.If(test=test) | ast.IfExp(test=test) | ast.While(test=test):
            asked = [test]
        case ast.UnaryOp(op=ast.Not(), operand=one) | ast.Call(func=ast.Name(id="bool"), args=[one]):
            asked = [one]
        case ast.MatchClass(cls=ast.Name(id=name)):
            return name in _KINDS
        case ast.Call(func=ast.Name(id=name)) | ast.Attribute(attr=name):
            return name in _KINDS and name.startswith("is_")
    return any(map(_is_length, asked))


def _is_length(node: ast.AST) -> bool:
    """Whether a node is a length that other contacts do not have."""
    match node:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name in _LENGTHS
    return False


def _is_word_of_a_kind(node: ast.AST) -> bool:
    """Whether a node is a name of a kind, of its bodies, or the dimension of what its bodies are meshed of."""
    match node:
        case ast.Constant(value=value):
            return value in _NAMES
        case ast.Name(id=name):
            return name in _PAIRS
        case ast.Attribute(value=ast.Name(id="kinds")):
            return True
        case ast.Subscript(value=ast.Attribute(value=ast.Attribute(attr="points"), attr="shape")):
            return True
    return False


def anys(file: Path) -> Iterator[tuple[str, ast.expr]]:
    """Each annotation with `Any`, of an argument or a result of a function whose name has no underscore first.

    The shape of an array, NDArray[Any], is none; a name that stands for such an annotation in the same file is one.
    """
    named = {
        target.id
        for node in nodes_of(file)
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and _says_any(node.value, set())
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name) and not isinstance(node.value, ast.Call)
    }
    for node in nodes_of(file):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not node.name.startswith("_"):
            arguments = (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)
            for one in (*(own.annotation for own in arguments), node.returns):
                if one is not None and _says_any(one, named):
                    yield node.name, one


def _says_any(annotation: ast.expr, named: set[str]) -> bool:
    match annotation:
        case ast.Subscript(value=ast.Name(id="NDArray")):
            return False
        case ast.Name(id=name):
            return name == "Any" or name in named
    return any(_says_any(inner, named) for inner in ast.iter_child_nodes(annotation) if isinstance(inner, ast.expr))


def weights(root: Path) -> dict[str, float]:
    """What has a budget: lines, files, rooms, arrows, questions for the kind of contact, share of lines that import."""
    code = {name: sorted((root / name).rglob("*.py")) for name in (*CODE, "tests")}
    lines = {name: sum(_lines(file) for file in files) for name, files in code.items()}
    packages = [file for name in CODE[:3] for file in code[name]]
    importing = sum(
        1 + int(node.end_lineno or node.lineno) - node.lineno
        for file in code["wirewear"]
        for node in nodes_of(file)
        if isinstance(node, ast.Import | ast.ImportFrom)
    )
    rooms = rooms_among(modules_of(root))
    return {
        "lines of geometry, solvers and wirewear": sum(lines[name] for name in CODE[:3]),
        "lines of wirewear": lines["wirewear"],
        "lines of studies": lines["studies"],
        "lines of tests": lines["tests"],
        "files of geometry, solvers and wirewear": len(packages),
        "rooms of wirewear": len(rooms),
        "arrows between rooms": sum(map(len, rooms.values())),
        "questions for the kind of contact": branches_on_kinds(
            file for file in code["wirewear"] if not _MAY_ASK & {*file.parts}
        ),
        "Any in public signatures": sum(len([*anys(file)]) for file in packages),
        "lines of wirewear that import, per cent": round(100.0 * importing / lines["wirewear"], 1),
    }


def _lines(file: Path) -> int:
    return file.read_text(encoding="utf-8").count("\n")


def figures(root: Path) -> dict[str, str]:
    """The figures of a tree, by what they are."""
    files = [file for package in CODE for file in sorted((root / package).rglob("*.py"))]
    texts = [file.read_text(encoding="utf-8") for file in files]
    lines = [text.count("\n") for text in texts]
    functions = [
        (1 + int(node.end_lineno or node.lineno) - node.lineno, node.name)
        for text in texts
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    modules = modules_of(root)
    rooms, found = rooms_among(modules), circles(imports_among(modules))
    at_root = [name for name in modules if name.count(".") == 1]
    packages = [name for name in at_root if modules[name].name == "__init__.py"]
    longest = max(range(len(files)), key=lambda i: lines[i])
    longest_function = max(functions)
    return {
        "files": f"{len(files)}",
        "lines": f"{sum(lines)}",
        "file, median": f"{median(lines):.0f}",
        "file, longest": f"{lines[longest]} ({files[longest].relative_to(root)})",
        "function, median": f"{median(length for length, _ in functions):.0f}",
        "function, longest": f"{longest_function[0]} ({longest_function[1]})",
        "folders at the root of wirewear/": f"{len(packages)}",
        "loose modules there": f"{len(at_root) - len(packages)}",
        "rooms": f"{len(rooms)}",
        "arrows between rooms": f"{sum(map(len, rooms.values()))}",
        "circles among files": f"{len(found)}" + (f" (of {len(found[0])} files)" if found else ""),
    }


def main() -> None:
    """Print the figures of the trees that are given."""
    roots = [Path(argument) for argument in sys.argv[1:]] or [Path(__file__).resolve().parent.parent]
    columns = [figures(root) for root in roots]
    for name in columns[0]:
        print(f"| {name} |" + "".join(f" {column[name]} |" for column in columns))


if __name__ == "__main__":
    main()
