"""SVG drawings, written here, against geometry by hand and svgelements' own points as a second opinion."""

import math
from itertools import pairwise

import numpy as np
import pytest

from leadscrew.paths.read import read_drawing
from leadscrew.paths.segments import Arc, EllipseArc
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" {}>{}</svg>'
)
MM = 'width="100mm" height="50mm" viewBox="0 0 100 50"'


def read(tmp_path, body, size=MM, **options):
    file = tmp_path / "drawing.svg"
    file.write_text(HEAD.format(size, body))
    return read_drawing(file, **options)


def test_every_shape_comes_out_in_mm_with_y_upwards(tmp_path):
    drawing = read(
        tmp_path,
        '<line x1="0" y1="0" x2="10" y2="0"/><rect x="20" y="10" width="30" height="20"/>'
        '<rect x="60" y="10" width="30" height="20" rx="5"/><circle cx="50" cy="25" r="4"/>'
        '<ellipse cx="10" cy="40" rx="8" ry="4"/><polyline points="0,20 5,20 5,25"/>'
        '<polygon points="0,30 3,30 3,34"/>',
    )
    assert drawing.unit == "mm" and drawing.notes == ()
    lengths = [10, 100, 80 - 20 + 10 * math.pi, 8 * math.pi, None, 10, 12]
    for path, length in zip(drawing.paths, lengths, strict=True):
        if length is not None:
            assert path.length == pytest.approx(length, abs=1e-9)
    assert [p.closed for p in drawing.paths] == [False, True, True, True, True, False, True]
    line, rect, rounded, circle, *_ = drawing.paths
    assert line.segments[0].start == pytest.approx((0, 50)) and line.segments[0].end == pytest.approx((10, 50))
    assert rect.segments[0].start == pytest.approx((20, 40))
    assert len(rect.corners) == 4 and not rounded.corners
    # Drawn clockwise on a page whose y runs downwards: clockwise too where y runs upwards.
    assert rect.turn == pytest.approx(-360) and circle.turn == pytest.approx(-360)
    assert all(isinstance(s, Arc) and s.radius == pytest.approx(4) for s in circle.segments)


PATH = (
    "M10 20 L20 20 l5 5 H40 v-10 C50 0 60 0 70 10 S80 30 90 20 Q 95 10 90 5 T 80 5 A 10 5 30 1 0 60 8 "
    "a 6 6 0 0 1 -9 -3 z m 1 1 h 3"
)
TRANSFORMS = {
    "none": "",
    "turned in a group": "translate(10,5) rotate(30, 20, 10)",
    "skewed": "skewX(25) scale(1.2,0.7)",
    "mirrored": "matrix(-1 0.2 0.1 1.3 90 -4)",
}


@pytest.mark.parametrize("name", TRANSFORMS)
def test_path_data_under_transforms_agrees_with_svgelements(tmp_path, name):
    import svgelements

    drawing = read(tmp_path, f'<g transform="{TRANSFORMS[name]}"><path transform="scale(1.5)" d="{PATH}"/></g>')
    whole = svgelements.Path(PATH)
    matrix = svgelements.Matrix("scale(1.5) " if not TRANSFORMS[name] else f"{TRANSFORMS[name]} scale(1.5)")
    first, second = drawing.paths
    assert first.closed and not second.closed
    assert second.length == pytest.approx(3 * 1.5 * math.hypot(matrix.a / 1.5, matrix.b / 1.5), rel=1e-9)
    drawn = [s for s in whole.as_subpaths().__next__() if not isinstance(s, svgelements.Move)]
    assert len(drawn) == len(first.segments)
    for theirs, ours in zip(drawn, first.segments, strict=True):
        for u in (0.0, 0.21, 0.5, 0.83, 1.0):
            x, y = matrix.point_in_matrix_space(theirs.point(u))
            point = ours.derivative(np.array([u]), 0)[0]
            # svgelements runs an arc by the angle of its ellipse, as we do.
            assert point == pytest.approx((x, 50 - y), abs=1e-6)


def test_a_skewed_circle_is_the_arc_of_an_ellipse(tmp_path):
    (path,) = read(tmp_path, '<circle cx="0" cy="0" r="10" transform="translate(50,25) skewX(45)"/>').paths
    assert all(isinstance(s, EllipseArc) for s in path.segments)
    # The map (1, 1; 0, 1) has the singular values golden and 1/golden.
    from scipy.special import ellipe

    golden = (1 + math.sqrt(5)) / 2
    assert path.length == pytest.approx(4 * 10 * golden * ellipe(1 - golden**-4), rel=1e-12)


def test_arcs_whose_radii_do_not_fit_follow_the_format(tmp_path):
    body = '<path d="M 20 25 A 5 5 0 0 1 40 25"/><path d="M 60 25 A 0 5 0 0 1 80 25"/>'
    enlarged, straight = read(tmp_path, body).paths
    assert enlarged.length == pytest.approx(10 * math.pi) and enlarged.segments[0].radius == pytest.approx(10)
    assert straight.length == pytest.approx(20)


def test_data_written_without_spaces_are_read(tmp_path):
    body = (
        '<path d="M1 2L5 5.5.5-.5-.5 1e0z m1 1h1E1v-2a5,5 0 015 5 5 5 0 105,5"/>'
        '<g transform="matrix(1 0 0 1-5 3)translate(1.5.5), rotate(30deg) none "><line x2="4"/></g>'
    )
    with pytest.raises(DataError, match="transform="):
        read(tmp_path, body)
    three = read(tmp_path, body.replace(" none ", ""))
    closed, opened, line = three.paths
    corners = [(1, 2), (5, 5.5), (0.5, -0.5), (-0.5, 1), (1, 2)]
    assert closed.length == pytest.approx(sum(math.dist(a, b) for a, b in pairwise(corners)))
    # Two arcs of 5 mm about centres at a right angle to the chord: a quarter, and three quarters.
    assert opened.length == pytest.approx(10 + 2 + 5 * math.pi / 2 + 5 * 3 * math.pi / 2)
    assert line.segments[0].start == pytest.approx((-3.5, 50 - 3.5)) and line.length == pytest.approx(4)


def test_percentages_are_of_the_page_they_lie_on(tmp_path):
    rect, circle, inner = read(
        tmp_path,
        '<rect width="50%" height="20%"/><circle cx="60%" cy="50%" r="10%"/>'
        '<svg x="70%" width="20" height="20" viewBox="0 0 10 10"><line x2="40%" y2="0"/></svg>',
    ).paths
    assert rect.length == pytest.approx(2 * (50 + 10))
    # Of r: the diagonal over sqrt 2.
    assert circle.length == pytest.approx(2 * math.pi * 0.1 * math.hypot(100, 50) / math.sqrt(2))
    assert circle.at(0.0).y == pytest.approx(25, abs=1e-9)
    assert inner.segments[0].start == pytest.approx((70, 50)) and inner.length == pytest.approx(8)


def test_percentages_inside_of_a_view_box_are_of_its_own_width_and_height(tmp_path):
    box = '<svg width="20" height="10" viewBox="0 0 40 20"><line x2="50%"/><line x1="3" x2="3" y2="50%"/></svg>'
    across, up = read(tmp_path, box).paths
    assert across.length == pytest.approx(10) and up.length == pytest.approx(5)


def test_use_of_what_is_not_there_is_said(tmp_path):
    drawing = read(tmp_path, '<use href="part.svg#a"/><use xlink:href="#nix"/><use/><line x2="4"/>')
    assert drawing.notes == (
        "<use> of another file, not cut: part.svg#a",
        "<use> of what the file does not have, not cut: #nix, nothing",
    )
    with pytest.raises(DataError, match=r"nothing to cut in .*: <use> of another file, not cut: part\.svg#a"):
        read(tmp_path, '<use href="part.svg#a"/>')


def test_use_without_end_is_refused_before_it_is_drawn(tmp_path):
    level = '<g id="g{}">' + '<use href="#g{}"/>' * 10 + "</g>"
    body = '<defs><line id="g0" x2="4"/>' + "".join(level.format(k, *[k - 1] * 10) for k in range(1, 40)) + "</defs>"
    with pytest.raises(DataError, match="draws more than 100000 elements through <use>"):
        read(tmp_path, body + '<use href="#g39"/>')
    with pytest.raises(DataError, match=r"drawing\.svg: <g> lies more than 200 elements deep"):
        read(tmp_path, "<g>" * 20_000 + "</g>" * 20_000)
    chain = "".join(f'<g id="g{k}"><use href="#g{k - 1}"/></g>' for k in range(400, 0, -1))
    with pytest.raises(DataError, match="lies more than 200 elements deep"):
        read(tmp_path, f'<defs>{chain}<line id="g0" x2="4"/></defs><use href="#g400"/>')
    assert read(tmp_path, "<g>" * 150 + '<line x2="4"/>' + "</g>" * 150).length == pytest.approx(4)


@pytest.mark.parametrize(
    "size", ['viewBox="0 0 100 50"', 'width="100%" viewBox="0 0 100 50"', 'width="96px" height="9"']
)
def test_a_size_without_a_physical_unit_is_said(tmp_path, size):
    note = "the file names no physical unit: taken as 96 px an inch"
    assert read(tmp_path, '<line x2="4"/>', size).notes == (note,)
    for unit in ("px", "in", "inch"):
        found = read(tmp_path, '<line x2="4"/>', size, unit=unit)
        assert found.notes == ()
        assert found.unit == unit[:2]
    assert found.length == pytest.approx(4 * 25.4)
    assert read(tmp_path, '<line x2="4"/>', 'width="2in"', unit="inch").notes == ()


def test_use_nested_in_groups_puts_the_shape_where_it_belongs(tmp_path):
    drawing = read(
        tmp_path,
        '<defs><circle id="c" r="2"/></defs><symbol id="s"><rect width="4" height="2"/></symbol>'
        '<g transform="translate(10,10)"><use href="#c" x="5" y="3"/>'
        '<use xlink:href="#c" transform="scale(2)"/></g><use href="#s" x="70" y="30"/>',
    )
    small, large, rect = drawing.paths
    assert small.segments[0].start == pytest.approx((17, 37))
    assert large.segments[0].start == pytest.approx((14, 40)) and large.length == pytest.approx(8 * math.pi)
    assert rect.segments[0].start == pytest.approx((70, 20)) and rect.length == pytest.approx(12)


@pytest.mark.parametrize(
    ("size", "unit", "scale", "said"),
    [
        ('width="10cm" height="5cm" viewBox="0 0 200 100"', None, 0.5, "cm"),
        ('width="2in" height="1in" viewBox="0 0 50.8 25.4"', None, 1.0, "in"),
        ('width="192" height="96"', None, 25.4 / 96, "px"),
        ('width="192" height="96"', "mm", 1.0, "mm"),
        ('viewBox="0 0 100 50"', None, 25.4 / 96, "px"),
        ('width="100%" viewBox="0 0 100 50"', "in", 25.4, "in"),
        ('height="50mm" viewBox="0 0 100 25"', "mm", 2.0, "mm"),
        ('width="100mm" height="100mm" viewBox="0 0 50 20"', None, 2.0, "mm"),
    ],
)
def test_sizes_come_from_the_page_or_from_the_unit_given(tmp_path, size, unit, scale, said):
    drawing = read(tmp_path, '<line x1="0" y1="0" x2="12" y2="0"/>', size, unit=unit)
    assert drawing.length == pytest.approx(12 * scale, rel=1e-12)
    assert drawing.unit == said


def test_a_view_box_of_another_shape_is_centred_and_shifted(tmp_path):
    size = 'width="100mm" height="100mm" viewBox="10 20 50 20"'
    (path,) = read(tmp_path, '<line x1="10" y1="20" x2="60" y2="40"/>', size).paths
    # The box, 100 by 40 mm, lies in the middle of the page.
    assert path.segments[0].start == pytest.approx((0, 70)) and path.segments[0].end == pytest.approx((100, 30))


def test_hidden_text_and_images_are_left_out_and_said(tmp_path):
    drawing = read(
        tmp_path,
        '<g style="display:none"><line x2="9"/><circle r="3"/></g><line x2="5" display="none"/>'
        '<line x2="5" visibility="hidden"/><text>hello</text><image href="a.png" width="3" height="3"/>'
        '<clipPath id="k"><circle r="30"/></clipPath><line x1="1" x2="8" y1="5" y2="5"/>',
    )
    assert drawing.length == pytest.approx(7)
    assert drawing.notes == ("not cut: 1 image, 1 text", "hidden, not cut: 4")


def test_layers_of_inkscape_can_be_chosen(tmp_path):
    layer = '<g inkscape:groupmode="layer" inkscape:label="{}"><line x2="{}"/></g>'
    body = layer.format("cut", 10) + layer.format("draw", 20)
    both = read(tmp_path, body)
    assert both.layers == ("cut", "draw")
    assert read(tmp_path, body, layers=["draw"]).length == pytest.approx(20)
    with pytest.raises(NameUnknown, match=r"no layer 'cat'.*cut"):
        read(tmp_path, body, layers=["cat"])


def test_pieces_that_touch_become_one_path_and_doubles_are_cut_once(tmp_path):
    body = (
        '<line x1="0" y1="0" x2="10" y2="0"/><line x1="10" y1="10" x2="10" y2="0.004"/>'
        '<line x1="0" y1="10" x2="10" y2="10"/><line x1="0" y1="10" x2="0" y2="0"/>'
        '<line x1="10" y1="0" x2="0" y2="0"/><path d="M30 30 L30 30 L30 40"/>'
    )
    drawing = read(tmp_path, body)
    square, line = drawing.paths
    assert square.closed and square.length == pytest.approx(40, abs=0.01)
    assert square.segments[0].start == pytest.approx((0, 50)) and square.segments[0].end == pytest.approx((10, 50))
    assert line.length == pytest.approx(10)
    assert drawing.notes == (
        "1 segment of no length left out",
        "1 piece drawn twice, cut once",
        "5 pieces joined into 2 paths",
        "1 gap of at most 0.01 mm closed",
    )
    assert len(read(tmp_path, body, tolerance=1e-4).paths) == 2
    assert not read(tmp_path, body, tolerance=1e-4).paths[0].closed


def test_a_curve_with_coincident_control_points_has_its_tangent(tmp_path):
    (path,) = read(tmp_path, '<path d="M 10 10 C 10 10 20 20 30 10 L 40 0"/>').paths
    assert path.at(0.0).heading == pytest.approx(-45)
    assert path.corners == []


@pytest.mark.parametrize(
    ("body", "size", "text"),
    [
        ("", MM, "there is nothing to cut in .*drawing.svg: the file has no lines or curves"),
        ("<text>a</text>", MM, "there is nothing to cut in .*: not cut: 1 text"),
        ('<path d="M 5 5 L 5 5"/>', MM, "nothing to cut.*1 segment of no length"),
        ('<path d="M 5 5 L foo"/>', MM, r"<path>: its data cannot be read at 'foo' .character 9.: L takes 2 numbers"),
        ('<path id="k" d="M0 0 L 20 20 foo 30"/>', MM, r"<path> 'k': .*'foo 30' .character 14.: expected one of M L H"),
        ('<path d="M0 0 L 20 20 30"/>', MM, "at '30' .character 14.: L takes 2 numbers at a time"),
        ('<path d="M0 0 L nan 5"/>', MM, "at 'nan 5'"),
        ('<path d="M0 0 A 5 5 0 2 0 9 9"/>', MM, "A takes 7 numbers"),
        ('<path d="L 20 20"/>', MM, "expected M to begin with"),
        ('<polyline points="0,0 9,0 9"/>', MM, "<polyline>: its points cannot be read at '9' .character 9.: .*pairs"),
        ('<g transform="matrix(1 2)"><circle r="2"/></g>', MM, r"transform='matrix\(1 2\)' cannot be read; .*rotate"),
        ('<g transform="skewX(5) foo(1)"><circle r="2"/></g>', MM, "<g>: transform='skewX.*cannot be read"),
        ('<circle r="5em"/>', MM, "<circle>: r='5em' cannot be read: expected a number with px"),
        ('<circle r="-5"/>', MM, "<circle>: r='-5': expected no less than 0"),
        ('<circle r="5%"/>', "", "r='5%': the page has no size"),
        ('<line x1="0" x2="1e400"/>', MM, "finite"),
        ('<path d="M 0 0 C 1e300 0 1e300 5 0 5"/>', MM, "a coordinate beyond 1 km: is the unit right"),
        ('<line x2="5"/>', 'width="3 parsec"', "width='3 parsec' is no length.*expected a number with px, in, cm, mm"),
        ('<line x2="5"/>', 'width="10em"', "width='10em' is no length.*expected a number with px, in, cm, mm"),
        ('<line x2="5"/>', 'width="-10mm" height="10mm"', "width='-10mm': the size of a page is expected above 0"),
        ('<line x2="5"/>', 'width="10mm" height="0"', "height='0': the size of a page is expected above 0"),
        ('<line x2="5"/>', 'viewBox="0 0 five 5"', "expected four numbers"),
        ('<line x2="5"/>', 'viewBox="0 0 0 5"', "above 0"),
        ("<line", MM, "is no SVG"),
        ('<g id="g"><use href="#g"/></g>', MM, "<use> refers to itself"),
    ],
)
def test_what_cannot_be_cut_is_refused_in_a_sentence(tmp_path, body, size, text):
    with pytest.raises(DataError, match=text) as refused:
        read(tmp_path, body, size)
    assert "\n" not in str(refused.value)


def test_files_that_are_no_drawings_are_refused(tmp_path):
    with pytest.raises(DataError, match=r"there is no file '.*none\.svg'"):
        read_drawing(tmp_path / "none.svg")
    (tmp_path / "a.png").write_bytes(b"1")
    with pytest.raises(DataError, match=r"a\.png: a drawing is expected to end in \.svg, \.dxf, \.ngc"):
        read_drawing(tmp_path / "a.png")
    (tmp_path / "a.svg").write_text("<html/>")
    with pytest.raises(DataError, match="first element is <html>"):
        read_drawing(tmp_path / "a.svg")
    for content in (b"\xff\xfe\x00\x01", b'<?xml version="1.0" encoding="foo"?><svg/>'):
        (tmp_path / "a.svg").write_bytes(content)
        with pytest.raises(DataError, match="is no SVG"):
            read_drawing(tmp_path / "a.svg")
    with pytest.raises(ValueRefused, match=r"unit = 'furlong': expected one of mm, cm, m, in, px \(in or inch\)"):
        read_drawing(tmp_path / "a.svg", unit="furlong")
    with pytest.raises(ValueRefused, match="tolerance"):
        read_drawing(tmp_path / "a.svg", tolerance=0.0)
