"""Folders as zip files in memory: exported bundles, uploaded bundles and runs.

Of an uploaded archive only files with known names are read, each up to a size limit; nothing is
unpacked under a name from the archive. Only stored and deflated files are read: the memory that
the other methods take is up to the archive.
"""

import io
import struct
import tempfile
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from core.errors import UserError
from studio.export.filenames import safe_name
from studio.runs.bundle import METADATA, PROGRAMS, SCENE, WEIGHTS, Policy, load_bundle, save_bundle

LARGEST_UPLOAD = 32 * 2**20
"""Size of the largest file that a client may send, in bytes."""

LARGEST_MEMBER = 64 * 2**20
"""Largest unpacked size of a file in an archive, in bytes."""

MOST_MEMBERS = 500

REQUIRED = (METADATA, SCENE, WEIGHTS, *PROGRAMS)


_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENTRY = b"PK\1\2"
"""What each entry of an archive's directory begins with."""

_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    IndexError,
    KeyError,
    MemoryError,
    OSError,
    OverflowError,
    RuntimeError,
    ValueError,
)
"""What `zipfile` raises where an archive is damaged or encrypted, or has an unknown form."""


class ArchiveError(UserError):
    """An archive that cannot be used."""


def bundle_zip(policy: Policy) -> bytes:
    """Make a policy bundle as one zip file; exporting its programs takes seconds.

    Raises:
        UserError: the bundle cannot be made.
    """
    with tempfile.TemporaryDirectory(prefix="tgpo-bundle-") as parent:
        folder = Path(parent) / "bundle"
        save_bundle(policy, folder)
        file = io.BytesIO()
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(folder.iterdir()):
                archive.write(path, path.name)
    return file.getvalue()


def read_policy_zip(name: str, content: bytes) -> Policy:
    """Read the policy of a zipped bundle, or of a zipped run.

    Args:
        name: as given by the client; only displayed.
        content: all bytes of the file.

    Raises:
        UserError: too large, not a zip file, or one without a valid bundle.
    """
    shown = safe_name(name, "upload")
    if len(content) > LARGEST_UPLOAD:
        raise ArchiveError(f"{shown}: larger than {LARGEST_UPLOAD:,} bytes")
    if content.count(_ENTRY) > MOST_MEMBERS:  # before the directory is read
        raise ArchiveError(f"{shown}: more than {MOST_MEMBERS} files")
    with tempfile.TemporaryDirectory(prefix="tgpo-upload-") as parent:
        folder = Path(parent)
        try:
            with zipfile.ZipFile(io.BytesIO(content)) as archive:
                for file, member in _bundle_files(archive, shown).items():
                    _unpack(archive, member, folder / file, shown)
        except UserError:
            raise
        except _DAMAGE as error:
            raise ArchiveError(f"{shown}: not a readable zip file: {error}") from error
        try:
            return load_bundle(folder)
        except UserError as error:
            raise ArchiveError(str(error).replace(str(folder), shown)) from error


def _bundle_files(archive: zipfile.ZipFile, shown: str) -> dict[str, zipfile.ZipInfo]:
    """The files of the bundle nearest to the archive's root, by file name."""
    members = archive.infolist()
    folders = [
        PurePosixPath(member.filename).parent
        for member in members
        if PurePosixPath(member.filename).name == METADATA
    ]
    if not folders:
        raise ArchiveError(f"{shown}: contains no policy bundle ({METADATA} is missing)")
    folder = min(folders, key=lambda path: len(path.parts))
    by_path = {PurePosixPath(member.filename): member for member in members}
    for name in REQUIRED:
        if folder / name not in by_path:
            raise ArchiveError(f"{shown}: the bundle is incomplete: {name} is missing")
    return {name: by_path[folder / name] for name in REQUIRED}


def _unpack(archive: zipfile.ZipFile, member: zipfile.ZipInfo, path: Path, shown: str) -> None:
    """Write a member to a file, piece by piece."""
    if member.compress_type not in _METHODS:
        raise ArchiveError(
            f"{shown}: {path.name} is compressed by method {member.compress_type}; only stored "
            "and deflated files are read"
        )
    written = 0
    try:
        with archive.open(member) as source, path.open("wb") as target:
            while piece := source.read(2**20):
                written += len(piece)
                if written > LARGEST_MEMBER:
                    raise ArchiveError(
                        f"{shown}: {path.name} is larger than {LARGEST_MEMBER:,} bytes"
                    )
                target.write(piece)
    except UserError:
        raise
    except _DAMAGE as error:
        raise ArchiveError(f"{shown}: {path.name} cannot be unpacked: {error}") from error
