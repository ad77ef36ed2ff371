#include "surface.hpp"

#include "surface_point.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kSlopePerGrey = 19;  // of the Laplacian at a sharp upright step, for each grey level of it

size_t count_of(int32_t n) { return static_cast<size_t>(n); }

void lay_out_view(const rvdnav_rig& rig, Arena& arena, SurfaceView* view) {
  arena.take(&view->map.nodes, rect_map_length(rig.width, rig.height));
  arena.take(&view->spans, count_of(rig.height));
  int32_t width = rig.width, height = rig.height;
  for (PyramidLevel& level : view->level) {
    level.width = width;
    level.height = height;
    const size_t pixels = count_of(width) * count_of(height);
    arena.take(&level.grey, pixels);
    arena.take(&level.smoothed, pixels);
    arena.take(&level.laplacian, pixels);
    width = halved(width);
    height = halved(height);
  }
  arena.take(&view->rows.crossings, count_of(max_crossings(rig.width)) * count_of(rig.height));
  arena.take(&view->rows.row_start, count_of(rig.height) + 1);
}

void build_pyramid(const rvdnav_rig& rig, int32_t camera, const GreyView& raw, SurfaceMemory& memory) {
  SurfaceView& view = memory.view[camera];
  build_rect_map(rig, camera, &view.map);
  resample(raw, view.map, memory.raw_u, memory.raw_v, view.level[0].grey, view.spans);
  for (int32_t level = 0; level < kPyramidLevels; ++level) {
    if (level > 0) halve(view.level[level - 1], view.level[level]);
    filter_level(view.level[level], memory.filter_row, memory.filter_plane);
  }
}

// Pixels, rounded down; at most the image's width.
int32_t disparity_at(const rvdnav_rig& rig, double range) {
  const double d = rig.focal_rect * rig.baseline / range;
  return d < rig.width ? static_cast<int32_t>(d) : rig.width;
}

}  // namespace

void lay_out(const rvdnav_rig& rig, Arena& arena, SurfaceMemory* memory) {
  for (SurfaceView& view : memory->view) lay_out_view(rig, arena, &view);
  arena.take(&memory->raw_u, count_of(rig.width));
  arena.take(&memory->raw_v, count_of(rig.width));
  arena.take(&memory->filter_row, count_of(rig.width) + 4);
  arena.take(&memory->filter_plane, count_of(rig.width) * count_of(rig.height));
  for (DisparityTiles& tiles : memory->tiles)
    arena.take(&tiles.tiles, count_of(tiles_over(rig.width)) * count_of(tiles_over(rig.height)));
  const size_t crossings = count_of(max_crossings(rig.width)) * count_of(rig.height);
  arena.take(&memory->match.right_score, crossings);
  arena.take(&memory->match.right_left, crossings);
  arena.take(&memory->match.keep, crossings);
  arena.take(&memory->matches, crossings);
}

SurfaceCounts reconstruct_surface(const rvdnav_config& config, const rvdnav_rig& rig, const GreyView& left,
                                  const GreyView& right, SurfaceMemory& memory, rvdnav_surface_point* points,
                                  uint32_t capacity) {
  build_pyramid(rig, 0, left, memory);
  build_pyramid(rig, 1, right, memory);
  const CrossingLimits limits = {config.match_half_window, config.match_min_score_q8 * 128, config.match_uniqueness_q8,
                                 config.match_max_gradient_q8};
  const int32_t low = disparity_at(rig, config.range_max);
  const int32_t high = disparity_at(rig, config.range_min) + 1;
  LevelView views[RVDNAV_CAMERAS];
  for (int32_t level = kPyramidLevels - 1; level >= 0; --level) {
    for (int32_t camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
      const SurfaceView& view = memory.view[camera];
      views[camera] = {level, view.level[level], view.spans, rig.height, view.rows};
      find_crossings(views[camera], config.edge_floor * kSlopePerGrey);
    }
    const DisparityTiles* coarse = level == kPyramidLevels - 1 ? nullptr : &memory.tiles[(level + 1) % 2];
    match_crossings(views[0], views[1], low >> level, (high >> level) + 1, coarse, limits, memory.match,
                    memory.matches);
    if (level == 0) break;
    DisparityTiles& tiles = memory.tiles[level % 2];
    tiles.columns = tiles_over(views[0].image.width);
    tiles.rows = tiles_over(views[0].image.height);
    fill_tiles(views[0], views[1], memory.matches, &tiles);
  }

  const RectRig rect = rect_rig(rig);
  const SurfaceGeometry geometry = {rect, projection_matrix(rect, 0), projection_matrix(rect, 1)};
  const CrossingRows& rows = views[0].rows;
  SurfaceCounts counts = {0, 0, 0};
  for (int32_t y = 0; y < rig.height; ++y) {
    for (uint32_t i = rows.begin(y); i < rows.end(y); ++i) {
      rvdnav_surface_point point;
      ++counts.crossings;
      if (memory.matches[i].right < 0) continue;
      if (!make_surface_point(views[0], views[1], y, memory.matches[i], rows.crossings[i], geometry, &point)) continue;
      ++counts.points;
      if (counts.written < capacity) points[counts.written++] = point;
    }
  }
  return counts;
}

}  // namespace rvdnav
