# SPDX-License-Identifier: LGPL-2.1-or-later
"""H.264 for a browser's Media Source Extensions: a header, then a fragment for each frame.

The form is fragmented mp4 (ISO 14496-12). mp4mux can't be used for three reasons. Its times begin
with 0 and are rounded to its timescale, so no line of tracks could be matched with its frame. Its
output doesn't show where a keyframe begins, where late viewers must start. And it writes nothing
new when the picture changes its size.
"""

import struct

MICROSECONDS = 1_000_000  # the timescale
TRACK = 1
SYNC, DELTA = 0x02000000, 0x01010000  # sample_depends_on, sample_is_non_sync_sample
MATRIX = struct.pack(">9I", 0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000)


def box(kind: bytes, *parts: bytes) -> bytes:
    content = b"".join(parts)
    return struct.pack(">I4s", 8 + len(content), kind) + content


def full_box(kind: bytes, *parts: bytes, version: int = 0, flags: int = 0) -> bytes:
    return box(kind, struct.pack(">I", version << 24 | flags), *parts)


def media_type(configuration: bytes) -> str:
    """`configuration`: codec_data of video/x-h264, an AVCDecoderConfigurationRecord."""
    return f'video/mp4; codecs="avc1.{configuration[1:4].hex()}"'


def header(width: int, height: int, configuration: bytes) -> bytes:
    picture = box(
        b"avc1", bytes(6),
        struct.pack(">H16xHHIIIH32xHH", 1, width, height, 72 << 16, 72 << 16, 0, 1, 24, 0xffff),
        box(b"avcC", configuration))
    samples = box(b"stbl", full_box(b"stsd", struct.pack(">I", 1), picture),
                  full_box(b"stts", bytes(4)), full_box(b"stsc", bytes(4)),
                  full_box(b"stsz", bytes(8)), full_box(b"stco", bytes(4)))
    reference = full_box(b"dref", struct.pack(">I", 1), full_box(b"url ", flags=1))
    media = box(
        b"mdia", full_box(b"mdhd", struct.pack(">IIIIHH", 0, 0, MICROSECONDS, 0, 0x55c4, 0)),
        full_box(b"hdlr", struct.pack(">I4s12x", 0, b"vide"), b"\0"),
        box(b"minf", full_box(b"vmhd", bytes(8), flags=1), box(b"dinf", reference), samples))
    track = box(
        b"trak",
        full_box(b"tkhd", struct.pack(">IIIII8xHHHH", 0, 0, TRACK, 0, 0, 0, 0, 0, 0), MATRIX,
                 struct.pack(">II", width << 16, height << 16), flags=3), media)
    movie = full_box(b"mvhd", struct.pack(">IIIIIH10x", 0, 0, MICROSECONDS, 0, 0x10000, 0x100),
                     MATRIX, bytes(24), struct.pack(">I", TRACK + 1))
    extends = full_box(b"trex", struct.pack(">5I", TRACK, 1, 0, 0, 0))
    return box(b"ftyp", b"isom", struct.pack(">I", 0), b"isomiso6avc1") + box(
        b"moov", movie, track, box(b"mvex", extends))


def fragment(number: int, time: int, duration: int, keyframe: bool, frame: bytes) -> bytes:
    """`time`, `duration`: µs; `frame`: an access unit whose NAL units follow their lengths.

    Frames are decoded in the order in which they are shown.
    """

    def moof(offset: int) -> bytes:
        # tfhd: offsets count from this box. trun: the one sample's offset, duration, size, flags.
        sample = struct.pack(">IIIII", 1, offset, duration, len(frame),
                             SYNC if keyframe else DELTA)
        track = box(b"traf", full_box(b"tfhd", struct.pack(">I", TRACK), flags=0x20000),
                    full_box(b"tfdt", struct.pack(">Q", time), version=1),
                    full_box(b"trun", sample, flags=0x701))
        return box(b"moof", full_box(b"mfhd", struct.pack(">I", number)), track)

    return moof(len(moof(0)) + 8) + box(b"mdat", frame)
