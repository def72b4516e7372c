"""What pyproject.toml cannot say: the examples of `wirewear.base.recognising` go into the package that is installed."""

from pathlib import Path
from shutil import copytree, ignore_patterns

from setuptools import setup
from setuptools.command.build_py import build_py

EXAMPLES = ("steel_wires", "ball_on_flat", "cylinder_on_flat")
LEFT_OUT = ignore_patterns("*.py", "*.md", "*.png", "__pycache__")


class WithExamples(build_py):
    """Modules and, unless they are installed in place, the examples."""

    def run(self) -> None:
        """Copy both."""
        super().run()
        if not self.editable_mode:
            for name in EXAMPLES:
                target = Path(self.build_lib) / "wirewear" / "examples" / name
                copytree(Path("studies") / name, target, ignore=LEFT_OUT, dirs_exist_ok=True)


setup(cmdclass={"build_py": WithExamples})
