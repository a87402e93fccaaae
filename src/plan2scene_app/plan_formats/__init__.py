"""Plans that other programs drew: rooms as outlines, walls as axes with a thickness."""
