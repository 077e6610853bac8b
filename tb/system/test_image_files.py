# SPDX-License-Identifier: Apache-2.0
"""A stored memory image gives the hits of a built one; a damaged or foreign one is refused."""

import struct
import zlib

import pytest
from agents.program import SCENES, Run, call

CORNELL = SCENES / "cornell.gltf"
RAYS = "random:500"
VERSION, CHECKSUM = 4, 8  # bytes of the header, `docs/memory-image.md`
FORMAT_AND_KINDS, ROOT_NODE, SECTION_COUNT, TABLE = 16, 20, 52, 64


@pytest.fixture(scope="module")
def write(ti):
    """A function that writes the image of a scene."""

    def write(path, scene=CORNELL, config=ti.config):
        return call([ti.path, "image", "--config", config, "--scene", scene, "--out", path])

    return write


@pytest.fixture
def image(write, tmp_path):
    path = tmp_path / "cornell.tiim"
    write(path).good()
    return path


def changed(data, place, value, mend=True):
    """The image with another word at a place; `mend`: with the checksum that belongs to it."""
    data = bytearray(data)
    struct.pack_into("<I", data, place, value)
    if mend:
        struct.pack_into("<I", data, CHECKSUM, 0)
        struct.pack_into("<I", data, CHECKSUM, zlib.crc32(data))
    return bytes(data)


def flipped(data, place):
    return data[:place] + bytes([data[place] ^ 1]) + data[place + 1 :]


DAMAGE = {
    "cut-in-half": (lambda data: data[: len(data) // 2], ["header says 6144"]),
    "cut-by-a-section": (lambda data: data[:-128], ["header says 6144"]),
    "cut-in-its-header": (lambda data: data[:100], ["100 bytes"]),
    "empty": (lambda data: b"", ["0 bytes"]),
    "too-long": (lambda data: data + bytes(128), ["header says 6144"]),
    "a-byte-of-a-node": (lambda data: flipped(data, 128), ["checksum"]),
    "a-byte-of-the-last-record": (lambda data: flipped(data, len(data) - 100), ["checksum"]),
    "the-checksum": (lambda data: flipped(data, CHECKSUM), ["checksum"]),
    "the-magic": (lambda data: flipped(data, 0), ["TIIM"]),
    "version-1": (lambda data: changed(data, VERSION, 1), ["version 1", "reads 2", "make image"]),
    "newer-version": (lambda data: changed(data, VERSION, 3), ["version 3", "reads 2"]),
    "another-tree": (
        lambda data: changed(data, FORMAT_AND_KINDS, 0x01051708),
        ["tree is of kind 5", "1 (kd)", "make image"],
    ),
    "another-test": (
        lambda data: changed(data, FORMAT_AND_KINDS, 0x05011708),
        ["test is of kind 5", "1 (local)", "make image"],
    ),
    "a-longer-table": (lambda data: changed(data, SECTION_COUNT, 1 << 30), ["1073741824 sections"]),
    "no-nodes": (lambda data: changed(data, TABLE, 99), ["no section has its nodes"]),
    "a-section-beyond-the-end": (
        lambda data: changed(data, TABLE + 4, 1 << 20),
        ["section 0", "does not fit"],
    ),
    "no-such-root": (lambda data: changed(data, ROOT_NODE, 1 << 20), ["root 1048576"]),
    "a-text": (lambda data: b"not an image " * 20, ["TIIM"]),
}


def same_hits(a: Run, b: Run):
    return all(a.read(name) == b.read(name) for name in ("hits.npy", "prims.npy"))


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_image_is_refused(ti, image, out, damage):
    spoil, words = DAMAGE[damage]
    image.write_bytes(spoil(image.read_bytes()))

    ti.trace(out, CORNELL, RAYS, "--image", image).refused("cornell.tiim", *words)
    ti.render(out, CORNELL, "--image", image).refused("cornell.tiim", *words)


def test_the_rtl_refuses_a_damaged_image_too(tiny, image, out):
    image.write_bytes(flipped(image.read_bytes(), 200))

    tiny.trace(out, CORNELL, RAYS, "--image", image).refused("cornell.tiim", "checksum")


def test_every_flipped_byte_of_the_header_is_noticed(ti, image, out):
    good = image.read_bytes()
    for place in range(128):
        image.write_bytes(flipped(good, place))
        ti.trace(out, CORNELL, "random:1", "--image", image).refused("cornell.tiim")


def test_an_image_of_another_scene_is_refused(ti, image, out):
    triangle = SCENES / "one_triangle.obj"

    ti.trace(out, triangle, RAYS, "--image", image).refused("cornell.tiim", "another scene")
    ti.trace(out, SCENES / "empty.ply", RAYS, "--image", image).refused("another scene")


def test_an_image_without_one_of_the_triangles_is_refused(write, ti, tmp_path, out):
    corners = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nv 0 1 1\nf 1 2 3\n"
    less, more = tmp_path / "less.obj", tmp_path / "more.obj"
    less.write_text(corners)
    more.write_text(corners + "f 1 2 4\n")
    write(tmp_path / "less.tiim", less).good()

    ti.trace(out, more, RAYS, "--image", tmp_path / "less.tiim").refused("another scene")


def test_an_image_of_another_format_is_refused(ti, image, tmp_path, out):
    config = tmp_path / "config.json"
    config.write_text(ti.config.read_text().replace('"frac_bits": 23', '"frac_bits": 16'))

    run = ti.trace(out, CORNELL, RAYS, "--image", image, config=config)
    run.refused("cornell.tiim", "(8,23)", "(8,16)")


def test_an_image_of_another_layout_is_refused(ti, image, tmp_path, out):
    config = ti.with_keys(tmp_path, layout="dfl")

    run = ti.trace(out, CORNELL, RAYS, "--image", image, config=config)
    run.refused("cornell.tiim", "layout odfl", "has dfl", "make image")


def test_a_missing_image_is_refused(ti, tmp_path, out):
    for place in (tmp_path / "none.tiim", tmp_path):
        ti.trace(out, CORNELL, RAYS, "--image", place).refused(str(place))


def test_an_image_is_not_written_where_it_cannot_be(write, tmp_path):
    (tmp_path / "file").write_text("mine")
    write(tmp_path / "file/a.tiim").refused("file", "folder cannot be made")
    assert (tmp_path / "file").read_text() == "mine"
    write(tmp_path / "a.tiim", tmp_path / "none.ply").refused("none.ply")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]


@pytest.mark.parametrize("layout", ["odfl", "dfl"])
def test_a_stored_image_gives_the_hits_and_the_work_of_a_built_one(
    write, tiny, scene, tmp_path, layout
):
    path = tmp_path / "images" / "a.tiim"
    config = tiny.with_keys(tmp_path, layout=layout)
    write(path, scene, config).good()
    built = tiny.trace(tmp_path / "built", scene, RAYS, config=config).good()
    stored = tiny.trace(tmp_path / "stored", scene, RAYS, "--image", path, config=config).good()

    assert same_hits(built, stored)
    for key in ("cycles", "per_ray", "phase", "cache", "image_bytes"):
        assert built.report[key] == stored.report[key]
    assert stored.report["tree"] == built.report["tree"] | {"sah_cost": None}
    assert stored.report["time"]["build"] is None


def test_the_same_scene_gives_the_same_bytes(write, image, tmp_path):
    write(tmp_path / "again.tiim").good()

    assert (tmp_path / "again.tiim").read_bytes() == image.read_bytes()


def test_an_empty_scene_has_an_image(write, ti, tmp_path, out):
    empty = SCENES / "empty.ply"
    write(tmp_path / "empty.tiim", empty).good()

    run = ti.trace(out, empty, RAYS, "--image", tmp_path / "empty.tiim").good()
    assert (run.prims == -1).all()
