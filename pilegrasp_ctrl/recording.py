"""Recording of an attempt: shapes, motion and signals in one `.npz` file that numpy alone can read."""

from __future__ import annotations

import io
import json
import os
import struct
import zipfile
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .exceptions import RecordingError
from .files import read_file, write_whole
from .recording_parts import UNIT_TOLERANCE, Body, Contacts, Shape, finite_array

FORMAT = "pilegrasp-recording"
"""Name of the format in the file's header."""

VERSION = 2
"""Version of the files that `Recording.save` writes without meshes."""

MESH_VERSION = 3
"""Version of the files with a shape that is a mesh, which earlier programs cannot read."""

READABLE = (1, 2, 3)
"""Versions of the files that `Recording.load` reads. Version 1 has no contacts."""

MAX_BYTES = 1 << 30
"""Largest unpacked size of a file that is read [bytes]; chosen far above that of a recording of ten minutes."""

MAX_FILE_BYTES = 1 << 28
"""Largest file that is read [bytes]; chosen: recordings compress to less than half their size."""

MAX_HEADER = 1 << 23
"""Longest header of a file [characters]; chosen, a hundred times that of an order of 30 attempts."""

MAX_ENTRIES = 4096
"""Largest number of entries of a file's archive; chosen far above the number of recorded signals."""

MAX_TIME = 1e7
"""Largest time in a recording [s]; chosen."""

_SIGNAL_PREFIX = "signal/"
_CONTACT_PREFIX = "contact/"
_CONTACT_ENTRIES = ("start", "bodies", "position", "force")


def _increasing_times(value: ArrayLike, name: str) -> NDArray[np.float64]:
    """Return a read-only copy of strictly increasing times."""
    times = finite_array(value, np.float64, name)
    if times.ndim != 1 or (np.diff(times) <= 0.0).any():
        raise RecordingError(f"{name} is not a list of strictly increasing times")
    if times.size and np.abs(times).max() > MAX_TIME:
        raise RecordingError(f"{name} holds a time beyond {MAX_TIME:g} s")
    return times


def _json_value(value: Any) -> Any:
    """Return numpy's numbers and arrays as JSON values."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not a JSON value")


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Recording of one attempt: F frames of B bodies, and signals at S other times.

    The numbers have the types of the file, so a saved and loaded recording is the same to the last bit. NaN, infinite
    values, non-increasing times and non-unit quaternions are rejected, both on writing and on reading.

    Attributes:
        meta: JSON values: scenario, seed, success, reason, outcomes and further entries of the writer.
        bodies: B bodies with distinct names.
        frame_time: (F,) times of the frames, strictly increasing, float64 [s].
        body_position: (F, B, 3) positions in the scene's frame, float32 [m].
        body_quaternion: (F, B, 4) rotations of the bodies to the scene, wxyz, float32.
        signal_time: (S,) times of the signals, strictly increasing, float64 [s].
        signals: Signals (S,) or (S, k) by name, float32; the units are in `meta["signal_units"]`.
        contacts: Contacts at each frame; None if they were not recorded.

    Raises:
        RecordingError: The arrays do not fit together, a value or time is rejected, or `meta` holds a value that JSON
            cannot.
    """

    meta: Mapping[str, Any]
    bodies: tuple[Body, ...]
    frame_time: NDArray[np.float64]
    body_position: NDArray[np.float32]
    body_quaternion: NDArray[np.float32]
    signal_time: NDArray[np.float64]
    signals: Mapping[str, NDArray[np.float32]]
    contacts: Contacts | None = None

    def __post_init__(self) -> None:
        try:
            meta = json.loads(json.dumps(dict(self.meta), default=_json_value, allow_nan=False))
        except (TypeError, ValueError, RecursionError) as error:
            raise RecordingError(f"the recording's meta cannot be written as JSON: {error}") from error
        bodies = tuple(self.bodies)
        repeated = sorted(name for name, count in Counter(body.name for body in bodies).items() if count > 1)
        if repeated:
            raise RecordingError(f"the body name {repeated[0]!r} is used more than once")
        frame_time = _increasing_times(self.frame_time, "frame_time")
        if not bodies or not frame_time.size:
            raise RecordingError("a recording needs at least one body and one frame")
        position = finite_array(self.body_position, np.float32, "body_position")
        quaternion = finite_array(self.body_quaternion, np.float32, "body_quaternion")
        for array, width, name in ((position, 3, "body_position"), (quaternion, 4, "body_quaternion")):
            if array.shape != (frame_time.size, len(bodies), width):
                raise RecordingError(
                    f"{name} has shape {array.shape}; {(frame_time.size, len(bodies), width)} is expected"
                )
        if (np.abs(np.linalg.norm(quaternion, axis=-1) - 1.0) > UNIT_TOLERANCE).any():
            raise RecordingError("body_quaternion holds a quaternion that is not of unit length")
        signal_time = _increasing_times(self.signal_time, "signal_time")
        signals = {
            str(name): finite_array(value, np.float32, f"signal {name!r}") for name, value in self.signals.items()
        }
        for name, array in signals.items():
            if array.ndim not in (1, 2) or array.shape[0] != signal_time.size:
                raise RecordingError(f"signal {name!r} has shape {array.shape}; its length must be {signal_time.size}")
        if self.contacts is not None:
            if self.contacts.frames != frame_time.size:
                raise RecordingError(f"contacts hold {self.contacts.frames} frames; {frame_time.size} are expected")
            if self.contacts.bodies.size and self.contacts.bodies.max() >= len(bodies):
                raise RecordingError("contacts name a body that is not recorded")
        for name, value in (
            ("meta", meta),
            ("bodies", bodies),
            ("frame_time", frame_time),
            ("body_position", position),
            ("body_quaternion", quaternion),
            ("signal_time", signal_time),
            ("signals", signals),
        ):
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return (
            f"Recording({self.meta.get('scenario')!r}, seed={self.meta.get('seed')}, {len(self.frame_time)} frames, "
            f"{len(self.bodies)} bodies, {len(self.signals)} signals)"
        )

    def plot(self, *names: str) -> Any:
        """Return curves of the recording as a `matplotlib.figure.Figure`.

        Args:
            names: Keys of the lanes, as "force" or "closure"; by default those that a page shows at first.

        Raises:
            ArgumentError: The recording has no such curves.
        """
        from .viewer.plot import plot

        return plot(self, *names)

    def _repr_html_(self) -> str:
        """Return the recording's page in a frame, for Jupyter."""
        from .viewer.page.document import frame

        return frame(self)

    def to_dataframe(self) -> Any:
        """Return the signals as a `pandas.DataFrame`: a row for each sample, the index is the time [s].

        A signal of several columns is named by their numbers, such as `q[0]`. pandas must be installed.

        Raises:
            RecordingError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise RecordingError("to_dataframe needs pandas; install it with `pip install pilegrasp[pandas]`") from None
        columns: dict[str, NDArray[np.float32]] = {}
        for name, values in sorted(self.signals.items()):
            flat = {name: values} if values.ndim == 1 else {f"{name}[{k}]": part for k, part in enumerate(values.T)}
            columns |= flat
        return pandas.DataFrame(columns, index=pandas.Index(self.signal_time, name="time"))

    def to_bytes(self) -> bytes:
        """Return the content of the recording's file, a compressed `.npz`; equal recordings give equal bytes.

        Raises:
            RecordingError: Meta and bodies are too long for a file.
        """
        header: dict[str, Any] = {
            "format": FORMAT,
            "version": MESH_VERSION if self._has_mesh() else VERSION,
            "meta": self.meta,
            "bodies": [
                {"name": body.name, "role": body.role, "shapes": [shape.as_dict() for shape in body.shapes]}
                for body in self.bodies
            ],
            "signals": sorted(self.signals),
            "contacts": self.contacts is not None,
        }
        words = json.dumps(header, allow_nan=False)
        if len(words) > MAX_HEADER:
            raise RecordingError(_too_long(len(words)))
        arrays: dict[str, Any] = {
            "header": np.array(words),
            "frame_time": self.frame_time,
            "body_position": self.body_position,
            "body_quaternion": self.body_quaternion,
            "signal_time": self.signal_time,
        }
        arrays |= {_SIGNAL_PREFIX + name: self.signals[name] for name in header["signals"]}
        if self.contacts is not None:
            arrays |= {_CONTACT_PREFIX + name: getattr(self.contacts, name) for name in _CONTACT_ENTRIES}
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        return buffer.getvalue()

    def _has_mesh(self) -> bool:
        return any(shape.kind == "mesh" for body in self.bodies for shape in body.shapes)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the recording's file, all of it or nothing.

        Raises:
            RecordingError: The file cannot be written, or meta and bodies are too long for one; no half-written file is
                left.
        """
        content = self.to_bytes()
        try:
            write_whole(Path(path), content)
        except (OSError, ValueError) as error:
            raise RecordingError(f"the recording cannot be written to {str(path)!r}: {error}") from error

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a recording. Nothing in the file is executed.

        Raises:
            RecordingError: The file is missing, too large, damaged, not a recording, or of an unknown version.
        """
        try:
            return cls._from_arrays(_read_arrays(Path(path)))
        except _FileError as error:
            raise RecordingError(str(error)) from None
        except RecordingError as error:
            raise RecordingError(f"{str(path)!r} cannot be read as a recording: {error}") from error
        except OSError as error:
            raise RecordingError(f"{str(path)!r} cannot be read: {error.strerror or error}") from error
        # For damaged archives, zipfile, zlib and numpy raise a dozen unrelated types of errors.
        except Exception as error:
            raise RecordingError(
                f"{str(path)!r} cannot be read as a recording: the file is damaged or is not an .npz of this program"
            ) from error

    @classmethod
    def _from_arrays(cls, arrays: dict[str, NDArray[Any]]) -> Self:
        header = json.loads(str(arrays.pop("header"))) if "header" in arrays else None
        if not isinstance(header, dict) or header.get("format") != FORMAT:
            raise RecordingError(f"its header does not hold the format {FORMAT!r}")
        if header.get("version") not in READABLE:
            known = f"{READABLE[0]} to {READABLE[-1]}"
            raise RecordingError(f"it has version {header.get('version')!r}; this program reads versions {known}")
        # A damaged archive can lose entries without an error, so the header lists the signals, too.
        signals = {name: _SIGNAL_PREFIX + name for name in header["signals"]}
        contacts = {name: _CONTACT_PREFIX + name for name in _CONTACT_ENTRIES} if header.get("contacts") else {}
        expected = {"frame_time", "body_position", "body_quaternion", "signal_time"}
        missing = {*expected, *signals.values(), *contacts.values()} - arrays.keys()
        if missing:
            raise RecordingError(f"the entry {min(missing)!r} is missing")
        bodies = tuple(
            Body(body["name"], body["role"], tuple(Shape(**shape) for shape in body["shapes"]))
            for body in header["bodies"]
        )
        return cls(
            meta=header["meta"],
            bodies=bodies,
            frame_time=arrays["frame_time"],
            body_position=arrays["body_position"],
            body_quaternion=arrays["body_quaternion"],
            signal_time=arrays["signal_time"],
            signals={name: arrays[entry] for name, entry in signals.items()},
            contacts=Contacts(**{name: arrays[entry] for name, entry in contacts.items()}) if contacts else None,
        )


def _too_long(length: int) -> str:
    return f"meta and bodies take {length} characters; a file holds {MAX_HEADER} at most"


def _read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    content = read_file(path, MAX_FILE_BYTES, error=_FileError)
    if not zipfile.is_zipfile(io.BytesIO(content)):
        raise RecordingError("the file is not a complete .npz archive")
    if _entries(content) > MAX_ENTRIES:
        raise RecordingError(f"its archive has more than {MAX_ENTRIES} entries, or is not one of numpy's")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        sizes = {entry.filename: entry.file_size for entry in archive.infolist()}
    if sum(sizes.values()) > MAX_BYTES:
        raise RecordingError(f"it would unpack to more than {MAX_BYTES >> 20} MiB")
    # numpy keeps a text with four bytes a character.
    if sizes.get("header.npy", 0) > 4 * MAX_HEADER + 1024:
        raise RecordingError(_too_long(sizes["header.npy"] // 4))
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def _entries(content: bytes) -> int:
    """Return the number of entries that an archive's last 22 bytes state, before `zipfile` makes an object of each.

    An archive with a comment behind, or with the wide table for very many entries, counts as too large.
    """
    end, locator = content[-22:], content[-42:-38]
    if end[:4] != b"PK\x05\x06" or locator == b"PK\x06\x07":
        return MAX_ENTRIES + 1
    entries, size = struct.unpack("<HI", end[10:16])
    # The directory is read by its size, whatever number is stated.
    return int(max(entries, size // 512))


class _FileError(RecordingError):
    """The file is missing, is no regular file, or is too large; the sentence names it."""
