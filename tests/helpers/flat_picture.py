import cv2
import numpy as np

#: Pixels of a metre.
PPM = 50


def flat_picture():
    image = np.full((7 * PPM, 10 * PPM, 3), 255, np.uint8)

    def box(colour, *metres):
        x0, y0, x1, y1 = (round(v * PPM) for v in metres)
        cv2.rectangle(image, (x0, y0), (x1 - 1, y1 - 1), colour, -1)

    black, white = (0, 0, 0), (255, 255, 255)
    box(black, 0.8, 0.8, 9.2, 6.2)
    box(white, 1, 1, 5, 6)
    box(white, 5.12, 1, 9, 6)
    box(white, 5, 2, 5.12, 2.9)  # a door between the rooms, one to the outside, a window
    box(white, 2, 6, 2.9, 6.2)
    box(white, 6, 0.8, 7.5, 1)
    for y in (0.8, 0.9, 1.0):
        cv2.line(image, (300, round(y * PPM)), (375, round(y * PPM)), black, 1)
    for hinge, angle in (((250, 100), 90), ((100, 310), 0)):
        end = (hinge[0] - 45, hinge[1]) if angle == 90 else (hinge[0], hinge[1] + 45)
        cv2.line(image, hinge, end, black, 1)
        cv2.ellipse(image, hinge, (45, 45), angle, 0, 90, black, 1, cv2.LINE_AA)
    return image
