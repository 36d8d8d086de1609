"""Meshes: every format gives the same tetrahedron, hostile files give codes, simple shapes obey their laws."""

import base64
import io
import json
import os
import re
import struct
import sys
import time
import zipfile
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks
from audit import opened
from kinestatics.robots.shapes import Visual
from kinestatics.scene import mesh_parts
from kinestatics.scene.meshes import FARTHEST, TriangleMesh, load_mesh
from kinestatics.scene.simple_shapes import box, capsule, cylinder, ellipsoid, sphere, triangles_of

pytest.importorskip("trimesh")
pytest.importorskip("collada")

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32)
SIDES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
DATA = Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data/robots")
ROBOTS = next(DATA, None)
real = pytest.mark.skipif(ROBOTS is None, reason="example-robot-data is not installed")


def binary_stl(triangles=CORNERS[SIDES], count=None):
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = triangles
    return b"solid" + bytes(75) + struct.pack("<I", len(triangles) if count is None else count) + rows.tobytes()


def text_stl(triangles=CORNERS[SIDES]):
    lines = ["solid tetra"]
    for corners in triangles:
        lines += [
            "facet normal 0 0 0",
            "outer loop",
            *(f"  vertex {x} {y} {z:e}" for x, y, z in corners),
            "endloop",
            "endfacet",
        ]
    return "\n".join([*lines, "endsolid tetra"]).encode()


FACES = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in SIDES)


def obj(faces=FACES, head=""):
    return (head + "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS) + faces).encode()


def text_ply(counts=(4, 4)):
    head = f"ply\nformat ascii 1.0\nelement vertex {counts[0]}\nproperty float x\nproperty float y\nproperty float z\n"
    head += f"element face {counts[1]}\nproperty list uchar int vertex_indices\nend_header\n"
    return (
        head + "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS) + "".join(f"3 {a} {b} {c}\n" for a, b, c in SIDES)
    ).encode()


def binary_ply():
    head = text_ply().decode().partition("end_header\n")[0].replace("ascii", "binary_little_endian") + "end_header\n"
    return head.encode() + CORNERS.tobytes() + b"".join(struct.pack("<B3i", 3, *side) for side in SIDES)


DRAWN = '<instance_geometry url="#g">{}</instance_geometry>'


def dae(
    unit='<unit meter="1"/>', up="Z_UP", corners=CORNERS, sides=SIDES, nodes=f"<node>{DRAWN}</node>",
    head="", library="", effects="", bound="",
):  # fmt: skip
    points = " ".join(str(x) for x in np.ravel(corners))
    return f"""<?xml version="1.0"?>{head}
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{unit}<up_axis>{up}</up_axis></asset>
{effects}<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">{points}</float_array>
<technique_common><accessor source="#a" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4" material="paint"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{" ".join(str(i) for i in np.ravel(sides))}</p></triangles>
</mesh></geometry></library_geometries>{library}
<library_visual_scenes><visual_scene id="s">{nodes.format(bound)}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


def effects(color="1 0 0 1"):
    return f"""<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert>
<diffuse><color>{color}</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>"""


BOUND = (
    '<bind_material><technique_common><instance_material symbol="paint" target="#{}"/></technique_common></bind_material>'
)


def gltf(changes=None, corners=CORNERS[:, [0, 2, 1]] * (1, 1, -1), **more):
    """A scene whose y points up; `changes` maps a path such as "accessors.0.count" to a value."""
    data = np.asarray(corners, dtype="<f4").tobytes() + SIDES.astype("<u2").tobytes()
    tree = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "buffers": [{"byteLength": len(data)}],
    } | more
    for path, value in (changes or {}).items():
        *steps, last = [int(step) if step.isdigit() else step for step in path.split(".")]
        place = tree
        for step in steps:
            place = place[step]
        place[last] = value
    return tree, data


def glb(changes=None, **more):
    tree, data = gltf(changes, **more)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def gltf_text(changes=None, uri=None, **more):
    tree, data = gltf(changes, **more)
    tree["buffers"][0]["uri"] = uri or "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps(tree).encode()


def volume(mesh):
    """Of a closed mesh, positive where its faces look outwards."""
    a, b, c = np.moveaxis(mesh.vertices.astype(float)[mesh.faces], 1, 0)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def edges(mesh):
    """Directed edges, as a set; a closed surface has each once, and each reversed."""
    pairs = [tuple(edge) for face in mesh.faces.tolist() for edge in zip(face, face[1:] + face[:1], strict=True)]
    assert len(pairs) == len(set(pairs))
    return set(pairs)


@pytest.fixture
def load(tmp_path):
    """Writes a mesh and loads it."""
    folder = tmp_path / "meshes"
    folder.mkdir()

    def write_and_load(name, data, **arguments):
        path = folder / name
        path.write_bytes(data)
        return load_mesh(path, **arguments)

    write_and_load.folder = folder
    return write_and_load


FORMATS = {
    "binary.stl": binary_stl,
    "text.STL": text_stl,
    "mesh.obj": obj,
    "text.ply": text_ply,
    "binary.ply": binary_ply,
    "mesh.dae": dae,
    "mesh.glb": glb,
    "mesh.gltf": gltf_text,
}


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_holds_the_same_tetrahedron(load, name):
    """Four corners in place, four faces outwards, nothing twice."""
    mesh = load(name, FORMATS[name]())
    assert (mesh.vertices.dtype, mesh.faces.dtype, mesh.colors) == (np.float32, np.int32, None)
    assert sorted(mesh.vertices.tolist()) == sorted(CORNERS.tolist())
    assert volume(mesh) == pytest.approx(1 / 6)
    assert {(b, a) for a, b in edges(mesh)} == edges(mesh)
    assert not mesh.vertices.flags.writeable


@pytest.mark.parametrize("name", FORMATS)
def test_scale_stretches_and_mirrors(load, name):
    """Volume grows by the product; a mirrored mesh keeps its faces outwards."""
    mesh = load(name, FORMATS[name](), scale=(2, -3, 0.5))
    assert volume(mesh) == pytest.approx(0.5)
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [0, -3, 0], atol=1e-7)


def test_collada_unit_counts_and_up_axis_does_not(load):
    """As in RViz, MoveIt and Gazebo; the transforms of nodes are in the file's unit."""
    for up in ("X_UP", "Y_UP", "Z_UP"):
        nodes = f"<node><translate>100 0 0</translate><rotate>0 0 1 90</rotate>{DRAWN}</node>"
        mesh = load("unit.dae", dae('<unit name="centimeter" meter="0.01"/>', up, nodes=nodes))
        np.testing.assert_allclose(mesh.vertices.min(axis=0), [0.99, 0, 0], atol=1e-7)
        np.testing.assert_allclose(mesh.vertices.max(axis=0), [1, 0.01, 0.01], atol=1e-7)
        assert volume(mesh) == pytest.approx(1e-6 / 6)
    mirrored = dae(nodes=f"<node><scale>-1 1 1</scale>{DRAWN}</node>")
    assert volume(load("mirrored.dae", mirrored)) == pytest.approx(1 / 6)


def test_collada_colors(load):
    """The diffuse colour; a material that is broken is left out, and its triangles are not."""
    mesh = load("red.dae", dae(effects=effects("1 0 0.5 0"), bound=BOUND.format("m")))
    assert {tuple(color) for color in mesh.colors.tolist()} == {(255, 0, 128, 255)}
    ((color, part),) = mesh.by_color()
    assert (color, len(part.faces)) == ((255, 0, 128, 255), 4)
    assert load("broken.dae", dae(bound=BOUND.format("nowhere"))).colors is None


def test_obj_colors_polygons_and_lines(load):
    """Materials beside the file colour its triangles; polygons become fans; other colours stay apart."""
    (load.folder / "paint.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\nmap_Kd ../../picture.png\n")
    faces = "usemtl red\nf 1 3 2\nf 1 2 4\nusemtl blue\nf 1 4 3\nf 2 3 4\nl 1 2\n"
    mesh = load("mesh.obj", obj(faces, "mtllib paint.mtl\n"))
    assert volume(mesh) == pytest.approx(1 / 6)
    assert {color: len(part.faces) for color, part in mesh.by_color()} == {(255, 0, 0, 255): 2, (0, 0, 255, 255): 2}
    assert len(load("square.obj", obj("f 1 2 3 4\n")).faces) == 2
    assert len(load("both.obj", obj("f 1 2 3 4\nf 1 2 3\n")).faces) == 3


def test_gltf_nodes_colors_and_files(load):
    """Nodes move their children, base colours are shown as a screen needs them, buffers may lie beside the file."""
    nodes = [{"children": [1], "translation": [0, 5, 0]}, {"mesh": 0, "scale": [2, 2, 2], "rotation": [0, 0, 0, 1]}]
    tree, data = gltf(nodes=nodes, materials=[{"pbrMetallicRoughness": {"baseColorFactor": [0.214, 1, 0, 0.5]}}])
    tree["meshes"][0]["primitives"][0]["material"] = 0
    tree["buffers"][0]["uri"] = "points.bin"
    (load.folder / "points.bin").write_bytes(data)
    mesh = load("mesh.gltf", json.dumps(tree).encode())
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [0, 0, 5], atol=1e-6)
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [2, 2, 7], atol=1e-6)
    assert {tuple(color) for color in mesh.colors.tolist()} == {(127, 255, 0, 128)}


def test_vertices_are_merged_and_unused_ones_dropped(load):
    """Shared corners are one, 0 and -0 are the same, and a number that is none hurts nobody where no face uses it."""
    flat = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[-0.0, -0.0, 0], [0, 1, 0], [-1, 0, 0]]], dtype=np.float32)
    assert load("two.stl", binary_stl(flat)).vertices.shape == (4, 3)
    assert load("unused.obj", obj("f 1 2 3\n", "")).vertices.shape == (3, 3)


def nested(depth):
    """Nodes that draw the next ten times, as deep as that."""
    last = '<node id="n0"><instance_geometry url="#g"/></node>'
    return "<library_nodes>" + last + "".join(
        f'<node id="n{i}">{f"<instance_node url={chr(34)}#n{i - 1}{chr(34)}/>" * 10}</node>' for i in range(1, depth)
    ) + "</library_nodes>"  # fmt: skip


LAUGHS = '<!ENTITY a0 "lol">' + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 10))


def archive():
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as bomb:
        bomb.writestr("a.dae", bytes(1 << 26))
    return buffer.getvalue()


HOSTILE = {
    "4_billion_triangles.stl": (binary_stl(count=0xFFFFFFFF), "KS443"),
    "one_too_few.stl": (binary_stl(count=5), "KS443"),
    "cut.stl": (binary_stl()[:-7], "KS443"),
    "empty.stl": (b"", "KS443"),
    "none.stl": (binary_stl(CORNERS[SIDES][:0]), "KS446"),
    "nan.stl": (binary_stl(np.full((1, 3, 3), np.nan)), "KS444"),
    "inf.stl": (binary_stl(np.full((1, 3, 3), np.inf)), "KS444"),
    "far.stl": (binary_stl(np.full((1, 3, 3), 1e30)), "KS444"),
    "words.stl": (b"solid\nfacet\nouter loop\nvertex a b c\nendloop\nendsolid", "KS446"),
    "nan_in_text.stl": (text_stl(np.full((1, 3, 3), np.nan)), "KS444"),
    "two_corners.stl": (text_stl()[: text_stl().rindex(b"vertex")], "KS443"),
    "not_a_number.stl": (text_stl().replace(b"vertex 0.0", b"vertex 0.0.0"), "KS443"),
    "index_out_of_range.obj": (obj("f 1 2 999999999\n"), "KS443"),
    "index_before_the_first.obj": (obj("f 1 2 -99\n"), "KS443"),
    "no_faces.obj": (obj(""), "KS446"),
    "empty.obj": (b"", "KS446"),
    "nan.obj": (b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "KS444"),
    "binary.obj": (bytes(range(256)) * 40, "KS446"),
    "billions.ply": (text_ply((4_000_000_000, 4)), "KS443"),
    "huge_count.ply": (text_ply((10**400, 4)), "KS443"),
    "index.ply": (text_ply().replace(b"3 1 2 3", b"3 1 2 9"), "KS445"),
    "cut.ply": (binary_ply()[:-5], "KS443"),
    "no.ply": (b"ply\nwords\n", "KS443"),
    "external_entity.dae": (dae(head='<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]>', up="&x;"), "KS448"),
    "billion_laughs.dae": (dae(head=f"<!DOCTYPE r [{LAUGHS}]>", up="&a9;"), "KS448"),
    "utf16.dae": (dae(head="<!DOCTYPE r []>").decode().encode("utf-16"), "KS443"),
    "archive.dae": (archive(), "KS441"),
    "archive_behind.dae": (dae() + archive(), "KS441"),
    "cut.dae": (dae()[:-40], "KS443"),
    "robot.dae": (b"<robot/>", "KS446"),
    "no_scene.dae": (dae().partition(b"<library_visual")[0] + b"</COLLADA>", "KS446"),
    "index.dae": (dae(sides=SIDES + 1), "KS443"),
    "negative.dae": (dae(sides=SIDES - 1), "KS445"),
    "words.dae": (dae(corners=["x"] * 12), "KS443"),
    "nan.dae": (dae(corners=["nan"] * 12), "KS446"),
    "unit.dae": (dae(unit='<unit meter="1e30"/>'), "KS444"),
    "nested.dae": (dae(library=nested(9), nodes='<node><instance_node url="#n8"/></node>'), "KS449"),
    "loop.dae": (dae(library='<library_nodes><node id="n"><instance_node url="#n"/></node></library_nodes>',
                     nodes='<node><instance_node url="#n"/></node>'), "KS443"),
    "count.glb": (glb({"accessors.0.count": 10**9}), "KS442"),
    "beyond.glb": (glb({"accessors.1.count": 3000}), "KS445"),
    "offset.glb": (glb({"bufferViews.1.byteOffset": 10**9}), "KS445"),
    "negative.glb": (glb({"bufferViews.1.byteOffset": -4}), "KS443"),
    "stride.glb": (glb({"bufferViews.0.byteStride": 1}), "KS445"),
    "sparse.glb": (glb({"accessors.0.sparse": {"count": 10**9}}), "KS443"),
    "no_view.glb": (glb({"accessors.0.bufferView": None}), "KS443"),
    "loop.glb": (glb({"nodes.0.children": [0]}), "KS449"),
    "twice.glb": (glb({"scenes.0.nodes": [0, 0]}), "KS449"),
    "draco.glb": (glb(extensionsRequired=["KHR_draco_mesh_compression"]), "KS441"),
    "cut.glb": (glb()[:-10], "KS443"),
    "no_json.glb": (b"glTF" + struct.pack("<II", 2, 12), "KS443"),
    "deep.gltf": (b"[" * 100_000, "KS443"),
    "list.gltf": (b"[]", "KS443"),
    "nan.gltf": (gltf_text({"nodes.0.translation": [float("nan"), 0, 0]}), "KS444"),
    "elsewhere.gltf": (gltf_text(uri="../secret.bin"), "KS447"),
    "absolute.gltf": (gltf_text(uri="/etc/passwd"), "KS447"),
    "url.gltf": (gltf_text(uri="http://127.0.0.1:9/points.bin"), "KS447"),
    "file_url.gltf": (gltf_text(uri="file:///etc/passwd"), "KS447"),
    "bomb.zip": (archive(), "KS441"),
    "mesh.msh": (b"", "KS441"),
    "no_suffix": (b"", "KS441"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_mesh(load, name, capfd):
    """One error with its code and the file's name, soon; nothing else is opened and nothing is printed."""
    data, code = HOSTILE[name]
    (load.folder.parent / "secret.bin").write_bytes(bytes(72))
    began = time.monotonic()
    with opened() as paths, pytest.raises(ks.KinestaticsError, match=rf"{re.escape(name)}(:\d+:\d+)?: error {code}: "):
        load(name, data)
    assert time.monotonic() - began < 5.0
    assert set(paths) <= {os.path.realpath(load.folder / name)}
    assert capfd.readouterr() == ("", "")


def test_material_outside_is_not_opened(load):
    """An OBJ file that names a material elsewhere is drawn without it."""
    for name in ("../../../../etc/hostname", "../secret.mtl", "/etc/passwd", "link.mtl", "http://127.0.0.1:9/a.mtl"):
        (load.folder.parent / "secret.mtl").write_text("newmtl a\nKd 1 0 0\n")
        (load.folder / "link.mtl").unlink(missing_ok=True)
        (load.folder / "link.mtl").symlink_to(load.folder.parent / "secret.mtl")
        with opened() as paths:
            mesh = load("mesh.obj", obj("usemtl a\nf 1 2 3\n", f"mtllib {name}\n"))
        assert mesh.colors is None
        assert set(paths) == {os.path.realpath(load.folder / "mesh.obj")}


def test_files_that_are_none(tmp_path):
    """A folder, a pipe and a missing file are refused before they are opened."""
    (tmp_path / "folder.stl").mkdir()
    os.mkfifo(tmp_path / "pipe.stl")
    for name in ("folder.stl", "pipe.stl", "missing.stl", "a" * 5000 + ".stl", "nul\0.stl"):
        with pytest.raises(ks.KinestaticsError, match="KS440"):
            load_mesh(tmp_path / name)


def test_limits_hold_before_parsing(load, monkeypatch):
    """Size and number of triangles."""
    monkeypatch.setattr(mesh_parts, "MAX_TRIANGLES", 3)
    for name, make in FORMATS.items():
        with pytest.raises(ks.KinestaticsError, match=r"KS442: .*(triangles|points or corners)"):
            load(name, make())
    monkeypatch.setattr(mesh_parts, "MAX_BYTES", 10)
    with pytest.raises(ks.KinestaticsError, match="KS442: the mesh file is 284 bytes; the limit is 10"):
        load("binary.stl", binary_stl())


def test_a_large_file_is_refused_without_being_read(tmp_path):
    """A sparse file of a terabyte takes no time."""
    with (tmp_path / "large.stl").open("wb") as stream:
        stream.truncate(1 << 40)
    began = time.monotonic()
    with pytest.raises(ks.KinestaticsError, match="KS442"):
        load_mesh(tmp_path / "large.stl")
    assert time.monotonic() - began < 1.0


def test_scale_that_overflows(load):
    """It is told, and no infinity is drawn."""
    with pytest.raises(ks.KinestaticsError, match=re.escape(f"farther away than {FARTHEST:g} m")):
        load("mesh.stl", binary_stl(), scale=(1e300, 1, 1))


def test_mutated_meshes(load):
    """Whatever a broken file holds, it is a mesh or an error with a code."""
    random = np.random.default_rng(5)
    codes = set()
    for name, make in FORMATS.items():
        data = make()
        for _ in range(40):
            mutant = bytearray(data[: random.integers(len(data) // 2, len(data) + 1)] if random.random() < 0.3 else data)
            for place in random.integers(0, len(mutant), 3):
                mutant[place] = random.integers(0, 256)
            mesh = attempt(load, name, bytes(mutant))
            if isinstance(mesh, TriangleMesh):
                assert np.all(np.isfinite(mesh.vertices))
                assert 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices)
            else:
                codes.add(mesh)
    assert codes <= {f"KS44{i}" for i in range(10)}


def attempt(load, name, data):
    """The mesh, or the code of its error."""
    try:
        return load(name, data)
    except ks.KinestaticsError as failure:
        return failure.code


SOLIDS = {
    "box": (lambda _: box(1, 2, 3), 6.0),
    "cylinder": (lambda sides: cylinder(0.5, 2.0, sides), 0.5 * np.pi),
    "sphere": (lambda sides: sphere(2.0, sides), 32 / 3 * np.pi),
    "capsule": (lambda sides: capsule(0.5, 2.0, sides), (0.5 + 1 / 6) * np.pi),
    "ellipsoid": (lambda sides: ellipsoid(1, 2, 3, sides), 8 * np.pi),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_simple_shapes_are_closed_and_look_outwards(name):
    """Each edge twice, once in each direction; Euler's number of a ball; no triangle without area; positive volume."""
    make, true = SOLIDS[name]
    mesh = make(24)
    assert {(b, a) for a, b in edges(mesh)} == edges(mesh)
    assert len(mesh.vertices) - len(edges(mesh)) // 2 + len(mesh.faces) == 2
    a, b, c = np.moveaxis(mesh.vertices.astype(float)[mesh.faces], 1, 0)
    normals = np.cross(b - a, c - a)
    assert np.linalg.norm(normals, axis=1).min() > 1e-4
    assert np.all(np.einsum("ij,ij->i", normals, a + b + c) > 0)  # all five are star-shaped about the origin
    assert 0 < volume(mesh) <= true * (1 + 1e-6)
    assert len(mesh.faces) <= 700


@pytest.mark.parametrize("name", [name for name in SOLIDS if name != "box"])
def test_volume_comes_up_to_the_true_one(name):
    """From below, by a quarter of the error with twice the sides."""
    make, true = SOLIDS[name]
    errors = [1 - volume(make(sides)) / true for sides in (16, 32, 64, 128)]
    assert all(3.5 < coarse / fine < 4.5 for coarse, fine in pairwise(errors))
    assert 0 < errors[-1] < 2e-3


def test_simple_shapes_reach_their_sizes():
    """Their extent along the axes is the size that was asked for; triangles_of takes the sizes of a Visual."""
    cases = {"box": (1, 2, 3), "cylinder": (0.5, 2), "sphere": (2,), "capsule": (0.5, 2), "ellipsoid": (1, 2, 3)}
    extents = {"box": (1, 2, 3), "cylinder": (1, 1, 2), "sphere": (4, 4, 4), "capsule": (1, 1, 3), "ellipsoid": (2, 4, 6)}
    for kind, size in cases.items():
        mesh = triangles_of(Visual("link", kind, np.eye(4), size))
        np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), extents[kind], rtol=1e-6)


def test_triangles_of_a_mesh(load):
    """Loaded from its file, scaled."""
    load("mesh.stl", binary_stl())
    visual = Visual("link", "mesh", np.eye(4), file=load.folder / "mesh.stl", scale=(2.0, 2.0, 2.0))
    assert isinstance(triangles_of(visual), TriangleMesh)
    assert volume(triangles_of(visual)) == pytest.approx(8 / 6)


PAIRS = [  # COLLADA to look at, STL to collide with, of the same link, both at the origin of it: made by other hands
    *(("panda_description", f"{name}.dae", f"{name}.stl", 0.001) for name in ("link0", "link1", "link2", "link4", "hand")),
    *(("ur_description", f"ur5/visual/{name}.dae", f"ur5/collision/{name}.stl", 0.001) for name in ("upperarm", "wrist1")),
]


@real
@pytest.mark.parametrize(("robot", "seen", "hit", "tolerance"), PAIRS)
def test_collada_agrees_with_stl_of_the_same_link(robot, seen, hit, tolerance):
    """Their boxes are the same to a millimetre: the unit and the axes are right."""
    meshes = ROBOTS / robot / "meshes"
    first, second = (
        next(iter(sorted(meshes.rglob(f"*{name}")))) if "/" not in name else meshes / name for name in (seen, hit)
    )
    boxes = [(m.vertices.min(axis=0), m.vertices.max(axis=0)) for m in (load_mesh(first), load_mesh(second))]
    np.testing.assert_allclose(*boxes, atol=tolerance)


@real
def test_collada_with_y_up_reaches_from_joint_to_joint():
    """Where a file says Y_UP, its axes are still those of the link: the next joint lies within the link's box."""
    from kinestatics.robots.visuals import visuals

    arm = ks.load(ROBOTS / "borinot_description" / "urdf" / "borinot_flying_arm_2.urdf", whole_tree=True)
    checked = 0
    for shape in visuals(arm).shapes:
        assert b"Y_UP" in shape.file.read_bytes()[:4000]
        carrier = arm.link_joints[arm.link(shape.link)]
        mesh = load_mesh(shape.file, scale=shape.scale)
        points = mesh.vertices @ shape.T_link_visual[:3, :3].T + shape.T_link_visual[:3, 3]
        for child, parent in enumerate(arm.parents):
            if parent == carrier and carrier >= 0:
                joint = arm.placements[child][:3, 3]
                assert np.all(points.min(axis=0) - 0.02 < joint)
                assert np.all(joint < points.max(axis=0) + 0.02)
                assert np.linalg.norm(joint) > 0.1
                checked += 1
    assert checked == 1


@real
def test_panda_in_time():
    """Eleven meshes, 134,300 triangles."""
    from kinestatics.robots.visuals import visuals

    arm = ks.load(ROBOTS / "panda_description" / "urdf" / "panda.urdf", whole_tree=True)
    shapes = visuals(arm).shapes
    load_mesh(shapes[0].file)  # the import
    began = time.process_time()
    meshes = [triangles_of(shape) for shape in shapes]
    assert time.process_time() - began < 2.0
    assert sum(len(mesh.faces) for mesh in meshes) == 134_300 + len(meshes[-1].faces)


@real
@pytest.mark.slow
def test_every_mesh_of_every_robot():
    """All visual meshes of example-robot-data load, and nothing is opened but themselves and materials beside them."""
    from kinestatics.robots.visuals import visuals

    files = {}
    for path in sorted(ROBOTS.rglob("*.urdf")):
        if path.name not in ("alex_psyonic_hands.urdf", "ur3.urdf"):
            shapes = visuals(ks.load(path, whole_tree=True)).shapes
            files |= {(shape.file, shape.scale): shape for shape in shapes if shape.kind == "mesh"}
    for shape in files.values():
        with opened() as paths:
            mesh = triangles_of(shape)
        assert len(mesh.faces) > 0
        for path in map(Path, paths):
            assert path == shape.file or (path.parent == shape.file.parent and path.suffix == ".mtl")
    assert len(files) == 528
