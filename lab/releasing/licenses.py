"""Lists the licenses of all installed packages, as they declare them."""

from __future__ import annotations

import re
import sys
from importlib.metadata import Distribution, distributions

ALLOWED = {
    "0bsd",
    "3-clause bsd license",
    "apache 2.0",
    "apache software license",
    "apache-2.0",
    "bsd",
    "bsd license",
    "bsd-2-clause",
    "bsd-3-clause",
    "cc0-1.0",
    "isc",
    "isc license iscl",
    "llvm-exception",
    "mit",
    "mit license",
    "mit-cmu",
    "mozilla public license 2.0 mpl 2.0",
    "mpl-2.0",
    "psf-2.0",
    "python software foundation license",
    "zlib",
}
"""Licenses without an obligation for our Apache-2.0 code; MPL-2.0 applies to its own files only."""
PARTS = re.compile(r"\s+(?:AND|OR|WITH)\s+|\s*[;,]\s*|^\(|\)$")


def declared(distribution: Distribution) -> str:
    """Return the declared license of a package: the expression, the classifiers, or the first line of the text."""
    expressions = distribution.metadata.get_all("License-Expression") or []
    kinds = [
        c.rpartition(" :: ")[2] for c in distribution.metadata.get_all("Classifier") or [] if c.startswith("License ::")
    ]
    text = "".join(distribution.metadata.get_all("License") or []).strip().splitlines()
    return " AND ".join(expressions or [kind for kind in kinds if kind != "OSI Approved"] or text[:1])


def allowed(license: str) -> bool:
    """True if every part of a license is allowed. An empty one is not."""
    parts = [part.strip().lower() for part in PARTS.split(license.replace("(", "").replace(")", "")) if part.strip()]
    return bool(parts) and all(part in ALLOWED for part in parts)


def main() -> int:
    """List the licenses in this environment; return 1 if one is missing or not allowed."""
    bad = 0
    for distribution in sorted(distributions(), key=lambda each: str(each.metadata["Name"]).lower()):
        name, license = distribution.metadata["Name"], declared(distribution)
        if name in ("pip", "setuptools"):
            continue  # part of the environment, not of our dependencies
        fine = allowed(license)
        bad |= not fine
        print(f"{'ok     ' if fine else 'REFUSED'} {name} {distribution.version}: {license or 'none declared'}")
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
