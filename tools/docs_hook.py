"""What MkDocs does beside its own while it builds the site: pages made from the code, links that leave the site."""

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

from tools.reference import pages

#: A link to a file of the repository that is no page.
OUTSIDE = re.compile(r"(?<!!)\[([^\]]+)\]\((?:\.\./)+((?:studies|wirewear|solvers|geometry|tests|tools)[^)#]*)\)")

#: A formula in TeX, which GitHub typesets and Markdown does not.
FORMULA = re.compile(r"^```math\n(.*?)\n```$", re.DOTALL | re.MULTILINE)


def on_config(config: Any) -> Any:
    """Pages that the menu does not name come last in it."""
    docs = Path(config.docs_dir)
    named = set(_named(config.nav))
    others = sorted(str(page.relative_to(docs)) for page in docs.rglob("*.md"))
    if left := [page for page in others if page not in named and not config.exclude_docs.match_file(page)]:
        config.nav.append({"More": left})
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the reference."""
    for name, text in pages().items():
        files.append(File.generated(config, f"reference/{name}", content=text))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Name files of the repository in place of links to them, which lead nowhere in the site; L2M4M's marks."""
    return FORMULA.sub(r"\n$$\1$$\n", OUTSIDE.sub(lambda link: f"{link[1]} (`{link[2]}`)", markdown))


def _named(nav: Any) -> list[str]:
    if isinstance(nav, str):
        return [nav]
    parts = nav.values() if isinstance(nav, dict) else nav
    return [page for part in parts for page in _named(part)]
