"""The OpenEXR project's own reader and writer of deep images, for deep_exr_peer.rs.

    deep_exr_peer.py check            is the package there?
    deep_exr_peer.py dump FILE        prints the deep image as JSON
    deep_exr_peer.py make FILE        writes a deep image from the JSON on its standard input

The JSON is {"compression": "NONE" or "ZIPS", "decreasing": bool, "window": [x0, y0, x1, y1],
"channels": {name: {"type": "half", "float" or "uint", "pixels": [[sample, ...], ...]}}}, pixels row
by row.
"""

import json
import sys

import numpy as np
import OpenEXR

TYPES = {"half": np.float16, "float": np.float32, "uint": np.uint32}
COMPRESSIONS = {"NONE": OpenEXR.NO_COMPRESSION, "ZIPS": OpenEXR.ZIPS_COMPRESSION}


def dump(path):
    with OpenEXR.File(path, separate_channels=True) as file:
        header = file.header()
        assert header["type"] == OpenEXR.deepscanline, header["type"]
        channels = {}
        for name, channel in file.channels().items():
            # A pixel without samples is None or an empty array, by the package's version.
            pixels = [[] if p is None else np.asarray(p) for p in channel.pixels.ravel()]
            types = {p.dtype for p in pixels if len(p)}
            assert len(types) <= 1, types
            kind = next((k for k, t in TYPES.items() if np.dtype(t) in types), None)
            channels[name] = {"type": kind, "pixels": [[float(s) for s in p] for p in pixels]}
        low, high = header["dataWindow"]
        json.dump(
            {
                "compression": next(k for k, c in COMPRESSIONS.items() if c == header["compression"]),
                "decreasing": header["lineOrder"] == OpenEXR.DECREASING_Y,
                "window": [int(x) for x in (*low, *high)],
                "channels": channels,
            },
            sys.stdout,
        )


def make(path):
    image = json.load(sys.stdin)
    x0, y0, x1, y1 = image["window"]
    channels = {}
    for name, channel in image["channels"].items():
        pixels = np.empty((y1 - y0 + 1, x1 - x0 + 1), dtype=object)
        for i, samples in enumerate(channel["pixels"]):
            pixels.flat[i] = np.array(samples, dtype=TYPES[channel["type"]])
        channels[name] = pixels
    window = (np.array([x0, y0], dtype=np.int32), np.array([x1, y1], dtype=np.int32))
    header = {
        "type": OpenEXR.deepscanline,
        "compression": COMPRESSIONS[image["compression"]],
        "lineOrder": OpenEXR.DECREASING_Y if image["decreasing"] else OpenEXR.INCREASING_Y,
        "dataWindow": window,
        "displayWindow": window,
    }
    with OpenEXR.File(header, channels) as file:
        file.write(path)


if __name__ == "__main__":
    if sys.argv[1] == "check":
        print(OpenEXR.__version__)
    else:
        {"dump": dump, "make": make}[sys.argv[1]](sys.argv[2])
