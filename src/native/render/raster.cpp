// Software z-buffer: the picture in tiles, and its Python face.
//
// Tiles are independent, so any number of threads gives the same bytes.
#include <atomic>
#include <limits>
#include <stdexcept>
#include <thread>

#include "bindings/module.h"
#include "render/raster_shade.h"

namespace {

using namespace raster;

constexpr int kTile = 32;        // pixels
constexpr int kStyleColumns = 13;

// Bytes of linear light: a table fine enough that no 8-bit step is missed.
struct Encoder {
  static constexpr int kSize = 1 << 14;
  std::vector<unsigned char> table;
  Encoder() : table(kSize + 1) {
    for (int k = 0; k <= kSize; ++k) {
      const double x = static_cast<double>(k) / kSize;
      const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
      table[k] = static_cast<unsigned char>(std::lround(255.0 * s));
    }
  }
  unsigned char operator()(double x) const {
    return table[static_cast<int>(clamp01(x) * kSize + 0.5)];
  }
};

// Nearest surface per sample of one tile; inverse depth 0 is the background.
struct Layer {
  int mesh = -1;
  std::vector<double> inverse;
  std::vector<int> face;
  void reset(int samples) {
    inverse.assign(samples, 0.0);
    face.assign(samples, -1);
  }
  void draw(const Tri& t, const Box& box) {
    const int stride = box.x1 - box.x0;
    fill(t, box, [&](int i, int j, double value) {
      const int at = (j - box.y0) * stride + (i - box.x0);
      if (value > inverse[at]) {
        inverse[at] = value;
        face[at] = t.face;
      }
    });
  }
};

struct Bins {
  int across, down;
  std::vector<std::vector<int>> opaque, clear;  // triangles per tile, in face order

  Bins(const Camera& cam, const Meshes& m, const std::vector<Tri>& tris)
      : across((cam.width + kTile - 1) / kTile),
        down((cam.height + kTile - 1) / kTile),
        opaque(static_cast<std::size_t>(across) * down),
        clear(opaque.size()) {
    const int step = kTile * cam.samples;
    const Box all{0, 0, cam.width * cam.samples, cam.height * cam.samples};
    for (std::size_t k = 0; k < tris.size(); ++k) {
      const Box box = bounds(tris[k], all);
      if (box.empty()) continue;
      auto& bins = m.styles[tris[k].mesh].alpha < 1.0 ? clear : opaque;
      for (int ty = box.y0 / step; ty <= (box.y1 - 1) / step; ++ty)
        for (int tx = box.x0 / step; tx <= (box.x1 - 1) / step; ++tx)
          bins[static_cast<std::size_t>(ty) * across + tx].push_back(static_cast<int>(k));
    }
  }
  Box box(const Camera& cam, int tile) const {
    const int x = tile % across * kTile, y = tile / across * kTile, s = cam.samples;
    return {x * s, y * s, std::min(x + kTile, cam.width) * s,
            std::min(y + kTile, cam.height) * s};
  }
};

// One worker's memory, reused from tile to tile.
class TilePainter {
 public:
  TilePainter(const Meshes& m, const Camera& cam, const std::vector<Tri>& tris, const Bins& bins)
      : m_(m), cam_(cam), tris_(tris), bins_(bins) {}

  void resolve(int tile) {
    box_ = bins_.box(cam_, tile);
    const int samples = (box_.x1 - box_.x0) * (box_.y1 - box_.y0);
    solid_.reset(samples);
    for (int k : bins_.opaque[tile]) solid_.draw(tris_[k], box_);
    used_ = 0;
    for (int k : bins_.clear[tile]) {
      const Tri& t = tris_[k];
      if (used_ == 0 || layers_[used_ - 1].mesh != t.mesh) {
        if (layers_.size() == used_) layers_.emplace_back();
        layers_[used_].reset(samples);
        layers_[used_++].mesh = t.mesh;
      }
      layers_[used_ - 1].draw(t, box_);
    }
    // A translucent surface shows where it is nearer than everything solid by its bias.
    for (std::size_t l = 0; l < used_; ++l) {
      const double bias = m_.styles[layers_[l].mesh].bias;
      for (int k = 0; k < samples; ++k) {
        const double q = layers_[l].inverse[k];
        if (q > 0 && q / (1 + bias * q) <= solid_.inverse[k]) layers_[l].face[k] = -1;
      }
    }
  }

  void paint(const Shader& shader, const Encoder& encode, unsigned char* out) {
    const int s = cam_.samples, stride = box_.x1 - box_.x0;
    for (int y = box_.y0 / s; y < box_.y1 / s; ++y) {
      const Vec sky = shader.background(y + 0.5);
      for (int x = box_.x0 / s; x < box_.x1 / s; ++x) {
        const int corner = (y * s - box_.y0) * stride + (x * s - box_.x0);
        const Vec c = pixel(shader, sky, corner, stride, x, y);
        unsigned char* rgb = out + 3 * (static_cast<std::size_t>(y) * cam_.width + x);
        rgb[0] = encode(c.x);
        rgb[1] = encode(c.y);
        rgb[2] = encode(c.z);
      }
    }
  }

  void index(int* mesh, double* depth) const {  // one sample per pixel
    const int stride = box_.x1 - box_.x0;
    for (int y = box_.y0; y < box_.y1; ++y)
      for (int x = box_.x0; x < box_.x1; ++x) {
        const int k = (y - box_.y0) * stride + (x - box_.x0);
        double best = solid_.inverse[k];
        int face = solid_.face[k];
        for (std::size_t l = 0; l < used_; ++l)
          if (layers_[l].face[k] >= 0 && layers_[l].inverse[k] > best) {
            best = layers_[l].inverse[k];
            face = layers_[l].face[k];
          }
        const std::size_t at = static_cast<std::size_t>(y) * cam_.width + x;
        mesh[at] = face < 0 ? -1 : m_.mesh_of_face[face];
        depth[at] = face < 0 ? std::numeric_limits<double>::infinity() : 1.0 / best;
      }
  }

 private:
  struct Shaded {
    int face, count;
    double x, y, alpha;
    Vec color;
  };

  // Each face is shaded once per pixel, at the mean of the samples where it shows.
  Vec pixel(const Shader& shader, Vec sky, int corner, int stride, int x, int y) {
    const int s = cam_.samples;
    cache_.clear();
    const auto note = [&](int face, int i, int j) {
      if (face < 0) return;
      for (Shaded& e : cache_)
        if (e.face == face) {
          ++e.count;
          e.x += i + 0.5;
          e.y += j + 0.5;
          return;
        }
      cache_.push_back({face, 1, i + 0.5, j + 0.5, 1.0, {}});
    };
    for (int j = 0; j < s; ++j)
      for (int i = 0; i < s; ++i) {
        const int k = corner + j * stride + i;
        note(solid_.face[k], i, j);
        for (std::size_t l = 0; l < used_; ++l) note(layers_[l].face[k], i, j);
      }
    if (cache_.empty()) return sky;
    for (Shaded& e : cache_)
      e.color = shader.shade(e.face, x + e.x / (e.count * s), y + e.y / (e.count * s), e.alpha);
    const auto find = [&](int face) -> const Shaded& {
      std::size_t k = 0;
      while (cache_[k].face != face) ++k;
      return cache_[k];
    };
    Vec sum;
    for (int j = 0; j < s; ++j)
      for (int i = 0; i < s; ++i) {
        const int k = corner + j * stride + i;
        Vec c = solid_.face[k] < 0 ? sky : find(solid_.face[k]).color;
        order_.clear();
        for (std::size_t l = 0; l < used_; ++l)
          if (layers_[l].face[k] >= 0) order_.push_back(l);
        // Far to near; stable, so that equal depths keep the order of the meshes.
        std::stable_sort(order_.begin(), order_.end(), [&](std::size_t p, std::size_t q) {
          return layers_[p].inverse[k] < layers_[q].inverse[k];
        });
        for (std::size_t l : order_) {
          const Shaded& e = find(layers_[l].face[k]);
          c = mix(c, e.color, e.alpha);
        }
        sum = sum + c;
      }
    return (1.0 / (s * s)) * sum;
  }

  const Meshes& m_;
  const Camera& cam_;
  const std::vector<Tri>& tris_;
  const Bins& bins_;
  Box box_{};
  Layer solid_;
  std::vector<Layer> layers_;
  std::size_t used_ = 0;
  std::vector<Shaded> cache_;
  std::vector<std::size_t> order_;
};

template <class Work>
void over_tiles(int tiles, int threads, Work work) {
  std::atomic<int> next{0};
  const auto loop = [&] { work(next); };
  std::vector<std::thread> pool;
  for (int k = 1; k < std::min(threads, tiles); ++k) pool.emplace_back(loop);
  loop();
  for (auto& t : pool) t.join();
}

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
  if (styles.shape(1) != kStyleColumns || flags.shape(0) != nm || mesh_of_face.shape(0) != nf)
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
    const double* r = styles.data() + kStyleColumns * k;
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

auto render(f64<nb::shape<-1, 3>> vertices, i32<nb::shape<-1, 3>> faces,
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
    static const Encoder encode;
    compute_normals(m);
    const std::vector<Tri> tris = project(m, cam);
    const Bins bins(cam, m, tris);
    const Shader shader(m, cam, look);
    over_tiles(bins.across * bins.down, threads, [&](std::atomic<int>& next) {
      TilePainter painter(m, cam, tris, bins);
      for (int tile; (tile = next++) < bins.across * bins.down;) {
        painter.resolve(tile);
        painter.paint(shader, encode, out);
      }
    });
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
    const std::vector<Tri> tris = project(m, cam);
    const Bins bins(cam, m, tris);
    TilePainter painter(m, cam, tris, bins);
    for (int tile = 0; tile < bins.across * bins.down; ++tile) {
      painter.resolve(tile);
      painter.index(index, depth);
    }
  }
  return nb::make_tuple(indices, depths);
}

}  // namespace

void bind_raster(nb::module_& m) {
  m.def("raster_render", &render, nb::arg("vertices"), nb::arg("faces"), nb::arg("mesh_of_face"),
        nb::arg("styles"), nb::arg("flags"), nb::arg("camera"), nb::arg("look"),
        nb::arg("lights"), nb::arg("width"), nb::arg("height"), nb::arg("samples"),
        nb::arg("threads"),
        "Picture (height, width, 3) uint8 of indexed meshes; halfphysics.render packs the tables.");
  m.def("raster_visible", &visible, nb::arg("vertices"), nb::arg("faces"),
        nb::arg("mesh_of_face"), nb::arg("styles"), nb::arg("flags"), nb::arg("camera"),
        nb::arg("width"), nb::arg("height"),
        "Nearest mesh (height, width) int32, -1 for none, and its depth (height, width) [m].");
}
