"""Frame: in whose axes a six-vector is written, and at whose origin it is taken. Floor 1."""

from __future__ import annotations

from typing import Any, NamedTuple

BASE, TIP = "base", "tip"


class Frame(NamedTuple):
    """Where a twist, wrench or Jacobian is expressed: the axes of one link, the origin of another.

    "base" and "tip" stand for the model's own base and tip; every other word is a link name. Two words cover all
    Jacobians in use (docs/conventions.md):

        Frame("base", "tip")     geometric Jacobian of textbooks: base axes, velocity of the tip's origin (the default)
        Frame.body("tip")        body Jacobian (Murray, Li, Sastry 1994, eq. 3.56): tip axes at the tip
        Frame.spatial()          spatial Jacobian (MLS eq. 3.54): base axes, the body point now at the base origin

    Attributes:
        axes: link whose axes the components refer to.
        origin: link at whose origin the linear part (velocity, or the moment of a wrench) is taken.
        offset: displacement of that point [m], in the axes of the link `origin`.

    Example:
        >>> Frame.body("tip")
        Frame(axes='tip', origin='tip')
    """

    axes: str = BASE
    origin: str = TIP
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def body(cls, link: str = TIP) -> Frame:
        """Axes and origin of `link`."""
        return cls(link, link)

    @classmethod
    def spatial(cls) -> Frame:
        """Axes and origin of the base."""
        return cls(BASE, BASE)

    def to_dict(self) -> dict[str, Any]:
        """Axes, origin and offset, for JSON."""
        return {"axes": self.axes, "origin": self.origin, "offset": list(self.offset)}

    def __repr__(self) -> str:
        point = f", offset={self.offset}" if any(self.offset) else ""
        return f"Frame(axes={self.axes!r}, origin={self.origin!r}{point})"

    def __str__(self) -> str:
        point = f" + ({', '.join(f'{x:g}' for x in self.offset)})" if any(self.offset) else ""
        return f"axes of {self.axes}, at the origin of {self.origin}{point}"
