"""Commands as they are typed."""

from click.testing import CliRunner, Result

from wirewear.app.cli import cli


def wirewear(*words: object, code: int = 0) -> Result:
    """What a command ends with, and with that exit code."""
    ended = CliRunner().invoke(cli, [str(word) for word in words])
    assert ended.exit_code == code, ended.output or ended.exception
    return ended
