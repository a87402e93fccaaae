"""The studio's pages: the editor with a server behind it, and the list of projects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plan2scene.html_page import html_page, inline_json, source_hash
from plan2scene.textures.methods import texture_methods
from plan2scene_app.editor.page import FOLDER as EDITOR
from plan2scene_app.editor.page import joined_program
from plan2scene_app.editor.rules import page_rules
from plan2scene_app.exports.registry import exports
from plan2scene_app.run import TEXTURE_SIZES

_FOLDER = Path(__file__).parent


def project_page(start: dict[str, Any]) -> tuple[str, str]:
    """Return the page of a project and its content policy; `start` is the project's state."""
    rules = page_rules() | {
        "methods": list(texture_methods()),
        "texture_sizes": list(TEXTURE_SIZES),
        "exports": {form: export.purpose for form, export in exports().items()},
    }
    editor = (EDITOR / "editor.html").read_text("utf-8")
    tools = editor[editor.index("<nav") : editor.index("<script")]
    return _filled("studio.html", "studio_page", str(start["house"]), start, rules, tools)


def home_page(start: dict[str, Any]) -> tuple[str, str]:
    """Return the page of all projects and its content policy; `start` is ``{projects, folder}``."""
    return _filled("home.html", "home_page", "Studio", start, {}, "")


def _filled(
    name: str, entry: str, title: str, start: dict[str, Any], rules: dict[str, Any], tools: str
) -> tuple[str, str]:
    program = joined_program(entry, (_FOLDER, EDITOR))
    style = (EDITOR / "editor.css").read_text("utf-8") + (_FOLDER / "studio.css").read_text("utf-8")
    page = html_page(
        _FOLDER / name,
        title=title,
        style=style,
        tools=tools,
        rules=inline_json(rules),
        start=inline_json(start),
        program=program,
    )
    policy = (
        f"default-src 'none'; script-src {source_hash(program)}; style-src {source_hash(style)}; "
        "img-src 'self' data: blob:; connect-src 'self'; frame-src 'self'; form-action 'none'; "
        "base-uri 'none'; frame-ancestors 'none'"
    )
    return page, policy
