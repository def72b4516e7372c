"""Sealing the key of a batch: encrypted beside the records, its hash published, the means to open it kept apart.

The hash is taken of the key together with a random salt inside it, so that it binds whoever made the batch and yet
reveals nothing, not even to somebody who guesses seeds.
"""

import hashlib
import json
import os
import secrets
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from studies.blind.errors import BlindError
from wirewear.base.writing import prepared_folder

KEY_MODE = 0o600


def new_key_file(path: Path) -> bytes:
    """A new key, written to a file that only its owner may read.
    Raises BlindError if the file exists or cannot be written, and RunError if its folder cannot be made, or takes no
    files.
    """
    key: bytes = _fernet().Fernet.generate_key()
    prepared_folder(path.parent)
    try:
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, KEY_MODE), "wb") as file:
            file.write(key + b"\n")
    except FileExistsError:
        raise BlindError(f"the key file {path} exists already, and no key is replaced: name a new file.") from None
    except OSError as problem:
        raise BlindError(f"the key file {path} cannot be written ({problem.strerror or problem}).") from None
    return key


def read_key_file(path: Path) -> bytes:
    """The key in a file.
    Raises BlindError if there is none, or it is not one that `python -m studies.blind make` wrote.
    """
    fernet = _fernet()
    try:
        key = path.read_bytes().strip()
    except OSError as problem:
        raise BlindError(f"the key file {path} cannot be read ({problem.strerror or problem}).") from None
    try:
        fernet.Fernet(key)
    except ValueError:
        raise BlindError(f"{path} is not a key file that `python -m studies.blind make` wrote.") from None
    return key


def salted(truth: Mapping[str, Any]) -> dict[str, Any]:
    """The truth with a new salt."""
    return {"salt": secrets.token_hex(32), **truth}


def fingerprint(truth: Mapping[str, Any]) -> str:
    """SHA-256 of a truth with its salt, spelled in one way only."""
    return hashlib.sha256(_spelled(truth)).hexdigest()


def sealed(truth: Mapping[str, Any], key: bytes) -> bytes:
    """The truth, encrypted (Fernet: AES-128 in CBC mode with HMAC-SHA256)."""
    return bytes(_fernet().Fernet(key).encrypt(_spelled(truth)))


def opened(token: bytes, key: bytes, where: str) -> dict[str, Any]:
    """The truth that was sealed. Raises BlindError if the key does not open it, or it was altered."""
    fernet = _fernet()
    try:
        truth = json.loads(fernet.Fernet(key).decrypt(token))
    except fernet.InvalidToken:
        raise BlindError(
            f"the key does not open {where}: it belongs to another batch, or the file was altered."
        ) from None
    if not isinstance(truth, dict):
        raise BlindError(f"{where} holds no table.")
    return truth


def _fernet() -> ModuleType:
    """The module that encrypts. Raises BlindError if its package is not installed."""
    try:
        from cryptography import fernet
    except ImportError:
        raise BlindError(
            "the exam seals its keys by cryptography, which is not installed: pip install 'wirewear[exam]'."
        ) from None
    return fernet


def _spelled(truth: Mapping[str, Any]) -> bytes:
    return json.dumps(truth, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode("ascii")
