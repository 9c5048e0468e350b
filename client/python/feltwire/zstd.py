"""Decompresses zstd by what this machine has: Python 3.14, libzstd, or the package zstandard."""
from __future__ import annotations

import ctypes
import ctypes.util
import functools
from typing import Callable

from .errors import Error


def _of_python() -> Callable[[bytes, int], bytes]:
    from compression import zstd
    # A byte more than expected: the frame may say another size than the file, and must not fill the memory.
    return lambda data, size: bytes(zstd.ZstdDecompressor().decompress(data, max_length=size + 1))


def _of_library() -> Callable[[bytes, int], bytes]:
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    library.ZSTD_decompress.restype = ctypes.c_size_t
    library.ZSTD_decompress.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    library.ZSTD_isError.argtypes = [ctypes.c_size_t]

    def decompress(data: bytes, size: int) -> bytes:
        room = ctypes.create_string_buffer(max(size, 1))
        written = library.ZSTD_decompress(room, size, data, len(data))
        if library.ZSTD_isError(written):
            raise ValueError("no zstd frame")
        return room.raw[:written]

    return decompress


def _of_package() -> Callable[[bytes, int], bytes]:
    import zstandard
    return lambda data, size: bytes(zstandard.ZstdDecompressor().stream_reader(data).read(size + 1))


@functools.lru_cache(maxsize=None)
def _decompressor() -> Callable[[bytes, int], bytes]:
    for kind in (_of_python, _of_library, _of_package):
        try:
            return kind()
        except (ImportError, OSError):
            continue
    raise Error("a recording is compressed by zstd, and this machine has no zstd; install libzstd1, or the Python package zstandard")


def decompress(data: bytes, size: int) -> bytes:
    """The `size` bytes [bytes] of a zstd frame. Raises ValueError if the data are none or have another size."""
    try:
        found = _decompressor()(data, size)
    except Error:
        raise
    except Exception as error:  # each library has its own
        raise ValueError(str(error)) from None
    if len(found) != size:
        raise ValueError("another size")
    return found
