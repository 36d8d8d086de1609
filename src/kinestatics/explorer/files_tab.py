"""Postures kept by name, and what leaves the page: postures, the scene, a report."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..namespaces import Array
from .session import Session
from .words import shown_name

_NONE = "(none yet)"
_MOST, _LARGEST = 200, 1_000_000
"""Postures that are kept, and bytes of a file of them that is read."""


class FilesTab:
    """Saves and loads postures; exports the scene and a report of the present posture.

    Args:
        scene_html: what makes a page of the scene; report_html: what makes the report.
    """

    def __init__(
        self,
        gui: Any,
        session: Session,
        attempt: Callable[[Callable[[], None]], None],
        told: Callable[[str], None],
        scene_html: Callable[[], str],
        report_html: Callable[[], str],
    ) -> None:
        self._session, self._told = session, told
        self.kept: dict[str, Array] = {}
        self.name = gui.add_text("name", "posture 1", hint="under which this posture is kept")
        gui.add_button("keep this posture").on_click(lambda _event: attempt(self._keep))
        self.list = gui.add_dropdown("kept postures", (_NONE,))
        gui.add_button("go to it").on_click(lambda _event: attempt(self._return))
        gui.add_button("download the postures (.json)").on_click(lambda event: attempt(lambda: self._download(event.client)))
        upload = gui.add_upload_button("load postures (.json)", mime_type="application/json")
        upload.on_upload(lambda event: attempt(lambda: self._load(event.target.value.content)))
        gui.add_button("download the scene (.html)").on_click(
            lambda event: attempt(lambda: self._send(event.client, "scene.html", scene_html))
        )
        gui.add_button("download a report (.html)").on_click(
            lambda event: attempt(lambda: self._send(event.client, "report.html", report_html))
        )

    def _keep(self) -> None:
        name = shown_name(self.name.value.strip(), 60) or f"posture {len(self.kept) + 1}"
        if len(self.kept) >= _MOST and name not in self.kept:
            raise ConfigurationError("KS435", f"{_MOST} postures are kept already", "download them, and load fewer")
        self.kept[name] = self._session.situation.q
        self._listed(name)
        self.name.value = f"posture {len(self.kept) + 1}"
        self._told(f"kept as {name!r}")

    def _listed(self, chosen: str) -> None:
        self.list.options = tuple(self.kept) or (_NONE,)
        self.list.value = chosen

    def _return(self) -> None:
        if (q := self.kept.get(self.list.value)) is not None:
            self._session.change(q=q)

    def _download(self, client: Any) -> None:
        self._send(client, "postures.json", lambda: json.dumps(postures_data(self._session, self.kept), indent=2))

    def _load(self, content: bytes) -> None:
        found = read_postures(content, self._session.model.joint_names)
        self.kept = dict(list({**self.kept, **found}.items())[:_MOST])
        self._listed(next(iter(found)))
        self._told(f"{len(found)} postures were loaded")

    def _send(self, client: Any, ending: str, make: Callable[[], str]) -> None:
        """Hands a file to the reader who asked for it."""
        if client is None:
            return
        self._told("making the file …")
        content = make().encode()
        stem = (
            "".join(c if (c.isalnum() and c.isascii()) or c in "-_" else "_" for c in self._session.model.name)[:40] or "arm"
        )
        client.send_file_download(f"{stem}.{ending}", content, save_immediately=True)
        self._told(f"{stem}.{ending}: {len(content) / 1e6:.2f} MB")


def postures_data(session: Session, kept: dict[str, Array]) -> dict[str, Any]:
    """Kept postures as plain data."""
    named = kept or {"posture": session.situation.q}
    postures = [{"name": name, "q": q.tolist()} for name, q in named.items()]
    return {"robot": session.model.name, "joints": list(session.model.joint_names), "postures": postures}


def read_postures(content: bytes, joints: tuple[str, ...]) -> dict[str, Array]:
    """Postures from a file that `postures_data` describes.

    Raises:
        ConfigurationError: KS436 for a file of another form, another robot's joints, or numbers that are none.
    """
    hint = "load a file that this page made: {robot, joints, postures: [{name, q}]}"
    if len(content) > _LARGEST:
        raise ConfigurationError("KS436", f"the file has more than {_LARGEST:,} bytes", hint)
    try:
        data = json.loads(content)
        named, given = data["postures"], tuple(data["joints"])
        rows = [(shown_name(str(entry["name"]), 60), [float(x) for x in entry["q"]]) for entry in named]
    except (ValueError, TypeError, KeyError, RecursionError):
        raise ConfigurationError("KS436", "the file holds no postures", hint) from None
    if given != joints:
        raise ConfigurationError("KS436", f"its joints are {', '.join(map(str, given))[:200]}", f"here: {', '.join(joints)}")
    if not rows or any(len(q) != len(joints) or not all(map(math.isfinite, q)) for _, q in rows):
        raise ConfigurationError("KS436", f"a posture needs {len(joints)} finite numbers", hint)
    return {name: np.array(q) for name, q in rows}
