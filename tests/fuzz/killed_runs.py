"""Runs that are killed at random moments: what they leave, and that they resume to the same bits.

`robustness.py` runs them. A seed names a command, a signal and a moment: a part of the time that
the command takes here, or a saved step. The same command runs again to its end, and its files are
compared bit by bit with those of an undisturbed run. POSIX only: children are searched for in
/proc.
"""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import roughcontact as rc

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
if str(BENCHMARKS) not in sys.path:
    sys.path.append(str(BENCHMARKS))

from items import items_of_file, normalize_text  # noqa: E402

SOURCE = Path(rc.__file__).parents[1]
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
# Time limits for the end of a process and of its children [s].
ENDS, CHILDREN = 10.0, 1.0
# As a shell reports a program that a signal ended.
STATUS = {number: (128 + number, -number) for number in SIGNALS}

RESUMED = "resumed to the same bits"
ENDED = "had ended before"
WRONG = "wrong"
VERDICTS = (RESUMED, ENDED, WRONG)

_MAP = "--unit um --size '0.1 mm' --young '210 GPa' --poisson 0.3 --yield-strength '1 GPa'"
_VOLUME = (
    "--unit um --size '0.3 mm' --young '210 GPa' --poisson 0.3 --yield-strength '1.6 GPa' "
    "--model elastoplastic --set tolerance=1e-3"
)
_PROJECT = """\
folder = "results"
write = ["nc", "csv"]

[materials.steel]
young = "210 GPa"
poisson = 0.3
yield-strength = "1 GPa"

[defaults]
unit = "um"
size = "0.1 mm"
material = "steel"

[[contact]]
name = "one"
file = "rough.npy"
load = ["0.2 N", "1 N"]

[[contact]]
name = "several"
file = "rough.npy"
task = "sweep"
from = "10 mN"
to = "0.5 N"
steps = 5
folder = "kept"
"""


@dataclass(frozen=True)
class Command:
    """A run to kill.

    Parameters
    ----------
    words : str
        Of the command line.
    outputs : tuple of str
        Files that the user requested; an old one of the name exists before.
    steps : str
        Pattern of the files that let a run continue.
    """

    words: str
    outputs: tuple[str, ...]
    steps: str = ""


COMMANDS = {
    "solve": Command(
        f"solve rough.npy {_MAP} --load '1 N' --output out.nc --output out.csv --report out.html",
        ("out.nc", "out.csv", "out.html"),
    ),
    "sweep": Command(
        f"sweep rough.npy {_MAP} --from '10 mN' --to '2 N' --steps 10 --folder kept "
        "--output out.csv",
        ("out.csv",),
        "kept/step-*.npz",
    ),
    "history": Command(
        f"history rough.npy {_MAP} --path '0.5 N, 0 N' --passes 3 --output out.csv "
        "--indented-surface out.x3p",
        ("out.csv", "out.x3p"),
    ),
    "volume": Command(
        f"solve ball.npy {_VOLUME} --load '0.6 N' --set increments=4 --folder kept --output out.nc",
        ("out.nc",),
        "kept/step-*.nc",
    ),
    "project": Command(
        "run project.toml",
        tuple(
            f"results/{name}.{suffix}"
            for name in ("one-0.2-N", "one-1-N")
            for suffix in ("nc", "csv")
        ),
        "results/*.json",
    ),
}


@dataclass(frozen=True)
class Reference:
    """Files of an undisturbed command, its time and that of its imports [s]."""

    files: dict[str, dict[str, str]]
    seconds: float
    begins: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """Outcome of a kill.

    Parameters
    ----------
    seed : int
        Source of the draw.
    command : str
        Of ``COMMANDS``.
    what : str
        The signal and the moment.
    verdict : str
        One of ``VERDICTS``.
    words : str
        Errors.
    kept : int
        Complete steps.
    seconds : float
        From the signal to the end of the process.
    children : float
        From there to the end of its last child.
    """

    seed: int
    command: str
    what: str
    verdict: str
    words: str = ""
    kept: int = 0
    seconds: float = 0.0
    children: float = 0.0

    def __str__(self) -> str:
        """Return everything in one line."""
        return (
            f"{self.seed}: {self.command}, {self.what}: {self.verdict}"
            f"{': ' if self.words else ''}{self.words} ({self.kept} steps kept, ended after "
            f"{self.seconds:.2f} s, its children {self.children:.2f} s later)"
        )


@dataclass(frozen=True)
class Kill:
    """A command, a signal, to whom it goes and when."""

    seed: int
    command: str
    number: signal.Signals
    group: bool
    part: float
    early: float
    # Number of saved steps after which it comes, instead of after a time.
    steps: int = 0

    @classmethod
    def draw(cls, seed: int) -> Kill:
        """Return the kill of a seed: commands and signals in turn, the moment at random."""
        rng = np.random.default_rng(seed)
        number = SIGNALS[seed // len(COMMANDS) % len(SIGNALS)]
        # Ctrl-C in a terminal reaches all processes at once.
        group = number == signal.SIGINT and rng.random() < 0.5
        # Some while the program is still being imported.
        early = float(rng.uniform(0.05, 0.6)) if rng.random() < 0.15 else 0.0
        name, part = list(COMMANDS)[seed % len(COMMANDS)], float(rng.uniform(0.05, 1.0))
        # The solves of small maps take a small part of the time.
        is_at_step = bool(COMMANDS[name].steps) and not early and rng.random() < 0.5
        steps = int(rng.integers(1, 4)) if is_at_step else 0
        return cls(seed, name, number, bool(group), part, early, steps)

    def moment(self, seconds: float) -> float:
        """Return when it comes in a command that takes ``seconds``, or after its step [s]."""
        return self.early or self.part * seconds * (0.01 if self.steps else 1.0)


# Commands -----------------------------------------------------------------------------------------


def inputs(folder: Path, points: int = 192) -> None:
    """Write the maps and the project file that the commands read."""
    folder.mkdir(parents=True, exist_ok=True)
    edge = 1e-4 / points
    heights = rc.self_affine(
        (points, points),
        (edge, edge),
        rms_height=2e-7,
        rolloff_wavelength=5e-5,
        cutoff_wavelength=6 * edge,
        rng=np.random.default_rng(1),
    )
    np.save(folder / "rough.npy", heights * 1e6)
    y, x = (np.mgrid[:40, :40] - 19.5) * 7.5e-6
    np.save(folder / "ball.npy", -(y**2 + x**2) / (2 * 105e-6 * 20) * 1e6)
    (folder / "project.toml").write_text(_PROJECT, encoding="utf-8")


def started(words: str, folder: Path) -> subprocess.Popen[bytes]:
    """Start a command in a separate session."""
    (folder / "tmp").mkdir(exist_ok=True)
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(SOURCE), os.environ.get("PYTHONPATH", "")]),
        "TMPDIR": str(folder / "tmp"),
        "COLUMNS": "200",
        "NO_COLOR": "1",
        "TERM": "dumb",
    }
    return subprocess.Popen(
        [sys.executable, "-m", "roughcontact", *shlex.split(words)],
        cwd=folder,
        env=environment,
        start_new_session=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def alive(session: int) -> list[int]:
    """Return the processes of a session that have not ended."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            # The name of a process may hold anything; state, parent, group, session follow it.
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] not in "ZX":
            found.append(int(entry.name))
    return found


def files_of(folder: Path) -> dict[str, Path]:
    """Return the files in a folder by their names in it."""
    return {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def read_content(path: Path, folder: Path) -> dict[str, str]:
    """Return the content of a file without times."""
    return {name: normalize_text(text, folder) for name, text in items_of_file(path).items()}


def reference(name: str, folder: Path) -> Reference:
    """Run a command to its end and return what it leaves."""
    inputs(folder)
    began = time.perf_counter()
    process = started(COMMANDS[name].words, folder)
    _, errors = process.communicate()
    seconds = time.perf_counter() - began
    if process.returncode:
        raise RuntimeError(f"{name} ends with {process.returncode}: {errors.decode()}")
    files = {file: read_content(path, folder) for file, path in files_of(folder).items()}
    began = time.perf_counter()
    started("--version", folder).communicate()
    begins = time.perf_counter() - began
    shutil.rmtree(folder)
    return Reference(files, seconds, begins)


# One kill -----------------------------------------------------------------------------------------


@dataclass
class Case:
    """A kill in its folder, and what was found to be wrong."""

    kill: Kill
    folder: Path
    whole: Reference
    faults: list[str] = field(default_factory=list)

    @property
    def command(self) -> Command:
        """Command that runs."""
        return COMMANDS[self.kill.command]

    def lay_out(self) -> None:
        """Write the inputs, and old files where the command is to write."""
        inputs(self.folder)
        for name in self.command.outputs:
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(self.old(name))

    def count_steps(self) -> int:
        """Return the number of complete steps."""
        steps = self.command.steps
        return len(list(self.folder.glob(steps))) if steps else 0

    @staticmethod
    def old(name: str) -> bytes:
        """Return the previous content of a file."""
        return f"an old {name}\n".encode()

    def look_at_files(self, after: str, strict: bool) -> None:
        """Find what is neither old nor whole; ``strict`` where no temporary file may be left."""
        for name, path in files_of(self.folder).items():
            if name not in self.whole.files:
                if strict:
                    self.faults.append(f"{after} {name} is left")
            elif name in self.command.outputs and path.read_bytes() != self.old(name):
                self._compare(after, name, path)

    def _compare(self, after: str, name: str, path: Path) -> None:
        try:
            found = read_content(path, self.folder)
        except Exception as error:
            self.faults.append(f"{after} {name} cannot be read ({type(error).__name__})")
            return
        if found != self.whole.files[name]:
            self.faults.append(f"{after} {name} holds something else")

    def look_at_end(self, status: int, errors: str) -> None:
        """Judge how the killed process ended and what it said."""
        number = self.kill.number
        if status not in STATUS[number]:
            self.faults.append(f"ended with status {status}")
        if number == signal.SIGKILL:
            return
        lines = errors.strip().splitlines()
        # Python itself may be hit before the program has begun.
        if not lines and self.kill.moment(self.whole.seconds) > 2 * self.whole.begins:
            self.faults.append("said nothing")
        if "Traceback" in errors and "roughcontact" in errors.partition("Traceback")[2]:
            self.faults.append(f"a traceback, {lines[-1]!r} at its end")
        elif "Traceback" not in errors and len(lines) > 1:
            self.faults.append(f"said {len(lines)} lines, {lines[0]!r} and more")
        elif lines and "Traceback" not in errors and not lines[0].startswith("roughcontact: "):
            self.faults.append(f"said {lines[0]!r}")

    def end(self) -> None:
        """Run the command again to its end and compare."""
        process = started(self.command.words, self.folder)
        _, errors = process.communicate()
        if process.returncode:
            self.faults.append(
                f"run again, it ends with status {process.returncode}: {errors.decode().strip()!r}"
            )
            return
        found = files_of(self.folder)
        for name in self.whole.files:
            if name not in found:
                self.faults.append(f"run again, {name} is missing")
            else:
                self._compare("run again,", name, found[name])
        extra = sorted(found.keys() - self.whole.files.keys())
        if extra:
            self.faults.append(f"run again, {', '.join(extra)} left over")


def killed(case: Case) -> Outcome:
    """Start a command, kill it, look at what it leaves, and let it continue to its end."""
    kill = case.kill
    case.lay_out()
    process = started(case.command.words, case.folder)
    moment = kill.moment(case.whole.seconds)
    whom = "group" if kill.group else "process"
    what = f"{kill.number.name} to the {whom} after {moment:.2f} s"
    if kill.steps:
        what += f" and step {kill.steps}"
    ended = True
    while case.count_steps() < kill.steps and process.poll() is None:
        time.sleep(0.0005)
    try:
        process.wait(moment)
    except subprocess.TimeoutExpired:
        ended = False
        (os.killpg if kill.group else os.kill)(process.pid, kill.number)
    seconds, children, errors = _gone(process, case)
    if not ended:
        # A process may have done its work just before the signal.
        done = process.returncode == 0
        if not done:
            case.look_at_end(process.returncode, errors)
        ended = done
    case.look_at_files("killed,", strict=kill.number != signal.SIGKILL)
    kept = case.count_steps()
    case.end()
    verdict = WRONG if case.faults else ENDED if ended else RESUMED
    return Outcome(
        kill.seed, kill.command, what, verdict, "; ".join(case.faults), kept, seconds, children
    )


def _gone(process: subprocess.Popen[bytes], case: Case) -> tuple[float, float, str]:
    """Wait for a process and its children; return how long either took, and what it said."""
    began = time.perf_counter()
    # Children hold the pipes as well: the process itself is waited for first.
    try:
        process.wait(ENDS)
    except subprocess.TimeoutExpired:
        case.faults.append(f"had not ended after {ENDS:.0f} s")
        process.kill()
        process.wait()
    ended = time.perf_counter()
    while (left := alive(process.pid)) and time.perf_counter() - ended < CHILDREN:
        time.sleep(0.02)
    children = time.perf_counter() - ended
    if left:
        case.faults.append(f"{len(left)} children were alive {CHILDREN:.0f} s later")
        for child in left:
            os.kill(child, signal.SIGKILL)
    errors = process.communicate()[1].decode("utf-8", "replace")
    return ended - began, children if children > 0.02 else 0.0, errors


def run(seeds: Sequence[int], workers: int = 1, every: bool = False) -> list[Outcome]:
    """Kill the commands of some seeds; print what is wrong, or all."""
    kills = [Kill.draw(seed) for seed in seeds]
    outcomes: list[Outcome] = []
    # Signals that a process ignores, as in the background of a shell, its children ignore as well.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    with tempfile.TemporaryDirectory(prefix="kills-") as place:
        names = dict.fromkeys(kill.command for kill in kills)
        whole = {name: reference(name, Path(place, f"whole-{name}")) for name in names}

        def one(kill: Kill) -> Outcome:
            folder = Path(place, str(kill.seed))
            outcome = killed(Case(kill, folder, whole[kill.command]))
            shutil.rmtree(folder)
            return outcome

        with ThreadPoolExecutor(workers) as pool:
            for outcome in pool.map(one, kills):
                outcomes.append(outcome)
                if every or outcome.verdict == WRONG:
                    print(outcome, flush=True)
                elif len(outcomes) % 10 == 0:
                    print(f"{len(outcomes)} of {len(kills)} kills", flush=True)
    return outcomes


# The table ----------------------------------------------------------------------------------------


def table(outcomes: Sequence[Outcome]) -> str:
    """Return the outcomes of the kills, by command, as Markdown."""
    names = [number.name for number in SIGNALS]
    lines = [
        f"| run | {' | '.join(names)} | {' | '.join(VERDICTS)} | most steps kept | "
        "slowest end [s] | slowest children [s] |",
        "|---|" + "---|" * (len(names) + len(VERDICTS) + 3),
    ]
    for command in [*COMMANDS, "all"]:
        chosen = [o for o in outcomes if command in (o.command, "all")]
        if not chosen:
            continue
        cells = [str(sum(o.what.startswith(name) for o in chosen)) for name in names]
        cells += [str(sum(o.verdict == verdict for o in chosen)) for verdict in VERDICTS]
        cells.append(str(max(o.kept for o in chosen)))
        cells += [f"{max(getattr(o, n) for o in chosen):.2f}" for n in ("seconds", "children")]
        lines.append(f"| {command} | {' | '.join(cells)} |")
    return "\n".join(lines)


def page(outcomes: Sequence[Outcome], seconds: float) -> str:
    """Return the part of the documentation that a run renews."""
    notes = [
        f"{len(outcomes)} kills in {seconds:.0f} s, roughcontact {rc.__version__}, "
        f"Python {platform.python_version()}, {platform.system()}."
    ]
    notes += [str(outcome) for outcome in outcomes if outcome.verdict == WRONG]
    return table(outcomes) + "\n\n" + "\n".join(f"- {note}" for note in notes)
