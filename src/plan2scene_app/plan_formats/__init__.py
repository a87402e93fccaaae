"""Read plans of other programs: rooms as outlines, walls as axes with a thickness."""
