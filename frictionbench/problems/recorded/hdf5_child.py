"""Reads one HDF5 file in a separate process, and writes its arrays as an .npz to the standard output.

    python hdf5_child.py FILE BYTES

A damaged or malicious file can crash the HDF5 library or make it run forever; here this affects only this process. Only plain
data are read: no links, no data outside the file, no virtual data, only filters of the library itself, only numbers, and at
most BYTES in total by the shapes and chunks stated in the file. A data set that was created but never written is ignored. A
refused file is reported by one line on the standard error and exit code 2.
"""

import io
import math
import resource
import sys

import h5py
import numpy as np

FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32, h5py.h5z.FILTER_SZIP}
MOST_OBJECTS = 1000  # groups and data sets, far more than in FCLIB's files
DEEPEST = 6  # levels of groups, more than in FCLIB's files


class Refused(Exception):  # noqa: N818  # a finding about the file
    """The file is refused; the message states the field and the reason."""


def read(path: str, most: int) -> dict[str, np.ndarray]:
    """All numeric arrays by their paths; attributes and text are ignored."""
    arrays: dict[str, np.ndarray] = {}
    left, seen = most, 0
    with h5py.File(path, "r") as file:
        groups = [("", file, 0)]
        while groups:
            above, group, depth = groups.pop()
            if depth > DEEPEST:
                raise Refused(f"{above}: groups are nested more than {DEEPEST} levels deep")
            for name in group:
                field, seen = f"{above}/{name}".lstrip("/"), seen + 1
                if seen > MOST_OBJECTS:
                    raise Refused(f"{above or 'file'}: more than {MOST_OBJECTS} groups and data sets")
                if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                    raise Refused(f"{field}: is a link; only plain data are read")
                data = group[name]
                if isinstance(data, h5py.Group):
                    groups.append((field, data, depth + 1))
                elif isinstance(data, h5py.Dataset) and data.dtype.kind in "fiu":
                    if data.size and not (data.is_virtual or data.external or data.id.get_storage_size()):
                        continue  # created but never written: it counts as missing
                    # The bytes of its shape or of one chunk, which is unpacked as a whole and may be larger.
                    left -= data.dtype.itemsize * max(math.prod(data.shape), math.prod(data.chunks or ()))
                    _check(field, data, left)
                    arrays[field] = data[()]
    return arrays


def _check(field: str, data: h5py.Dataset, left: int) -> None:
    if data.is_virtual or data.external:
        raise Refused(f"{field}: its data are stored outside the data set")
    if len(data.shape) > 2:
        raise Refused(f"{field}: expected a number, a vector or a matrix, got shape {data.shape}")
    if left < 0:
        raise Refused(f"{field}: has shape {data.shape} and chunks {data.chunks}, with which the file is larger than the limit")
    properties = data.id.get_create_plist()
    for k in range(properties.get_nfilters()):
        if properties.get_filter(k)[0] not in FILTERS:
            raise Refused(f"{field}: is compressed by a filter that is not part of HDF5")


def main() -> int:
    """Return the exit code: 0 with the arrays on the standard output, or 2 with a reason on the standard error."""
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
    np.savez(out, allow_pickle=False, **{"|" + name.replace("/", "|"): value for name, value in arrays.items()})
    sys.stdout.buffer.write(out.getbuffer())
    return 0


if __name__ == "__main__":
    sys.exit(main())
