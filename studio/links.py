"""Links that show a project, a take and a frame: `?project=6fb8e4c4b851&take=3&frame=52`.

The open tab (`&tab=text`) and the takes that are compared (`&compare=1.4`) go with them. The address of the page
follows what is shown, so that a page that is loaded again shows the same, after a kill too. Without a link, a cookie
says which project this browser had open last.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from studio.library import Library
from studio.state import FIRST_TAB, TABS, StudioState


@dataclass(frozen=True)
class Link:
    """What an address asks for."""

    project: str = ""
    """Key of a project; empty: a new one."""
    take: str = ""
    """Id of a take; empty: the first."""
    frame: int = -1
    """Frame to stand at; -1: play."""
    tab: str = FIRST_TAB
    """Tab of the left panel."""
    compared: tuple[str, ...] = ()
    """Ids of the takes that are ticked."""
    asked: bool = False
    """The address names the project (and not the cookie)."""

    @classmethod
    def of_page(cls, library: Library | None) -> Link:
        """What the page that is being made was asked for."""
        import panel as pn

        return cls.parse(pn.state.session_args, pn.state.cookies, library.id if library else "")

    @classmethod
    def parse(cls, query: Mapping[str, Sequence[bytes]], cookies: Mapping[str, str], library: str) -> Link:
        """Of the parts of an address and the cookies; what is not understood is left out.

        Args:
            query: name -> values.
            cookies: name -> value.
            library: id of the library.
        """

        def first(name: str, pattern: str) -> str:
            found = re.fullmatch(pattern, query[name][0].decode("utf-8", "replace")) if query.get(name) else None
            return found[1] if found else ""

        named = first("project", r"([0-9a-f]{1,32})")
        number, frame = first("take", r"(?:take-)?(\d{1,9})"), first("frame", r"(\d{1,9})")
        tab, ticked = first("tab", f"({'|'.join(TABS)})"), first("compare", r"(\d{1,9}(?:\.\d{1,9}){0,99})")
        project = named or (cookies.get(cookie(library), "") if library else "")
        return cls(
            project, f"take-{number}" if number else "", int(frame) if frame else -1, tab or FIRST_TAB,
            tuple(f"take-{one}" for one in ticked.split(".") if one), bool(named),
        )  # fmt: skip

    @staticmethod
    def of_state(state: StudioState) -> dict[str, str]:
        """The parts of an address that shows the same again, by name; those that are empty are left out of it."""
        return {
            "project": state.project,
            "take": state.selected.removeprefix("take-"),
            "frame": str(state.frame) if state.frame >= 0 and state.selected else "",
            "tab": "" if state.compose_tab == FIRST_TAB else state.compose_tab,
            "compare": ".".join(take.removeprefix("take-") for take in state.compared),
        }


def cookie(library: str) -> str:
    """Name of the cookie that says which project of a library a browser had open last."""
    return f"motionloom-{library}"
