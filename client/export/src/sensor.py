"""What the photographs' camera makes of light.

    from sensor import photograph
    values = photograph(image, "00")                              # noiseless
    values = photograph(image, "00", rng=np.random.default_rng(1))  # with the sensor's noise

`image` is a render of that photo: float, H x W x 3, linear RGB radiance, the top row first. The answer has its shape and holds
photo values, as the photo's file would. In this order: glare, exposure and gain, vignetting, crosstalk, response, gamma,
black level, clipping, noise. Needs numpy alone.
"""
import json

import numpy as np

CAPTURE = json.loads(r"""@CAPTURE@""")


def photograph(image, photo, rng=None):
    """Photo values of `image`, a render of the photo named `photo`; with noise where a numpy generator is given."""
    sensor, view = CAPTURE["sensor"], CAPTURE["photos"][photo]
    light = np.asarray(image, dtype=np.float64)
    height, width = light.shape[:2]
    if light.shape != (view["height"], view["width"], 3):
        raise ValueError(f"image is {light.shape}; photo {photo} is ({view['height']}, {view['width']}, 3)")
    if view["glare_fraction"] > 0:
        light = glare(light, view["glare_fraction"], view["glare_width"])
    light = light * view["factor"] * np.asarray(view["balance"]) * np.asarray(view["balance"])
    x, y = np.meshgrid(np.arange(width) + 0.5 - view["cx"], np.arange(height) + 0.5 - view["cy"])
    r2 = (x * x + y * y) / (0.25 * (width * width + height * height))
    k1, k2 = sensor["vignetting"]
    light = light * (1 + r2 * (k1 + r2 * k2))[..., None]
    rg, rb, gr, gb, br, bg = sensor["crosstalk"]
    light = light @ np.array([[1, rg, rb], [gr, 1, gb], [br, bg, 1]]).T
    value = response(light, sensor["response"], sensor["curve"])
    value = np.where(value > 0, np.abs(value) ** sensor["gamma"], value) + sensor["black_level"]
    if sensor["clip_level"] is not None:
        value = np.minimum(value, sensor["clip_level"])
    if rng is not None:
        variance = sensor["read_noise"] ** 2 + sensor["shot_noise"] * np.maximum(value, 0)
        value = value + rng.normal(size=value.shape) * np.sqrt(variance)
    return value


def response(light, kind, curve):
    """The file's value of exposed light."""
    if kind == "linear":
        return light
    if kind == "srgb":
        return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.abs(light) ** (1 / 2.4) - 0.055)
    # A curve holds ln(exposed light) at codes 0..255 of each channel.
    log = np.log(np.where(light > 0, light, 1))
    codes = np.arange(256) / 255
    channels = [np.interp(log[..., c], curve[c], codes, left=0.0, right=1.0) for c in range(3)]
    return np.where(light > 0, np.stack(channels, axis=-1), 0.0)


def glare(light, fraction, width):
    """`fraction` of each pixel's light comes from around it, by a Gaussian of standard deviation `width` pixels.

    What lies outside of the frame is not in the image: the border's pixels stand for it.
    """
    reach = int(np.ceil(4 * width))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    weights /= weights.sum()
    blurred = light
    for axis in (0, 1):
        pad = [(0, 0)] * 3
        pad[axis] = (reach, reach)
        blurred = np.apply_along_axis(np.convolve, axis, np.pad(blurred, pad, mode="edge"), weights, "valid")
    return (1 - fraction) * light + fraction * blurred
