# SPDX-License-Identifier: GPL-3.0-or-later
"""The people who may come in: a file of their names, each with the hash of a token that only they have."""

import hashlib
import hmac
import secrets
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ..core.files import write_text

SHORT = 32

OPERATOR = "operator"
"""The name of the person who runs the server, and sees who uses it."""


@dataclass(frozen=True)
class People:
    """A file with a line for each person: name, tab, SHA-256 of the token. Each question reads it anew."""

    file: Path | None

    def __bool__(self) -> bool:
        return bool(self.hashes())

    def hashes(self) -> dict[str, str]:
        """The hash of each person's token by name."""
        with suppress(OSError, ValueError):
            lines = self.file.read_text(encoding="utf-8").splitlines() if self.file else []
            rows = (line.rpartition("\t") for line in lines if not line.startswith("#"))
            return {name.strip(): digest.strip() for name, _, digest in rows if name.strip()}
        return {}

    def owner(self, token: str) -> str:
        """The folder of the person who has a token, whatever tokens they had before; "" if nobody has it."""
        given = _hash(token)
        found = [
            name
            for name, digest in self.hashes().items()
            if hmac.compare_digest(given.encode(), digest.encode())
        ]
        return folder_of_person(found[0]) if found else ""

    def invite(self, name: str) -> str:
        """Draw a token for a person, in the place of an earlier one; only its hash is written down."""
        if self.file is None or not name.strip() or not name.isprintable() or name.startswith("#"):
            raise ValueError(f"{name!r} is no name of a person")
        token = secrets.token_urlsafe(24)
        people = {**self.hashes(), name.strip(): _hash(token)}
        write_text(self.file, "".join(f"{one}\t{digest}\n" for one, digest in people.items()))
        self.file.chmod(0o600)
        return token


NOBODY = People(None)


def folder_of(token: str) -> str:
    """The name of the folder for the studies of a token that no person has."""
    return _hash(token)[:SHORT]


def folder_of_person(name: str) -> str:
    """The name of the folder for a person's studies."""
    return _hash(f"person\n{name}")[:SHORT]


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
