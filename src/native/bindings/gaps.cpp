// Distances of contacts' sides (gaps.h).
#include "bindings/arrays.h"
#include "labels/gaps.h"

using namespace hp;

namespace {

Mat3 matrix(const double* from) {
  Mat3 R;
  std::copy(from, from + 9, R.m);
  return R;
}

auto between(const GapThing& t, Rows3 position, f64<nb::shape<-1, 3, 3>> turn,
             const GapThing& other, Rows3 other_position, f64<nb::shape<-1, 3, 3>> other_turn,
             double range) {
  const size_t rows = position.shape(0);
  need(turn.shape(0) == rows && other_position.shape(0) == rows && other_turn.shape(0) == rows,
       "positions and turns: expected one of every row");
  std::vector<double> out(rows, std::numeric_limits<double>::infinity());
  PosedShape placed;
  for (size_t i = 0; i < rows; i++) {
    const Mat3 R = matrix(other_turn.data() + 9 * i);
    const Vec3 at = load3(other_position.data() + 3 * i);
    for (const Convex& c : t.hulls) {
      placed.place(c, matrix(turn.data() + 9 * i), load3(position.data() + 3 * i));
      out[i] = std::min(out[i], other.gap(placed, R, at, range));
    }
    if (!(out[i] < range)) out[i] = std::numeric_limits<double>::infinity();
  }
  return array(out);
}

auto gaps(const GapThing& t, f64<nb::shape<-1, -1, 3>> posed, Ints frame, Ints first, Ints last,
          Ints hull_first, Ints hull_vertex, Rows3 position, f64<nb::shape<-1, 3, 3>> turn,
          double range) {
  const size_t rows = frame.shape(0), frames = posed.shape(0), n = posed.shape(1);
  const int hulls = (int)hull_first.shape(0) - 1, corners = (int)hull_vertex.shape(0);
  need(first.shape(0) == rows && last.shape(0) == rows, "first, last: one of every row");
  need(position.shape(0) == frames && turn.shape(0) == frames,
       "position and turn: expected one of every frame");
  need(hulls >= 0 && hull_first.data()[0] == 0 && hull_first.data()[hulls] == corners,
       "hull_first: expected where each hull starts, and the end");
  for (int h = 0; h < hulls; h++)
    need(hull_first.data()[h] < hull_first.data()[h + 1], "hull_first: out of order");
  for (int i = 0; i < corners; i++)
    need(hull_vertex.data()[i] >= 0 && (size_t)hull_vertex.data()[i] < n,
         "hull_vertex: out of range");
  for (size_t i = 0; i < rows; i++)
    need(frame.data()[i] >= 0 && (size_t)frame.data()[i] < frames && first.data()[i] >= 0 &&
             last.data()[i] <= hulls,
         "rows: out of range");
  std::vector<double> out(rows, std::numeric_limits<double>::infinity());
  {
    nb::gil_scoped_release release;
    Convex c;
    PosedShape placed;
    for (size_t i = 0; i < rows; i++) {
      const size_t k = frame.data()[i];
      const Mat3 R = matrix(turn.data() + 9 * k);
      for (int h = first.data()[i]; h < last.data()[i]; h++) {
        c.vertices.clear();
        for (int v = hull_first.data()[h]; v < hull_first.data()[h + 1]; v++)
          c.vertices.push_back(load3(posed.data() + 3 * (k * n + hull_vertex.data()[v])));
        c.lay_out();
        placed.place(c, {}, {});
        const double d = t.gap(placed, R, load3(position.data() + 3 * k), range);
        out[i] = std::min(out[i], d);
      }
      if (!(out[i] < range)) out[i] = std::numeric_limits<double>::infinity();
    }
  }
  return array(out);
}

}  // namespace

void bind_gaps(nb::module_& m) {
  nb::class_<GapThing>(m, "GapThing", "What a thing touches by: half-spaces, hulls, triangles.")
      .def(nb::init<>())
      .def("add_half_space",
           [](GapThing& t, Doubles normal, double offset) {
             need(normal.shape(0) == 3, "normal: expected (3,)");
             t.half_spaces.push_back({load3(normal.data()), offset});
           })
      .def("add_hull",
           [](GapThing& t, Rows3 vertices, Rows3 normals, double radius, Doubles rim) {
             t.hulls.push_back(convex(vertices, radius, rim, vectors(normals)));
           })
      .def("add_mesh",
           [](GapThing& t, Rows3 vertices, Faces faces) {
             t.meshes.push_back(TriangleTree::shared(vertices.data(), (int)vertices.shape(0),
                                                     faces.data(), (int)faces.shape(0)));
           })
      .def("between", &between,
           "Distances (r,) of its hulls from another thing, both at their poses of every "
           "row; inf beyond range.")
      .def("gaps", &gaps, nb::arg("posed"), nb::arg("frame"), nb::arg("first"), nb::arg("last"),
           nb::arg("hull_first"), nb::arg("hull_vertex"), nb::arg("position"), nb::arg("turn"),
           nb::arg("range"),
           "Distances (r,) between hulls first to last of a skin and the thing; inf beyond range.");
}
