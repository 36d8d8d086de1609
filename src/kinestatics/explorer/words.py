"""Names from robot files, made fit for labels: they can hold anything."""

from __future__ import annotations

from ..report.blocks import visible


def shown_name(name: str, most: int = 60) -> str:
    """A name on one line, its controls visible, cut in the middle where it is long: for labels, which are plain text.

    Example:
        >>> shown_name("panda_joint1"), shown_name("a\\nb" * 40, 12)
        ('panda_joint1', 'a\\\\nb…\\\\nba\\\\nb')
    """
    text = visible(name).replace("\n", "\\n")
    if len(text) <= most:
        return text
    head = most // 2 - 2
    return f"{text[:head]}…{text[-(most - head - 1) :]}"
