"""Reads layers back by another implementation, and checks what they promise.

    pip install OpenEXR numpy
    rutilant scene.toml --layers all -o layers.exr
    python docs/check_layers.py layers.exr

Names are hashed here anew, so that a mistake in the renderer's own hash is seen.
Exits with 1 where something is wrong.
"""

import json
import struct
import sys

import numpy as np
import OpenEXR

FLOAT, UINT = np.dtype(np.float32), np.dtype(np.uint32)


def murmur3_32(data: bytes) -> int:
    """MurmurHash3_x86_32 of Austin Appleby, seed 0."""
    mask, length = 0xFFFFFFFF, len(data)

    def mixed(k):
        k = k * 0xCC9E2D51 & mask
        k = (k << 15 | k >> 17) & mask
        return k * 0x1B873593 & mask

    h = 0
    whole = length - length % 4
    for (k,) in struct.iter_unpack("<I", data[:whole]):
        h ^= mixed(k)
        h = (h << 13 | h >> 19) & mask
        h = h * 5 + 0xE6546B64 & mask
    h ^= mixed(int.from_bytes(data[whole:], "little"))
    h ^= length
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
        h = (h ^ h >> shift) * factor & mask
    return h ^ h >> 16


def id_of(name: str) -> int:
    """The bits of a name's number: Cryptomatte specification 1.2.0, floating point conversion."""
    h = murmur3_32(name.encode("utf-8"))
    return h ^ (1 << 23) if h >> 23 & 255 in (0, 255) else h


def main(path: str) -> int:
    wrong = []

    def expect(is_so, what):
        if not is_so:
            wrong.append(what)

    # Open to the end: what it gives out is gone when it is closed.
    file = OpenEXR.File(path, separate_channels=True)
    header = file.header()
    values = {name: channel.pixels for name, channel in file.channels().items()}

    groups = {}
    for name in sorted(values):
        groups.setdefault(name.rpartition(".")[0] or "(color)", []).append(name)
    for layer, names in groups.items():
        last = ", ".join(name.rpartition(".")[2] for name in names)
        print(f"{layer}: {last} ({values[names[0]].dtype})")

    for name, pixels in values.items():
        layer = name.rpartition(".")[0]
        if name.endswith(".id") or layer == "samples":
            expect(pixels.dtype == UINT, f"{name} is no UINT")
        if layer.startswith("Crypto") or layer in ("variance", "depth", "position", "uv"):
            expect(pixels.dtype == FLOAT, f"{name} is no FLOAT")
        expect(np.isfinite(pixels).all(), f"{name} has values that are no numbers")

    def expect_sum(parts, what):
        for c in "RGB":
            total = sum(values[f"{part}.{c}"].astype(np.float64) for part in parts)
            light = values[c].astype(np.float64)
            half = values[c].dtype == np.float16
            off = np.abs(total - light).max() / max(light.max(), 1e-9)
            print(f"{' + '.join(parts)} - {c}: at most {off:.1e} of the brightest")
            expect(off < (2e-3 if half else 1e-6), f"{what} do not add up to {c}")

    if "direct.R" in values:
        expect_sum(("emission", "direct", "indirect"), "the parts of light")
    lights = [layer for layer in groups if layer.startswith("Combined_")]
    if lights:
        expect_sum(lights, "the light groups")
        for layer in lights:
            types = {values[f"{layer}.{c}"].dtype for c in "RGB"}
            expect(types == {values["R"].dtype}, f"{layer} is of another type than R")
    if "normal.X" in values:
        length = np.sqrt(sum(values[f"normal.{c}"].astype(np.float64) ** 2 for c in "XYZ"))
        print(f"normals: at most {length.max():.4f} long")
        expect(length.max() < 1.1, "normals are too long")

    keys = {key.split("/")[1] for key in header if key.startswith("cryptomatte/")}
    expect(not any(n.startswith("Crypto") for n in values) or len(keys) == 3, "three manifests are due")
    for key in sorted(keys):
        said = {what: header[f"cryptomatte/{key}/{what}"] for what in ("name", "hash", "conversion", "manifest")}
        layer = said["name"]
        expect(key == f"{id_of(layer):08x}"[:7], f"{layer}: the key {key} is not its hash")
        expect(said["hash"] == "MurmurHash3_32", f"{layer}: another hash")
        expect(said["conversion"] == "uint32_to_float32", f"{layer}: another conversion")
        manifest = json.loads(said["manifest"])
        for name, written in manifest.items():
            expect(written == f"{id_of(name):08x}", f"{layer}: {name} has another id")

        known = {id_of(name) for name in manifest} | {0}
        levels = sorted({n.split(".")[0] for n in values if n.startswith(layer) and n[len(layer)].isdigit()})
        expect(len(levels) >= 3, f"{layer}: fewer than six ranks")
        total, before, seen = 0.0, np.inf, set()
        for level in levels:
            for of_id, of_coverage in ("RG", "BA"):
                ids = np.ascontiguousarray(values[f"{level}.{of_id}"]).view(UINT)
                coverage = values[f"{level}.{of_coverage}"].astype(np.float64)
                expect((coverage >= 0).all() and (coverage <= before + 1e-7).all(), f"{level}: not by rank")
                seen |= set(np.unique(ids[coverage > 0]).tolist())
                total, before = total + coverage, coverage
        off = np.abs(total - 1).max()
        expect(off <= 1e-3, f"{layer}: coverages add up to 1 ± {off}")
        expect(seen <= known, f"{layer}: ids without a name: {seen - known}")
        names = {id_of(name): name for name in manifest} | {0: "(nothing)"}
        print(f"{layer}: {len(manifest)} names, {2 * len(levels)} ranks, coverages add up to 1 ± {off:.1e}")
        print("  seen: " + ", ".join(sorted(names[i] for i in seen if i in names)[:12]))

    for what in wrong:
        print(f"WRONG {what}")
    print("all is well" if not wrong else f"{len(wrong)} mistakes")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
