from evaluated_house import *  # noqa: F403 - its fixtures
