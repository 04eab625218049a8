// The module `_render`: pictures of meshes without a graphics library (render/picture.h).
#include "render/picture.h"

#include <stdexcept>

#include "bindings/module.h"

namespace {

using namespace raster;

// Numbers of a row of `styles`.
const std::size_t style_columns = 13;

using Table = nb::ndarray<const double, nb::c_contig, nb::device::cpu, nb::ndim<2>>;

Vec vec(const double* p) { return {p[0], p[1], p[2]}; }

Camera read_camera(const double* c, int width, int height, int samples) {
  Camera cam;
  cam.right = vec(c);
  cam.down = vec(c + 3);
  cam.forward = vec(c + 6);
  cam.position = vec(c + 9);
  cam.fx = c[12];
  cam.fy = c[13];
  cam.cx = c[14];
  cam.cy = c[15];
  cam.near = c[16];
  cam.width = width;
  cam.height = height;
  cam.samples = samples;
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || samples < 1 || samples > 4)
    throw std::invalid_argument("raster: impossible picture size or sample count");
  return cam;
}

Meshes read_meshes(f64<nb::shape<-1, 3>> vertices, i32<nb::shape<-1, 3>> faces,
                   i32<nb::shape<-1>> mesh_of_face, Table styles, i32<nb::shape<-1, 3>> flags,
                   const Camera& cam) {
  Meshes m;
  const std::size_t nv = vertices.shape(0), nf = faces.shape(0), nm = styles.shape(0);
  if (styles.shape(1) != style_columns || flags.shape(0) != nm || mesh_of_face.shape(0) != nf)
    throw std::invalid_argument("raster: tables of different lengths");
  for (std::size_t v = 0; v < nv; ++v) {
    m.world.push_back(vec(vertices.data() + 3 * v));
    m.view.push_back(cam.to_camera(m.world.back()));
  }
  m.mesh_of_face.assign(mesh_of_face.data(), mesh_of_face.data() + nf);
  for (std::size_t f = 0; f < nf; ++f) {
    const int* t = faces.data() + 3 * f;
    for (int k = 0; k < 3; ++k)
      if (t[k] < 0 || static_cast<std::size_t>(t[k]) >= nv)
        throw std::invalid_argument("raster: face index outside the vertices");
    if (m.mesh_of_face[f] < 0 || static_cast<std::size_t>(m.mesh_of_face[f]) >= nm)
      throw std::invalid_argument("raster: mesh index outside the styles");
    m.faces.push_back({t[0], t[1], t[2]});
  }
  for (std::size_t k = 0; k < nm; ++k) {
    const double* r = styles.data() + style_columns * k;
    const int* g = flags.data() + 3 * k;
    Style s;
    s.color = vec(r);
    s.checker = vec(r + 3);
    s.alpha = r[6];
    s.rim = r[7];
    s.checker_size = r[8];
    s.bias = r[9];
    s.fade_from = r[10];
    s.fade_to = r[11];
    s.crease = r[12];
    s.cull = g[0];
    s.casts = g[1] != 0;
    s.receives = g[2] != 0;
    m.styles.push_back(s);
  }
  return m;
}

Look read_look(Table look, Table lights) {
  if (look.shape(0) != 5 || look.shape(1) != 3 || lights.shape(1) != 6)
    throw std::invalid_argument("raster: look is (5, 3) and lights (L, 6)");
  const double* r = look.data();
  Look out{vec(r), vec(r + 3), vec(r + 6), vec(r + 9), vec(r + 12), {}};
  for (std::size_t k = 0; k < lights.shape(0); ++k) {
    const double* l = lights.data() + 6 * k;
    out.lights.push_back({unit(vec(l)), l[3], l[4], l[5]});
  }
  return out;
}

template <class T>
auto owned(T* data, std::initializer_list<std::size_t> shape) {
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return nb::ndarray<nb::numpy, T>(data, shape, owner);
}

auto picture(f64<nb::shape<-1, 3>> vertices, i32<nb::shape<-1, 3>> faces,
             i32<nb::shape<-1>> mesh_of_face, Table styles, i32<nb::shape<-1, 3>> flags,
             f64<nb::shape<17>> camera, Table look_table, Table lights, int width, int height,
             int samples, int threads) {
  const Camera cam = read_camera(camera.data(), width, height, samples);
  Meshes m = read_meshes(vertices, faces, mesh_of_face, styles, flags, cam);
  const Look look = read_look(look_table, lights);
  auto* out = new unsigned char[static_cast<std::size_t>(width) * height * 3];
  auto array = owned(out, {static_cast<std::size_t>(height), static_cast<std::size_t>(width), 3});
  {
    nb::gil_scoped_release release;
    draw_picture(m, cam, look, threads, out);
  }
  return array;
}

auto visible(f64<nb::shape<-1, 3>> vertices, i32<nb::shape<-1, 3>> faces,
             i32<nb::shape<-1>> mesh_of_face, Table styles, i32<nb::shape<-1, 3>> flags,
             f64<nb::shape<17>> camera, int width, int height) {
  const Camera cam = read_camera(camera.data(), width, height, 1);
  const Meshes m = read_meshes(vertices, faces, mesh_of_face, styles, flags, cam);
  const std::size_t h = height, w = width;
  auto* index = new int[h * w];
  auto indices = owned(index, {h, w});
  auto* depth = new double[h * w];
  auto depths = owned(depth, {h, w});
  {
    nb::gil_scoped_release release;
    find_visible(m, cam, index, depth);
  }
  return nb::make_tuple(indices, depths);
}

}  // namespace

NB_MODULE(_render, m) {
  m.doc() = "Rasteriser of halfphysics.";
  m.def("picture", &picture, nb::arg("vertices"), nb::arg("faces"), nb::arg("mesh_of_face"),
        nb::arg("styles"), nb::arg("flags"), nb::arg("camera"), nb::arg("look"), nb::arg("lights"),
        nb::arg("width"), nb::arg("height"), nb::arg("samples"), nb::arg("threads"),
        "Picture (height, width, 3) uint8 of indexed meshes; halfphysics.render packs the tables.");
  m.def("visible", &visible, nb::arg("vertices"), nb::arg("faces"), nb::arg("mesh_of_face"),
        nb::arg("styles"), nb::arg("flags"), nb::arg("camera"), nb::arg("width"), nb::arg("height"),
        "Nearest mesh (height, width) int32, -1 for none, and its depth (height, width) [m].");
}
