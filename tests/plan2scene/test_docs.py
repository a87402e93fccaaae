"""Links and paths in the pages lead somewhere; measurements say how they were made."""

import re
from pathlib import Path

import pytest

CLONE = Path(__file__).parents[2]
FOLDERS = ("benchmarks", "config", "docs", "envs", "resources", "src", "workflow", "workshop")
#: Files that a text may name; a name with a wildcard or a placeholder in it is not one.
NAMED = re.compile(
    r"(?<![\w./{}-])((?:\.ci|benchmarks|config|docs|envs|resources|src|tests|workflow|workshop)/"
    r"[\w./-]+\.(?:html|json|md|py|rst|smk|tsv|yaml))(?![\w{*])"
)
LINK = re.compile(r"\]\((?!https?:|#)([^)#\s]+)(?:#[^)\s]*)?\)")


def files(*suffixes: str) -> list[Path]:
    """Return the clone's own files of these suffixes, those of its top folder included."""
    below = (path for name in FOLDERS for path in (CLONE / name).rglob("*"))
    found = [path for path in (*CLONE.iterdir(), *below) if path.suffix in suffixes]
    return sorted(path for path in found if "node_modules" not in path.parts)


def test_links_lead_somewhere():
    dead = [
        f"{page.relative_to(CLONE)}: {target}"
        for page in files(".md")
        for target in LINK.findall(page.read_text(encoding="utf-8"))
        if not (page.parent / target).exists()
    ]
    assert dead == []


def test_named_files_exist():
    missing = [
        f"{path.relative_to(CLONE)}: {name}"
        for path in files(".md", ".py", ".smk", ".yaml", ".rst")
        for name in NAMED.findall(path.read_text(encoding="utf-8"))
        if not (CLONE / name).exists()
    ]
    assert missing == []


@pytest.mark.parametrize(
    "page", sorted((CLONE / "docs" / "measurements").glob("[a-z]*.md")), ids=lambda path: path.stem
)
def test_measurements_say_how_they_were_made(page):
    text = page.read_text(encoding="utf-8")
    assert "```" in text and "\n|---" in text
    assert re.search(r"\b20\d\d-\d\d-\d\d\b", text), "a date"
    assert re.search(r"\bcommit [0-9a-f]{7}\b", text, re.IGNORECASE), "a commit"
    assert re.search(r"\b\d+[ -]cores?\b", text), "a machine"
