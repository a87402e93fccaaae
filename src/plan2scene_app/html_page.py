"""Offline HTML pages: the head that all share, and safe embedding of data and scripts."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from pathlib import Path
from string import Template

_PAGE = Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
$meta<link rel="icon" href="data:,">
<title>$title - Plan2Scene</title>
<style>$style</style>
</head>
$body</html>
""")


def html_page(
    body: Path, *, title: str, style: str, policy: str | None = None, maker: str = "", **values: str
) -> str:
    """Return the text of a whole HTML page.

    Parameters
    ----------
    body : path
        A template (:class:`string.Template`) of the element ``body``. It is filled with ``title``
        and with `values`, which are HTML and not escaped.
    title : str
        Text; it is escaped.
    style : str
        The style sheet.
    policy : str, optional
        Content security policy, for a page that is not served with such a header.
    maker : str
        Name of the command that made the page. A command overwrites only files with its own name.
    """
    meta = ""
    if policy is not None:
        meta += f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
    if maker:
        meta += f'<meta name="generator" content="{maker}">\n'
    escaped = html.escape(title)
    text = Template(body.read_text(encoding="utf-8")).substitute(title=escaped, **values)
    return _PAGE.substitute(meta=meta, title=escaped, style=style, body=text)


def inline_json(value: object) -> str:
    """Return JSON that can't end the script element in which it is embedded."""
    text = json.dumps(value, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def source_hash(text: str) -> str:
    """Return the source expression with which a content policy allows exactly this text."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"
