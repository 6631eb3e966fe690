"""Reads one HDF5 file in a process of its own, and writes its arrays as an .npz to the standard output.

    python hdf5_child.py FILE BYTES

HDF5 is a language for files, and its library was not written for hostile ones: a damaged file can crash it or keep it busy for
ever. Here that ends this process and no other. Of the file's language only plain data are read: no links, not to other files
either, no data outside the file, no virtual data, no filters but those of the library itself, no types but numbers, no more
than BYTES in all by what the file claims of itself. An array that was announced and never written is left out. What is
refused, and why, is one line on the standard error, exit 2.
"""

import io
import resource
import sys

import h5py
import numpy as np

FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32, h5py.h5z.FILTER_SZIP}
MOST = 1000  # datasets
DEEPEST = 6  # groups


class Refused(Exception):  # noqa: N818  # a finding about the file
    """The field and what is wrong with it."""


def read(path: str, most: int) -> dict[str, np.ndarray]:
    """All numeric arrays under their paths; attributes and texts are left alone."""
    arrays: dict[str, np.ndarray] = {}
    left, seen = most, 0
    with h5py.File(path, "r") as file:
        groups = [("", file, 0)]
        while groups:
            above, group, depth = groups.pop()
            if depth > DEEPEST:
                raise Refused(f"{above}: groups within groups within groups")
            for name in group:
                field, seen = f"{above}/{name}".lstrip("/"), seen + 1
                if seen > MOST:
                    raise Refused(f"{above or 'file'}: more than {MOST} entries")
                if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                    raise Refused(f"{field}: a link; only plain data are read")
                entry = group[name]
                if isinstance(entry, h5py.Group):
                    groups.append((field, entry, depth + 1))
                elif isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiu" and _is_written(entry):
                    left -= entry.size * entry.dtype.itemsize
                    _check(field, entry, left)
                    arrays[field] = entry[()]
    return arrays


def _check(field: str, entry: h5py.Dataset, left: int) -> None:
    if entry.is_virtual or entry.external:
        raise Refused(f"{field}: its data lie outside the file")
    if len(entry.shape) > 2:
        raise Refused(f"{field}: expected a number, a vector or a matrix, got shape {entry.shape}")
    if left < 0:
        raise Refused(f"{field}: claims shape {entry.shape}; that is more than is read of any file")
    properties = entry.id.get_create_plist()
    for k in range(properties.get_nfilters()):
        if properties.get_filter(k)[0] not in FILTERS:
            raise Refused(f"{field}: packed by a filter that is not HDF5's own")


def _is_written(entry: h5py.Dataset) -> bool:
    """Whether there is anything behind the shape; what was announced and never written counts as missing."""
    return entry.size == 0 or entry.is_virtual or bool(entry.external) or entry.id.get_storage_size() > 0


def main() -> int:
    """Exit 0 with the arrays, 2 with a reason."""
    path, most = sys.argv[1], int(sys.argv[2])
    resource.setrlimit(resource.RLIMIT_AS, (4 * most + 2**30,) * 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        arrays = read(path, most)
    except Refused as refused:
        sys.stderr.write(str(refused))
        return 2
    except (OSError, KeyError, ValueError, RuntimeError, TypeError, MemoryError) as error:
        sys.stderr.write("not a readable HDF5 file: " + " ".join(str(error).split())[:300])
        return 2
    out = io.BytesIO()
    np.savez(out, allow_pickle=False, **{name.replace("/", "|"): value for name, value in arrays.items()})
    sys.stdout.buffer.write(out.getbuffer())
    return 0


if __name__ == "__main__":
    sys.exit(main())
