"""Who may reach the studio, and with how many processes: what Panel and Bokeh are told, checked beforehand."""

from __future__ import annotations

import json
import os
import secrets
import signal
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engines.errors import FormatError, MotionloomError, OutOfRangeError, UnknownLabelError
from studio.views.parts import ASSETS

LOCAL = ("127.0.0.1", "localhost", "::1")
"""Addresses that no other machine reaches."""
MOST_PROCESSES = 64


@dataclass(frozen=True)
class Access:
    """Who may open the page, and how they say who they are. Secrets stay out of the representation."""

    basic_auth: str = ""
    """A password for everybody, or a JSON file of names and passwords."""
    oauth_provider: str = ""
    """As `github`; see `providers`."""
    oauth_key: str = ""
    oauth_secret: str = ""
    oauth_redirect_uri: str = ""
    cookie_secret: str = ""
    """What cookies are signed with; made anew at each start unless given."""
    origins: tuple[str, ...] = ()
    """HOST:PORT under which pages may connect, as the browser's address line has it."""

    def __repr__(self) -> str:
        return f"Access(origins={self.origins}, asks={self.asks})"

    @property
    def asks(self) -> bool:
        """Whether people have to say who they are."""
        return bool(self.basic_auth or self.oauth_provider)

    def checked(self, host: str) -> Access:
        """The same, if it can work.

        Raises:
            MotionloomError: two ways to sign in, or one for others without the address they come from.
            FormatError: the file of passwords cannot be read, or holds something else.
            UnknownLabelError: no provider of that name.
            OutOfRangeError: an origin that is none, or a provider without key and secret.
        """
        if self.basic_auth and self.oauth_provider:
            raise MotionloomError("--basic-auth and --oauth-provider: accepted: one of the two.")
        if self.basic_auth:
            _check_passwords(self.basic_auth)
        if self.oauth_provider:
            self._check_provider()
        for origin in self.origins:
            if "://" in origin or "/" in origin or not origin.strip():
                raise OutOfRangeError(
                    "--allow-websocket-origin", origin, "HOST or HOST:PORT, without https:// and path"
                )
        if self.asks and host not in LOCAL and not self.origins:
            raise MotionloomError(
                "People sign in from other machines: say under which address with --allow-websocket-origin HOST:PORT, "
                "as their browsers show it (else any web page could use what they signed in to)."
            )
        return self

    def _check_provider(self) -> None:
        if self.oauth_provider not in providers():
            raise UnknownLabelError("OAuth provider", self.oauth_provider, providers())
        missing = [name for name in ("key", "secret") if not getattr(self, f"oauth_{name}")]
        if missing and self.oauth_provider not in ("pam", "password", "auth_code"):
            words = " and ".join(f"--oauth-{name} (or PANEL_OAUTH_{name.upper()})" for name in missing)
            raise MotionloomError(f"OAuth with {self.oauth_provider} needs {words}, as the provider gave it to you.")

    def options(self, host: str, port: int) -> dict[str, Any]:
        """What `panel.serve` is told."""
        own = [f"{name}:{port}" for name in ("localhost", "127.0.0.1")]
        told: dict[str, Any] = {
            "websocket_origin": list(self.origins) + own if self.origins else own if host in LOCAL else ["*"]
        }
        if self.asks:
            told["cookie_secret"] = self.cookie_secret or os.environ.get("PANEL_COOKIE_SECRET") or secrets.token_hex(32)
        if self.basic_auth:
            told |= {"basic_auth": self.basic_auth, "login_template": str(ASSETS / "login.html")}
        if self.oauth_provider:
            names = ("oauth_provider", "oauth_key", "oauth_secret", "oauth_redirect_uri")
            told |= {name: getattr(self, name) for name in names if getattr(self, name)}
        return told


def providers() -> tuple[str, ...]:
    """Names of the services people can sign in with."""
    from panel.auth import AUTH_PROVIDERS

    return tuple(AUTH_PROVIDERS)


def processes(wanted: int) -> int:
    """How many processes serve; 0 means one a processor.

    Raises:
        OutOfRangeError: a number that cannot be.
        MotionloomError: more than one where processes cannot be split off.
    """
    if not 0 <= wanted <= MOST_PROCESSES:
        raise OutOfRangeError("--num-procs", wanted, f"1 to {MOST_PROCESSES}, or 0 for one a processor")
    count = wanted or os.cpu_count() or 1
    if count > 1 and not hasattr(os, "fork"):
        raise MotionloomError("--num-procs: this system splits no processes; accepted: 1.")
    return count


def end_with(parent: int) -> None:
    """End this process soon after its parent has: a studio that is killed leaves none of its processes behind."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os.kill(os.getpid(), signal.SIGTERM)  # as if told: what sessions left behind is cleared away

    threading.Thread(target=watch, name="motionloom-parent", daemon=True).start()


def _check_passwords(said: str) -> None:
    """A password is any text; what looks like a file has to be one, of names and passwords."""
    path = Path(said)
    if not path.is_file():
        if path.suffix == ".json":
            raise FormatError(
                path, "there is no such file; accepted: a password, or a JSON file of names and passwords"
            )
        return
    try:
        held = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as problem:
        raise FormatError(path, f"cannot be read as JSON ({problem}); accepted: names and passwords") from None
    if not isinstance(held, dict) or not held or not all(isinstance(word, str) and word for word in held.values()):
        raise FormatError(path, 'holds something else; accepted: names and passwords, {"anna": "her password"}')
