"""A study from wherever it is written."""

from pathlib import Path

from wirewear.study import Study, load_study, parse_study


def load(source: str | Path) -> Study:
    """Read a study from a file, or from text that is one: TOML of more than one line.

    Raises:
        StudyError: there is no such file, or it is no valid study; the message is one sentence.
    """
    if isinstance(source, str) and "\n" in source.strip():
        return parse_study(source, "the text given")
    return load_study(source)
