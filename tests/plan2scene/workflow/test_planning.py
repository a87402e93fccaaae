"""A plan looks at the first job of each kind alone, and holds no empty flags."""

import inspect

from plan2scene.workflow.planning import (
    answer_of_each,
    first_of_each,
    flags_of_flagged,
    one_of_each,
    parameters_of_each,
    plain_as_it_is,
)


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


def test_each_kind_answers_once_for_each_question():
    asked = []
    answer = answer_of_each(lambda *question: asked.append(question) or len(asked), kind=len)
    assert [answer("a"), answer("b"), answer("cd"), answer("e", "x"), answer("f", "x")] == [
        *(1, 1, 2, 3, 3)
    ]
    assert asked == [("a",), ("cd",), ("e", "x")]


def test_parameters_are_read_once_for_a_function_and_for_a_method():
    class Resource:
        def evaluate(self, wildcards, attempt):
            """Take what a rule's function may ask for."""

    read = []

    def names(function):
        read.append(function)
        return inspect.signature(function).parameters

    parameters = parameters_of_each(names)
    for _ in range(2):
        assert list(parameters(Resource().evaluate)) == ["wildcards", "attempt"]
        assert list(parameters(Resource.evaluate)) == ["self", "wildcards", "attempt"]
        assert list(parameters(len)) == ["obj"]
    assert read[1:] == [Resource.evaluate, len]


def test_paths_with_flags_are_formed():
    class Path(str):
        __slots__ = ("_file",)

    class Flagged(str):
        __slots__ = ()

    plain, flagged = Path("a.png"), Path("b")
    plain._file, flagged._file = "a.png", Flagged("b")
    form = plain_as_it_is(lambda path, **how: f"{path} {sorted(how.items())}")
    assert form(plain, as_output=True) == "a.png"
    assert type(form(plain)) is str
    assert form(flagged, as_input=True) == "b [('as_input', True), ('as_output', False)]"
    assert form("c") == "c [('as_input', False), ('as_output', False)]"
