"""What pyproject.toml cannot say: an installed package brings the examples of `wirewear.base.recognising`, and is the
only one to import, for `geometry` and `solvers` are common names: they lie within it.
"""

import re
from pathlib import Path
from shutil import copytree, ignore_patterns, move, rmtree

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.egg_info import egg_info

EXAMPLES = ("steel_wires", "ball_on_flat", "cylinder_on_flat")
LEFT_OUT = ignore_patterns("*.py", "*.md", "*.png", "__pycache__")
PARTS = ("geometry", "solvers")
OF_PARTS = re.compile(rf"^(\s*)(?:from ({'|'.join(PARTS)})\b|import ({'|'.join(PARTS)})$)", re.MULTILINE)


def _within(statement: re.Match[str]) -> str:
    indent, origin, name = statement.groups()
    return f"{indent}from wirewear.{origin}" if origin else f"{indent}from wirewear import {name}"


class OnePackage(build_py):
    """Modules and examples, unless they are installed in place."""

    def run(self) -> None:
        """Copy both, and move the parts into the package."""
        super().run()
        if self.editable_mode:
            return
        package = Path(self.build_lib) / "wirewear"
        for name in EXAMPLES:
            copytree(Path("studies") / name, package / "examples" / name, ignore=LEFT_OUT, dirs_exist_ok=True)
        for part in PARTS:
            rmtree(package / part, ignore_errors=True)
            move(package.with_name(part), package / part)
        for file in package.rglob("*.py"):
            file.write_text(OF_PARTS.sub(_within, file.read_text(encoding="utf-8")), encoding="utf-8")


class OneName(egg_info):
    """What is known of a package that is installed."""

    def run(self) -> None:
        """State which name it takes."""
        super().run()
        (Path(self.egg_info) / "top_level.txt").write_text("wirewear\n", encoding="utf-8")


setup(cmdclass={"build_py": OnePackage, "egg_info": OneName})
