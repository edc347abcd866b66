"""Damaged files of every kind that the program reads, each judged by what comes of reading it.

`robustness.py` runs them. A seed names a file and its damage. Worker processes read them under a
limit of time and of memory with their output caught, so that a crash, a hang and a word too many
are seen. docs/evidence/robustness.md defines the verdicts. Run as a program, this is such a worker.
"""

from __future__ import annotations

import collections
import functools
import json
import math
import os
import platform
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Lock

ROOT = Path(__file__).parents[2]
if str(ROOT / "tests") not in sys.path:
    sys.path.append(str(ROOT / "tests"))

import numpy as np  # noqa: E402

import damages  # noqa: E402 - found next to this file
import targets  # noqa: E402
from targets import Target  # noqa: E402

REFUSED = "refused"
UNCHANGED = "read, nothing changed"
STATED = "read as its bytes now say"
AGAIN = "solved again, same bits"
SAID = "read, and said to be unproven"
WRONG = "wrong"
ABSENT = "absent"
VERDICTS = (REFUSED, UNCHANGED, STATED, AGAIN, SAID, WRONG)


# Formats whose checksums are of the heights alone, and not of the scales.
UNSUMMED = (".mnt",)


@dataclass(frozen=True)
class Limits:
    """Limits for reading one of these files, all below 5 MB.

    Parameters
    ----------
    seconds : float
        Time; a process that takes twice as long is ended.
    memory : int
        Memory limit of a process [bytes].
    growth : int
        By how much it may grow [bytes].
    """

    seconds: float = 10.0
    memory: int = 3 * 2**30
    growth: int = 2**30


@dataclass(frozen=True)
class Outcome:
    """Outcome of a damaged file.

    Parameters
    ----------
    seed : int
        Source of the draw.
    target : str
        The file.
    what : str
        Kind of damage.
    verdict : str
        One of ``VERDICTS``, or ``ABSENT``.
    words : str
        Error, or reason of the rejection.
    seconds : float
        Wall time of the reading.
    memory : int
        By how much the process grew in it [bytes].
    """

    seed: int
    target: str
    what: str
    verdict: str
    words: str = ""
    seconds: float = 0.0
    memory: int = 0

    def __str__(self) -> str:
        """Return everything in one line."""
        words = f": {self.words}" if self.words else ""
        return (
            f"{self.seed}: {self.target}, {self.what}: {self.verdict}{words} "
            f"({self.seconds:.2f} s, {self.memory / 2**20:.0f} MiB)"
        )


# One file -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Damaged:
    """A target with one of its files damaged.

    ``sealed`` says that the checksums of its archive were made to fit, ``moved`` that HDF5 was
    used to change it; ``name`` is another file name.
    """

    target: Target
    file: str
    content: bytes
    what: str
    sealed: bool = False
    moved: bool = False
    name: str = ""


@dataclass(frozen=True)
class Order:
    """A file to read: drawn from a seed, except for the values given here.

    Parameters
    ----------
    seed : int
        Source of the draw.
    target : str
        The file, by its name among the targets.
    suffix : str
        No damage, but another suffix.
    path : str
        Where the damaged file stands already.
    """

    seed: int
    target: str = ""
    suffix: str = ""
    path: str = ""


def draw(order: Order, known: dict[str, Target], scratch: Path, outside: Path) -> Damaged | str:
    """Return the damaged file that is meant, or the name of one that is absent."""
    rng = np.random.default_rng(order.seed)
    drawn = str(rng.choice(list(targets.SHARES), p=targets.probabilities()))
    name = order.target or drawn
    if name not in known:
        return name
    target = known[name]
    file = target.damaged[int(rng.integers(len(target.damaged)))]
    content = target.files[file]
    if order.path:
        return Damaged(target, file, Path(order.path).read_bytes(), order.path)
    other = order.suffix
    if not other and target.sample is not None and rng.random() < 0.02:
        other = str(rng.choice(targets.other_suffixes(Path(file).suffix)))
    if other:
        return Damaged(target, file, content, f"called {other}", name=Path(file).stem + other)
    return _draw_damage(rng, target, file, scratch, outside)


def _draw_damage(
    rng: np.random.Generator, target: Target, file: str, scratch: Path, outside: Path
) -> Damaged:
    """Return a file with damage of a kind that its format can have."""
    content, fields, suffix = target.files[file], target.fields.get(file, ()), Path(file).suffix
    draw = rng.random()
    if draw < 0.45:
        damage = damages.RAW
    elif suffix in (".nc", ".datx"):
        what, content = damages.restored(rng, content, outside, scratch / "scratch.h5")
        return Damaged(target, file, content, what, moved=True)
    elif suffix in (".npz", ".x3p", ".plux"):
        if draw < 0.5:
            damage = (damages.bombed,)
        elif draw < 0.55 and suffix != ".npz":
            damage = (functools.partial(damages.expanded, outside=outside.with_suffix(".txt")),)
        else:
            damage = damages.ARCHIVE
    elif suffix == ".json" and draw < 0.8:
        damage = (damages.rekeyed,)
    elif suffix in targets.TEXTS:
        damage = damages.TEXT if suffix in targets.PLAIN_TEXTS else damages.TEXT[:1]
    else:
        damage = damages.RAW
    done = damage[int(rng.integers(len(damage)))]
    what, content = done(rng, content, fields)
    function = done.func if isinstance(done, functools.partial) else done
    return Damaged(target, file, content, what, function in damages.SEALING)


class Watch:
    """Whether anything in a folder is touched, by Python or by a library in C; Linux only."""

    def __init__(self, folder: Path) -> None:
        import ctypes

        self.stream = -1
        try:
            library = ctypes.CDLL(None, use_errno=True)
            self.stream = library.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
            # Opened, changed, created, removed.
            library.inotify_add_watch(self.stream, os.fsencode(folder), 0x20 | 0x2 | 0x100 | 0x200)
        except (OSError, AttributeError):
            pass

    def touched(self) -> bool:
        """Return whether it was since the last look."""
        try:
            return self.stream >= 0 and bool(os.read(self.stream, 2**16))
        except BlockingIOError:
            return False


# The process that reads ---------------------------------------------------------------------------


def serve(prepared: Path, work: Path, limits: Limits) -> None:
    """Read the files ordered on standard input; answer the file, then the outcome."""
    import resource

    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # The output of libraries, in Python or in C, goes to a file.
    noise = os.open(work / "noise", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(noise, 1)
    os.dup2(noise, 2)
    resource.setrlimit(resource.RLIMIT_AS, (limits.memory, limits.memory))
    known = targets.load(prepared)
    if "made.sdf" in known:
        # The library of instruments' files takes seconds to import.
        targets.original(known["made.sdf"])
    # A separate copy: the other processes must not touch it.
    shutil.copytree(prepared / "outside", work / "outside", dirs_exist_ok=True)
    outside = work / "outside" / "numbers.bin"
    watch = Watch(outside.parent)
    place = work / "place"
    place.mkdir(exist_ok=True)
    os.chdir(place)
    for line in sys.stdin:
        order = Order(**json.loads(line))
        drawn = draw(order, known, work, outside)
        if isinstance(drawn, str):
            answer = Outcome(order.seed, drawn, "", ABSENT)
        else:
            # Itself seen to be read, once.
            targets.original(drawn.target)
            begun = Outcome(order.seed, drawn.target.name, f"{drawn.file}: {drawn.what}", WRONG)
            answers.write(json.dumps(asdict(begun)) + "\n")
            answers.flush()
            answer = one(begun, drawn, place, noise, watch, limits)
        answers.write(json.dumps(asdict(answer)) + "\n")
        answers.flush()


def one(
    begun: Outcome, drawn: Damaged, place: Path, noise: int, watch: Watch, limits: Limits
) -> Outcome:
    """Read a damaged file and judge what came."""
    for old in place.iterdir():
        shutil.rmtree(old) if old.is_dir() else old.unlink()
    files = {**drawn.target.files, drawn.file: drawn.content}
    if drawn.name:
        files[drawn.name] = files.pop(drawn.file)
    for name, content in files.items():
        path = place / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    original = targets.original(drawn.target)
    streams, length, held = (sys.stdout, sys.stderr), os.lseek(noise, 0, os.SEEK_END), _memory()
    watch.touched()
    start = time.perf_counter()
    read = drawn.target.read(place, drawn.name or drawn.file)
    seconds, grown = time.perf_counter() - start, _memory(peak=True) - held
    sys.stdout.flush()
    verdict, words = judge(drawn, original, read)
    faults = [words] if verdict == WRONG else []
    if os.lseek(noise, 0, os.SEEK_END) != length:
        faults.append(f"printed {printed(place.parent / 'noise', length)!r}")
    if (sys.stdout, sys.stderr) != streams:
        faults.append("left another stream as standard output")
    if watch.touched():
        faults.append("opened another file than it was given")
    if grown > limits.growth:
        faults.append(f"took {grown / 2**30:.1f} GiB")
    if seconds > limits.seconds:
        faults.append(f"took {seconds:.0f} s")
    left = {str(p.relative_to(place)) for p in place.rglob("*") if p.is_file()} - files.keys()
    if left:
        faults.append(f"left {', '.join(sorted(left))}")
    return Outcome(
        begun.seed,
        begun.target,
        begun.what,
        WRONG if faults else verdict,
        "; ".join(faults) if faults else words,
        seconds,
        max(grown, 0),
    )


def _memory(peak: bool = False) -> int:
    """Return the memory of the process, or its maximum since the previous call [bytes]."""
    word = b"VmHWM:" if peak else b"VmRSS:"
    try:
        with Path("/proc/self/status").open("rb") as stream:
            lines = stream.read().splitlines()
        if not peak:
            with Path("/proc/self/clear_refs").open("w") as stream:
                stream.write("5")
    except OSError:
        return 0
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(word))


def printed(noise: Path, start: int) -> bytes:
    """Return the output of a process without its answers, from a byte on."""
    return noise.read_bytes()[start : start + 300]


# The judgment -------------------------------------------------------------------------------------


def judge(drawn: Damaged, original: targets.Reading, read: targets.Reading) -> tuple[str, str]:
    """Return the verdict on a reading, and the error or message."""
    if read.raised:
        return WRONG, read.raised
    if read.refused:
        return _refusal(drawn, read)
    if drawn.target.sample is not None:
        return _map(drawn, original, read)
    names = sorted(original.facts.keys() | read.facts.keys())
    changed = [n for n in names if original.facts.get(n) != read.facts.get(n)]
    if read.again:
        # Times differ, and a contact that is not solved yet has no values.
        changed = [n for n in changed if n in read.facts and not n.endswith("seconds")]
    if not changed:
        return (AGAIN if read.again else UNCHANGED), ""
    text = f"{len(changed)} of {len(names)} values changed, {', '.join(changed[:3])} among them"
    if drawn.target.unproven:
        return STATED, text
    if read.said:
        return SAID, read.said
    return WRONG, f"silent change: {text}"


def _refusal(drawn: Damaged, read: targets.Reading) -> tuple[str, str]:
    message = read.refused
    if "\n" in message or not message.isprintable() or len(message) > 700:
        return WRONG, f"no sentence: {message!r}"
    names = {Path(drawn.name or drawn.file).stem, *Path(drawn.file).parts}
    if not any(name in message for name in names):
        return WRONG, f"does not name the file: {message!r}"
    # The request would fail on a larger machine as well.
    if "MemoryError" in message + read.cause:
        return WRONG, f"out of memory: {message!r}"
    return REFUSED, message


def _alike(one: np.ndarray, two: np.ndarray) -> bool:
    """Return whether heights are the same but for their scale and where it begins."""
    shares = [(z - np.nanmin(z)) / (np.nanmax(z) - np.nanmin(z)) for z in (one, two)]
    return one.shape == two.shape and np.allclose(*shares, rtol=0, atol=1e-9, equal_nan=True)


def _map(drawn: Damaged, original: targets.Reading, read: targets.Reading) -> tuple[str, str]:
    """Judge a map by what a plain reading of the damaged bytes says."""
    from plain import differing, implausible

    sample, one, two = drawn.target.sample, original.plain, read.plain
    assert sample is not None
    assert one is not None
    assert two is not None
    wrong = implausible(two.heights, two.pixel)
    if wrong:
        return WRONG, wrong
    if one.heights.shape == two.heights.shape and one.pixel == two.pixel:
        changed = ~((one.heights == two.heights) | (np.isnan(one.heights) & np.isnan(two.heights)))
        count = int(np.count_nonzero(changed))
        if not count:
            return UNCHANGED, ""
        exact = sample.checked or drawn.sealed or drawn.moved
        limit = 0 if exact else _bytes_changed(drawn, sample.content)
        if count <= limit:
            return STATED, f"{count} heights changed"
    if drawn.name:
        wrong = differing(two, one)
        return (WRONG, f"read as another map: {wrong}") if wrong else (UNCHANGED, "")
    if read.said:
        return SAID, read.said
    reading = sample.structured if drawn.moved and sample.structured else sample.stated
    try:
        stated = reading(drawn.content)
    except Exception as error:
        return WRONG, f"read, while a plain reading fails with {error!r}"
    wrong = differing(two, stated)
    if wrong:
        return WRONG, f"{wrong}: {two.heights.shape} of {two.pixel}, stated {stated.pixel}"
    unsummed = sample.name.endswith(UNSUMMED) and _alike(one.heights, two.heights)
    if sample.checked and not drawn.sealed and not unsummed:
        return WRONG, "silent change behind a checksum"
    return STATED, f"{two.heights.shape} of {two.pixel}"


def _bytes_changed(drawn: Damaged, content: bytes) -> int:
    common = min(len(content), len(drawn.content))
    old, new = (np.frombuffer(part[:common], "u1") for part in (content, drawn.content))
    return int(np.count_nonzero(old != new))


# Workers ------------------------------------------------------------------------------------------


class Worker:
    """A process that reads damaged files, replaced by another where it hangs or dies."""

    def __init__(self, prepared: Path, work: Path, limits: Limits | None = None) -> None:
        self.prepared, self.work, self.limits = prepared, work, limits or Limits()
        self.process: subprocess.Popen[bytes] | None = None
        self.rest = b""

    def attempt(self, order: Order) -> Outcome:
        """Read a damaged file."""
        if self.process is None:
            self._start()
        assert self.process is not None
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(asdict(order)).encode() + b"\n")
        self.process.stdin.flush()
        # Imports and undamaged files come first.
        begun = self._answer(120.0)
        if begun is None or begun.verdict == ABSENT:
            ended = f"no file was made, {self._end()}" if begun is None else ""
            return begun or Outcome(order.seed, order.target, "", WRONG, ended)
        outcome = self._answer(2 * self.limits.seconds)
        if outcome is not None:
            return outcome
        return Outcome(order.seed, begun.target, begun.what, WRONG, self._end())

    def _answer(self, seconds: float) -> Outcome | None:
        assert self.process is not None
        assert self.process.stdout is not None
        until = time.monotonic() + seconds
        while b"\n" not in self.rest:
            ready, _, _ = select.select([self.process.stdout], [], [], until - time.monotonic())
            part = os.read(self.process.stdout.fileno(), 2**16) if ready else b""
            if not part:
                return None
            self.rest += part
        line, _, self.rest = self.rest.partition(b"\n")
        return Outcome(**json.loads(line))

    def _end(self) -> str:
        """Return how the process ended, and end it if it did not."""
        assert self.process is not None
        try:
            words = f"died with status {self.process.wait(1)}"
        except subprocess.TimeoutExpired:
            words = f"took more than {2 * self.limits.seconds:.0f} s"
        noise = printed(self.work / "noise", max((self.work / "noise").stat().st_size - 300, 0))
        self.close()
        return f"{words}{f', printed {noise!r}' if noise else ''}"

    def _start(self) -> None:
        self.work.mkdir(parents=True, exist_ok=True)
        (self.work / "noise").write_bytes(b"")
        self.rest = b""
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([str(targets.SOURCE), os.environ.get("PYTHONPATH", "")]),
            "PYTHONUNBUFFERED": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
        }
        self.process = subprocess.Popen(
            [
                sys.executable,
                __file__,
                str(self.prepared),
                str(self.work),
                json.dumps(asdict(self.limits)),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment,
        )

    def close(self) -> None:
        """End the process."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None


def attempts(orders: Iterable[Order], workers: int = 0) -> Iterator[Outcome]:
    """Yield what comes of some files, in no order."""
    count = workers or len(os.sched_getaffinity(0))
    waiting, lock = iter(orders), Lock()
    with tempfile.TemporaryDirectory(prefix="damage-") as folder:
        prepared = Path(folder, "prepared")
        targets.prepare(prepared)
        found: collections.deque[Outcome] = collections.deque()

        def work(number: int) -> None:
            worker = Worker(prepared, Path(folder, f"worker-{number}"))
            try:
                while True:
                    with lock:
                        order = next(waiting, None)
                    if order is None:
                        return
                    found.append(worker.attempt(order))
            finally:
                worker.close()

        with ThreadPoolExecutor(count) as pool:
            running = [pool.submit(work, number) for number in range(count)]
            while found or not all(future.done() for future in running):
                if found:
                    yield found.popleft()
                else:
                    time.sleep(0.01)
            for future in running:
                future.result()


# The table ----------------------------------------------------------------------------------------


def table(outcomes: Sequence[Outcome]) -> str:
    """Return the outcomes of the files, by their kind, as Markdown."""
    lines = [
        f"| file | damaged | {' | '.join(VERDICTS)} | slowest [s] | most memory [MiB] |",
        "|---|" + "---|" * (len(VERDICTS) + 3),
    ]
    present = [o for o in outcomes if o.verdict != ABSENT]
    for group in [*dict.fromkeys(targets.GROUPS.values()), "all"]:
        chosen = [o for o in present if group in (targets.GROUPS.get(o.target), "all")]
        if not chosen:
            continue
        counts = " | ".join(str(sum(o.verdict == v for o in chosen)) for v in VERDICTS)
        slowest = max(o.seconds for o in chosen)
        most = max(o.memory for o in chosen) / 2**20
        lines.append(f"| {group} | {len(chosen)} | {counts} | {slowest:.1f} | {most:.0f} |")
    return "\n".join(lines)


def page(outcomes: Sequence[Outcome], seconds: float) -> str:
    """Return the part of the documentation that a run renews."""
    import roughcontact as rc

    absent = sum(o.verdict == ABSENT for o in outcomes)
    notes = [
        f"{len(outcomes) - absent} damaged files in {seconds:.0f} s, roughcontact "
        f"{rc.__version__}, Python {platform.python_version()}, NumPy {np.__version__}."
    ]
    if absent:
        notes.append(f"{absent} more fell on measurements or readers that are not here.")
    notes += [str(o) for o in sorted(outcomes, key=lambda o: o.seed) if o.verdict == WRONG]
    return table(outcomes) + "\n\n" + "\n".join(f"- {note}" for note in notes)


def run(seeds: Sequence[int], workers: int = 0, every: bool = False) -> list[Outcome]:
    """Read the files of some seeds; print what is wrong, or all."""
    outcomes = []
    for outcome in attempts(map(Order, seeds), workers):
        outcomes.append(outcome)
        if every or outcome.verdict == WRONG:
            print(outcome, flush=True)
        elif len(outcomes) % max(math.ceil(len(seeds) / 10), 100) == 0:
            print(f"{len(outcomes)} of {len(seeds)} damaged files", flush=True)
    return outcomes


if __name__ == "__main__":
    serve(Path(sys.argv[1]), Path(sys.argv[2]), Limits(**json.loads(sys.argv[3])))
