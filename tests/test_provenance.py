"""The hash of a module follows what the module imports, at any distance."""

import pytest

from plan2scene import provenance


@pytest.fixture
def package(tmp_path, monkeypatch):
    (tmp_path / "far.py").write_text("X = 1\n")
    (tmp_path / "near.py").write_text("def f():\n    from plan2scene.far import X\n    return X\n")
    (tmp_path / "top.py").write_text("from plan2scene import near\n")
    (tmp_path / "other.py").write_text("Y = 1\n")
    (tmp_path / "__init__.py").write_text("")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "__init__.py").write_text("from .inner import Z\nfrom ..far import X\n")
    (tmp_path / "sub" / "inner.py").write_text("Z = 1\n")
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path)
    provenance.code_hash.cache_clear()
    provenance._dependencies.cache_clear()
    yield tmp_path
    provenance.code_hash.cache_clear()
    provenance._dependencies.cache_clear()


def fresh(*modules: str) -> str:
    provenance.code_hash.cache_clear()
    provenance._dependencies.cache_clear()
    return provenance.code_hash(*modules)


def test_a_change_far_down_changes_the_hash(package):
    before = fresh("top")
    (package / "far.py").write_text("X = 2\n")
    assert fresh("top") != before


@pytest.mark.parametrize("name", ["far.py", "sub/inner.py"])
def test_relative_imports_are_followed(package, name):
    before = fresh("sub")
    (package / name).write_text("X = Z = 3\n")
    assert fresh("sub") != before


def test_a_change_elsewhere_does_not(package):
    before = fresh("top")
    (package / "other.py").write_text("Y = 2\n")
    assert fresh("top") == before


def test_an_unknown_module_is_an_error(package):
    with pytest.raises(ValueError, match="no module"):
        fresh("absent")
