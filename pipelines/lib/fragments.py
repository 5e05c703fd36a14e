# SPDX-License-Identifier: LGPL-2.1-or-later
"""H.264 as a browser's Media Source Extensions take it: a head (ISO 14496-12, fragmented), then a fragment for each frame.

Not mp4mux: its times begin with 0 whatever the frames' are and are rounded to its timescale, so no track could be matched with its frame; its
pieces don't say where a keyframe begins, where those who come later must start; and of a picture that changes its size it writes nothing new.
"""

import struct

MICROSECONDS = 1_000_000  # the timescale
TRACK = 1
SYNC, DELTA = 0x02000000, 0x01010000  # sample_depends_on, sample_is_non_sync_sample
MATRIX = struct.pack(">9I", 0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000)


def box(kind, *parts):
    content = b"".join(parts)
    return struct.pack(">I4s", 8 + len(content), kind) + content


def full(kind, *parts, version=0, flags=0):
    return box(kind, struct.pack(">I", version << 24 | flags), *parts)


def media_type(configuration):
    """`configuration`: codec_data of video/x-h264, an AVCDecoderConfigurationRecord."""
    return f'video/mp4; codecs="avc1.{configuration[1:4].hex()}"'


def head(width, height, configuration):
    picture = box(
        b"avc1", bytes(6),
        struct.pack(">H16xHHIIIH32xHH", 1, width, height, 72 << 16, 72 << 16, 0, 1, 24, 0xffff),
        box(b"avcC", configuration))
    table = box(b"stbl", full(b"stsd", struct.pack(">I", 1), picture), full(b"stts", bytes(4)),
                full(b"stsc", bytes(4)), full(b"stsz", bytes(8)), full(b"stco", bytes(4)))
    media = box(
        b"mdia", full(b"mdhd", struct.pack(">IIIIHH", 0, 0, MICROSECONDS, 0, 0x55c4, 0)),
        full(b"hdlr", struct.pack(">I4s12x", 0, b"vide"), b"\0"),
        box(b"minf", full(b"vmhd", bytes(8), flags=1),
            box(b"dinf", full(b"dref", struct.pack(">I", 1), full(b"url ", flags=1))), table))
    track = box(
        b"trak",
        full(b"tkhd", struct.pack(">IIIII8xHHHH", 0, 0, TRACK, 0, 0, 0, 0, 0, 0), MATRIX,
             struct.pack(">II", width << 16, height << 16), flags=3), media)
    movie = full(b"mvhd", struct.pack(">IIIIIH10x", 0, 0, MICROSECONDS, 0, 0x10000, 0x100), MATRIX,
                 bytes(24), struct.pack(">I", TRACK + 1))
    return box(b"ftyp", b"isom", struct.pack(">I", 0), b"isomiso6avc1") + box(
        b"moov", movie, track, box(b"mvex", full(b"trex", struct.pack(">5I", TRACK, 1, 0, 0, 0))))


def fragment(number, time, duration, keyframe, frame):
    """`time`, `duration`: µs; `frame`: an access unit, its units behind their lengths. Decoded in the order in which they are shown."""
    def movie(offset):
        # tfhd: the base is this box. trun: of one sample its place, duration, size and flags.
        track = box(
            b"traf", full(b"tfhd", struct.pack(">I", TRACK), flags=0x20000),
            full(b"tfdt", struct.pack(">Q", time), version=1),
            full(
                b"trun",
                struct.pack(">IIIII", 1, offset, duration, len(frame), SYNC if keyframe else DELTA),
                flags=0x701))
        return box(b"moof", full(b"mfhd", struct.pack(">I", number)), track)

    return movie(len(movie(0)) + 8) + box(b"mdat", frame)
