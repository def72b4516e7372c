"""What libraries raise on damaged binary files, beside exceptions of their own."""

import struct
import zipfile
import zlib

#: Found by reading files with bytes changed, cut off and left out: readers trust sizes, names and types in the file.
DAMAGED_FILE_ERRORS: tuple[type[Exception], ...] = (
    OSError,
    EOFError,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    AttributeError,
    NameError,
    AssertionError,
    RuntimeError,
    MemoryError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


def reason_of(problem: Exception) -> str:
    """What an exception says, on one line and not too long."""
    return " ".join(str(problem).split())[:120] or type(problem).__name__
