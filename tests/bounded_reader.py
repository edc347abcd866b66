"""A second process that reads files, under a limit of time and of memory."""

import json
import os
import select
import subprocess
import sys
from pathlib import Path

import numpy as np

from samples import Sample

SECONDS = 20.0
MEMORY = 4 * 2**30


# The second process


def serve() -> None:
    """Read the files that are named on standard input, and answer in one line each."""
    import resource

    from roughcontact.errors import RoughcontactError
    from roughcontact.formats.read import read_surface

    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # The output of libraries, in Python or in C, goes to a file.
    noise = os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(noise, 1)
    os.dup2(noise, 2)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for line in sys.stdin:
        order = json.loads(line)
        answer: dict[str, object] = {}
        try:
            surface = read_surface(order["path"], **order["arguments"])
            np.save(order["path"] + ".read.npy", surface.heights)
            answer = {"pixel": surface.pixel}
        except RoughcontactError as error:
            answer = {"refused": str(error), "cause": repr(error.__cause__)}
        except BaseException as error:
            answer = {"raised": repr(error)}
        sys.stdout.flush()
        answer["printed"] = os.lseek(noise, 0, os.SEEK_CUR)
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


class Reader:
    """A process that reads files, replaced by another where it hangs or dies."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process: subprocess.Popen[str] | None = None
        self.printed = 0

    def read(self, path: Path, arguments: dict[str, str]) -> dict[str, object]:
        if self.process is None:
            self.start()
        assert self.process is not None
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        order = json.dumps({"path": str(path), "arguments": arguments})
        self.process.stdin.write(order + "\n")
        self.process.stdin.flush()
        ready, _, _ = select.select([self.process.stdout], [], [], SECONDS)
        line = self.process.stdout.readline() if ready else ""
        if not line:
            died = self.process.wait(SECONDS) if ready else None
            self.close()
            return {"raised": f"died with {died}" if ready else f"took more than {SECONDS} s"}
        answer: dict[str, object] = json.loads(line)
        printed = answer.pop("printed")
        if printed != self.printed:
            noise = (self.folder / "noise").read_bytes()[self.printed :]
            answer = {"raised": f"printed {noise[:300]!r}"}
            self.printed = printed
        if "pixel" in answer:
            answer["heights"] = np.load(f"{path}.read.npy")
        return answer

    def start(self) -> None:
        import roughcontact

        (self.folder / "noise").write_bytes(b"")
        self.printed = 0
        source = Path(roughcontact.__file__).parents[1]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([str(source), os.environ.get("PYTHONPATH", "")]),
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
            "PYTHONUNBUFFERED": "1",
        }
        self.process = subprocess.Popen(
            [sys.executable, __file__, str(self.folder / "noise")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None


# Damage


def wrong_in_message(case: Sample, answer: dict[str, object]) -> str:
    message = str(answer["refused"])
    if "\n" in message or not message.isprintable() or len(message) > 700:
        return f"no sentence: {message!r}"
    if case.name.split(".")[0] not in message:
        return f"does not name the file: {message!r}"
    # The request would fail on a larger machine as well.
    if "MemoryError" in message + str(answer["cause"]):
        return f"out of memory: {message!r}"
    return ""


if __name__ == "__main__":
    serve()
