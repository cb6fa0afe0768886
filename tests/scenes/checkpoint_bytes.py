# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checkpoints whose bytes are changed, and that are sealed again as the programs seal them."""
import re

from scene_tools import need

BASIS, BLOCK_BYTES = 0xcbf29ce484222325, 1 << 14


def everything(path):
    with open(path, "rb") as f:
        return f.read()


def seal(data, h=BASIS):
    """FNV-1a, as dem/base/checksum.hpp has it, of data that follow what h is of."""
    prime, end = 0x100000001b3, 1 << 64
    for part in re.split(b"(\0{64,})", data):
        if part[:64] == bytes(64):  # most of a file is empty: a power of the prime
            h = h * pow(prime, len(part), end) % end
            continue
        for c in part:
            h = (h ^ c) * prime % end
    return h


class Kept:
    """A checkpoint whose parts can be changed, and sealed again."""

    def __init__(self, path):
        import h5py
        self.image = everything(path)[:-8]
        with h5py.File(path, "r") as f:
            self.size = f["parts"].shape[0]
            self.offsets = [int(x) for x in f["offsets"]]
            self.at = [f["parts"].id.get_chunk_info(k).byte_offset for k in range(f["parts"].id.get_num_chunks())]
            self.about, self.about_size = f["about"].id.get_offset(), f["about"].shape[0]
        self.seals = [BASIS]  # of what lies before each block
        for k in range(0, len(self.image), BLOCK_BYTES):
            self.seals.append(seal(self.image[k:k + BLOCK_BYTES], self.seals[-1]))
        need(self.seals[-1].to_bytes(8, "little") == everything(path)[-8:], "the seal is another")

    def place(self, byte):
        return self.at[byte >> 18] + (byte & 0x3ffff)

    def changed(self, byte, value, about=False):
        image = bytearray(self.image)
        places = [self.about + byte + k if about else self.place(byte + k) for k in range(len(value))]
        for place, v in zip(places, value):
            image[place] = v
        block = min(places, default=0) // BLOCK_BYTES  # what lies before is as it was
        return bytes(image) + seal(bytes(image[block * BLOCK_BYTES:]), self.seals[block]).to_bytes(8, "little")


def pretend_seconds(path, **seconds):
    """A checkpoint that says its part took so long: what a resumed run adds to does not hang on this machine."""
    kept = Kept(path)
    about = kept.image[kept.about:kept.about + kept.about_size].decode()
    for key, value in seconds.items():
        at = re.search(rf'"{key}":([0-9.e+-]+)', about)
        text = str(value).ljust(len(at[1]))
        need(len(text) == len(at[1]), f"{key} of {path}: {at[0]}")
        about = about[:at.start(1)] + text + about[at.end(1):]
    with open(path, "r+b") as f:
        f.write(kept.changed(0, about.encode(), about=True))


def draw_change(kept, draw):
    """What is written where: bits, counts, indices, numbers; in what the file tells of itself now and then."""
    if draw.random() < 0.08:
        return draw.randrange(kept.about_size - 1), bytes([draw.randrange(32, 127)]), True
    part = draw.choice([0, 0, 0, 1]) if len(kept.offsets) > 2 else 0
    low, high = kept.offsets[part], kept.offsets[part + 1]
    if draw.random() < 0.3:
        low, high = kept.offsets[0], kept.offsets[-1]
    byte = low + 4 * draw.randrange(max(1, (high - low - 8) // 4))
    old = kept.image[kept.place(byte)]
    values = [
        draw.randbytes(8), b"\xff" * 8,
        bytes(8), (1 << draw.randrange(64)).to_bytes(8, "little"), b"\0\0\0\0\0\0\xf8\x7f", b"\xff\xff\xff\x7f",
        b"\xff\xff\xff\xff",
        bytes([old ^ (1 << draw.randrange(8))]), (draw.randrange(5000)).to_bytes(4, "little"), b"\0\0\0\0\0\0\xf0\x3f",
        b"\x9c\x75\x00\x88\x3c\xe4\x37\x7e"
    ]
    value = draw.choice(values)
    return byte, value[:high - byte] if byte + len(value) > high else value, False
