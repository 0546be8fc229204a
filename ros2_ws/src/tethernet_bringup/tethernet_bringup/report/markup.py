"""Pieces of HTML. Every text that comes from outside is escaped here, and nowhere else."""

from __future__ import annotations

import html
import json
from collections.abc import Iterable, Sequence
from typing import Any

UNKNOWN = "–"


def text(value: object) -> str:
    """A text as part of HTML, in attributes too."""
    return html.escape(str(value), quote=True)


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, name: str = "", numeric: bool = True) -> str:
    """A table whose first column names the rows.

    Args:
        head: of each column.
        rows: as many cells each.
        name: of the table, for those who do not see it.
        numeric: cells behind the first are numbers, aligned to the right.
    """
    kind = ' class="numeric"' if numeric else ""
    label = f' aria-label="{text(name)}"' if name else ""
    lines = [f'<div class="wide" tabindex="0" role="group"{label}><table{kind}>']
    if any(head):
        lines.append("<thead><tr>" + "".join(f'<th scope="col">{text(cell)}</th>' for cell in head) + "</tr></thead>")
    lines.append("<tbody>")
    for first, *others in rows:
        cells = "".join(f"<td>{text(cell)}</td>" for cell in others)
        lines.append(f'<tr><th scope="row">{text(first)}</th>{cells}</tr>')
    return "\n".join([*lines, "</tbody></table></div>"])


def section(title: str, body: str, *, name: str) -> str:
    """A part of the page with its heading; empty where the body is.

    Args:
        title: of the heading.
        body: HTML.
        name: for links.
    """
    if not body:
        return ""
    return f'<section id="{text(name)}"><h2>{text(title)}</h2>\n{body}</section>'


def details(title: str, body: str) -> str:
    """A part that is opened by a click.

    Args:
        title: what is inside.
        body: HTML.
    """
    return f"<details><summary>{text(title)}</summary>\n{body}</details>"


def block(content: str) -> str:
    """Text with its line ends."""
    return f"<pre>{text(content)}</pre>"


def items(lines: Sequence[str]) -> str:
    """A list; empty without lines."""
    return "<ul>" + "".join(f"<li>{text(line)}</li>" for line in lines) + "</ul>" if lines else ""


def data(content: Any) -> str:
    """JSON that may stand in a script element: no text in it ends the element, and no browser takes it for markup.

    Raises:
        ValueError: for NaN or infinity, which JSON does not know.
    """
    plain = json.dumps(content, allow_nan=False, separators=(",", ":"))
    for letter in "<>&\u2028\u2029":
        plain = plain.replace(letter, f"\\u{ord(letter):04x}")
    return plain


def number(value: float | None, digits: int, unit: str = "") -> str:
    """A number with its unit, a dash where it is not known."""
    return UNKNOWN if value is None else f"{value:.{digits}f}{unit}"


def yes(value: bool | None) -> str:
    """Yes, no, or a dash."""
    return UNKNOWN if value is None else "yes" if value else "no"


def percent(share: float | None) -> str:
    """A share, a dash where it is not known."""
    return UNKNOWN if share is None else f"{100.0 * share:.1f} %"
