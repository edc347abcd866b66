"""Saved projects: the project file and the uploaded files of each."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import roughcontact as rc
from roughcontact import errors
from roughcontact._tools import files
from roughcontact._tools.text import join_words

DAYS = 30
"""Lifetime of a project without visits [days]."""

_KEY_BYTES = 24
PROJECT = "project.toml"
"""Project file of a project."""

KEPT = "map-"
"""Prefix of the names of uploaded files."""

_KEY = re.compile(r"[A-Za-z0-9_-]{32}")
_SUFFIX = re.compile(r"(?:\.[A-Za-z0-9]{1,12}){1,2}$")
_MAX_NAME_LENGTH = 200
# Maximum number of new projects without a folder that are remembered.
_MAX_RESERVED = 10_000
# Minimum age of a page folder to remove [s]: another server may not have locked it yet.
_MIN_AGE_SECONDS = 60.0
_SECRET = "secret"
_PAGE, _LOCK = "page-", "lock"


@dataclass(frozen=True)
class SavedProject:
    """Saved project: its key and its folder."""

    key: str  # Secret key: it gives access to the project
    folder: Path  # Folder of its files

    @property
    def project(self) -> Path:
        """Project file, which does not exist before the first change."""
        return self.folder / PROJECT

    def make_folder(self) -> Path:
        """Return the folder, and create it if this is the first file of the project."""
        self.folder.mkdir(mode=0o700, exist_ok=True)
        return self.folder

    @contextmanager
    def page(self) -> Iterator[Path]:
        """Yield a folder for the files of a page, removed when the page closes."""
        folder = self.make_folder() / f"{_PAGE}{secrets.token_hex(8)}"
        folder.mkdir(mode=0o700)
        try:
            with files.file_lock(folder / _LOCK):
                yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    @contextmanager
    def open_upload(self, name: str, limit: int) -> Iterator[Upload]:
        """Yield an upload that stores a file in parts under a generated name."""
        path = self.make_folder() / f"{KEPT}{secrets.token_hex(4)}{format_suffix(name)}"
        with files.atomic_write(path) as stream:
            yield Upload(path, safe_file_name(name), limit, stream.write)


class Upload:
    """Running upload of a file."""

    def __init__(self, path: Path, name: str, limit: int, write: Callable[[bytes], object]) -> None:
        self.path, self.name = path, name
        self._limit, self._write, self._size = limit, write, 0

    def write(self, piece: bytes) -> None:
        """Write the next bytes; raise `InputError` for a file above the limit."""
        self._size += len(piece)
        require_size(self.name, self._size, self._limit)
        self._write(piece)


class ProjectStore:
    """Folder of all projects of a user."""

    def __init__(self, folder: Path | None = None) -> None:
        # A relative folder would be read relative to the project files in it.
        self.folder = (state_folder() if folder is None else folder).absolute()
        self._coming = 0
        self._reserved: dict[str, None] = {}
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            raise rc.InputError(
                f"the folder '{self.folder}' cannot be created ({error.strerror}); give another",
                argument="folder",
            ) from None
        if not os.access(self.folder, os.W_OK | os.X_OK):
            raise rc.InputError(
                f"no permission to write into the folder '{self.folder}'; give another",
                argument="folder",
            )

    def reserve(self) -> SavedProject:
        """Return a new project, whose folder is created with its first file."""
        key = secrets.token_urlsafe(_KEY_BYTES)
        self._reserved[key] = None
        if len(self._reserved) > _MAX_RESERVED:
            del self._reserved[next(iter(self._reserved))]
        return SavedProject(key, self.folder / key)

    def create(self) -> SavedProject:
        """Return a new project with its folder."""
        work = self.reserve()
        work.make_folder()
        return work

    def open_project(self, key: str) -> SavedProject | None:
        """Return the project with a key, and mark it as used; None if there is none."""
        if _KEY.fullmatch(key) is None:
            return None
        folder = self.folder / key
        try:
            os.utime(folder)
        except OSError:
            if key not in self._reserved:
                return None
        return SavedProject(key, folder)

    @property
    def secret(self) -> bytes:
        """Secret that signs the cookies of this user's browsers, readable by this user alone."""
        path = self.folder / _SECRET
        if not path.exists():
            files.write_atomically(path, secrets.token_hex(_KEY_BYTES))
            path.chmod(0o600)
        return path.read_bytes()

    @contextmanager
    def reserve_upload(self, name: str, size: int, limit: int) -> Iterator[None]:
        """Reserve space for an upload; raise `InputError` if all files exceed a limit."""
        total = self._coming
        # Unfinished uploads have hidden names; their announced sizes are already reserved.
        for path in self.folder.glob("*/[!.]*"):
            with contextlib.suppress(OSError):
                total += path.stat().st_size if path.is_file() else 0
        if total + size > limit:
            raise rc.InputError(
                f"{name} has {_format_bytes(size)}, and the saved projects have "
                f"{_format_bytes(total)}: more than {_format_bytes(limit)} together. Remove "
                "projects that are not needed, or start the desk with a larger ",
                errors.ArgumentRef("upload_limit"),
            )
        self._coming += size
        try:
            yield
        finally:
            self._coming -= size

    def saved_projects(self) -> list[SavedProject]:
        """Return the projects with a project file, the last used first."""
        result = [
            SavedProject(folder.name, folder)
            for folder in self.folder.iterdir()
            if _KEY.fullmatch(folder.name) and (folder / PROJECT).is_file()
        ]
        return sorted(result, key=lambda work: work.folder.stat().st_mtime, reverse=True)

    def remove(self, key: str) -> None:
        """Remove a project with all its files."""
        self._reserved.pop(key, None)
        if _KEY.fullmatch(key) is not None:
            shutil.rmtree(self.folder / key, ignore_errors=True)

    def expire(self, age: float = DAYS * 86400.0) -> None:
        """Remove projects unused for some time [s], and page folders of killed servers."""
        now = time.time()
        for folder in self.folder.iterdir():
            if _KEY.fullmatch(folder.name) is None or not folder.is_dir():
                continue
            with contextlib.suppress(OSError):
                before = folder.stat().st_mtime
                if now - before > age:
                    shutil.rmtree(folder)
                    continue
                _remove_page_folders(folder, now)
                os.utime(folder, (before, before))


def _remove_page_folders(folder: Path, now: float) -> None:
    """Remove unfinished files and the folders of closed pages."""
    files.remove_unfinished(folder)
    for page in folder.glob(f"{_PAGE}*"):
        if now - page.stat().st_mtime > _MIN_AGE_SECONDS and not _is_held(page / _LOCK):
            shutil.rmtree(page)


def _is_held(lock: Path) -> bool:
    try:
        with files.file_lock(lock):
            return False
    except BlockingIOError:
        return True


def state_folder() -> Path:
    """Return the folder of projects of this user, by the conventions of the system."""
    if os.name == "nt":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    else:
        # https://specifications.freedesktop.org/basedir-spec: a relative path is ignored.
        base = os.environ.get("XDG_STATE_HOME") or ""
        base = base if Path(base).is_absolute() else str(Path.home() / ".local" / "state")
    return Path(base) / "roughcontact" / "desk"


def format_suffix(name: str) -> str:
    """Return the format suffix of a file name, such as ``.csv.gz``; empty if invalid."""
    suffix = "".join(Path(safe_file_name(name)).suffixes[-2:])
    if not suffix.lower().endswith(".gz"):
        suffix = Path(safe_file_name(name)).suffix
    return suffix.lower() if _SUFFIX.fullmatch(suffix) else ""


def safe_file_name(name: str) -> str:
    """Return a file name as one line without folders."""
    last = re.split(r"[/\\]", name)[-1]
    return join_words(last)[-_MAX_NAME_LENGTH:] or "map"


def require_size(name: str, size: int, limit: int) -> None:
    """Raise `InputError` if a file is larger than the upload limit."""
    if size > limit:
        raise rc.InputError(
            f"{name} has more than {_format_bytes(limit)}, the upload limit; crop it, or start the "
            "desk with a larger ",
            errors.ArgumentRef("upload_limit"),
        )


def _format_bytes(size: int) -> str:
    """Return a number of bytes as text in GiB, MiB or bytes."""
    for unit, name in ((2**30, "GiB"), (2**20, "MiB")):
        if size >= unit:
            return f"{size / unit:.3g} {name}"
    return f"{size} bytes"
