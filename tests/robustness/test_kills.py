"""Commands killed at random moments, on disks that fill up, and without permissions: nothing is lost or wrong.

Each command is run once undisturbed, with an empty cache and with a full one. Then it is killed at a random moment, or
its disk fills up, or it may not read or write something. It must end by itself in one sentence, unless it was killed or
went on without; then it is given again, and its end must be that of the undisturbed one, bit by bit. What lay in its
output folder before must be there, and nothing may be left beside it.

Disks are file systems in memory where those may be made, else a largest size of file (RLIMIT_FSIZE). Where permissions
are taken, root counts as any user.
"""

import os
import shutil
import subprocess
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import pytest
from hypothesis import settings

from tests.robustness.commands import BEFORE, COMMANDS, Command, make_given, prepared
from tests.robustness.forked import Commands, Ended, Hardship

#: Shares of trials with an empty cache, and of those in a process that loads everything itself.
EMPTY, WHOLE = 0.3, 0.1


@dataclass
class Scene:
    """Where commands meet hardships; `tally` counts how they ended."""

    base: Path
    commands: Commands
    random: Random
    tally: Counter[str] = field(default_factory=Counter)

    @property
    def given(self) -> Path:
        """What commands read."""
        return self.base / "given"

    @property
    def cache(self) -> Path:
        """A cache that holds all that they keep."""
        return self.base / "cache"

    def ended(self, name: str, what: str, ended: Ended) -> Ended:
        """Count how a command ended that met something."""
        how = {0: "went on", 2: "one sentence" if ended.sentence else "no sentence", -9: "killed"}
        self.tally[f"{name}, {what}: {how.get(ended.status, f'exit code {ended.status}')}"] += 1
        return ended


@dataclass(frozen=True)
class Undisturbed:
    """What comes out of a command when nothing happens, and how long it takes with a full cache and an empty one."""

    outcome: dict[str, str]
    seconds: float
    seconds_empty: float


def undisturbed(scene: Scene, command: Command) -> Undisturbed:
    """A command run in peace, twice. Raises RuntimeError if it fails, or the two do not come out alike."""
    outcomes, seconds = [], []
    for name, cache in (("empty", None), ("filled", scene.cache), ("whole", scene.cache)):
        folder = prepared(scene.base / command.name / name, scene.given)
        ended = scene.commands.run(folder, command.first, cache or folder / "cache")
        if ended.status != 0:
            raise RuntimeError(f"{command.name} ended with {ended.status}: {ended.last_words}")
        outcomes.append(command.outcome(folder))
        seconds.append(ended.seconds)
    differ = sorted(name for name, own in outcomes[0].items() if any(one.get(name) != own for one in outcomes))
    if differ:
        raise RuntimeError(f"{command.name} does not come out alike twice: {', '.join(differ[:5])}")
    # On a busy machine either may have taken long: a kill is to come before the end.
    return Undisturbed(outcomes[-1], min(seconds[1:]), seconds[0])


def remains(folder: Path) -> list[str]:
    """What killed writers have left and nobody has cleared away."""
    return [path.name for path in folder.rglob(".*") if ".partial" in path.name or path.name == ".wirewear-lock"]


def given_again(scene: Scene, command: Command, folder: Path, cache: Path, expected: Undisturbed) -> Iterator[str]:
    """Complaints about a command that is given again when all is well; its folder goes if there are none."""
    ended = scene.commands.run(folder, command.again, cache)
    before = folder / command.output / BEFORE
    if ended.status != 0:
        yield f"given again, ended with {ended.status}: {ended.last_words}"
        return
    outcome = command.outcome(folder)
    if outcome != expected.outcome:
        names = {name for name, _ in outcome.items() ^ expected.outcome.items()}
        yield f"another outcome: {', '.join(sorted(names)[:4])}"
    elif left := remains(folder / command.output):
        yield f"{', '.join(left)} left behind"
    elif before.parent.with_name("had_before").exists() and before.read_text() != BEFORE:
        yield "a file from before is lost"


def something_before(folder: Path, command: Command) -> None:
    """A file in the output folder, where the command takes folders that hold others."""
    (folder / command.output).mkdir(exist_ok=True)
    if command.takes_full_folders:
        (folder / command.output / BEFORE).write_text(BEFORE)
        (folder / "had_before").write_text("")


def killed(scene: Scene, command: Command, expected: Undisturbed, folder: Path) -> Iterator[str]:
    """Complaints about a command that is killed at a random moment, perhaps twice, and given again."""
    random = scene.random
    prepared(folder, scene.given)
    something_before(folder, command)
    empty, whole = random.random() < EMPTY, random.random() < WHOLE
    cache = folder / "cache" if empty else scene.cache
    moments: list[float] = []
    for arguments in (command.first, command.again)[: random.choice((1, 1, 2))]:
        longest = (2.0 if whole else 0.0) + 1.05 * (expected.seconds_empty if empty else expected.seconds)
        moments.append(random.uniform(0.0, longest))
        ended = scene.commands.run(folder, arguments, cache, Hardship(kill_after_s=moments[-1]), whole=whole)
        scene.ended(command.name, "kills with an empty cache" if empty else "kills", ended)
        if ended.status not in (0, -9):
            yield f"ended with {ended.status}: {ended.last_words}"
    where = f"killed after {', '.join(f'{moment:.3f}' for moment in moments)} s{' on an empty cache' if empty else ''}"
    yield from (f"{where}: {one}" for one in given_again(scene, command, folder, cache, expected))


@contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Callable[[int], None] | None]:
    """A file system of so many bytes at a folder; yields what gives it another size, None where none may be made."""
    folder.mkdir(parents=True)
    options = ("mount", "-t", "tmpfs", "-o")
    made = subprocess.run([*options, f"size={size}", "tmpfs", str(folder)], capture_output=True, check=False)

    def resize(new: int) -> None:
        subprocess.run(["mount", "-o", f"remount,size={new}", str(folder)], check=True)

    try:
        yield resize if made.returncode == 0 else None
    finally:
        if made.returncode == 0:
            subprocess.run(["umount", "-l", str(folder)], check=True)


def on_full_disk(scene: Scene, command: Command, expected: Undisturbed, folder: Path) -> Iterator[str]:
    """Complaints about a command on a disk that fills up, perhaps after a kill, and given again when there is room."""
    random = scene.random
    with small_disk(folder, 2**28) as resize:
        prepared(folder, scene.given)
        something_before(folder, command)
        cache = folder / "cache" if random.random() < EMPTY else scene.cache
        if random.random() < 0.5:
            moment = random.uniform(0.0, expected.seconds)
            scene.commands.run(folder, command.first, cache, Hardship(kill_after_s=moment))
        whole = scene.base / command.name / ("empty" if cache != scene.cache else "whole")
        room = sum(path.stat().st_size for path in whole.rglob("*") if path.is_file())
        most = int(10.0 ** random.uniform(2.0, len(str(room)) - 0.7))
        if resize is None:
            met = Hardship(most_bytes=most)
        else:
            used = os.statvfs(folder)
            resize((used.f_blocks - used.f_bfree) * used.f_frsize + most)
            met = Hardship()
        ended = scene.commands.run(folder, command.again, cache, met)
        scene.ended(command.name, "full disks", ended)
        where = f"with {most} bytes of disk"
        if ended.status != 0 and not ended.sentence:
            yield f"{where}: ended with {ended.status}: {ended.last_words}"
        if list(folder.rglob("core*")):
            yield f"{where}: a core dump"
        if resize is not None:
            resize(2**28)
        yield from (f"{where}: {one}" for one in given_again(scene, command, folder, cache, expected))


def denials(folder: Path, command: Command, cache: Path) -> dict[str, dict[Path, int]]:
    """What a user may not do, by its name: the modes of files and folders."""
    output, reads = folder / command.output, folder / command.reads
    kept = dict.fromkeys(cache.iterdir(), 0) if cache.is_dir() else {}
    return {
        "the output takes no files": {output: 0o555},
        "the output cannot be entered": {output: 0o666},
        "the output cannot be listed": {output: 0o333},
        "what was there cannot be read": dict.fromkeys(output.rglob("*"), 0),
        "the folder takes no files": {folder: 0o555},
        "the folder cannot be entered": {folder: 0o666},
        "the input cannot be read": {reads: 0o000},
        "the cache takes no files": {cache: 0o555},
        "the cache cannot be entered": {cache: 0o000},
        "what is kept cannot be read": kept,
    }


def without_permission(scene: Scene, command: Command, expected: Undisturbed, folder: Path) -> Iterator[str]:
    """Complaints about a command that may not do something, perhaps after a kill, and given again when it may."""
    random = scene.random
    prepared(folder, scene.given)
    something_before(folder, command)
    cache = folder / "cache"
    if random.random() < 0.5:
        shutil.copytree(scene.cache, cache)
        cache.chmod(0o700)
    else:
        cache.mkdir(mode=0o700)
    if random.random() < 0.5:
        moment = random.uniform(0.0, expected.seconds)
        scene.commands.run(folder, command.first, cache, Hardship(kill_after_s=moment, common=True))
    what, modes = random.choice(sorted(denials(folder, command, cache).items()))
    before = {path: path.stat().st_mode for path in modes}
    after = random.choice((0.0, random.uniform(0.0, expected.seconds)))
    for path, mode in modes.items() if after == 0.0 else ():
        path.chmod(mode)
    met = Hardship(common=True, modes={str(path): mode for path, mode in modes.items()}, modes_after_s=after)
    ended = scene.commands.run(folder, command.again, cache, met)
    scene.ended(command.name, "permissions", ended)
    for path, mode in before.items():
        if path.exists():
            path.chmod(mode)
    if ended.status != 0 and not ended.sentence:
        yield f"{what} ({after:.3f} s): ended with {ended.status}: {ended.last_words}"
    yield from (f"{what} ({after:.3f} s): {one}" for one in given_again(scene, command, folder, cache, expected))


HARDSHIPS = {"kills": killed, "full": on_full_disk, "denied": without_permission}


def tried(scene: Scene, command: Command, expected: Undisturbed, what: str, trials: Iterable[int]) -> Iterator[str]:
    """Complaints about a command after trials of one hardship, each in a folder of its number."""
    for trial in trials:
        folder = scene.base / command.name / f"{what}{trial}"
        found = [f"{command.name}, {what} {trial}: {one}" for one in HARDSHIPS[what](scene, command, expected, folder)]
        yield from found
        if not found:
            shutil.rmtree(folder)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    """A folder with what commands read, and the process that starts them."""
    with Commands() as commands:
        made = Scene(tmp_path_factory.mktemp("hardships"), commands, Random(5))
        make_given(commands, made.given, made.cache)
        yield made


#: Trials of a command in all tests; a campaign of 10 000 examples makes 50 times as many of all commands together.
LEAST = {"kills": 2, "full": 1, "denied": 1}
#: Commands of which a few trials are made with all tests; a campaign tries every one.
FEW = ("run", "planar", "import", "export")


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_nothing_is_lost_or_wrong_after_kills_full_disks_and_lost_permissions(scene: Scene, command: Command) -> None:
    times = settings().max_examples / 10_000
    if times < 1 and command.name not in FEW:
        pytest.skip("is tried in campaigns")
    expected = undisturbed(scene, command)
    counts = {what: max(least, round(least * 50 * times * command.share)) for what, least in LEAST.items()}
    for what, count in counts.items():
        assert list(tried(scene, command, expected, what, range(count))) == []
    # A command takes longer at one time than at another: it may have ended before each of its kills.
    name, later = command.name, iter(range(counts["kills"], counts["kills"] + 30))
    while not scene.tally[f"{name}, kills: killed"] + scene.tally[f"{name}, kills with an empty cache: killed"]:
        assert list(tried(scene, command, expected, "kills", [next(later)])) == []
