"""What a client may say to a guarded server: words about what it sees, with finite numbers, of bounded size. Floor 10.

viser would let a client set any attribute of a slider, not only its value, store files without bound, and open a public
tunnel. What is not admitted here never reaches viser.
"""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

ADMITTED = frozenset(
    {
        "CommandTriggerMessage",
        "FileTransferPart",
        "FileTransferStartUpload",
        "GetRenderResponseMessage",
        "GuiButtonHoldMessage",
        "GuiFormDirtyMessage",
        "GuiFormSubmitMessage",
        "GuiUpdateMessage",
        "SceneNodeClickMessage",
        "SceneNodeDragMessage",
        "ScenePointerMessage",
        "TransformControlsDragEndMessage",
        "TransformControlsDragStartMessage",
        "TransformControlsUpdateMessage",
        "ViewerCameraMessage",
    }
)
TUNNEL = ("ShareUrlRequest", "ShareUrlDisconnect")
_UPLOADED = 16 * 2**20  # bytes of files that one client may send in all
_LENGTHS = {"wxyz": 4, "position": 3, "look_at": 3, "up_direction": 3}


def careful_connection() -> type[ServerConnection]:
    """A websocket connection that hands on only what a client may say."""
    from websockets.asyncio.server import ServerConnection

    class CarefulConnection(ServerConnection):
        """Skips messages that are not admissible."""

        _left = _UPLOADED

        async def recv(self, decode: bool | None = None) -> Any:
            """The next message that is admissible."""
            while True:
                raw = await super().recv(decode)
                message = admissible(raw)
                self._left -= len(getattr(message, "content", b""))
                if message is not None and self._left >= 0:
                    return raw

    return CarefulConnection


def admissible(raw: str | bytes) -> Any:
    """The message in these bytes, or None if a client may not say it."""
    import viser._messages as messages

    if not isinstance(raw, bytes):
        return None
    try:
        message = messages.Message.deserialize(raw)
        return message if type(message).__name__ in ADMITTED and _sound(vars(message)) else None
    except Exception:  # whatever a stranger's bytes raise in viser's reader, or in ours
        return None


def _sound(said: dict[str, Any]) -> bool:
    """Whether numbers are finite, vectors have their length, and of a slider only the value is meant."""
    lengths = all(len(said[name]) == length for name, length in _LENGTHS.items() if name in said)
    updates = said.get("updates", {"value": None})
    return lengths and _finite(said) and list(updates) == ["value"] and _finite(updates["value"], spelled=True)


def _finite(value: Any, spelled: bool = False) -> bool:
    """Whether every number in there is finite; a text that spells one too, where viser would read it as one."""
    if isinstance(value, str) and spelled:
        with contextlib.suppress(ValueError):
            value = float(value)
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, dict):
        return all(map(_finite, value.values()))
    return all(_finite(part, spelled) for part in value) if isinstance(value, list | tuple) else True
