"""A plan looks at the first job of each kind alone, and holds no empty flags."""

from plan2scene.planning import first_of_each, flags_of_flagged, one_of_each


def test_the_first_of_each_kind_is_checked():
    seen = []
    look = first_of_each(lambda dag, job: seen.append((dag, job)), kind=len)
    for job in ("a", "bc", "d", "ef", ""):
        look("dag", job)
    assert seen == [("dag", "a"), ("dag", "bc"), ("dag", "")]


def test_a_check_that_fails_is_told_each_time():
    calls = []

    def check(_dag, job):
        calls.append(job)
        raise OSError("no such script")

    look = first_of_each(check, kind=len)
    for _ in range(2):
        try:
            look(None, "a")
        except OSError:
            continue
    assert calls == ["a", "a"]


def test_flags_are_copied_where_there_are_any():
    class Path:
        def __init__(self, **flags):
            self.flags = flags

    copied = []
    clone = flags_of_flagged(lambda own, other, **options: copied.append((own, other, options)))
    plain, directory = Path(), Path(directory=True)
    clone(plain, Path())
    assert copied == []
    clone(plain, directory, skip_storage_object=True)
    clone(directory, plain)
    assert copied[0] == (plain, directory, {"skip_storage_object": True})
    assert copied[1] == (directory, plain, {"skip_storage_object": False})


def test_equal_arguments_make_one_object():
    class Guard:
        def __init__(self, name):
            self.name = name

    Guard.__new__ = one_of_each()
    assert Guard("sort") is Guard("sort")
    assert (Guard("sort").name, Guard("index").name) == ("sort", "index")
