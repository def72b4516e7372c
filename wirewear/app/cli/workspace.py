"""The command that opens a workspace in a browser."""

from pathlib import Path

import click

from wirewear.app.cli.group import Given, OutputFolder, cli


@cli.command(name="open")
@click.argument("paths", metavar="[RECORD|RESULT|FILES]...", nargs=-1, type=Given())
@click.option("--output", metavar="DIR", type=OutputFolder(), default="runs/open", show_default=True,
              help="Where files and answers are kept; the same folder goes on.")  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="[default: any that is free]")
@click.option("--no-browser", is_flag=True, help="Print the address alone.")
def open_command(paths: tuple[Path, ...], output: Path, port: int, no_browser: bool) -> None:
    """Work in a browser: drop a logger's files, import, check, fit and diagnose them. Nobody else can see the pages."""
    import webbrowser

    from wirewear.app.web.server import WorkspaceServer
    from wirewear.app.web.workspace import Workspace
    from wirewear.base.locks import occupied

    with occupied(output, "open"):
        workspace = Workspace(output)
        for path in paths:
            workspace.take(path)
        with WorkspaceServer(workspace, port) as server:
            click.echo(f"Open this address in a browser: {server.url}\nKeep this running; Ctrl-C ends it.")
            try:
                if not no_browser:
                    webbrowser.open(server.door().as_uri())
                server.serve_forever()
            finally:
                workspace.stop()
