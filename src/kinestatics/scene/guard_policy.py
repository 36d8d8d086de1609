"""What viser's page may do: run its own scripts, and talk to its own server. Floor 10.

viser shows markdown and HTML as they come, so that a script hidden in a robot's name would run. The page carries its scripts
in itself: one that unpacks, and one that is unpacked. The policy admits these two, by their hashes, and no other.
"""

from __future__ import annotations

import base64
import hashlib
import re
from functools import cache
from importlib.resources import files

_LOADER = re.compile(r'<script data-p="([^"]+)" data-ss="(\d+)" data-cs="(\d+)">(.*?)</script>', re.DOTALL)
_DIGITS = bytes(c for c in range(0x21, 0x7F) if c not in b"\"&<>'`")  # of base 88, five for each four bytes


def content_policy(scripts: tuple[str, ...], host: str) -> str:
    """The Content-Security-Policy of a page at `host`, whose scripts have these hashes."""
    own = f"'self' ws://{host}" if host else "'self'"
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {' '.join(scripts)} 'unsafe-eval'",  # its WebAssembly calls for eval; no markup can
            "worker-src blob: data:",
            "style-src 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src data:",
            f"connect-src {own} data: blob:",
            "frame-ancestors 'none'",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


@cache
def hashes_of_scripts() -> tuple[str, ...]:
    """Hashes of the scripts in viser's page, as a policy names them; none where they are not found."""
    import zstandard

    page = files("viser").joinpath("client", "build", "index.html").read_text(encoding="utf-8")
    found = _LOADER.search(page)
    if found is None:
        return ()
    packed, style, length, loader = found[1], int(found[2]), int(found[3]), found[4]
    unpacked = zstandard.ZstdDecompressor().decompress(_from_base_88(packed), max_output_size=style + length)
    return tuple(
        f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"
        for script in (loader.encode(), unpacked[style : style + length])
    )


def _from_base_88(text: str) -> bytes:
    """Four bytes from each five digits, the most significant first; a last group of k digits holds k - 1 bytes."""
    import numpy as np

    spare = -len(text) % 5
    digits = np.frombuffer(bytes.maketrans(_DIGITS, bytes(range(88))), np.uint8)[np.frombuffer(text.encode(), np.uint8)]
    groups = np.pad(digits, (0, spare)).reshape(-1, 5).astype(np.uint64)
    words = groups @ np.array([88**k for k in (4, 3, 2, 1, 0)], dtype=np.uint64)
    if spare:  # the last group is short: its bytes are the low ones of its own number
        tail = int(words[-1]) // 88**spare
        return words[:-1].astype(">u4").tobytes() + tail.to_bytes(4 - spare, "big")
    return words.astype(">u4").tobytes()
