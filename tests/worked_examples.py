"""The worked examples of docs/extending.md, installed from the page's own text or the file that it links to."""

import re
from dataclasses import dataclass
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parent.parent / "docs" / "extending.md"


@dataclass(frozen=True)
class WorkedExample:
    """What a section of the page gives beside its code."""

    #: Name of the entry point.
    name: str
    #: The TOML after the registration, such as a study's or a mapping's.
    tables: tuple[str, ...]


def install_example(title: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> WorkedExample:
    """Make the section's module and its entry point findable until the patches are undone."""
    section = next(part for part in PAGE.read_text(encoding="utf-8").split("\n## ") if part.startswith(f"{title}\n"))
    written = re.findall(r"```python\n# (\S+)\n(.*?)```", section, re.DOTALL)
    linked = [PAGE.parent / path for path in re.findall(r"\]\((\S+/plugin_example/\w+\.py)\)", section)]
    ((file, code),) = written or [(path.name, path.read_text(encoding="utf-8")) for path in linked]
    registration, *tables = re.findall(r"```toml\n(.*?)```", section, re.DOTALL)
    header, point = registration.strip().split("\n")
    group = re.fullmatch(r'\[project\.entry-points\."(.*)"\]', header)
    assert group is not None
    assert not linked or registration in (linked[0].parent / "pyproject.toml").read_text(encoding="utf-8")
    module = folder / file
    module.parent.mkdir(exist_ok=True)
    module.write_text(code, encoding="utf-8")
    metadata = folder / "plugin-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: plugin\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[{group[1]}]\n{point.replace(chr(34), '')}\n")
    monkeypatch.syspath_prepend(str(folder))
    return WorkedExample(point.split(" ")[0], tuple(tables))
