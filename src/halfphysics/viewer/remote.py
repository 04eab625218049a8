"""The wire between a server and the script in its page (player/server.js).

viser carries it: text fields that are never shown. One is written by the browser, a command each
time; one by the server, all that the script has to know, for browsers that come later, too; and one
by the server, what changes with every frame.
"""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Callable
from typing import Any

_LABEL = "halfphysics-wire"
#: A sentence is taken back after this time [s]: browsers that come later do not show it.
_SAID = 1.0

#: A command: its name, the value `to` that it has, and the browser that sent it.
Act = Callable[[str, Any, Any], None]


class Remote:
    """Commands of browsers, and what their scripts are told.

    Args:
        gui: viser's panel.
        act: Executes a command; called in viser's event loop.
    """

    def __init__(self, gui: Any, act: Act) -> None:
        self._act = act
        # A page that connects again, to another server or a scene built anew, has to notice.
        self._told: dict[str, Any] = {"scene": secrets.token_hex(8)}
        self._since = 0.0
        self._heard = gui.add_text(f"{_LABEL}-out", "", visible=False)
        self._tells = gui.add_text(f"{_LABEL}-in", "", visible=False)
        self._now = gui.add_text(f"{_LABEL}-now", "", visible=False)

        # Not in viser's pool of threads: there, a later command may overtake an earlier one.
        async def heard(event: Any) -> None:
            if event.client_id is not None:
                self.obey(event.target.value, event.client)

        self._heard.on_update(heard)

    def obey(self, text: str, client: Any) -> None:
        """Execute a command of a browser; what is no command is ignored."""
        try:
            command = json.loads(text, parse_int=float)  # of any length: inf
        except (ValueError, RecursionError):
            return
        if isinstance(command, dict) and isinstance(command.get("do"), str):
            self._act(command["do"], command.get("to"), client)

    def tell(self, **values: Any) -> None:
        """Tell all browsers; what they know already stays as it is, and nothing is sent twice."""
        told = {**self._told, **values}
        if "say" in told and time.monotonic() - self._since > _SAID and "say" not in values:
            del told["say"]
        if told == self._told:
            return
        self._told = told
        self._tells.value = json.dumps(told, separators=(",", ":"))

    def tell_now(self, **values: Any) -> None:
        """Tell all browsers what holds for this frame."""
        text = json.dumps(values, separators=(",", ":"))
        if text != self._now.value:
            self._now.value = text

    def say(self, text: str) -> None:
        """Show one sentence over the scene of all browsers."""
        self._since = time.monotonic()
        self.tell(say=text)
