"""What the pages say of the tree is so: the README's map, links, and paths named in text."""

import re
import subprocess
from collections.abc import Iterable
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest

CLONE = Path(__file__).parents[2]
#: Every folder below these is in the map, as is every entry of the clone's own folder.
MAPPED = ("src/plan2scene", "src/plan2scene_app", "workshop")
#: Files that a text may name; a name with a wildcard or a placeholder in it is not one.
NAMED = re.compile(
    r"(?<![\w./{}-])((?:\.ci|benchmarks|config|docs|envs|resources|src|tests|workflow|workshop)/"
    r"[\w./-]+\.(?:html|json|md|py|rst|smk|tsv|yaml))(?![\w{*])"
)
LINK = re.compile(r"\]\((?!https?:|#)([^)#\s]+)(?:#[^)\s]*)?\)")


def listed_by_git(*options: str) -> set[str]:
    """Return what ``git ls-files`` lists and is there; nothing where this is no clone."""
    if not (CLONE / ".git").exists():
        return set()
    command = ["git", "ls-files", "-z", *options]
    found = subprocess.run(command, cwd=CLONE, capture_output=True, text=True)
    return {name for name in found.stdout.split("\0") if name and (CLONE / name).exists()}


def walked() -> set[str]:
    """Return the files of the clone that ``.gitignore`` does not name, without git."""
    patterns = [".git", ".git/", *(CLONE / ".gitignore").read_text(encoding="utf-8").split()]

    def kept(path: Path, end: str) -> bool:
        name = f"/{path.relative_to(CLONE).as_posix()}{end}"
        return not any(fnmatch(name, p if p[0] == "/" else f"*/{p}") for p in patterns)

    found = set()
    queue = [CLONE]
    while queue:
        for path in queue.pop().iterdir():
            if path.is_dir() and not path.is_symlink():
                queue += [path] if kept(path, "/") else []
            elif kept(path, ""):
                found.add(path.relative_to(CLONE).as_posix())
    return found


@cache
def tree() -> frozenset[str]:
    """Return the files of the clone."""
    return frozenset(listed_by_git() or walked())


def folders(files: Iterable[str]) -> set[str]:
    """Return every folder of a set of files, ``a/b`` without a slash at its end."""
    return {parent.as_posix() for name in files for parent in Path(name).parents} - {"."}


def mapped_paths(readme: str) -> list[str]:
    """Return the paths of the README's map.

    The map is the code block under "Where things are": a path, two spaces or more, what it is.
    An indented line lies in the folder of the line above that is indented less; ``a/{b,c}/``
    stands for two.
    """
    block = readme.split("## Where things are", 1)[1].split("```")[1]
    above: list[tuple[int, str]] = []
    paths = []
    for line in block.splitlines():
        if not line.strip():
            continue
        indent = len(line) - len(line.lstrip())
        while above and above[-1][0] >= indent:
            above.pop()
        for name in expanded(line.split()[0]):
            path = (above[-1][1] if above else "") + name
            paths.append(path)
        above.append((indent, path))
    return paths


def expanded(name: str) -> list[str]:
    """Return what ``a/{b,c}/d`` stands for."""
    found = re.fullmatch(r"(.*)\{(.*)\}(.*)", name)
    if not found:
        return [name]
    return [found[1] + part + found[3] for part in found[2].split(",")]


def pages() -> list[Path]:
    return sorted(CLONE / name for name in tree() if name.endswith(".md"))


def test_map_reader():
    text = "## Where things are\n```\na  first\nb/  second\n  c/{d,e}/  third\nf/g  last\n```\n"
    assert mapped_paths(text) == ["a", "b/", "b/c/d/", "b/c/e/", "f/g"]


def test_readme_maps_the_tree():
    paths = mapped_paths((CLONE / "README.md").read_text(encoding="utf-8"))
    files = tree()
    there = files | {f"{name}/" for name in folders(files)}
    assert [path for path in paths if path not in there] == []
    assert len(set(paths)) == len(paths)
    told = {path.rstrip("/") for path in paths}
    told |= folders({f"{name}/x" for name in told})
    top = {name.split("/")[0] for name in files}
    assert sorted(top - told) == []
    deep = {name for name in folders(files) for root in MAPPED if name.startswith(f"{root}/")}
    assert sorted(deep - told) == []


def test_walk_sees_what_git_sees():
    if not listed_by_git():
        pytest.skip("no git to compare with")
    new = listed_by_git("--others", "--exclude-standard")
    assert walked() - new == listed_by_git()


def test_links_lead_somewhere():
    dead = [
        f"{page.relative_to(CLONE)}: {target}"
        for page in pages()
        for target in LINK.findall(page.read_text(encoding="utf-8"))
        if not (page.parent / target).exists()
    ]
    assert dead == []


def test_named_files_exist():
    missing = []
    for name in sorted(tree()):
        if not name.endswith((".md", ".py", ".smk", ".yaml", ".rst")) or name.startswith("tests/"):
            continue
        text = (CLONE / name).read_text(encoding="utf-8")
        missing += [f"{name}: {f}" for f in NAMED.findall(text) if not (CLONE / f).exists()]
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


def test_training_is_told_by_its_command():
    assert "snakemake -s workshop/Snakefile" in (CLONE / "README.md").read_text(encoding="utf-8")
