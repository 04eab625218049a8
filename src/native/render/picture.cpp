#include "render/picture.h"

#include <atomic>
#include <system_error>
#include <thread>

#include "render/projection.h"
#include "render/tiles.h"

namespace raster {

namespace {

template <class Work>
void over_tiles(int tiles, int threads, Work work) {
  std::atomic<int> next{0};
  const auto loop = [&] { work(next); };
  std::vector<std::thread> pool;
  try {
    for (int k = 1; k < std::min(threads, tiles); ++k) pool.emplace_back(loop);
  } catch (const std::system_error&) {  // NOLINT(bugprone-empty-catch): fewer threads do it
  }
  loop();
  for (auto& t : pool) t.join();
}

}  // namespace

void draw_picture(Meshes& m, const Camera& cam, const Look& look, int threads, unsigned char* out) {
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

void find_visible(const Meshes& m, const Camera& cam, int* index, double* depth) {
  const std::vector<Tri> tris = project(m, cam);
  const Bins bins(cam, m, tris);
  TilePainter painter(m, cam, tris, bins);
  for (int tile = 0; tile < bins.across * bins.down; ++tile) {
    painter.resolve(tile);
    painter.index(index, depth);
  }
}

}  // namespace raster
