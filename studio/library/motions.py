"""Motions in the library: by the hash of their bytes, fetched when they are looked at, the last ones kept at hand."""

from __future__ import annotations

import hashlib
import threading
import time
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field

from sqlalchemy import Connection, Engine, delete, insert, select, update
from sqlalchemy.exc import IntegrityError

from engines import Motion
from engines.formats import npz
from studio.library import schema
from studio.library.database import LibraryError, place, reading

AT_HAND = 256 * 2**20
"""Bytes of motions that are kept in memory."""
UNUSED = 24 * 3600.0
"""Seconds after which a motion that no take shows is let go."""


@dataclass(frozen=True)
class Packed:
    """A motion as bytes."""

    hash: str
    frames: int
    fps: float
    data: bytes = field(repr=False)


def pack(motion: Motion) -> Packed:
    """The bytes of a motion, which are the same whenever the motion is.

    Raises:
        FormatError: its provenance holds what JSON cannot say.
    """
    data = npz.to_bytes(motion)
    return Packed(hashlib.sha256(data).hexdigest(), motion.frames, motion.fps, data)


class Cache:
    """The motions last looked at. Any thread may use it."""

    def __init__(self, limit: int = AT_HAND) -> None:
        self._limit, self._bytes = limit, 0
        self._motions: OrderedDict[str, Motion] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: str) -> Motion | None:
        """The motion, if it is at hand."""
        with self._lock:
            motion = self._motions.get(key)
            if motion is not None:
                self._motions.move_to_end(key)
            return motion

    def put(self, key: str, motion: Motion) -> None:
        """Keep a motion at hand; those looked at longest ago make room."""
        with self._lock:
            if key in self._motions:
                return
            self._motions[key] = motion
            self._bytes += _size(motion)
            while self._bytes > self._limit and len(self._motions) > 1:
                self._bytes -= _size(self._motions.popitem(last=False)[1])


def _size(motion: Motion) -> int:
    # what follows from a motion (places, turns) is kept with it once asked for, and is about three times as large
    return 4 * (motion.rotations.nbytes + motion.translation.nbytes)


@dataclass(frozen=True)
class Stored:
    """A motion in the library."""

    engine: Engine = field(repr=False)
    cache: Cache = field(repr=False)
    hash: str
    frames: int
    fps: float

    def motion(self) -> Motion:
        """The motion itself.

        Raises:
            LibraryError: the library cannot be read, or does not hold it any more.
            FormatError: its bytes are damaged.
        """
        found = self.cache.get(self.hash)
        if found is None:
            found = npz.from_bytes(fetch(self.engine, self.hash), f"motion {self.hash[:8]} of the library")
            self.cache.put(self.hash, found)
        return found


def fetch(engine: Engine, key: str) -> bytes:
    """The bytes of a motion.

    Raises:
        LibraryError: it is not there.
    """
    with reading(engine) as connection:
        rows = schema.motions.c
        data = connection.execute(select(rows.data).where(rows.hash == key)).scalar_one_or_none()
    if data is None:
        raise LibraryError(f"Library {place(engine.url)}: the motion {key[:8]} is missing.")
    return bytes(data)


def put_in(connection: Connection, packed: Iterable[Packed]) -> None:
    """Motions into the library, those that are not in it."""
    rows, now = schema.motions.c, time.time()
    for motion in packed:
        known = connection.execute(update(schema.motions).where(rows.hash == motion.hash).values(used=now))
        if known.rowcount:
            continue
        values = {"hash": motion.hash, "frames": motion.frames, "fps": motion.fps, "data": motion.data, "used": now}
        if connection.dialect.name == "sqlite":  # one writes at a time
            connection.execute(insert(schema.motions).values(**values))
            continue
        try:
            with connection.begin_nested():
                connection.execute(insert(schema.motions).values(**values))
        except IntegrityError:  # another program put it in at the same moment
            continue


def drop_unused(connection: Connection) -> int:
    """Let go of motions that no take shows, but for those just put in. Returns how many."""
    rows = schema.motions.c
    shown = select(schema.takes.c.motion)
    gone = delete(schema.motions).where(rows.used < time.time() - UNUSED, rows.hash.not_in(shown))
    return connection.execute(gone).rowcount
