import numpy as np

from plan2scene.camera import Camera


def camera_looking(size, *, heading_deg=0.0, pitch_deg=0.0, focal):
    """Return the camera of a photo of `size` (rows, columns) with its truth.

    It is turned about the vertical by `heading_deg` and looks down by `pitch_deg`; `focal` in
    pixels.
    """
    h, p = np.radians([heading_deg, pitch_deg])
    turn = np.array([[np.cos(h), 0, np.sin(h)], [0, 1, 0], [-np.sin(h), 0, np.cos(h)]])
    tilt = np.array([[1, 0, 0], [0, np.cos(p), -np.sin(p)], [0, np.sin(p), np.cos(p)]])
    shot = {"width": size[1], "height": size[0], "cx": (size[1] - 1) / 2, "cy": (size[0] - 1) / 2}
    rotation = tilt @ np.diag([-1.0, -1.0, 1.0]) @ turn
    return Camera.from_json(shot | {"focal_px": focal, "rotation": rotation.tolist()})
