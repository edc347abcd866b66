"""Run every command of the pages and compare its output with the page.

    python docs/commands.py             # run all, list differences, exit status 1 if there are any
    python docs/commands.py --write     # write the outputs into the pages
    python docs/commands.py howto/law.md start.md

A block ``console`` is a session; the sessions of a page share a folder. A line ``$ echo $?`` shows the
exit status. A line ``…`` replaces the rest of an output; long outputs are cut at `LINES`. The commands
of the README run on the map of `demo`.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent

_SESSION = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_SCRIPT = re.compile(r"^```(?:sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# Prompt, command, and what it printed.
_COMMAND = re.compile(r"^\$ ((?:.*\\\n)*.*)\n((?:(?!\$ ).*\n)*)", re.MULTILINE)
LEFT_OUT = "…"
# Lines of an output that a page shows.
LINES = 20
STATUS = "echo $?"

# What differs from one machine, or one run, to the next: times, memory, how near to the answer
# the solver ended, and how many steps it took.
_VARYING = re.compile(
    r"certificate|sha256|error|residual|convolution|iteration|memory|GiB|MiB|GB|MB|seconds?|version|\d m?s\b"
)
_NUMBER = re.compile(r"[-−+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# By how much numbers of other machines may differ.
_TOLERANCE = 0.01


@dataclass(frozen=True)
class Shown:
    """A command that a page shows.

    Parameters
    ----------
    command : str
        As it is typed.
    output : str
        What the page shows of what it prints.
    """

    command: str
    output: str


def pages() -> list[Path]:
    """Return the pages whose commands are run."""
    first = (HERE / f"{name}.md" for name in ("index", "start", "tutorial", "formats", "others"))
    return [*first, *sorted((HERE / "howto").glob("*.md"))]


def sessions(text: str) -> Iterator[tuple[re.Match[str], list[Shown]]]:
    """Yield the blocks of a page with their commands."""
    for block in _SESSION.finditer(text):
        yield block, [Shown(*found.groups()) for found in _COMMAND.finditer(block[1])]


def scripts(text: str) -> Iterator[str]:
    """Yield what the README has run, but for what installs, tests, or waits for a browser."""
    for block in _SCRIPT.finditer(text):
        if "import roughcontact" in block[1]:
            yield f"python - <<'END'\n{block[1]}END\n"
        elif not re.search(r"pip install|roughcontact desk", block[1]):
            # The environment is this one, and the folder the one of the example.
            yield re.sub(r"^source .*\n", "", block[1], flags=re.MULTILINE)


def run_command(command: str, folder: Path) -> tuple[str, int]:
    """Return what a command printed, and its exit status."""
    environment = {
        **os.environ,
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        "COLUMNS": "96",
        "NO_COLOR": "1",
    }
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=environment,
        text=True,
        encoding="utf-8",
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        timeout=600,
    )
    # A slow machine shows lines of progress.
    printed = (line.rstrip() for line in done.stdout.strip("\n").splitlines())
    lines = [line for line in printed if not line.startswith("progress: ")]
    return "".join(f"{line}\n" for line in lines), done.returncode


def run_timed(command: str, folder: Path) -> tuple[str, int]:
    """Run a command and say how long it took."""
    started = time.perf_counter()
    done = run_command(command, folder)
    first = command.removeprefix("set -e\n").partition("\n")[0]
    print(f"{time.perf_counter() - started:6.1f} s  {first[:100]}", flush=True)
    return done


def shorten_output(printed: str, shown: str) -> str:
    """Return an output up to where the page leaves out the rest, and no more than `LINES`."""
    lines, others = printed.splitlines(), shown.splitlines()
    end = others.index(LEFT_OUT) if LEFT_OUT in others else LINES
    if len(lines) <= end:
        return printed
    return "".join(f"{line}\n" for line in [*lines[:end], LEFT_OUT])


def same(printed: str, shown: str) -> bool:
    """Return whether two outputs say the same, but for what is the machine's own."""
    lines, others = printed.splitlines(), shown.splitlines()
    return len(lines) == len(others) and all(map(_is_equivalent, lines, others))


def _is_equivalent(line: str, other: str) -> bool:
    if _words(line) != _words(other):
        return False
    if _VARYING.search(line):
        return True
    numbers = (map(float, _NUMBER.findall(text.replace("−", "-"))) for text in (line, other))
    return all(
        abs(a - b) <= _TOLERANCE * max(abs(a), abs(b)) for a, b in zip(*numbers, strict=True)
    )


def _words(line: str) -> list[str]:
    # Checksums cover times; bars and rules are as long as there is room.
    line = re.sub(r"\b[0-9a-f]{16,}", "#", line)
    if _VARYING.search(line):
        # A time on another machine may have another unit.
        line = re.sub(r"(\d) ms\b", r"\1 s", line)
    return re.sub(r"[─━═╌]+", "─", _NUMBER.sub("#", line)).split()


def check_page(page: Path, folder: Path) -> tuple[str, list[str]]:
    """Run the commands of a page.

    Parameters
    ----------
    page : Path
        The page.
    folder : Path
        Where its commands run.

    Returns
    -------
    str
        The page with what they print now.
    list of str
        What differs.
    """
    text = page.read_text(encoding="utf-8")
    parts, differing, end = [], [], 0
    for block, commands in sessions(text):
        now, status, silent = "", 0, False
        for shown in commands:
            if shown.command == STATUS:
                printed, silent = f"{status}\n", False
            else:
                if silent:
                    differing.append(f"exit status {status} is not shown: {now}")
                printed, status = run_timed(shown.command, folder)
                silent = status != 0
                printed = shorten_output(printed, shown.output)
            if not same(printed, shown.output):
                differing.append(f"$ {shown.command}\nshown\n{shown.output}printed\n{printed}")
            now += f"$ {shown.command}\n{printed}"
        if silent:
            differing.append(f"exit status {status} is not shown: {now}")
        parts += [text[end : block.start(1)], now]
        end = block.end(1)
    return "".join([*parts, text[end:]]), differing


def readme(folder: Path, write: bool, points: int = 256) -> list[str]:
    """Run what the README shows, on a smaller map; draw its figure, or return what failed."""
    failed = []
    if write:
        # The figure shows the output of the default command.
        (folder / "figure").mkdir()
        run_timed("roughcontact demo", folder / "figure")
        drawn = folder / "figure" / "roughcontact-demo" / "comparison.png"
        shutil.copy(drawn, HERE / "images" / "demo.png")
    printed, status = run_timed(f"roughcontact demo --points {points}", folder)
    for script in scripts((ROOT / "README.md").read_text(encoding="utf-8")):
        if status == 0:
            printed, status = run_timed(f"set -e\n{script}", folder / "roughcontact-demo")
        if status:
            failed.append(f"README.md: exit status {status}\n{printed}")
            break
    return failed


def compare_page(page: Path, maps: Path, write: bool) -> list[str]:
    """Run the commands of a page in a folder of its own; mend the page, or return what differs."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place, "page")
        shutil.copytree(maps, folder)
        text, differing = check_page(page, folder)
    if write:
        page.write_text(text, encoding="utf-8")
        return []
    return [f"{page.relative_to(ROOT)}: {line}" for line in differing]


def prepare(folder: Path) -> None:
    """Lay out the measurements and files that the pages use."""
    subprocess.run(
        [sys.executable, str(HERE / "howto" / "maps.py")], cwd=folder, check=True, timeout=300
    )
    for name in ("project.toml", "cluster.toml", "memory.py"):
        shutil.copy(HERE / "howto" / name, folder)


def main() -> int:
    """Run the commands of some pages, or of all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="put what they print into the pages")
    parser.add_argument("pages", nargs="*", type=Path, help="below docs; all without any")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place, ThreadPoolExecutor(os.cpu_count()) as pool:
        maps = Path(place, "maps")
        maps.mkdir()
        prepare(maps)
        asked = [HERE / name for name in options.pages] or pages()
        # What takes longest first.
        checks = [] if options.pages else [pool.submit(readme, Path(place), options.write)]
        checks += [pool.submit(compare_page, page, maps, options.write) for page in asked]
        differing = [line for one in checks for line in one.result()]
    print("".join(differing), end="")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
