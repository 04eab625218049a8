// What contact labels ask: which vertices are near what (touching.h).
#include "bindings/arrays.h"
#include "labels/touching.h"

using namespace hp;

namespace {

using Kind = TouchingShape::Kind;

template <typename T>
nb::ndarray<nb::numpy, T> own(std::vector<T>&& values, std::vector<size_t> shape) {
  auto* data = new std::vector<T>(std::move(values));
  nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::ndarray<nb::numpy, T>(data->data(), shape.size(), shape.data(), owner);
}

nb::tuple rows(NearRows&& r, bool points) {
  const size_t n = r.frame.size();
  if (!points) {
    r.nearest.clear();
    r.point.clear();
  }
  return nb::make_tuple(
      own(std::move(r.frame), {n}), own(std::move(r.vertex), {n}), own(std::move(r.distance), {n}),
      own(std::move(r.nearest), {points ? n : 0}), own(std::move(r.point), {points ? n : 0, 3}));
}

TouchingShape shape(Kind kind, const f64<nb::shape<3, 3>>& turn, const Doubles& position) {
  need(position.shape(0) == 3, "position: expected (3,)");
  TouchingShape s;
  s.kind = kind;
  std::copy(turn.data(), turn.data() + 9, s.R.m);
  s.pos = load3(position.data());
  return s;
}

void close_groups(const TouchingThing& t, f64<nb::shape<-1, -1, 3>> centres, Square radii,
                  nb::ndarray<uint8_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu> asked,
                  Rows3 position, f64<nb::shape<-1, 3, 3>> turn, double reach) {
  const size_t frames = centres.shape(0), groups = centres.shape(1);
  const size_t places = position.shape(0);
  need(radii.shape(0) == frames && radii.shape(1) == groups && asked.shape(0) == frames &&
           asked.shape(1) == groups,
       "centres, radii and asked: expected one of every frame and group");
  need(turn.shape(0) == places && (places == 1 || places == frames),
       "position and turn: expected one, or one of every frame");
  nb::gil_scoped_release release;
  for (size_t k = 0; k < frames; k++) {
    const size_t place = places == 1 ? 0 : k;
    const Vec3 origin = load3(position.data() + 3 * place);
    Mat3 R;
    std::copy(turn.data() + 9 * place, turn.data() + 9 * place + 9, R.m);
    for (size_t i = k * groups; i < (k + 1) * groups; i++)
      if (asked.data()[i])
        asked.data()[i] =
            t.within(mul_t(R, load3(centres.data() + 3 * i) - origin), radii.data()[i] + reach);
  }
}

nb::tuple near_rows(
    const TouchingThing& t, f64<nb::shape<-1, -1, 3>> posed, Ints first,
    nb::ndarray<const uint8_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu> close,
    Rows3 position, f64<nb::shape<-1, 3, 3>> turn, double reach, const PointGrid* points,
    double off, Faces faces) {
  const size_t frames = posed.shape(0), n = posed.shape(1), k = position.shape(0);
  const size_t groups = close.shape(1);
  need(close.shape(0) == frames, "close: expected a row of every frame");
  need(turn.shape(0) == k && (k == 1 || k == frames),
       "position and turn: expected one, or one of every frame");
  need(first.shape(0) == groups + 1 && first.data()[0] == 0 && (size_t)first.data()[groups] == n,
       "first: expected where each group starts, and the end");
  for (size_t i = 0; i < groups; i++)
    need(first.data()[i] <= first.data()[i + 1], "first: out of order");
  for (size_t i = 0; i < faces.size(); i++)
    need(faces.data()[i] >= 0 && (size_t)faces.data()[i] < n, "faces: out of range");
  PosedSkin skin{posed.data(), (int)frames, (int)n, first.data(), close.data(), (int)groups};
  Placing placing{position.data(), turn.data(), k == 1};
  NearRows of_skin, of_points;
  {
    nb::gil_scoped_release release;
    const NearQuery query{t, skin, placing, reach, points, off, faces.data(), (int)faces.shape(0)};
    find_near(query, of_skin, of_points);
  }
  return nb::make_tuple(rows(std::move(of_skin), false), rows(std::move(of_points), true));
}

// The methods that add a shape: turn and position are in the thing's frame.
void add_shapes(nb::class_<TouchingThing>& thing) {
  thing
      .def("add_plane",
           [](TouchingThing& t, f64<nb::shape<3, 3>> turn, Doubles position, Doubles normal,
              double offset) {
             need(normal.shape(0) == 3, "normal: expected (3,)");
             TouchingShape s = shape(Kind::Plane, turn, position);
             s.size = load3(normal.data());
             s.offset = offset;
             t.shapes.push_back(s);
           })
      .def("add_box",
           [](TouchingThing& t, f64<nb::shape<3, 3>> turn, Doubles position, Doubles half) {
             need(half.shape(0) == 3, "half: expected (3,)");
             TouchingShape s = shape(Kind::Box, turn, position);
             s.size = load3(half.data());
             t.shapes.push_back(s);
           })
      // A ball is a capsule of no length.
      .def("add_capsule",
           [](TouchingThing& t, f64<nb::shape<3, 3>> turn, Doubles position, double radius,
              double half) {
             TouchingShape s = shape(Kind::Capsule, turn, position);
             s.size = {radius, half, 0};
             t.shapes.push_back(s);
           })
      .def("add_cylinder",
           [](TouchingThing& t, f64<nb::shape<3, 3>> turn, Doubles position, double radius,
              double half) {
             TouchingShape s = shape(Kind::Cylinder, turn, position);
             s.size = {radius, half, 0};
             t.shapes.push_back(s);
           })
      // With the planes (normal, offset) of its faces it is a solid, without them a surface.
      .def(
          "add_triangles",
          [](TouchingThing& t, f64<nb::shape<3, 3>> turn, Doubles position,
             const triangles::Tree& tree, Rows4 planes) {
            const size_t n = planes.shape(0);
            TouchingShape s = shape(n ? Kind::Hull : Kind::Surface, turn, position);
            s.tree = &tree;
            for (size_t i = 0; i < n; i++) {
              s.normals.push_back(load3(planes.data() + 4 * i));
              s.offsets.push_back(planes.data()[4 * i + 3]);
            }
            t.shapes.push_back(std::move(s));
          },
          nb::keep_alive<1, 4>());
}

}  // namespace

void bind_touching(nb::module_& m) {
  nb::class_<PointGrid>(m, "PointGrid", "Points (n, 3) to find near triangles.")
      .def("__init__",
           [](PointGrid* self, Rows3 points) { new (self) PointGrid(vectors(points)); });
  nb::class_<TouchingThing> thing(m, "TouchingThing", "Shapes that touch, in their thing's frame.");
  thing.def(nb::init<>());
  add_shapes(thing);
  thing
      .def("distance",
           [](const TouchingThing& t, Rows3 points) {
             std::vector<double> out(points.shape(0));
             t.distances(vectors(points).data(), (int)out.size(),
                         std::numeric_limits<double>::infinity(), out.data());
             return array(out);
           })
      .def("close", &close_groups, nb::arg("centres"), nb::arg("radii"),
           nb::arg("asked").noconvert(), nb::arg("position"), nb::arg("turn"), nb::arg("reach"),
           "Which balls (t, g) of those asked about are at most `reach` from the thing: into "
           "`asked`.")
      .def("near", &near_rows, nb::arg("posed"), nb::arg("first"), nb::arg("close"),
           nb::arg("position"), nb::arg("turn"), nb::arg("reach"), nb::arg("points").none(),
           nb::arg("off"), nb::arg("faces"),
           "Vertices of a skin near the thing, and points near the skin: two tuples of rows.");
}
