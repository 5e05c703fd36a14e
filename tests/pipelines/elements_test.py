#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The elements themselves (as in gst-inspect-1.0), docs/elements.md and the SECTION blocks of the
sources are complete and agree."""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
# GStreamer reads this once, at the first preset.
os.environ["GST_PRESET_PATH"] = str(SOURCE / "gst" / "presets")
import harness  # noqa: E402
from harness import Gst  # noqa: E402
from gi.repository import GLib, GObject, GstVideo  # noqa: E402

PAGE = SOURCE / "docs" / "elements.md"
PRESETS_PAGE = SOURCE / "docs" / "pipelines.md"
TYPES = {"uint": "guint", "double": "gdouble"}  # of signals
SECONDS = {"s": 10**9, "ms": 10**6}


def plain(cell):
    return cell.strip().replace("`", "")


def number(text):
    """12, or a time: 10 s, 8 ms; in nanoseconds."""
    value, *unit = text.split()
    return int(value) * SECONDS[unit[0]] if unit else float(value)


def sections(page):
    """{element: its part of the page}."""
    parts = re.split(r"^# (.+)\n", page, flags=re.MULTILINE)
    return {name: text for name, text in zip(parts[1::2], parts[2::2])
            if name not in ("The elements", "Examples")}


def tables(text, first):
    """The rows, as {column: cell}, of all tables whose first column has this name."""
    for head, body in re.findall(r"^(\|.*\|)\n\|[-|]+\|\n((?:\|.*\|\n?)*)", text,
                                 flags=re.MULTILINE):
        names = [plain(name) for name in head.strip("|").split("|")]
        if names[0] == first:
            for row in body.splitlines():
                yield dict(zip(names, row.strip("|").split("|")))


def enum_values(element, spec):
    # From a value: in PyGObject 3.50 spec.enum_class is GLib's structure, not the Python class, and
    # the default is a number.
    return type(element.get_property(spec.name)).__enum_values__.values()


def own_properties(element):
    return {spec.name: spec for spec in element.list_properties()
            if spec.owner_type == element.__gtype__}


class Elements(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.page = sections(PAGE.read_text(encoding="utf-8"))
        features = Gst.Registry.get().get_feature_list_by_plugin("csdtrack")
        cls.factories = {f.get_name(): f for f in features if isinstance(f, Gst.ElementFactory)}
        cls.elements = {name: factory.create(None) for name, factory in cls.factories.items()}

    def test_the_page_has_these_elements(self):
        self.assertEqual(set(self.page), set(self.factories))
        self.assertGreaterEqual(len(self.factories), 4)

    def test_the_plugin_describes_itself(self):
        plugin = Gst.Registry.get().find_plugin("csdtrack")
        for text in (plugin.get_description(), plugin.get_version(), plugin.get_source(),
                     plugin.get_package(), plugin.get_origin()):
            self.assertTrue(text)
        self.assertEqual(plugin.get_license(), "LGPL")

    def test_factories_describe_their_element(self):
        for name in self.factories:
            with self.subTest(name):
                factory = self.factories[name]
                words = [factory.get_metadata(key) for key in (
                    Gst.ELEMENT_METADATA_LONGNAME, Gst.ELEMENT_METADATA_DESCRIPTION,
                    Gst.ELEMENT_METADATA_AUTHOR, Gst.ELEMENT_METADATA_KLASS)]
                self.assertTrue(all(words), words)
                self.assertEqual(len(set(words)), 4)
                first = re.match(r"\s*`([^`]+)`, rank (\w+)", self.page[name])
                self.assertEqual(first[1], words[3])
                self.assertEqual((first[2], factory.get_rank()), ("NONE", Gst.Rank.NONE))

    def test_gst_inspect_shows_each_without_a_warning(self):
        for name in self.factories:
            with self.subTest(name):
                done = subprocess.run(["gst-inspect-1.0", name], capture_output=True, text=True,
                                      timeout=harness.TIMEOUT)
                self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_properties_are_described(self):
        for name, element in self.elements.items():
            with self.subTest(name):
                specs = own_properties(element)
                self.assertTrue(specs)
                for spec in specs.values():
                    with self.subTest(spec.name):
                        self.assertTrue(spec.nick and spec.nick != spec.name,
                                        "needs a nick of its own")
                        self.assertGreater(len(spec.blurb), len(spec.nick))
                        self.assertNotEqual(spec.blurb.lower(), spec.name.replace("-", " "))
                        if isinstance(spec, GObject.ParamSpecEnum):
                            self.check_enum(element, spec)
                        elif not spec.flags & GObject.ParamFlags.WRITABLE:
                            continue
                        self.assertTrue(bool(spec.flags & Gst.PARAM_MUTABLE_READY) !=
                                        bool(spec.flags & Gst.PARAM_MUTABLE_PLAYING),
                                        "needs one flag for when it can be set")
                        if spec.flags & Gst.PARAM_CONTROLLABLE:
                            self.assertTrue(spec.flags & Gst.PARAM_MUTABLE_PLAYING)

    def check_enum(self, element, spec):
        self.assertTrue(Gst.type_is_plugin_api(spec.value_type)[0], "marked as plugin API")
        for value in enum_values(element, spec):
            # glib-mkenums gives values the name of their C constant, which tells a user nothing.
            self.assertNotRegex(value.value_name, r"^[A-Z0-9_]+$")
            self.assertNotEqual(value.value_name, value.value_nick)

    def test_properties_say_what_they_are(self):
        for name, element in self.elements.items():
            for key, spec in own_properties(element).items():
                with self.subTest(f"{name}: {key}"):
                    if (spec.flags & GObject.ParamFlags.WRITABLE
                            and spec.value_type.name != "GstValueArray"):  # which has no default
                        self.assertEqual(spec.default_value, element.get_property(key))
                    if spec.value_type.name in ("guint64", "gint64") and key != "seed":
                        self.assertIn("nanoseconds", spec.blurb.lower())
                    if key.endswith(("-size", "-radius")):
                        self.assertIn("pixels", spec.blurb)

    def test_the_page_has_the_properties_as_the_plugin_describes_them(self):
        build = pathlib.Path(
            Gst.Registry.get().find_plugin("csdtrack").get_filename()).parents[1]

        def run(page, *words):
            with tempfile.TemporaryDirectory() as folder:
                copy = pathlib.Path(folder, "docs")
                copy.mkdir()
                shutil.copy(SOURCE / "docs" / "properties", copy)
                (copy / PAGE.name).write_text(page, encoding="utf-8")
                done = subprocess.run([copy / "properties", *words, build],
                                      capture_output=True, text=True, timeout=harness.TIMEOUT)
                return done.returncode, done.stderr, (copy / PAGE.name).read_text("utf-8")

        page = PAGE.read_text(encoding="utf-8")
        self.assertEqual(run(page, "--check"), (0, "", page))
        changed = page.replace("| uint 0…10000 | 50 |", "| uint 0…10000 | 40 |", 1)
        self.assertNotEqual(changed, page)
        code, error, same = run(changed, "--check")
        self.assertEqual((code, same), (1, changed))
        self.assertIn("run docs/properties", error)
        self.assertEqual(run(changed), (0, "", page))
        code, error, _ = run(page.replace(" max-features", "", 1))
        self.assertEqual((code, "in no table" in error), (1, True), error)
        code, error, _ = run(page.replace("csdtrack: algorithm", "csdtrack: logarithm", 1))
        self.assertEqual((code, "logarithm" in error), (1, True), error)

    def test_signals_are_on_the_page(self):
        for name, element in self.elements.items():
            with self.subTest(name):
                found = {}
                for signal in GObject.signal_list_names(element.__gtype__):
                    query = GObject.signal_query(signal, element.__gtype__)
                    self.assertTrue(query.signal_flags & GObject.SignalFlags.ACTION)
                    found[signal] = [t.name for t in query.param_types], query.return_type.name
                said = {}
                for row in tables(self.page[name], "signal"):
                    signal, arguments, result = re.fullmatch(
                        r"(\S+) \((.*)\)(?: → (\S+) \w+)?", plain(row["signal"])).groups()
                    types = [TYPES[a.split()[0]] for a in arguments.split(", ") if a]
                    said[signal] = types, TYPES[result] if result else "void"
                self.assertEqual(said, found)

    def test_pads_are_on_the_page(self):
        formats = {}
        for name in self.factories:
            with self.subTest(name):
                templates = {t.name_template: t
                             for t in self.factories[name].get_static_pad_templates()}
                left = dict(templates)
                for pad, template in templates.items():
                    self.assertEqual(template.presence,
                                     Gst.PadPresence.REQUEST if pad == "text"
                                     else Gst.PadPresence.ALWAYS)
                for row in tables(self.page[name], "pad"):
                    for pad in re.findall(r"`(\w+)`", row["pad"]):
                        taken = left.pop(pad).get_caps()
                        said = re.findall("`([^`]+)`", row["caps"])
                        if "those of" in row["caps"]:
                            usual = self.factories["csdtrack"].get_static_pad_templates()[0]
                            said.insert(0, usual.get_caps().to_string())
                        self.assertTrue(
                            Gst.Caps.from_string(";".join(said)).is_strictly_equal(taken),
                            f"{pad}: {taken.to_string()}")
                formats.update({(name, pad): set(harness.formats(taken))
                                for pad, taken in left.items()})
                # Pads that no table has are in the text, with the formats of csdtrack.
                for pad in left:
                    self.assertIn(f"`{pad}`" if name == "csdtrack" else "those of", self.page[name])
        rows = re.findall(r"^\| formats, \d+ bit \| (.*) \|", self.page["csdtrack"], re.MULTILINE)
        said = set(" ".join(rows).split())
        self.assertEqual(len(formats), 3)  # sink and src of csdtrack, src of csdsimsrc
        newer = {f for f in said
                 if GstVideo.VideoFormat.from_string(f) == GstVideo.VideoFormat.UNKNOWN}
        raw = {GstVideo.VideoFormat.to_string(f) for f in GstVideo.video_formats_raw()}
        for (name, pad), taken in formats.items():
            if name == "csdtrack":  # its rows say which it reads in place
                self.assertLessEqual(said - newer, taken)
                self.assertEqual(taken, raw - {"DMA_DRM", "ENCODED"}, pad)
            else:
                planar = {f for f in said if f.startswith("GBR") or f in ("RGBP", "BGRP")}
                self.assertEqual(taken, said - planar - {"Y41B", "GRAY16_BE"}, pad)

    def test_presets_are_in_their_table(self):
        rows = {plain(row["preset"]): plain(row["sets"])
                for row in tables(PRESETS_PAGE.read_text(encoding="utf-8"), "preset")
                if "sets" in row}
        usual = self.elements["csdtrack"]
        self.assertEqual(set(rows), set(usual.get_preset_names()))
        for name, said in rows.items():
            with self.subTest(name):
                track = Gst.ElementFactory.make("csdtrack")
                self.assertTrue(track.load_preset(name))
                set_there = {key: value for key in own_properties(track) if key != "stats" and
                             (str(value := track.get_property(key)) !=
                              str(usual.get_property(key)) or
                              re.search(rf"\b{key}=", said))}
                told = {}
                for key, value in re.findall(r"(\S+)=(.+?)(?= \S+=|$)", said):
                    told[key] = number(value) if value[0].isdigit() else value
                self.assertEqual(told, {key: getattr(value, "value_nick", value)
                                        for key, value in set_there.items()})


class SectionBlocks(harness.Case):
    def blocks(self):
        for factory in Gst.Registry.get().get_feature_list_by_plugin("csdtrack"):
            name = factory.get_name()
            text = (SOURCE / "gst" / "elements" / f"{name}.cpp").read_text(encoding="utf-8")
            block = re.search(r"^/\*\*\n( \* SECTION:.*?) \*/\n", text,
                              flags=re.DOTALL | re.MULTILINE)
            yield name, re.sub(r"^ \* ?", "", block[1], flags=re.MULTILINE) if block else ""

    def test_each_element_has_a_section_block(self):
        for name, block in self.blocks():
            with self.subTest(name):
                head = (rf"SECTION:element-{name}\n@title: {name}\n@short_description: "
                        r"(\S.*)\n\n(?P<what>\S.*?)\n\n")
                found = re.match(head, block, flags=re.DOTALL)
                self.assertTrue(found, block[:200])
                self.assertGreater(len(found["what"].split()), 10)
                self.assertRegex(block, r"(?m)^Since: \d")

    def test_each_property_and_signal_has_a_block(self):
        """In the form that GStreamer's hotdoc reads, which adds the blurb: with the version that
        introduced it."""
        sources = "".join(path.read_text(encoding="utf-8")
                          for path in (SOURCE / "gst").rglob("*.cpp"))
        blocks = re.findall(r"^ */\*\*\n +\* (GstCsd\w+::?[\w-]+):\n(.*?)\*/", sources,
                            flags=re.DOTALL | re.MULTILINE)
        there = [f"{kind.name}:{name}" for element in self.elements()
                 for kind in [element.__gtype__] for name in own_properties(element)]
        there += [f"{element.__gtype__.name}::{name}" for element in self.elements()
                  for name in GObject.signal_list_names(element.__gtype__)]
        self.assertEqual(sorted({name for name, _ in blocks} - {"GstCsdTrack:attach-analytics"}),
                         sorted(set(there) - {"GstCsdTrack:attach-analytics"}))
        self.assertEqual(len(blocks), len(dict(blocks)))
        for name, text in blocks:
            with self.subTest(name):
                if "::" in name:
                    self.assertRegex(text, r"(?m)^ +\*\n +\* [A-Z]\w* ")
                self.assertRegex(text, r"(?m)^ +\* Since: \d+\.\d+$")

    def test_all_that_the_c_header_declares_has_a_block(self):
        header = (SOURCE / "gst" / "meta" / "csdtrackmeta.h").read_text(encoding="utf-8")
        declared = re.findall(r"^(?:#define (\w+)[( ]|static inline .*?(\w+)\(|\} (\w+);)", header,
                              flags=re.MULTILINE)
        declared = ["".join(names) for names in declared]
        self.assertGreater(len(declared), 15)
        blocks = dict(re.findall(r"^/\*\*\n \* (\w+):\n(.*?)\*/", header,
                                 flags=re.DOTALL | re.MULTILINE))
        self.assertEqual(sorted(blocks), sorted(declared))
        for name, text in blocks.items():
            with self.subTest(name):
                self.assertRegex(text, r"(?m)^ \* Since: \d+\.\d+$")

    def elements(self):
        return [factory.create()
                for factory in Gst.Registry.get().get_feature_list_by_plugin("csdtrack")]

    def test_example_lines_parse(self):
        for name, block in self.blocks():
            with self.subTest(name):
                examples = re.search(r"^## Example launch lines?\n(.*?)(?=^## |^Since:)", block,
                                     flags=re.DOTALL | re.MULTILINE)
                self.assertTrue(examples)
                lines = re.findall(r"^\|\[\n(.*?)^\]\|", examples[1],
                                   flags=re.DOTALL | re.MULTILINE)
                self.assertTrue(lines)
                self.assertEqual(examples[1].count("|["), len(lines))
                for line in lines:
                    with self.subTest(line):
                        program, *words = shlex.split(line.replace("\\\n", " "))
                        self.assertEqual(program, "gst-launch-1.0")
                        words = [word for word in words if not re.fullmatch("-[a-z]", word)]
                        self.assertIn(name, words)
                        if "|" in words:  # into another program
                            words = words[:words.index("|")]
                        try:
                            pipeline = Gst.parse_launchv(words)
                        except GLib.Error as error:
                            absent = error.matches(Gst.ParseError.quark(),
                                                   Gst.ParseError.NO_SUCH_ELEMENT)
                            if not absent or "csd" in error.message:
                                raise
                            print(f"SKIP: {name}: {error.message}", file=sys.stderr)
                            continue
                        self.assertTrue(pipeline)

    def test_properties_and_signals_that_blocks_mention_exist(self):
        names = ("csdtrack", "csdtrackenc", "csdtrackdec", "csdsimsrc")
        elements = {e.__gtype__.name: e for e in map(Gst.ElementFactory.make, names)}
        count = 0
        for name, block in self.blocks():
            with self.subTest(name):
                for kind, colons, key, value in re.findall(
                        r"#(GstCsd\w+)(::?)([\w-]+)(?:=([\w-]+))?", block):
                    count += 1
                    with self.subTest(f"{kind}{colons}{key}"):
                        if colons == "::":
                            self.assertIn(key, GObject.signal_list_names(elements[kind].__gtype__))
                            continue
                        spec = elements[kind].find_property(key)
                        self.assertTrue(spec)
                        if value:
                            self.assertIn(value,
                                          [v.value_nick for v in enum_values(elements[kind], spec)])
        self.assertGreater(count, 5)


if __name__ == "__main__":
    harness.main()
