"""Folders as zip files in memory: bundles that leave, bundles and runs that come in.

Of an archive that comes in only files with names that this program knows are read, each up to a
size; nothing is unpacked under a name that the archive chose.
"""

import io
import tempfile
import zipfile
from pathlib import Path, PurePosixPath

from core.errors import UserError
from studio.files.bundle import METADATA, PROGRAMS, SCENE, WEIGHTS, Policy, load_bundle, save_bundle
from studio.files.filenames import safe_name

LARGEST_UPLOAD = 32 * 2**20
"""Bytes of the largest file that a client may send."""

LARGEST_MEMBER = 64 * 2**20
"""Bytes of a file in an archive, unpacked."""

MOST_MEMBERS = 500

REQUIRED = (METADATA, SCENE, WEIGHTS, *PROGRAMS)


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
        name: as the client gives it; only shown.
        content: all bytes of the file.

    Raises:
        UserError: too large, no zip file, or one without a sound bundle.
    """
    shown = safe_name(name, "upload")
    if len(content) > LARGEST_UPLOAD:
        raise ArchiveError(f"{shown}: larger than {LARGEST_UPLOAD:,} bytes")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            files = _bundle_files(archive, shown)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        raise ArchiveError(f"{shown}: not a zip file that can be read: {error}") from error
    with tempfile.TemporaryDirectory(prefix="tgpo-upload-") as parent:
        folder = Path(parent)
        for member, data in files.items():
            (folder / member).write_bytes(data)
        try:
            return load_bundle(folder)
        except UserError as error:
            raise ArchiveError(str(error).replace(str(folder), shown)) from error


def _bundle_files(archive: zipfile.ZipFile, shown: str) -> dict[str, bytes]:
    """Content of the files of the bundle nearest to the archive's root, by their own names."""
    members = archive.infolist()
    if len(members) > MOST_MEMBERS:
        raise ArchiveError(f"{shown}: {len(members)} files; at most {MOST_MEMBERS} are read")
    folders = [
        PurePosixPath(member.filename).parent
        for member in members
        if PurePosixPath(member.filename).name == METADATA
    ]
    if not folders:
        raise ArchiveError(f"{shown}: no policy bundle in it ({METADATA} is missing)")
    folder = min(folders, key=lambda path: len(path.parts))
    by_path = {PurePosixPath(member.filename): member for member in members}
    found = {}
    for name in REQUIRED:
        member = by_path.get(folder / name)
        if member is None:
            raise ArchiveError(f"{shown}: the bundle is incomplete: {name} is missing")
        with archive.open(member) as file:
            found[name] = file.read(LARGEST_MEMBER + 1)
        if len(found[name]) > LARGEST_MEMBER:
            raise ArchiveError(f"{shown}: {name} is larger than {LARGEST_MEMBER:,} bytes")
    return found
