"""Labels of photos: floor, wall, ceiling and other for each pixel."""
