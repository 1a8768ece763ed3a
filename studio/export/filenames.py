"""Names of files that are downloaded or uploaded through the browser.

A name from a client is only displayed: files are stored under names made by this program.
"""

import re
import unicodedata

LONGEST = 80  # characters
_RESERVED = {"con", "prn", "aux", "nul", *(f"{d}{n}" for d in ("com", "lpt") for n in range(10))}


def safe_name(text: str, fallback: str = "untitled") -> str:
    """A name that every file system accepts and that stays in its folder.

    Only letters, digits, `.`, `_` and `-`, without a dot at either end; accents are dropped, other
    characters become `-`; at most `LONGEST` characters.
    """
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", plain)
    name = re.sub(r"\.{2,}", ".", name)[:LONGEST].strip("-.")
    if not name or name.split(".")[0].lower() in _RESERVED:
        return fallback
    return name


def download_name(*parts: str, suffix: str) -> str:
    """`linear-08-rollout.csv`: parts made safe, joined by hyphens, and a suffix such as `.csv`."""
    name = "-".join(safe_name(part) for part in parts)
    return safe_name(name[: LONGEST - len(suffix)]) + suffix
