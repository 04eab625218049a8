// Software z-buffer: one tile of a picture at a time.
//
// Tiles are independent, so that any number of threads gives the same bytes.
#pragma once
#include "render/raster.h"
#include "render/shading.h"
#include "tuning.h"

namespace raster {

// sRGB bytes of linear light: a table fine enough that no 8-bit step is missed.
struct Encoder {
  std::vector<unsigned char> table;
  Encoder();
  unsigned char operator()(double x) const {
    const double step = clamp01(x) * hp::tuning::render::kEncoderSteps;
    return table[static_cast<int>(step + 0.5)];  // NOLINT(bugprone-incorrect-roundings)
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

// The triangles that meet each tile, in face order.
struct Bins {
  int across, down;
  std::vector<std::vector<int>> opaque, clear;

  Bins(const Camera& cam, const Meshes& m, const std::vector<Tri>& tris);
  Box box(const Camera& cam, int tile) const;
};

// One worker's memory, reused from tile to tile.
class TilePainter {
 public:
  TilePainter(const Meshes& m, const Camera& cam, const std::vector<Tri>& tris, const Bins& bins)
      : m_(m), cam_(cam), tris_(tris), bins_(bins) {}

  // Finds the nearest surfaces of a tile's samples; `paint` and `index` then say what they show.
  void resolve(int tile);
  void paint(const Shader& shader, const Encoder& encode, unsigned char* out);
  void index(int* mesh, double* depth) const;  // one sample per pixel

 private:
  struct Shaded {
    int face, count;
    double x, y, alpha;
    Vec color;
  };

  Vec pixel(const Shader& shader, Vec sky, int corner, int stride, int x, int y);
  void note(int face, int i, int j);
  Vec sample(Vec sky, int k);
  const Shaded& shaded(int face) const;

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

}  // namespace raster
