import os

from plan2scene_app.workflow import closures
from plan2scene_app.workflow.closures import code_hash, contents_hash, imports


def fresh(*modules, packages):
    for function in vars(closures).values():
        getattr(function, "cache_clear", int)()
    return code_hash(*modules, packages=packages)


def test_a_change_far_down_or_of_a_named_data_file_alone_changes_the_hash(tmp_path):
    library, shop = tmp_path / "library", tmp_path / "shop"
    (library / "sub").mkdir(parents=True)
    shop.mkdir()
    (library / "far.py").write_text("X = 1\n")
    (library / "near.py").write_text("def f():\n    from library.far import X\n    return X\n")
    (library / "top.py").write_text("from library import near\n")
    (library / "other.py").write_text("Y = 1\n")
    (library / "__init__.py").write_text("")
    (library / "sub" / "__init__.py").write_text("from library.sub.inner import Z\n")
    (library / "sub" / "inner.py").write_text("Z = 1\n")
    (shop / "maker.py").write_text("from library.sub import Z\n")
    packages = library, shop
    before = fresh("library.top", packages=packages)
    (packages[0] / "other.py").write_text("Y = 2\n")
    assert fresh("library.top", packages=packages) == before
    (packages[0] / "far.py").write_text("X = 2\n")
    assert fresh("library.top", packages=packages) != before
    (packages[0] / "other.py").write_text('TABLE = "table.csv"\n')
    (packages[0] / "table.csv").write_text("a\n")
    before = fresh("library.other", packages=packages), fresh("library.top", packages=packages)
    (packages[0] / "table.csv").write_text("b\n")
    assert fresh("library.other", packages=packages) != before[0]
    assert fresh("library.top", packages=packages) == before[1]


def test_imports_of_a_source_wherever_they_stand(tmp_path):
    file = tmp_path / "module.py"
    file.write_text(
        "import a.b as c, d\nfrom e import (  # f\n    g as h,  # i, j\n    k,\n)\n"
        "def l():\n    try:\n        pass\n    except OSError:\n        import m\n"
        "    if n:\n        pass\n    else:\n        from o import p\n"
        "    match q:\n        case 1:\n            import r\n"
    )
    assert imports(file) == {"a.b", "d", "e", "e.g", "e.k", "m", "o", "o.p", "r"}


def test_contents_decide_whatever_the_times(tmp_path):
    seen = set()
    for size in (30, 3_000_000):
        path = tmp_path / f"{size}.bin"
        for change in (None, 0, size // 2, size - 1):
            content = bytearray(size)
            if change is not None:
                content[change] = 1
            path.write_bytes(content)
            os.utime(path, (10, 10))
            seen.add(contents_hash([path, tmp_path, tmp_path / "none"]))
            os.utime(path, (99, 99))
            seen.add(contents_hash([path]))
    assert len(seen) == 8
