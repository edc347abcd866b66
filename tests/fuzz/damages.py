"""Damage of files: flipped bits, lost and doubled runs, edited numbers, members and variables.

Each function takes a generator of random numbers and the content of a file and returns what was
done as text and the new content. Those in ``SEALING`` repack archives: their checksums hold
for the damaged members.
"""

from __future__ import annotations

import io
import json
import math
import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

Random = np.random.Generator
Done = tuple[str, bytes]
Fields = tuple[tuple[int, int], ...]

# Numbers that headers never held, and such as are nearly right.
_INTEGERS = (0, -1, 1, 2, 3, 255, 32767, 32768, 65535, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**63)
_FLOATS = (0.0, -0.0, -1.0, 1.0, 1e-300, 1e300, math.inf, -math.inf, math.nan, 1e-12, 1e12)
_WORDS = (
    b"0",
    b"-1",
    b"nan",
    b"inf",
    b"1e999",
    b"99999999999",
    b"1_0",
    b"0x10",
    b"1,5",
    b"",
    b"None",
    b"3" * 400,
    b"\xd9\xa3",
)
_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_EMPTY = "left alone"
# Size of a file that needs more memory than a machine has.
_MAX_POINTS = 60_000
_BOMB = 4 * 2**30


def _any(rng: Random, values: Any) -> Any:
    return values[int(rng.integers(len(values)))]


def place(rng: Random, content: bytes, fields: Fields) -> int:
    """Return a byte: of the fields, the head, the tail, or anywhere."""
    length, where = len(content), rng.random()
    fields = tuple((start, min(stop, length)) for start, stop in fields if start < length)
    if where < 0.4 and fields:
        return int(rng.integers(*_any(rng, fields)))
    if where < 0.6:
        return int(rng.integers(min(2048, length)))
    if where < 0.7:
        # Headers are at the start, directories of archives at the end.
        return int(rng.integers(max(length - 4096, 0), length))
    return int(rng.integers(length))


# Any file -----------------------------------------------------------------------------------------


def flipped(rng: Random, content: bytes, fields: Fields) -> Done:
    """Flip one bit, or some."""
    new = bytearray(content)
    places = [place(rng, content, fields) for _ in range(1 if rng.random() < 0.6 else 6)]
    for at in places:
        new[at] ^= 1 << int(rng.integers(8))
    return f"flipped a bit of bytes {', '.join(map(str, places))}", bytes(new)


def overwritten(rng: Random, content: bytes, fields: Fields) -> Done:
    """Put other bytes in place of some."""
    new = bytearray(content)
    places = [place(rng, content, fields) for _ in range(int(rng.integers(1, 6)))]
    for at in places:
        new[at] = int(rng.integers(256))
    return f"overwrote bytes {', '.join(map(str, places))}", bytes(new)


def numbered(rng: Random, content: bytes, fields: Fields) -> Done:
    """Write another number where one may stand."""
    kind = str(_any(rng, ("<h", "<i", "<q", ">h", ">i", "<f", "<d", ">f")))
    size = struct.calcsize(kind)
    at = min(place(rng, content, fields), len(content) - size)
    if at < 0:
        return truncated(rng, content, fields)
    (old,) = struct.unpack_from(kind, content, at)
    value = _other(rng, old, _FLOATS if kind[1] in "fd" else _INTEGERS)
    new = bytearray(content)
    if kind[1] in "fd":
        with np.errstate(all="ignore"):
            new[at : at + size] = np.array(value, kind).tobytes()
    else:
        new[at : at + size] = (int(value) % 256**size).to_bytes(
            size, "little" if kind[0] == "<" else "big"
        )
    return f"{kind} {value} at byte {at}", bytes(new)


def _other(rng: Random, old: float, absurd: tuple[float, ...]) -> float:
    draw = rng.random()
    if draw < 0.5 or not math.isfinite(old):
        return float(_any(rng, absurd)) if absurd is _FLOATS else int(_any(rng, absurd))
    if draw < 0.8:
        return old * _any(rng, (2, 10, 1000, -1)) if isinstance(old, int) else _scaled(rng, old)
    return old + 1 if isinstance(old, int) else float(np.nextafter(old, math.inf))


def _scaled(rng: Random, old: float) -> float:
    return float(old * _any(rng, (2.0, 1.001, 1e3, 1e-3, -1.0)))


def truncated(rng: Random, content: bytes, fields: Fields) -> Done:
    """Cut the end off."""
    keep = place(rng, content, fields)
    return f"truncated to {keep} of {len(content)} bytes", content[:keep]


def _run(rng: Random, content: bytes, fields: Fields) -> tuple[int, int]:
    start = place(rng, content, fields)
    return start, min(int(2 ** rng.uniform(0, 13)), len(content) - start)


def zeroed(rng: Random, content: bytes, fields: Fields) -> Done:
    """Lose a run as disks do."""
    start, size = _run(rng, content, fields)
    new = content[:start] + bytes(size) + content[start + size :]
    return f"zeroed {size} bytes at {start}", new


def doubled(rng: Random, content: bytes, fields: Fields) -> Done:
    """Write a run twice: all that follows is shifted."""
    start, size = _run(rng, content, fields)
    new = content[: start + size] + content[start:]
    return f"doubled {size} bytes at {start}", new


def dropped(rng: Random, content: bytes, fields: Fields) -> Done:
    """Leave a run out."""
    start, size = _run(rng, content, fields)
    return f"dropped {size} bytes at {start}", content[:start] + content[start + size :]


def swapped(rng: Random, content: bytes, fields: Fields) -> Done:
    """Exchange two runs."""
    start, size = _run(rng, content, fields)
    other = int(rng.integers(len(content) - size + 1))
    new = bytearray(content)
    new[start : start + size] = content[other : other + size]
    new[other : other + size] = content[start : start + size]
    return f"swapped {size} bytes at {start} and {other}", bytes(new[: len(content)])


def noisy(rng: Random, content: bytes, fields: Fields) -> Done:
    """Write noise over a run."""
    start, size = _run(rng, content, fields)
    new = content[:start] + rng.bytes(size) + content[start + size :]
    return f"noise over {size} bytes at {start}", new


def grown(rng: Random, content: bytes, fields: Fields) -> Done:
    """Append zeros, noise, or the file itself."""
    size = int(2 ** rng.uniform(0, 18))
    tail = _any(rng, (bytes(size), rng.bytes(size), (content * (size // len(content) + 1))[:size]))
    return f"{size} bytes more", content + tail


RAW = (
    flipped,
    flipped,
    overwritten,
    numbered,
    numbered,
    truncated,
    zeroed,
    doubled,
    dropped,
    swapped,
    noisy,
    grown,
)


# Text ---------------------------------------------------------------------------------------------


def reworded(rng: Random, content: bytes, fields: Fields) -> Done:
    """Write another number in a text, or in the part of a file that is text."""
    parts = fields or ((0, len(content)),)
    found = [m for start, stop in parts for m in _NUMBER.finditer(content, start, stop)]
    if not found:
        return flipped(rng, content, fields)
    old = _any(rng, found)
    draw = rng.random()
    if draw < 0.4:
        new = bytes(_any(rng, _WORDS))
    elif draw < 0.7:
        new = repr(_other(rng, float(old[0]), _FLOATS)).encode()
    else:
        digits = bytearray(old[0])
        digits[int(rng.integers(len(digits)))] = int(rng.integers(48, 58))
        new = bytes(digits)
    return (
        f"{old[0][:20]!r} at byte {old.start()} is {new[:20]!r}",
        content[: old.start()] + new + content[old.end() :],
    )


def relined(rng: Random, content: bytes, fields: Fields) -> Done:
    """Lose, double or exchange lines."""
    lines = content.splitlines(keepends=True)
    at, other = (int(number) for number in rng.integers(len(lines), size=2))
    draw = rng.random()
    if draw < 0.35:
        return f"line {at} is gone", b"".join(lines[:at] + lines[at + 1 :])
    if draw < 0.7:
        return f"line {at} twice", b"".join(lines[: at + 1] + lines[at:])
    lines[at], lines[other] = lines[other], lines[at]
    return f"lines {at} and {other} exchanged", b"".join(lines)


TEXT = (reworded, reworded, relined)


def rekeyed(rng: Random, content: bytes, fields: Fields) -> Done:
    """Change, drop or double what a JSON text holds."""
    held = json.loads(content)
    leaves = list(_leaves(held))
    holder, key = _any(rng, leaves)
    old = holder[key]
    if rng.random() < 0.25:
        del holder[key]
        return f"{key!r} is gone", json.dumps(held, indent=2).encode()
    if isinstance(old, bool) or old is None or isinstance(old, str):
        new: Any = _any(rng, (None, True, 7, "", "garbage", str(old)[::-1], [], {}))
    elif isinstance(old, int | float):
        new = _any(rng, (0, -old, old + 1, old * 1.001, 1e308, str(old), None, [old]))
    else:
        new = _any(rng, (None, 0, "garbage", [], {}))
    holder[key] = new
    return f"{key!r} is {new!r}", json.dumps(held, indent=2).encode()


def _leaves(held: Any) -> Any:
    for key in held if isinstance(held, dict) else range(len(held)):
        yield held, key
        if isinstance(held[key], dict | list):
            yield from _leaves(held[key])


# Archives -----------------------------------------------------------------------------------------


def _members(content: bytes) -> list[tuple[zipfile.ZipInfo, bytes]]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return [(info, archive.read(info)) for info in archive.infolist()]


def _pack_members(members: list[tuple[zipfile.ZipInfo, bytes]]) -> bytes:
    import warnings

    stream = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w") as archive:
        warnings.simplefilter("ignore")  # of two members of one name
        for info, content in members:
            new = zipfile.ZipInfo(info.filename, (1980, 1, 1, 0, 0, 0))
            archive.writestr(new, content, info.compress_type)
    return stream.getvalue()


def repacked(rng: Random, content: bytes, fields: Fields) -> Done:
    """Damage a member, and pack it with a right checksum."""
    members = _members(content)
    at = int(rng.integers(len(members)))
    info, inside = members[at]
    text = inside[:1] == b"<"
    damage = _any(rng, TEXT if text and rng.random() < 0.7 else RAW)
    words, members[at] = (
        (lambda done: (done[0], (info, done[1])))(damage(rng, inside, ()))
        if inside
        else (_EMPTY, members[at])
    )
    return f"{info.filename}: {words}", _pack_members(members)


def remembered(rng: Random, content: bytes, fields: Fields) -> Done:
    """Lose, double, rename or exchange members."""
    members = _members(content)
    at, other = (int(number) for number in rng.integers(len(members), size=2))
    name, draw = members[at][0].filename, rng.random()
    if draw < 0.3:
        return f"{name} is gone", _pack_members(members[:at] + members[at + 1 :])
    if draw < 0.5:
        info, inside = members[at]
        _, second = flipped(rng, inside, ()) if inside else ("", b"more")
        return f"{name} twice, once damaged", _pack_members([*members, (info, second)])
    if draw < 0.7:
        new = zipfile.ZipInfo(str(_any(rng, ("../" + name, "/" + name, name.upper(), "x"))))
        new.compress_type = members[at][0].compress_type
        members[at] = (new, members[at][1])
        return f"{name} is called {new.filename}", _pack_members(members)
    one, two = members[at], members[other]
    members[at], members[other] = (one[0], two[1]), (two[0], one[1])
    return f"{name} and {two[0].filename} exchanged", _pack_members(members)


def bombed(rng: Random, content: bytes, fields: Fields) -> Done:
    """Add a member of 4 GiB in 4 MB, or let a member continue so."""
    members = _members(content)
    if rng.random() < 0.5:
        name, head = "more" + Path(members[0][0].filename).suffix, b""
    else:
        at = int(rng.integers(len(members)))
        info, head = members.pop(at)
        name = info.filename
    packed = zlib.compressobj(1, zlib.DEFLATED, -15)
    start = packed.compress(head) + packed.flush(zlib.Z_FULL_FLUSH)
    block = zlib.compressobj(9, zlib.DEFLATED, -15)
    size = 2**24
    zeros = block.compress(bytes(size)) + block.flush(zlib.Z_FULL_FLUSH)
    body = start + zeros * (_BOMB // size) + b"\x03\x00"
    return f"{name} holds 4 GiB", _with_raw(_pack_members(members), name, body, _BOMB)


def _with_raw(content: bytes, name: str, body: bytes, size: int) -> bytes:
    """Return an archive with one more member, given as it is packed; its checksum is wrong."""
    end = content.rindex(b"PK\x05\x06")
    count, length, start = struct.unpack_from("<HII", content, end + 10)
    word, size = name.encode(), min(size, 2**32 - 2)
    sizes = struct.pack("<HHHHHIIIHH", 20, 0, 8, 0, 33, 0, len(body), size, len(word), 0)
    local = b"PK\x03\x04" + sizes + word + body
    entry = b"PK\x01\x02\x14\x00" + sizes + struct.pack("<HHHII", 0, 0, 0, 0, start) + word
    directory = content[start : start + length] + entry
    tail = struct.pack(
        "<4s4H2IH", b"PK\x05\x06", 0, 0, count + 1, count + 1, len(directory), start + len(local), 0
    )
    return content[:start] + local + directory + tail


_ENTITIES = b"""<?xml version="1.0"?><!DOCTYPE p [<!ENTITY a "aaaaaaaaaa">%s
<!ENTITY outside SYSTEM "file://%s">]>"""


def expanded(rng: Random, content: bytes, fields: Fields, outside: Path) -> Done:
    """Give a text in XML entities that stand for much text or for another file."""
    members = _members(content)
    names = [info.filename for info, _ in members]
    at = next(n for n, name in enumerate(names) if name.endswith(".xml"))
    info, inside = members[at]
    more = b"".join(b'<!ENTITY %c "%s">' % (98 + n, b"&%c;" % (97 + n) * 10) for n in range(9))
    head = _ENTITIES % (more, str(outside).encode())
    body = re.sub(rb"<\?xml[^>]*\?>", b"", inside)
    mark = rb">2e-6<" if b">2e-6<" in body else rb">[-\d.e]+<"
    entity = b">&outside;<" if rng.random() < 0.5 else b">&j;<"
    body = re.sub(mark, entity, body, count=1)
    members[at] = (info, head + body)
    return f"{info.filename} with entities", _pack_members(members)


ARCHIVE = (repacked, repacked, remembered)
SEALING = (repacked, remembered, expanded)


# HDF5 ---------------------------------------------------------------------------------------------


def restored(rng: Random, content: bytes, outside: Path, scratch: Path) -> Done:
    """Change attributes and variables of an HDF5 file through its library."""
    scratch.write_bytes(content)
    with h5py.File(scratch, "r+") as file:
        try:
            words = _any(rng, HDF5)(rng, file, outside)
        # The library refuses some: a variable of texts has no element to change.
        except (TypeError, ValueError, KeyError, OSError, OverflowError):
            words = _EMPTY
    new = scratch.read_bytes()
    scratch.unlink()
    return words, new


def _variables(file: h5py.File) -> list[str]:
    found: list[str] = []
    file.visititems(lambda name, node: found.append(name) if hasattr(node, "dtype") else None)
    return found


def _attribute(rng: Random, file: h5py.File, outside: Path) -> str:
    nodes = [file, file, *(file[name] for name in _variables(file))]
    node = _any(rng, [node for node in nodes if len(node.attrs)])
    name = str(_any(rng, sorted(node.attrs)))
    old = node.attrs[name]
    where = f"{node.name}@{name}"
    if rng.random() < 0.2:
        del node.attrs[name]
        return f"{where} is gone"
    if isinstance(old, str | bytes):
        text = old if isinstance(old, str) else old.decode("latin-1")
        new: Any = _any(rng, ("", "garbage", text[::-1], text + " ", text.upper(), 7.0, "x" * 9000))
    elif np.size(old) == 1 and np.asarray(old).dtype.kind in "fiu":
        new = _any(rng, (_other(rng, float(np.asarray(old).item()), _FLOATS), "garbage", [1.0, 2]))
        if isinstance(new, float) and np.asarray(old).dtype.kind in "iu":
            new = int(max(min(new, 1e18), -1e18)) if math.isfinite(new) else -1
        if not isinstance(new, str):
            new = np.atleast_1d(new)
    else:
        new = _any(rng, (0.0, "garbage"))
    del node.attrs[name]
    node.attrs[name] = new
    return f"{where} is {str(new)[:30]!r}"


def _element(rng: Random, file: h5py.File, outside: Path) -> str:
    variables = _variables(file)
    # By volume, as a disk would have it, or each alike.
    sizes = np.array([file[name].size for name in variables], dtype=float)
    weights = sizes / sizes.sum() if rng.random() < 0.5 else None
    name = str(rng.choice(variables, p=weights))
    values = file[name][()]
    flat = np.atleast_1d(values).ravel()
    at = int(rng.integers(flat.size))
    old = flat[at]
    if flat.dtype.kind == "f":
        raw = flat[at : at + 1].view(f"u{flat.itemsize}")
        if rng.random() < 0.5:
            raw ^= raw.dtype.type(1 << int(rng.integers(8 * flat.itemsize)))
        else:
            flat[at] = _other(rng, float(old), _FLOATS)
    else:
        flat[at] = flat[at] ^ 1
    file[name][...] = flat.reshape(np.shape(values))
    return f"{name}[{at}] is {flat[at]!r} for {old!r}"


def _removed(rng: Random, file: h5py.File, outside: Path) -> str:
    name = str(_any(rng, _variables(file)))
    draw = rng.random()
    if draw < 0.5:
        del file[name]
        return f"{name} is gone"
    if draw < 0.7:
        file.move(name, name + "_")
        return f"{name} is called {name}_"
    alike = [o for o in _variables(file) if file[o].shape == file[name].shape and o != name]
    other = str(_any(rng, alike))
    one, two = file[name][()], file[other][()]
    file[name][...], file[other][...] = two, one
    return f"{name} and {other} exchanged"


def _replaced(file: h5py.File, name: str, **options: Any) -> None:
    """Put a variable of other shape, type or storage in the place of one."""
    old = file[name]
    attributes = {
        key: old.attrs[key]
        for key in old.attrs
        if key not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")
    }
    axes = [[scale.name for scale in axis.values()] for axis in old.dims]
    del file[name]
    new = file.create_dataset(name, **options)
    for key, value in attributes.items():
        new.attrs[key] = value
    for axis, names in zip(new.dims, axes, strict=False):
        for scale in names:
            axis.attach_scale(file[scale])


def _grown(rng: Random, file: h5py.File, outside: Path) -> str:
    shape = (_MAX_POINTS, _MAX_POINTS)
    maps = [name for name in _variables(file) if file[name].ndim == 2]
    if not maps:
        raise ValueError("no maps")
    for name in maps if rng.random() < 0.5 else [_any(rng, maps)]:
        _replaced(
            file,
            name,
            shape=shape,
            dtype=file[name].dtype,
            chunks=(100, 100),
            compression="gzip",
            fillvalue=1,
        )
    return f"{len(maps)} maps of {_MAX_POINTS} × {_MAX_POINTS} points"


def _outside(rng: Random, file: h5py.File, outside: Path) -> str:
    name = str(_any(rng, [n for n in _variables(file) if file[n].ndim == 2]))
    shape, dtype, draw = file[name].shape, file[name].dtype, rng.random()
    if draw < 0.5:
        # Numbers from another file would pass for heights.
        size = math.prod(shape) * dtype.itemsize
        _replaced(file, name, shape=shape, dtype=dtype, external=[(str(outside), 0, size)])
        return f"{name} is in {outside.name}"
    if draw < 0.7:
        del file[name]
        file[name] = h5py.ExternalLink(str(outside.with_suffix(".h5")), "height")
        return f"{name} is a link to another file"
    if draw < 0.8:
        del file[name]
        file[name] = h5py.SoftLink(f"/{name}")
        return f"{name} is a link to itself"
    layout = h5py.VirtualLayout(shape, dtype)
    layout[...] = h5py.VirtualSource(str(outside.with_suffix(".h5")), "height", shape)
    attributes = dict(file[name].attrs)
    del file[name]
    new = file.create_virtual_dataset(name, layout)
    for key in ("units", "long_name"):
        if key in attributes:
            new.attrs[key] = attributes[key]
    return f"{name} is virtual, of another file"


def _retyped(rng: Random, file: h5py.File, outside: Path) -> str:
    name = str(_any(rng, _variables(file)))
    values = file[name][()]
    change = _any(
        rng,
        (
            lambda: values.astype("f4"),
            lambda: values.astype("i4"),
            lambda: values.astype("c16"),
            lambda: values.astype("S8"),
            lambda: values.T.copy(),
            lambda: values[..., :-1].copy(),
            lambda: np.zeros((0, 0)),
            lambda: values[None].copy(),
            lambda: values * 2,
        ),
    )
    with np.errstate(all="ignore"):
        new = change()
    _replaced(file, name, data=new)
    return f"{name} is {new.dtype} of shape {new.shape}"


HDF5 = (
    _attribute,
    _attribute,
    _attribute,
    _element,
    _element,
    _element,
    _removed,
    _removed,
    _retyped,
    _outside,
    _grown,
)

Damage = Callable[[Random, bytes, Fields], Done]
