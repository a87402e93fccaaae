"""Links and paths in the pages lead somewhere; measurements say how they were made."""

import re
from pathlib import Path

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
