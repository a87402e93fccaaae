"""A batch of a large data set plans its own houses alone, whatever the others are like."""

from clones import demo_rows, make_clone


def test_a_batch_plans_only_its_houses(tmp_path):
    rows = demo_rows()[:3]
    names = [row["house"] for row in rows]
    dataset = {"name": "tiny", "root": "data", "table": "houses.tsv", "splits": ["test"]}
    clone = make_clone(tmp_path / "clone", rows, dataset=dataset | {"houses": names[1:2]})
    (clone.root / "data" / rows[0]["plan"]).unlink()
    jobs = clone.jobs("all")
    assert {house for _, house in jobs} == {names[1], ""}
    assert ("paper_table", "") in jobs
    assert ("house", names[1]) in jobs


def test_the_workflow_in_batches_leaves_the_table_to_the_last(tmp_path):
    clone = make_clone(tmp_path / "clone", demo_rows()[:2])
    jobs = clone.jobs("--batch", "all=1/3", "--", "all")
    assert {house for _, house in jobs} - {""} == {demo_rows()[0]["house"]}
    assert "paper_table" not in {rule for rule, _ in jobs}
