"""A plan looks at the first job of each kind alone."""

from plan2scene.planning import first_of_each


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
