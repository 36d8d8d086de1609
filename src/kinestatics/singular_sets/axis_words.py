"""`AxisRelation`: what holds among the axes of joints at one posture, and the words for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..namespaces import Array
from ..quantities import plain


@dataclass(frozen=True, eq=False)
class AxisRelation:
    """What holds among the axes of joints at one posture and not at every one.

    Attributes:
        kind: "collinear", "parallel", "coplanar" (parallel axes in one plane), "meet" (axes through one point),
            "in-plane" (a point in the plane of two axes), "on-axis" (the tip on axes), "straight" (the line through two
            points of the arm crosses the axis between them).
        joints: names of the joints whose axes they are, from the base on; for "in-plane" the two of the plane.
        through: for "in-plane", the joints whose axes always meet in the point; empty for the tip; for "straight" those of
            the first point and then of the second.
        point: (3) where they meet, the point in the plane or on the axis; base axes, base origin [m]; None where there is
            none.
        direction: (3) unit vector along the axes or the line, or at right angles to the plane; None for axes that meet.
        tolerance: angles [rad] and lengths in reaches of the arm below which the relation holds.
        text: the same in words.
    """

    kind: str
    joints: tuple[str, ...]
    through: tuple[str, ...]
    point: Array | None
    direction: Array | None
    tolerance: float
    text: str

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "kind": self.kind,
            "joints": list(self.joints),
            "through": list(self.through),
            "point": plain(self.point),
            "direction": plain(self.direction),
            "tolerance": self.tolerance,
            "text": self.text,
        }

    def __str__(self) -> str:
        return self.text


def groups(count: Sequence[int], related: Callable[[int, int], bool]) -> list[tuple[int, ...]]:
    """Joints gathered into classes of two or more by a relation that carries over."""
    found: list[list[int]] = []
    for i in count:
        home = next((group for group in found if related(group[0], i)), None)
        if home is None:
            found.append([i])
        else:
            home.append(i)
    return [tuple(group) for group in found if len(group) > 1]


def listed(names: Sequence[str], joints: Sequence[int]) -> str:
    """Names in a sentence: "a, b and c"."""
    words = [names[i] for i in joints]
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)
