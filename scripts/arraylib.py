"""Pictures as numpy arrays for the benchmark scripts: rows, columns, and red, green, blue as 64-bit floats."""
import sys

import benchlib

try:
    import numpy as np
    import OpenImageIO as oiio
except ImportError:
    benchlib.fail("%s has no numpy or no OpenImageIO: install python3-numpy and python3-openimageio (they are /usr/bin/python3's)" % sys.executable)

FLOOR = 1e-3


def load(path):
    image = oiio.ImageInput.open(path)  # ImageBuf would give what an earlier file of this name held
    spec = image.spec()
    names = list(spec.channelnames)
    pixels = np.asarray(image.read_image(oiio.FLOAT)).reshape(spec.height, spec.width, spec.nchannels)
    return pixels[:, :, [names.index(c) for c in "RGB"]].astype(np.float64)


def blur(grey):
    """The mean over 3x3 pixels; rows and columns are the last axes."""
    wide = np.pad(grey, [(0, 0)] * (grey.ndim - 2) + [(1, 1), (1, 1)], mode="edge")
    rows, columns = grey.shape[-2:]
    return sum(wide[..., y:y + rows, x:x + columns] for y in range(3) for x in range(3)) / 9


def denominators(pictures):
    """What squared errors are divided by: the squared brightness over 3x3 pixels, and 0.001."""
    return blur(pictures.mean(-1)) ** 2 + FLOOR


def save_png(binary, base, picture, exposure="1"):
    """Writes base.exr and base.png; returns the path of the latter."""
    image = oiio.ImageBuf(oiio.ImageSpec(picture.shape[1], picture.shape[0], 3, oiio.FLOAT))
    image.set_pixels(oiio.ROI(), np.ascontiguousarray(picture, np.float32))
    image.write(base + ".exr")
    benchlib.run([binary, "png", base + ".exr", base + ".png", "--exposure", exposure])
    return base + ".png"
