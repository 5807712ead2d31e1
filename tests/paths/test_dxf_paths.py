"""DXF drawings, written here with ezdxf, against geometry by hand and ezdxf's flattening as a second opinion."""

import math

import numpy as np
import pytest

from leadscrew.paths.dxf import bulged
from leadscrew.paths.read import read_drawing
from leadscrew.paths.segments import Arc, EllipseArc, Spline
from leadscrew.util.errors import DataError, NameUnknown

ezdxf = pytest.importorskip("ezdxf")
DOWN = {"extrusion": (0, 0, -1)}


@pytest.fixture
def drawn(tmp_path):
    """Saves what a function draws and reads it."""

    def make(draw, units=4, **options):
        document = ezdxf.new()
        document.units = units
        draw(document.modelspace())
        file = tmp_path / "drawing.dxf"
        document.saveas(file)
        return read_drawing(file, **options)

    return make


def block(space):
    b = space.doc.blocks.new("B")
    b.add_circle((1, 1), 2)
    b.add_arc((5, 5), 2, 0, 90)
    b.add_lwpolyline([(0, 0, 0.5), (3, 0, 0), (3, 3, 0)], format="xyb")
    inner = space.doc.blocks.new("INNER")
    inner.add_line((0, 0), (4, 0))
    b.add_blockref("INNER", (9, 0), dxfattribs={"rotation": 90})


ENTITIES = {
    "line": lambda m: m.add_line((0, 0, 3), (10, 5, 3)),
    "circle": lambda m: m.add_circle((50, 0), 7),
    "arc": lambda m: m.add_arc((10, 5), 5, -80, 95),
    "arc from below": lambda m: m.add_arc((0, 50), 5, 10, 100, dxfattribs=DOWN),
    "ellipse": lambda m: m.add_ellipse((80, 0), (10, 5), 0.4, 0.3, 4),
    "ellipse from below": lambda m: m.add_ellipse((80, 0), (10, 5), 0.4, 0.3, 4, dxfattribs=DOWN),
    "round ellipse": lambda m: m.add_ellipse((80, 50), (10, 0), 1),
    "polyline with bulges": lambda m: m.add_lwpolyline(
        [(0, 100, 1), (10, 100, 0), (10, 120, -0.3)], format="xyb", close=True
    ),
    "polyline from below": lambda m: m.add_lwpolyline([(0, 0, 0.5), (9, 0, 2)], format="xyb", dxfattribs=DOWN),
    "old polyline": lambda m: m.add_polyline2d([(0, 300, 0.5), (10, 300, 0), (12, 310, 0)], format="xyb"),
    "fit points": lambda m: m.add_spline([(100, 100), (120, 130), (150, 100), (170, 120)]),
    "control points": lambda m: m.add_open_spline([(100, 200), (120, 230), (150, 200), (170, 220), (200, 200)]),
    "weights": lambda m: m.add_rational_spline(
        [(100, 300), (120, 330), (150, 300), (170, 320), (200, 300)], [1, 2, 3, 1, 1]
    ),
    "block": lambda m: (block(m), m.add_blockref("B", (30, 20), dxfattribs={"rotation": 30})),
    "block stretched": lambda m: (
        block(m),
        m.add_blockref("B", (30, 20), dxfattribs={"xscale": 2, "yscale": 0.7, "rotation": 30}),
    ),
    "block mirrored": lambda m: (
        block(m),
        m.add_blockref("B", (30, 20), dxfattribs={"xscale": -2, "yscale": 2, "rotation": -70}),
    ),
    "block from below": lambda m: (block(m), m.add_blockref("B", (30, 20), dxfattribs=DOWN)),
}


def flattened(entities):
    """Points of ezdxf's own polylines, nearly exact."""
    from ezdxf.path import make_path

    for entity in entities:
        if entity.dxftype() == "INSERT":
            yield from flattened(entity.virtual_entities())
        elif entity.dxftype() == "SPLINE":
            # Its path would be an approximation by cubics.
            yield np.array([(v.x, v.y) for v in entity.construction_tool().approximate(4000)])
        else:
            yield np.array([(v.x, v.y) for v in make_path(entity).flattening(1e-5, 32)])


@pytest.mark.parametrize("name", ENTITIES)
def test_every_entity_runs_where_ezdxf_draws_it(drawn, name):
    kept = []
    drawing = drawn(lambda m: kept.append((ENTITIES[name](m), m)))
    theirs = list(flattened(kept[0][1]))
    length = sum(np.hypot(*np.diff(rows, axis=0).T).sum() for rows in theirs)
    # ezdxf draws arcs as cubic curves, which are longer by up to 1e-4.
    assert drawing.length == pytest.approx(length, rel=2e-4)
    ours = np.concatenate([np.column_stack(p.at(np.linspace(0, p.length, 3000))[:2]) for p in drawing.paths])
    from scipy.spatial import cKDTree

    far, _ = cKDTree(ours).query(np.concatenate(theirs))
    assert far.max() < drawing.length / 3000 + 1e-3


def test_the_kinds_stay_what_they_are(drawn):
    kinds = {
        name: type(drawn(ENTITIES[name]).paths[0].segments[0])
        for name in ("arc", "ellipse", "round ellipse", "weights")
    }
    assert kinds == {"arc": Arc, "ellipse": EllipseArc, "round ellipse": Arc, "weights": Spline}


def test_bulges_by_hand():
    half, quarter = bulged([(0, 0, 1), (10, 0, -math.tan(math.pi / 8)), (10, 10, 0)], closed=False)
    # A bulge of 1 is half a turn to the left of the way: below the chord; -tan(22.5 deg) a quarter to the right.
    assert half.at(half.length / 2).y == pytest.approx(-5) and half.sweep == pytest.approx(math.pi)
    assert quarter.sweep == pytest.approx(-math.pi / 2) and quarter.radius == pytest.approx(math.sqrt(50))
    assert quarter.centre == pytest.approx((15, 5))
    assert quarter.end == pytest.approx((10, 10))


def test_a_closed_spline_has_no_corner_at_its_joint(drawn):
    points = [(0, 0, 0), (20, 30, 0), (50, 0, 0), (70, 20, 0), (40, -40, 0)]
    (path,) = drawn(lambda m: m.add_spline().set_closed(points)).paths
    assert path.closed and path.corners == [] and abs(path.turn) == pytest.approx(360)


def test_loose_entities_become_one_outline(drawn):
    def slot(m):
        m.add_line((0, 0), (10, 0))
        m.add_line((0, 10), (10, 10.002))
        m.add_arc((0, 5), 5, 90, 270)
        m.add_line((3, 3), (3, 3))
        m.add_arc((10, 5), 5, -90, 90)

    drawing = drawn(slot)
    (path,) = drawing.paths
    assert path.closed and path.turn == pytest.approx(360)
    assert all(abs(c.turn_deg) < 0.1 for c in path.corners)
    assert path.length == pytest.approx(20 + 10 * math.pi, abs=0.01)
    assert "4 pieces joined into 1 path" in drawing.notes
    assert "1 segment of no length left out" in drawing.notes


UNITS = [
    (4, 1, "mm"), (1, 25.4, "in"), (5, 10, "cm"), (6, 1000, "m"), (9, 0.0254, "mil"), (2, 12 * 25.4, "ft"),
    (10, 36 * 25.4, "yd"), (8, 25.4e-6, "microinch"), (13, 1e-3, "um"), (14, 100, "dm"),
]  # fmt: skip
"""By the codes of the DXF reference."""


@pytest.mark.parametrize(("units", "factor", "name"), UNITS)
def test_units_of_the_file(drawn, units, factor, name):
    # Drawn 5 m long, whatever the unit.
    drawing = drawn(lambda m: m.add_line((0, 0), (3000 / factor, 4000 / factor)), units)
    assert drawing.length == pytest.approx(5000) and drawing.unit == name


def test_a_file_without_a_unit_is_refused_with_the_way_out(drawn):
    with pytest.raises(DataError, match=r"does not say its unit \(\$INSUNITS is 0\): give it, as --unit mm"):
        drawn(lambda m: m.add_line((0, 0), (3, 4)), 0)
    assert drawn(lambda m: m.add_line((0, 0), (3, 4)), 0, unit="in").length == pytest.approx(127)
    asked = drawn(lambda m: m.add_line((0, 0), (3, 4)), 1, unit="mm")
    assert asked.length == pytest.approx(5) and asked.notes == ("the file is in in, read as mm as asked",)


def test_what_is_not_read_is_said(drawn):
    def draw(m):
        m.add_line((0, 0), (9, 0))
        m.add_text("hello")
        m.add_point((1, 2))
        m.add_circle((0, 0), 5, dxfattribs={"extrusion": (1, 0, 0)})
        m.doc.layers.add("off").off()
        m.add_line((0, 0), (0, 7), dxfattribs={"layer": "off"})

    drawing = drawn(draw)
    assert drawing.length == pytest.approx(9)
    assert drawing.notes == (
        "not cut: 1 POINT, 1 TEXT",
        "not in the XY plane, not cut: 1 CIRCLE",
        "hidden, not cut: 1 LINE",
    )


def test_layers_are_chosen_and_not_joined_across(drawn):
    def draw(m):
        m.add_line((0, 0), (9, 0), dxfattribs={"layer": "CUT"})
        m.add_line((9, 0), (9, 5), dxfattribs={"layer": "FOLD"})

    assert drawn(draw).layers == ("CUT", "FOLD")
    assert drawn(draw, layers=["FOLD"]).length == pytest.approx(5)
    with pytest.raises(NameUnknown, match=r"no layer 'CUTS'.*CUT"):
        drawn(draw, layers=["CUTS"])


def test_where_three_lines_meet_the_straightest_goes_on(drawn):
    def draw(m):
        m.add_line((0, 0), (10, 0))
        m.add_line((10, 0), (10, 10))
        m.add_line((10, 0), (20, 0.5))

    first, second = drawn(draw).paths
    assert len(first.segments) == 2 and abs(first.corners[0].turn_deg) < 5
    assert second.length == pytest.approx(10)


def test_a_block_that_holds_itself_is_refused(drawn):
    def draw(m):
        b = m.doc.blocks.new("SELF")
        b.add_line((0, 0), (1, 0))
        b.add_blockref("SELF", (1, 1))
        m.add_blockref("SELF", (0, 0))

    with pytest.raises(DataError, match="block 'SELF' lies more than 32 blocks deep"):
        drawn(draw)


def test_empty_and_broken_files_are_refused(drawn, tmp_path):
    with pytest.raises(DataError, match=r"there is nothing to cut in .*drawing\.dxf: the file has no lines or curves"):
        drawn(lambda m: None)
    with pytest.raises(DataError, match=r"nothing to cut.*1 TEXT"):
        drawn(lambda m: m.add_text("a"))
    infinite = b"0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n 90\n-inf\n10\n0\n20\n0\n0\nENDSEC\n0\nEOF\n"
    broken = (b"this is no DXF", b"", b"\x00\x01\x02\xff" * 40, b"0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nfoo\n",
              b"  0\nSECTION", infinite)  # fmt: skip
    for content in broken:
        (tmp_path / "broken.dxf").write_bytes(content)
        with pytest.raises(DataError, match=r"broken\.dxf"):
            read_drawing(tmp_path / "broken.dxf", unit="mm")


LINE = "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n0\n20\n0\n30\n0\n11\n30\n21\n40\n31\n0\n0\nENDSEC\n0\nEOF\n"


@pytest.mark.parametrize("head", ["", "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n"])
def test_a_file_without_a_header_is_not_taken_for_metres(tmp_path, head):
    file = tmp_path / "r12.dxf"
    file.write_text(head + LINE)
    with pytest.raises(DataError, match=r"r12\.dxf does not say its unit \(it has no \$INSUNITS\): give it"):
        read_drawing(file)
    assert read_drawing(file, unit="mm").length == pytest.approx(50)
    assert read_drawing(file, unit="inch").length == pytest.approx(1270)
    # A text that names it is no unit.
    file.write_text((head + LINE).replace("8\n0\n", "8\n$INSUNITS\n"))
    with pytest.raises(DataError, match="it has no"):
        read_drawing(file)


@pytest.mark.parametrize("form", ["asc", "bin"])
def test_the_unit_is_found_in_text_and_in_binary_files(tmp_path, form):
    document = ezdxf.new(units=5)
    document.modelspace().add_line((0, 0), (3, 4))
    document.saveas(tmp_path / "a.dxf", fmt=form)
    assert read_drawing(tmp_path / "a.dxf").length == pytest.approx(50)


SPLINE = "0\nSPLINE\n8\n0\n5\n7F\n100\nAcDbEntity\n100\nAcDbSpline\n70\n8\n71\n3\n{}"
POINTS = "".join(f"10\n{x}\n20\n{y}\n30\n0\n" for x, y in [(0, 0), (10, 20), (30, 20), (40, 0)])
KNOTS = "".join(f"40\n{k}\n" for k in (0, 0, 0, 0, 1, 1, 1, 1))
BROKEN = {
    "two points": (SPLINE.format(KNOTS + "10\n0\n20\n0\n30\n0\n10\n9\n20\n0\n30\n0\n"), "got 2 control points"),
    "three knots": (SPLINE.format(KNOTS[:15] + POINTS), "knot values required"),
    "two weights": (SPLINE.format(KNOTS + "41\n1\n41\n2\n" + POINTS), "invalid weight count"),
    "no number": ("0\nLINE\n5\n7F\n8\n0\n10\n0\n20\n0\n11\nnan\n21\n5\n", "expected finite coordinates"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_entity_is_refused_by_kind_and_handle(tmp_path, name):
    entity, why = BROKEN[name]
    (tmp_path / "a.dxf").write_text(f"0\nSECTION\n2\nENTITIES\n{entity}0\nENDSEC\n0\nEOF\n")
    with pytest.raises(DataError, match=rf"a\.dxf: {entity.split()[1]} 7F cannot be read: .*{why}"):
        read_drawing(tmp_path / "a.dxf", unit="mm")


def test_an_ellipse_of_no_size_is_a_point(tmp_path):
    axes = "10\n0\n20\n0\n30\n0\n11\n0\n21\n0\n31\n0\n40\n0.5\n41\n0\n42\n6.2\n"
    (tmp_path / "a.dxf").write_text(LINE.replace("0\nENDSEC", f"0\nELLIPSE\n8\n0\n{axes}0\nENDSEC"))
    drawing = read_drawing(tmp_path / "a.dxf", unit="mm")
    assert drawing.length == pytest.approx(50) and drawing.notes == ("1 segment of no length left out",)


def test_blocks_that_multiply_without_end_are_refused(drawn, monkeypatch):
    monkeypatch.setattr("leadscrew.paths.dxf.MOST_INSERTED", 1000)

    def draw(m):
        m.doc.blocks.new("B0").add_line((0, 0), (1, 0))
        for k in range(1, 12):
            b = m.doc.blocks.new(f"B{k}")
            for x in range(10):
                b.add_blockref(f"B{k - 1}", (x, k))
        m.add_blockref("B11", (0, 0))

    with pytest.raises(DataError, match=r"drawing\.dxf: its blocks draw more than 1000 entities"):
        drawn(draw)

    def rows(m):
        m.doc.blocks.new("B").add_line((0, 0), (1, 0))
        m.add_blockref("B", (0, 0), dxfattribs={"row_count": 9000, "column_count": 9000, "row_spacing": 1})

    with pytest.raises(DataError, match="more than 1000 entities"):
        drawn(rows)


def test_a_block_that_is_not_there_is_refused_by_its_reference(drawn):
    with pytest.raises(DataError, match=r"drawing\.dxf: INSERT [0-9A-F]+ cannot be read: .*NIX"):
        drawn(lambda m: (m.add_line((0, 0), (1, 0)), m.add_blockref("NIX", (0, 0))))
