#include "render/tiles.h"

#include "tuning.h"

#include <limits>

namespace raster {

namespace tune = hp::tuning::render;

Encoder::Encoder() : table(tune::kEncoderSteps + 1) {
  for (int k = 0; k <= tune::kEncoderSteps; ++k) {
    const double x = static_cast<double>(k) / tune::kEncoderSteps;
    const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    table[k] = static_cast<unsigned char>(std::lround(255.0 * s));
  }
}

Bins::Bins(const Camera& cam, const Meshes& m, const std::vector<Tri>& tris)
    : across((cam.width + tune::kTile - 1) / tune::kTile),
      down((cam.height + tune::kTile - 1) / tune::kTile),
      opaque(static_cast<std::size_t>(across) * down),
      clear(opaque.size()) {
  const int step = tune::kTile * cam.samples;
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

Box Bins::box(const Camera& cam, int tile) const {
  const int x = tile % across * tune::kTile, y = tile / across * tune::kTile, s = cam.samples;
  return {x * s, y * s, std::min(x + tune::kTile, cam.width) * s,
          std::min(y + tune::kTile, cam.height) * s};
}

void TilePainter::resolve(int tile) {
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

void TilePainter::paint(const Shader& shader, const Encoder& encode, unsigned char* out) {
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

void TilePainter::index(int* mesh, double* depth) const {
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

void TilePainter::note(int face, int i, int j) {
  if (face < 0) return;
  for (Shaded& e : cache_)
    if (e.face == face) {
      ++e.count;
      e.x += i + 0.5;
      e.y += j + 0.5;
      return;
    }
  cache_.push_back({face, 1, i + 0.5, j + 0.5, 1.0, {}});
}

const TilePainter::Shaded& TilePainter::shaded(int face) const {
  std::size_t k = 0;
  while (cache_[k].face != face) ++k;
  return cache_[k];
}

// The colour of sample k: the solid surface or the sky, under its translucent layers.
Vec TilePainter::sample(Vec sky, int k) {
  Vec c = solid_.face[k] < 0 ? sky : shaded(solid_.face[k]).color;
  order_.clear();
  for (std::size_t l = 0; l < used_; ++l)
    if (layers_[l].face[k] >= 0) order_.push_back(l);
  // Far to near; stable, so that equal depths keep the order of the meshes.
  std::stable_sort(order_.begin(), order_.end(), [&](std::size_t p, std::size_t q) {
    return layers_[p].inverse[k] < layers_[q].inverse[k];
  });
  for (std::size_t l : order_) {
    const Shaded& e = shaded(layers_[l].face[k]);
    c = mix(c, e.color, e.alpha);
  }
  return c;
}

// Each face is shaded once per pixel, at the mean of the samples where it shows.
Vec TilePainter::pixel(const Shader& shader, Vec sky, int corner, int stride, int x, int y) {
  const int s = cam_.samples;
  cache_.clear();
  for (int j = 0; j < s; ++j)
    for (int i = 0; i < s; ++i) {
      const int k = corner + j * stride + i;
      note(solid_.face[k], i, j);
      for (std::size_t l = 0; l < used_; ++l) note(layers_[l].face[k], i, j);
    }
  if (cache_.empty()) return sky;
  for (Shaded& e : cache_)
    e.color = shader.shade(e.face, x + e.x / (e.count * s), y + e.y / (e.count * s), e.alpha);
  Vec sum;
  for (int j = 0; j < s; ++j)
    for (int i = 0; i < s; ++i) sum = sum + sample(sky, corner + j * stride + i);
  return (1.0 / (s * s)) * sum;
}

}  // namespace raster
