"""Puts a page together: one HTML file that holds all it needs."""

from __future__ import annotations

import base64
import string
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tethernet_bringup.report import libraries, markup
from tethernet_core.atomic_file import write_text

LARGEST_BYTES = 6_000_000
"""No page is larger: it shall pass as an attachment."""
FLIGHTS_BYTES = 4_000_000
"""Of it for flights; libraries, plots and tables take the rest."""

_VIEWER = Path(__file__).parent / "viewer"
_SCRIPTS = ("campaign", "charts", "labels", "player", "stage", "tracks", "view")
"""Modules of the viewer; ``main`` starts them."""


@dataclass
class Page:
    """What a page says."""

    title: str
    verdicts: list[tuple[str, str, str]]
    """Badges: word, sentence, and good, bad or open."""
    facts: str
    """One line: what was flown."""
    body: str
    """Tables and the like, HTML from :mod:`.markup`."""
    content: dict[str, Any] = field(default_factory=dict)
    """What the viewer shows: ``systems``, ``flights``, ``plots``, ``missions``."""


def write(page: Page, path: Path) -> None:
    """Write the file whole or not at all.

    Raises:
        OSError: when it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    # Names of files may hold what is no character.
    write_text(path, html(page).encode("utf-8", "backslashreplace").decode("utf-8"), durable=False)


def html(page: Page) -> str:
    """The page."""
    template = string.Template((_VIEWER / "page.html").read_text(encoding="utf-8"))
    return template.substitute(
        title=markup.text(page.title),
        verdicts="\n".join(_badge(*verdict) for verdict in page.verdicts),
        facts=markup.text(page.facts),
        body=page.body,
        licences=_licences(),
        style=libraries.read("uPlot.min.css") + (_VIEWER / "style.css").read_text(encoding="utf-8"),
        imports=markup.data({"imports": _imports()}),
        charts=libraries.read("uPlot.iife.min.js"),
        data=markup.data(page.content),
        main=(_VIEWER / "main.js").read_text(encoding="utf-8"),
    )


def said_once(word: str, sentence: str) -> str:
    """A verdict's sentence without the word that it begins with, where a badge says that already."""
    return sentence[len(word) + 2 :] if sentence.lower().startswith(f"{word.lower()}: ") else sentence


def _badge(word: str, sentence: str, kind: str) -> str:
    return (
        f'<p class="verdict {markup.text(kind)}"><strong>{markup.text(word)}</strong> '
        f"<span>{markup.text(said_once(word, sentence))}</span></p>"
    )


def _licences() -> str:
    parts = [
        f"<h3>{markup.text(library.name)} {markup.text(library.version)}</h3>{markup.block(library.licence)}"
        for library in libraries.libraries()
    ]
    return markup.details("Licences of the libraries in this page", "\n".join(parts))


def _imports() -> dict[str, str]:
    """Modules by the names that they import each other with; nothing is loaded from anywhere."""
    texts = {name: (_VIEWER / f"{name}.js").read_text(encoding="utf-8") for name in _SCRIPTS}
    own = {f"viewer/{name}": f"{script}\n//# sourceURL={name}.js\n" for name, script in texts.items()}
    modules = {"three": libraries.read("three.min.js"), **own}
    return {name: _as_address(script) for name, script in modules.items()}


def _as_address(script: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(script.encode()).decode("ascii")
