import os

# Two test processes on two cores: threads that wait for each other take the core that the other
# needs.
os.environ.setdefault("OMP_NUM_THREADS", "1")
# The hundreds of processes that tests start find what the first of them compiled.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


#: Files that take a minute each, first: begun last, they would leave the other worker without work.
LONGEST = ["test_all", "test_wheel", "test_houses", "test_house", "test_rent3dpp", "test_targets"]
LONGEST += ["test_workshop", "test_trace", "test_segmentation_training", "test_clicks"]
LONGEST += ["test_propagation_training", "test_pipeline_example", "test_fuzz"]


def pytest_configure(config):
    """Keep pytest-xdist from its own order, by which files of few tests come last."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items):
    place = {name: k for k, name in enumerate(LONGEST)}
    items.sort(key=lambda item: place.get(item.path.stem, len(LONGEST)))


pytest_plugins = ["fake_imagenet", "sample_houses", "third_party"]
