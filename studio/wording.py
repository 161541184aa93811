"""Small numbers in words, the same wherever they stand."""

from __future__ import annotations

import time


def duration(seconds: float) -> str:
    """Length of a motion: "3.0 s", "63 min 20 s"."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60} s"


def counted(number: int, what: str) -> str:
    """A number of things: "1 take", "3 takes"."""
    return f"{number:,} {what}{'' if number == 1 else 's'}"


def since(then: float, now: float) -> str:
    """How long ago, in seconds since 1970: "just now", "5 minutes ago", "3 days ago"; later a date."""
    gone = max(0.0, now - then)
    for limit, size, unit in ((3600, 60, "minute"), (86400, 3600, "hour"), (14 * 86400, 86400, "day")):
        if gone < limit:
            count = int(gone // size)
            return f"{counted(count, unit)} ago" if count else "just now"
    day = time.localtime(then)
    return f"{day.tm_mday} {time.strftime('%B %Y', day)}"
